"""The meshes of geoms."""

from __future__ import annotations

from typing import Any, Callable, Collection, Dict, Hashable, Optional, Tuple

import numpy as np

from .._arrays import Array
from .._convert import mesh_arrays
from .._scene import Scene
from . import _shapes, _textures
from ._geoms import FLEX, GEOM, MESHES, SKIN, UNIT, has_flat_texture
from ._shapes import Shape


class Meshes:
    """Adds the meshes of a model's geoms to a scene, each once. is_round: as Mirror has it."""

    def __init__(self, model: Any, scene: Scene, is_textured: bool, is_round: bool) -> None:
        self._model, self._scene, self._is_textured = model, scene, is_textured
        self._numbers: Dict[Hashable, int] = {}
        self._moving: Dict[Hashable, Tuple[int, int]] = {}
        quality = model.vis.quality
        self._slices, self._stacks = max(int(quality.numslices), 3), max(int(quality.numstacks), 2)
        if is_round:  # what is refracted shows every edge
            self._slices, self._stacks = max(self._slices, 48), max(self._stacks, 32)

    def number(self, key: Hashable) -> int:
        return self._numbers[key]

    def key_of(self, geom: Any, source: Any) -> Optional[Hashable]:
        """The key of its mesh, which is made where it is new."""
        kind = geom.type
        if kind in (FLEX, SKIN):
            return self._moving_mesh(geom, source)
        mapping = self._mapping(geom)
        key: Hashable
        if kind in UNIT:
            key = (kind, mapping)
        elif kind == GEOM.mjGEOM_CAPSULE:
            key = (kind, mapping, round(float(geom.size[0]), 9), round(float(geom.size[2]), 9))
        elif kind == GEOM.mjGEOM_HFIELD and geom.dataid >= 0:
            key = (kind, mapping, int(geom.dataid))
        elif kind in MESHES and geom.dataid >= 0:
            key = (kind, mapping, int(geom.dataid))
        else:
            return None  # labels and what this version of MuJoCo adds
        if key not in self._numbers:
            shape = self._shape(geom)
            if shape is None:
                return None
            self._numbers[key] = self._scene.add_geometry(*self._mapped(shape, geom, mapping))
        return key

    def corners(self, geom: Any) -> Array:
        """(n, 3): the corners of a mesh's triangles."""
        shape = self._shape(geom)
        return shape[0] if shape is not None and shape[1] is None else np.zeros((0, 3))

    def forget_but(self, wanted: Collection[Hashable], kept: int) -> None:
        """Removes the meshes that are not wanted any more, once they are more than `kept`."""
        if len(self._numbers) > len(wanted) + kept:
            for key in [key for key in self._numbers if key not in wanted]:
                self._scene.remove_geometry(self._numbers.pop(key))

    def _shape(self, geom: Any) -> Optional[Shape]:
        kind = geom.type
        simple: Dict[int, Callable[[], Shape]] = {
            int(GEOM.mjGEOM_PLANE): _shapes.plane, int(GEOM.mjGEOM_BOX): _shapes.box,
            int(GEOM.mjGEOM_SPHERE): lambda: _shapes.sphere(self._slices, self._stacks),
            int(GEOM.mjGEOM_ELLIPSOID): lambda: _shapes.sphere(self._slices, self._stacks),
            int(GEOM.mjGEOM_CYLINDER): lambda: _shapes.cylinder(self._slices),
            int(GEOM.mjGEOM_ARROW): lambda: _shapes.arrow(1, 1.75, self._slices),
            int(GEOM.mjGEOM_ARROW1): lambda: _shapes.arrow(1, 1.0, self._slices),
            int(GEOM.mjGEOM_ARROW2): lambda: _shapes.arrow(2, 1.75, self._slices),
            int(GEOM.mjGEOM_LINE): _shapes.line,
            int(GEOM.mjGEOM_TRIANGLE): _shapes.triangle,
            int(GEOM.mjGEOM_CAPSULE): lambda: _shapes.capsule(geom.size[0], geom.size[2], self._slices, self._stacks),
            int(GEOM.mjGEOM_HFIELD): lambda: _shapes.height_field(self._model, geom.dataid),
        }
        if int(kind) in simple:
            return simple[int(kind)]()
        number = geom.dataid // 2
        if geom.dataid % 2:
            return _shapes.hull(self._model, number)
        return _shapes.mesh(self._model, number, bool(geom.texcoord))

    def _mapping(self, geom: Any) -> Hashable:
        """How texels lie on the shape: by its own coordinates, by x and y, or as a cube around it."""
        if not self._is_textured or geom.texid < 0:
            return ""
        if has_flat_texture(self._model, geom):
            return "uv"
        size = np.where(np.asarray(geom.size, np.float64) > 0, geom.size, 1.0)
        scale = np.ones(3)
        if geom.type == GEOM.mjGEOM_CAPSULE and not geom.texuniform:
            scale = 1.0 / size[[0, 0, 2]]
        elif geom.type == GEOM.mjGEOM_PLANE or (geom.type in UNIT and geom.texuniform):
            scale = size
        return "cube", tuple(np.round(scale, 6).tolist()), int(self._model.tex_width[geom.texid])

    def _mapped(self, shape: Shape, geom: Any, mapping: Hashable) -> Shape:
        positions, triangles, normals, uv = shape
        if mapping == "uv" and uv is None:
            uv = 0.5 + 0.5 * positions[:, :2] * [1, -1]
        if isinstance(mapping, tuple):
            return _textures.onto_cube(shape, np.asarray(mapping[1]), mapping[2])
        return positions, triangles, normals, uv if mapping else None

    def _moving_mesh(self, geom: Any, source: Any) -> Optional[Hashable]:
        """Skins and flexes: vertices that the scene gives anew, in the world."""
        key = (geom.type, int(geom.objid))
        shape = self._skin(geom, source) if geom.type == SKIN else self._flex(geom, source)
        if shape is None or len(shape[0]) == 0:
            return None
        count = len(shape[0]), 0 if shape[1] is None else len(shape[1])
        if key not in self._numbers:
            self._numbers[key] = self._scene.add_geometry(*shape)
        elif self._moving[key] == count:
            self._scene._edited().set_vertices(self._numbers[key], mesh_arrays(shape[0], None, shape[2], shape[3]))
        else:
            self._scene.replace_geometry(self._numbers[key], *shape)
        self._moving[key] = count
        return key

    def _skin(self, geom: Any, source: Any) -> Optional[Shape]:
        number, model = geom.objid, self._model
        begin, count = source.skinvertadr[number], source.skinvertnum[number]
        faces = model.skin_face[model.skin_faceadr[number]:model.skin_faceadr[number] + model.skin_facenum[number]]
        vertices = np.asarray(source.skinvert).reshape(-1, 3)[begin:begin + count]
        normals = np.asarray(source.skinnormal).reshape(-1, 3)[begin:begin + count]
        uv, address = None, model.skin_texcoordadr[number]
        if geom.texcoord and address >= 0:
            uv = np.asarray(model.skin_texcoord).reshape(-1, 2)[address:address + count]
        return vertices, faces, normals, uv

    def _flex(self, geom: Any, source: Any) -> Optional[Shape]:
        number = geom.objid
        used = int(source.flexfaceused[number])
        begin = int(source.flexfaceadr[number])
        rows = slice(3 * begin, 3 * (begin + used))
        uv = None
        if geom.texcoord:
            uv = np.asarray(source.flextexcoord).reshape(-1, 2)[rows]
        return (np.asarray(source.flexface).reshape(-1, 3)[rows], None,
                np.asarray(source.flexnormal).reshape(-1, 3)[rows], uv)
