"""A sideray.Scene that follows an mjvScene: what stays there stays here."""

from __future__ import annotations

import dataclasses
import fnmatch
from typing import Any, Callable, Dict, Hashable, List, Mapping, Optional, Sequence, Tuple, cast

import numpy as np

from .._arrays import Array
from .._camera import Camera
from .._scene import VISIBLE_ALL, Scene, _mesh_arrays
from . import _shapes, _textures
from ._untyped import mujoco
from ._shapes import Shape

_G = mujoco.mjtGeom
_UNIT = {int(_G.mjGEOM_PLANE), int(_G.mjGEOM_SPHERE), int(_G.mjGEOM_ELLIPSOID), int(_G.mjGEOM_CYLINDER),
         int(_G.mjGEOM_BOX), int(_G.mjGEOM_ARROW), int(_G.mjGEOM_ARROW1), int(_G.mjGEOM_ARROW2), int(_G.mjGEOM_LINE),
         int(_G.mjGEOM_TRIANGLE)}
_MESHES = {int(_G.mjGEOM_MESH), int(getattr(_G, "mjGEOM_SDF", _G.mjGEOM_MESH))}
_FLEX, _SKIN = int(getattr(_G, "mjGEOM_FLEX", -1)), int(_G.mjGEOM_SKIN)
# What a state places by itself.
_PLACED = (int(mujoco.mjtObj.mjOBJ_GEOM), int(mujoco.mjtObj.mjOBJ_SITE))
# As _native.with_backdrop() takes what is put behind a picture.
Backdrop = Tuple[Array, Optional[Array], float, bool]
# What a geom is (type, dataid, objtype, objid), and which of those that are the same.
_Key = Tuple[Tuple[int, int, int, int], int]
# Meshes and materials that no geom uses any more are kept, up to so many.
_KEPT = 256
# Where the sky is, in distances of the far plane: planes without an end are not seen beyond it.
_SKY = 0.7
# The alpha of planes that are seen from behind, as MuJoCo has it.
_SEEN_FROM_BELOW = 0.5


def _is_behind(geom: Any, source: Any) -> bool:
    """Whether the camera is on the other side of a plane."""
    if geom.type != _G.mjGEOM_PLANE:
        return False
    normal = np.asarray(geom.mat).reshape(3, 3)[:, 2]
    return bool((np.asarray(source.camera[0].pos) - geom.pos) @ normal < 0)


def _places(states: Sequence[Any], what: int, numbers: Sequence[int]) -> Tuple[Array, Array]:
    """Where geoms or sites are in each state: positions (states, numbers, 3) and rotations (states, numbers, 3, 3)."""
    positions, turns = (("geom_xpos", "geom_xmat") if what == _PLACED[0] else ("site_xpos", "site_xmat"))
    # Scenes of MuJoCo have them in single precision.
    return (np.stack([getattr(state, positions)[numbers] for state in states]).astype(np.float32),
            np.stack([getattr(state, turns)[numbers] for state in states]).astype(np.float32).reshape(len(states), -1, 3, 3))


def _sees_haze(camera: Camera, size: Tuple[int, int], up: Array, edge: float, share: float) -> bool:
    """Whether some of a picture looks between the horizon and where the haze begins. edge: how steeply one looks at its middle."""
    corner, across, down = camera._directions(size)
    x, y = np.meshgrid(np.linspace(0, size[0], 17), np.linspace(0, size[1], 17))
    looks = corner + x[..., None] * across + y[..., None] * down
    falls = -(looks @ up)
    along = np.linalg.norm(looks + falls[..., None] * up, axis=-1)
    return bool(((falls > 0) & (1.05 * along * edge > (1.0 - share) * falls)).any())


@dataclasses.dataclass
class Look:
    """How colours of a model become materials.

    linear: rgba are sRGB, as people choose colours, and the picture is tone mapped; else all numbers are taken as they are
    and shown as they come out, as MuJoCo does. glass: fields of the materials that names match. surrounded: ambient light comes
    from around the scene, where things can hide it; else it reaches everything.
    """

    linear: bool
    glass: Mapping[str, Mapping[str, Any]]
    surrounded: bool

    def color(self, rgb: Any) -> Array:
        values = np.asarray(rgb, np.float64)
        if not self.linear:
            return values
        return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)

    def glass_of(self, names: Sequence[str]) -> Optional[Mapping[str, Any]]:
        for pattern, fields in self.glass.items():
            if any(fnmatch.fnmatch(name.lower(), pattern.lower()) for name in names if name):
                return fields
        return None


@dataclasses.dataclass
class _Shown:
    """What an instance shows."""

    instance: int
    mesh: Hashable
    material: Hashable
    surface_id: int


def camera_of(source: Any, size: Tuple[int, int]) -> Camera:
    """The camera between both eyes, of a picture of this (width, height)."""
    eyes = source.camera
    position = 0.5 * (np.asarray(eyes[0].pos, np.float64) + eyes[1].pos)
    forward = np.asarray(eyes[0].forward, np.float64) + eyes[1].forward
    up = np.asarray(eyes[0].up, np.float64) + eyes[1].up
    world = np.eye(4)
    world[:3, 2] = -forward / np.linalg.norm(forward)
    world[:3, 0] = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
    world[:3, 1] = np.cross(world[:3, 2], world[:3, 0])
    world[:3, 3] = position
    eye = eyes[0]
    half = 0.5 * (eye.frustum_top - eye.frustum_bottom)
    center = 0.5 * (eyes[0].frustum_center + eyes[1].frustum_center)
    # MuJoCo's frustums have a width of their own only where the camera has intrinsics.
    square = half * size[0] / size[1]
    half_width = getattr(eye, "frustum_width", 0.0) or square
    shift = (-0.5 * center / half_width, 0.25 * (eye.frustum_top + eye.frustum_bottom) / half)
    return Camera(world, 2.0 * np.arctan(half / eye.frustum_near), eye.frustum_near, eye.frustum_far,
                  half if eye.orthographic else None, square / half_width, shift)


class Mirror:
    """Draws what mjv_updateScene wrote. is_solid: everything is opaque and without light, for depth and segmentation. is_round: with
    the shapes of colour, and all that colour shows; otherwise with MuJoCo's shapes, and what its segmentation has."""

    def __init__(self, model: Any, look: Look, is_solid: bool, is_round: bool) -> None:
        self.model, self.look, self.is_solid, self.is_round = model, look, is_solid, is_round
        self.scene = Scene(env=None, default_light=False)
        #: Of each surface id: (objid, objtype); row 0 is what is behind everything.
        self.objects = np.full((1, 2), -1, np.int32)
        self.sky: Optional[Array] = self._made_sky()
        self.ambient = np.zeros(3)
        self._shown: Dict[_Key, _Shown] = {}
        self._free: List[int] = []
        self._geometry: Dict[Hashable, int] = {}
        self._materials: Dict[Hashable, int] = {}
        self._materials_seen: Dict[Hashable, Hashable] = {}  # keys of _materials by all that they depend on
        self._textures: Dict[Tuple[int, bool], int] = {}
        self._moving: Dict[Hashable, Tuple[int, int]] = {}
        self._occlusions: Dict[int, int] = {}  # textures by their texel
        self._has_glass = False
        self._surroundings: Any = None  # as Scene.set_environment() was told
        self._transforms = np.empty((0, 12))
        self._lights: List[Dict[str, Any]] = []
        self._wanted_before: Dict[_Key, Any] = {}
        self._scales = np.empty((0, 3))
        # Of planes without an end: sides, repeats of the texture, rotation and position.
        self._endless: Dict[_Key, Tuple[Array, Array, Array, Array]] = {}
        #: Whether something that is drawn is not opaque.
        self.shows_through = False
        quality = model.vis.quality
        self._slices, self._stacks = max(int(quality.numslices), 3), max(int(quality.numstacks), 2)
        if is_round:  # what is refracted shows every edge
            self._slices, self._stacks = max(self._slices, 48), max(self._stacks, 32)

    def update(self, source: Any) -> None:
        """Follows an mjvScene."""
        if source.enabletransform:
            raise NotImplementedError("enabletransform: a scene with a transform of its own is not drawn; leave it out")
        if not self.is_solid:
            self.ambient = sum((self.look.color(light.ambient) for light in source.lights[:source.nlight]), np.zeros(3))
        was_in_sky = self.is_in_sky
        wanted = self._wanted(source)
        if self.is_in_sky != was_in_sky:
            wanted = self._wanted(source)
        edit = self.scene._edited
        gone = [self._shown.pop(key) for key in list(self._shown) if key not in wanted]
        if gone:
            edit().remove_instances(np.array([shown.instance for shown in gone], np.uint32))
            self._free += [shown.surface_id for shown in gone]
        shown = self._shown
        self._replace({k: w for k, w in wanted.items() if k in shown and w[:2] != (shown[k].mesh, shown[k].material)})
        self._add({k: w for k, w in wanted.items() if k not in shown})
        self._move(wanted)
        self._number(wanted)
        self._wanted_before = wanted
        self.shows_through = any(self._is_see_through(w[1]) for w in wanted.values())
        self._forget({w[0] for w in wanted.values()}, {w[1] for w in wanted.values()})
        if not self.is_solid:
            self._set_lights(source)
            self._set_surroundings()

    # ---- other states of the same model ----

    def moves_alone(self, states: Sequence[Any], eyes: Array) -> bool:
        """Whether other states of the model differ from the one that is drawn in where geoms, sites and lights are, and in nothing
        else."""
        if any(what not in _PLACED or index != 1 for (_, _, what, _), index in self._wanted_before):
            return False
        for (kind, _, what, number), _ in self._wanted_before:
            if kind == _G.mjGEOM_PLANE:
                position, turn = _places(states, what, [number])
                sides = np.einsum("nk,nk->n", eyes - position[:, 0], turn[:, 0, :, 2]) < 0
                if sides.any() and not sides.all():
                    return False
        return True

    def poses(self, states: Sequence[Any], eyes: Array) -> Tuple[Array, Array]:
        """The instances that move from state to state, and (states, instances, 12): where they are. eyes: of the cameras."""
        keys = list(self._wanted_before)
        placed = np.array([w[2] for w in self._wanted_before.values()]).reshape(-1, 4, 3)
        result = np.broadcast_to(placed, (len(states), *placed.shape)).copy()
        for what in _PLACED:
            rows = [row for row, ((_, _, other, _), _) in enumerate(keys)
                    if other == what and keys[row] not in self._endless]
            if rows:
                position, turn = _places(states, what, [keys[row][0][3] for row in rows])
                result[:, rows, :3] = turn.swapaxes(2, 3) * self._scales[rows, :, None]
                result[:, rows, 3] = position
        for row, key in enumerate(keys):
            if key in self._endless:
                size, repeat, turn, position = self._endless[key]
                for number, eye in enumerate(eyes):
                    scale_here, result[number, row, 3] = self._plane(size, repeat, eye, turn, position)
                    result[number, row, :3] = (turn * scale_here).T
        moving = np.nonzero((result != result[:1]).any((0, 2, 3)))[0]
        names = np.array([self._shown[keys[row]].instance for row in moving], np.uint32)
        self._transforms = np.empty((0, 12))  # the scene is left in the last state
        return names, np.ascontiguousarray(result[:, moving]).reshape(len(states), len(moving), 12)

    def lights(self, source: Any, states: Sequence[Any], forwards: Array) -> Optional[List[List[Dict[str, Any]]]]:
        """The lights of each state, whose camera looks along `forwards`; None where it is not known which they are."""
        shown = source.lights[:source.nlight]
        numbers = iter(np.nonzero(self.model.light_active)[0].tolist() if self.model.nlight else [])
        of_model = [None if light.headlight else next(numbers, None) for light in shown]
        first = states[0]
        for light, number in zip(shown, of_model):
            if light.headlight:
                continue
            if number is None or not (np.allclose(light.pos, first.light_xpos[number], atol=1e-4) and
                                      np.allclose(light.dir, first.light_xdir[number], atol=1e-4)):
                return None
        self._lights = [{"of": "the last state"}]

        def placed(light: Any, number: Optional[int], state: Any) -> Tuple[Any, Any]:
            if number is None:
                return light.pos, light.dir
            return np.float32(state.light_xpos[number]), np.float32(state.light_xdir[number])

        return [[self._light(light, placed(light, number, state), forward) for light, number in zip(shown, of_model)
                 if np.any(light.dir)] for state, forward in zip(states, forwards)]

    # ---- geoms ----

    def _wanted(self, source: Any) -> Dict[_Key, Tuple[Hashable, Hashable, Array, Tuple[int, int]]]:
        """Of each geom that is seen: its mesh, its material, its transform, and what it is."""
        shown: Dict[_Key, Tuple[Any, Hashable, Hashable]] = {}
        counts: Dict[Tuple[int, int, int, int], int] = {}
        self._endless = {}
        for geom in source.geoms[:source.ngeom]:
            if geom.rgba[3] == 0 or (not self.is_round and geom.segid < 0):
                continue
            if geom.type not in (_FLEX, _SKIN) and not geom.mat.any():  # it has no place before mj_forward()
                continue
            mesh = self._mesh_of(geom, source)
            if mesh is None:
                continue
            what = (geom.type, geom.dataid, geom.objtype, geom.objid)
            counts[what] = counts.get(what, 0) + 1
            is_behind = _is_behind(geom, source)
            material = ("solid", is_behind) if self.is_solid else self._material_of(geom, is_behind)
            if geom.type == _G.mjGEOM_PLANE and np.any(np.asarray(geom.size)[:2] <= 0):
                self._endless[(what, counts[what])] = (np.array(geom.size), np.array(geom.texrepeat),
                                                       np.array(geom.mat, np.float64).reshape(3, 3), np.array(geom.pos, np.float64))
            shown[(what, counts[what])] = geom, mesh, material
        placed = self._placed([geom for geom, _, _ in shown.values()], source)
        return {key: (mesh, material, where, (geom.objid, geom.objtype))
                for (key, (geom, mesh, material)), where in zip(shown.items(), placed)}

    def _placed(self, geoms: Sequence[Any], source: Any) -> Array:
        """World from object of each as twelve numbers, column by column. Keeps the scales along the objects' axes that are in it."""
        if not geoms:
            return np.empty((0, 12))
        turns = np.array([geom.mat for geom in geoms], np.float64).reshape(-1, 3, 3)
        positions = np.array([geom.pos for geom in geoms], np.float64)
        scales = np.ones((len(geoms), 3))
        for row, geom in enumerate(geoms):
            if geom.type in (_FLEX, _SKIN):  # their vertices are in the world already
                turns[row], positions[row] = np.eye(3), 0.0
            elif geom.type == _G.mjGEOM_PLANE:
                scales[row], positions[row] = self._plane(geom.size, geom.texrepeat, source.camera[0].pos, turns[row], positions[row])
            elif geom.type == _G.mjGEOM_LINE:
                thin = 0.001 * self.model.stat.meansize
                scales[row] = thin, thin, geom.size[2]
            elif geom.type in _UNIT:
                scales[row] = geom.size
        self._scales = np.where(np.abs(scales) < 1e-9, 1e-9, scales)
        columns = (turns * self._scales[:, None, :]).swapaxes(1, 2).reshape(-1, 9)
        return np.concatenate([columns, positions], 1)

    def _plane(self, sides: Any, texrepeat: Any, eye: Any, turn: Array,
               position: Array) -> Tuple[Array, Array]:
        """An infinite side reaches as far as is seen, around where the camera is, in whole repeats of its texture."""
        size = np.asarray(sides, np.float64)
        reach = self._reach()
        repeat = np.where(np.asarray(texrepeat) > 0, texrepeat, 1.0)
        scale, offset = np.ones(3), turn.T @ (np.asarray(eye) - position)
        for axis in range(2):
            if size[axis] > 0:
                scale[axis], offset[axis] = size[axis], 0.0
            else:
                period = 2.0 / repeat[axis]
                scale[axis] = max(np.ceil(reach / period), 1) * period
                offset[axis] = np.round(offset[axis] / period) * period
        offset[2] = 0.0
        return scale, position + turn @ offset

    def _reach(self) -> float:
        """How far infinite planes reach: beyond what is seen."""
        return 1.05 * float(self.model.vis.map.zfar) * float(self.model.stat.extent)

    def _mesh_of(self, geom: Any, source: Any) -> Optional[Hashable]:
        """The key of its mesh, which is made where it is new."""
        kind = geom.type
        if kind in (_FLEX, _SKIN):
            return self._moving_mesh(geom, source)
        mapping = self._mapping(geom)
        key: Hashable
        if kind in _UNIT:
            key = (kind, mapping)
        elif kind == _G.mjGEOM_CAPSULE:
            key = (kind, mapping, round(float(geom.size[0]), 9), round(float(geom.size[2]), 9))
        elif kind == _G.mjGEOM_HFIELD and geom.dataid >= 0:
            key = (kind, mapping, int(geom.dataid))
        elif kind in _MESHES and geom.dataid >= 0:
            key = (kind, mapping, int(geom.dataid))
        else:
            return None  # labels and what this version of MuJoCo adds
        if key not in self._geometry:
            shape = self._shape(geom)
            if shape is None:
                return None
            self._geometry[key] = self.scene.add_geometry(*self._mapped(shape, geom, mapping))
        return key

    def _shape(self, geom: Any) -> Optional[Shape]:
        kind = geom.type
        simple: Dict[int, Callable[[], Shape]] = {
            int(_G.mjGEOM_PLANE): _shapes.plane, int(_G.mjGEOM_BOX): _shapes.box,
            int(_G.mjGEOM_SPHERE): lambda: _shapes.sphere(self._slices, self._stacks),
            int(_G.mjGEOM_ELLIPSOID): lambda: _shapes.sphere(self._slices, self._stacks),
            int(_G.mjGEOM_CYLINDER): lambda: _shapes.cylinder(self._slices),
            int(_G.mjGEOM_ARROW): lambda: _shapes.arrow(1, 1.75, self._slices),
            int(_G.mjGEOM_ARROW1): lambda: _shapes.arrow(1, 1.0, self._slices),
            int(_G.mjGEOM_ARROW2): lambda: _shapes.arrow(2, 1.75, self._slices),
            int(_G.mjGEOM_LINE): _shapes.line,
            int(_G.mjGEOM_TRIANGLE): _shapes.triangle,
            int(_G.mjGEOM_CAPSULE): lambda: _shapes.capsule(geom.size[0], geom.size[2], self._slices, self._stacks),
            int(_G.mjGEOM_HFIELD): lambda: _shapes.height_field(self.model, geom.dataid),
        }
        if int(kind) in simple:
            return simple[int(kind)]()
        number = geom.dataid // 2
        if geom.dataid % 2:
            return _shapes.hull(self.model, number)
        return _shapes.mesh(self.model, number, bool(geom.texcoord))

    def _mapping(self, geom: Any) -> Hashable:
        """How texels lie on the shape: by its own coordinates, by x and y, or as a cube around it."""
        if self.is_solid or geom.texid < 0:
            return ""
        if self.model.tex_type[geom.texid] == mujoco.mjtTexture.mjTEXTURE_2D:
            return "uv"
        size = np.where(np.asarray(geom.size, np.float64) > 0, geom.size, 1.0)
        scale = np.ones(3)
        if geom.type == _G.mjGEOM_CAPSULE and not geom.texuniform:
            scale = 1.0 / size[[0, 0, 2]]
        elif geom.type == _G.mjGEOM_PLANE or (geom.type in _UNIT and geom.texuniform):
            scale = size
        return "cube", tuple(np.round(scale, 6).tolist()), int(self.model.tex_width[geom.texid])

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
        shape = self._skin(geom, source) if geom.type == _SKIN else self._flex(geom, source)
        if shape is None or len(shape[0]) == 0:
            return None
        count = len(shape[0]), 0 if shape[1] is None else len(shape[1])
        if key not in self._geometry:
            self._geometry[key] = self.scene.add_geometry(*shape)
        elif self._moving[key] == count:
            self.scene._edited().set_vertices(self._geometry[key], _mesh_arrays(shape[0], None, shape[2], shape[3]))
        else:
            self.scene.replace_geometry(self._geometry[key], *shape)
        self._moving[key] = count
        return key

    def _skin(self, geom: Any, source: Any) -> Optional[Shape]:
        number, model = geom.objid, self.model
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

    # ---- materials ----

    def _material_of(self, geom: Any, is_behind: bool) -> Hashable:
        """The key of its material, which is made where it is new."""
        seen = (is_behind, geom.matid, geom.texid, geom.rgba.tobytes(), geom.emission, geom.specular, geom.shininess,
                geom.reflectance, geom.type, geom.size.tobytes(), geom.texrepeat.tobytes(), geom.texuniform, geom.objtype, geom.objid,
                self.is_in_sky, self.ambient.tobytes())
        key = self._materials_seen.get(seen)
        if key not in self._materials:
            key = self._materials_seen[seen] = self._new_material_of(geom, is_behind)
        return key

    def _new_material_of(self, geom: Any, is_behind: bool) -> Hashable:
        key = (is_behind, int(geom.matid), int(geom.texid), tuple(np.round(geom.rgba, 6).tolist()), float(geom.emission),
               float(geom.specular), float(geom.shininess), float(geom.reflectance), self._texture_map(geom),
               self._is_glass(geom), self.is_in_sky, tuple(self.ambient.tolist()))
        if key not in self._materials:
            fields = self._fields(geom)
            if is_behind:
                fields.update(double_sided=True, alpha_mode="blend",
                              base_color=(*fields["base_color"][:3], _SEEN_FROM_BELOW * fields["base_color"][3]))
            self._materials[key] = self.scene.add_material(**fields)
        return key

    def _is_see_through(self, material: Any) -> bool:
        return not self.is_solid and bool(material[0] or material[3][3] < 1)

    def _texture_map(self, geom: Any) -> Tuple[float, ...]:
        """texture_from_uv: what texrepeat and texuniform come to."""
        if geom.texid < 0 or self.model.tex_type[geom.texid] != mujoco.mjtTexture.mjTEXTURE_2D:
            return (1, 0, 0, 1, 0, 0)
        repeat = np.where(np.asarray(geom.texrepeat, np.float64) > 0, geom.texrepeat, 1.0)
        size = np.asarray(geom.size[:2], np.float64)
        is_infinite = (size <= 0) & (geom.type == _G.mjGEOM_PLANE)
        if geom.texuniform and geom.type not in (*_MESHES, _SKIN, _FLEX):
            repeat = repeat * np.where(size > 0, size, 1.0)
        whole = np.maximum(np.ceil(self._reach() * repeat / 2.0), 1) * 2.0
        repeat = np.where(is_infinite, whole, repeat)
        # Where MuJoCo has no coordinates it makes some from the middle on, and else from a corner.
        is_made = geom.type == _G.mjGEOM_HFIELD or (geom.type in _MESHES and not geom.texcoord)
        offset = np.where(is_infinite | is_made, -0.5 * repeat - 0.5, 0.0)
        return (float(repeat[0]), 0, 0, float(repeat[1]), float(offset[0]), float(offset[1]))

    def _names(self, geom: Any) -> Tuple[str, str]:
        """Of its material and of itself."""
        material = mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_MATERIAL, geom.matid) if geom.matid >= 0 else ""
        is_geom = geom.objtype == mujoco.mjtObj.mjOBJ_GEOM and geom.objid >= 0
        # The scene has the material of textured geoms alone.
        if is_geom and geom.matid < 0 and self.model.geom_matid[geom.objid] >= 0:
            material = mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_MATERIAL, self.model.geom_matid[geom.objid])
        own = mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_GEOM, geom.objid) if is_geom else ""
        return material or "", own or ""

    def _is_glass(self, geom: Any) -> bool:
        return geom.rgba[3] < 1 and self.look.glass_of(self._names(geom)) is not None

    def _material_number(self, geom: Any) -> int:
        if geom.matid >= 0:
            return int(geom.matid)
        is_geom = geom.objtype == mujoco.mjtObj.mjOBJ_GEOM and geom.objid >= 0
        return int(self.model.geom_matid[geom.objid]) if is_geom else -1

    def _fields(self, geom: Any) -> Dict[str, Any]:
        color = self.look.color(geom.rgba[:3])
        number = self._material_number(geom)
        metallic = float(self.model.mat_metallic[number]) if number >= 0 and hasattr(self.model, "mat_metallic") else -1.0
        roughness = float(self.model.mat_roughness[number]) if number >= 0 and hasattr(self.model, "mat_roughness") else -1.0
        # The exponent of a highlight as a roughness (Walter et al. 2007: alpha^2 = 2 / (n + 2)).
        from_shine = (2.0 / (128.0 * float(geom.shininess) + 2.0)) ** 0.25
        fields: Dict[str, Any] = {
            "base_color": (*color, float(geom.rgba[3])), "metallic": max(metallic, 0.0),
            "roughness": roughness if roughness >= 0 else from_shine,
            "specular": float(np.clip(geom.specular, 0, 1)), "alpha_mode": "blend" if geom.rgba[3] < 1 else "opaque",
            **self._of_ambient(geom, color),
        }
        if geom.reflectance > 0:
            fields.update(self._of_mirror(geom, color), roughness=min(fields["roughness"], max(roughness, 0.0)))
        if geom.texid >= 0:
            place = {"texture": self._texture(geom.texid), "texture_from_uv": self._texture_map(geom)}
            fields.update(base_color_texture=place, emissive_texture=place)
        glass = self.look.glass_of(self._names(geom)) if geom.rgba[3] < 1 else None
        if glass is not None:
            fields.update(self._of_glass(geom, color), **glass)
            self._has_glass = True
        return fields

    def _of_mirror(self, geom: Any, color: Array) -> Dict[str, Any]:
        """MuJoCo adds what is mirrored, from all angles alike, and takes nothing away for it."""
        share = min(float(geom.reflectance), 0.98)
        if self.look.linear:
            return {"ior": (1 + share ** 0.5) / (1 - share ** 0.5), "specular": 1.0}
        # `specular` is what grazing angles mirror, and this much of an index of 1.5 makes it what is mirrored from above.
        return {"ior": 1.5, "specular_color": (25.0, 25.0, 25.0), "specular": share, "metallic": 0.0,
                "base_color": (*(color / (1.0 - share)), float(geom.rgba[3]))}

    def _of_glass(self, geom: Any, color: Array) -> Dict[str, Any]:
        """A solid that light of its colour passes through, over a length of its own size."""
        length = float(geom.modelrbound) if geom.modelrbound > 0 else float(np.max(geom.size))
        reach = 2.0 * length
        if geom.type in _MESHES and geom.dataid >= 0:  # walls are thinner than what they enclose
            reach = min(reach, _shapes.reach_inside(self._positions_of_mesh(geom)))
        return {"base_color": (1.0, 1.0, 1.0, 1.0), "alpha_mode": "opaque", "transmission": 1.0, "ior": 1.5,
                "thickness": max(length, 1e-6), "roughness": 0.0, "metallic": 0.0, "specular": 1.0,
                "attenuation_color": tuple(np.clip(color, 0.01, 1.0)), "attenuation_distance": max(reach, 1e-6),
                "emissive": tuple(float(geom.emission) * color), "occlusion_texture": None}

    def _positions_of_mesh(self, geom: Any) -> Array:
        shape = self._shape(geom)
        return shape[0] if shape is not None and shape[1] is None else np.zeros((0, 3))

    def _texture(self, number: int) -> int:
        key = int(number), self.look.linear
        if key not in self._textures:
            is_flat = self.model.tex_type[number] == mujoco.mjtTexture.mjTEXTURE_2D
            texels = _textures.image(self.model, number) if is_flat else _textures.strip(_textures.cube(self.model, number))
            self._textures[key] = self.scene.add_texture(texels, srgb=self.look.linear)
        return self._textures[key]

    # ---- how much light comes from the sky ----
    # MuJoCo's sky is seen and lights nothing; here what surrounds a scene lights it. With linear colours that is wanted.
    # Else nothing surrounds it, the sky is put behind the picture, and everything emits the model's ambient light. Where glass must
    # see the sky, a texture occludes it for everything else: wholly, and for what mirrors down to the ambient light.

    @property
    def is_in_sky(self) -> bool:
        """Whether the sky surrounds the scene, so that the picture has it already."""
        return self.sky is not None and (self.look.linear or self._has_glass)

    @property
    def _around(self) -> Array:
        """The ambient light that surrounds the scene, where the sky does not."""
        return self.ambient if self.look.linear or self.look.surrounded else np.zeros(3)

    def _of_ambient(self, geom: Any, color: Array) -> Dict[str, Any]:
        """What makes ambient light reach it as it reaches everything in MuJoCo."""
        is_lit_around = self.look.linear or self.look.surrounded or (geom.reflectance > 0 and self.is_in_sky)
        emitted = np.zeros(3) if is_lit_around else self.ambient
        occlusion = None
        if self.is_in_sky and not self.look.linear:
            share = self.ambient.mean() / max(float(cast(Array, self.sky).mean()), 1e-6) if is_lit_around else 0.0
            occlusion = self._occlusion(int(255 * min(share, 1.0) + 0.5))
        return {"emissive": tuple((float(geom.emission) + emitted) * color), "occlusion_texture": occlusion}

    def _occlusion(self, texel: int) -> int:
        if texel not in self._occlusions:
            self._occlusions[texel] = self.scene.add_texture(np.full((1, 1, 3), texel, np.uint8), srgb=False)
        return self._occlusions[texel]

    def backdrop(self, shows_sky: bool) -> Backdrop:
        """What is put behind the picture, as with_backdrop() takes it: a colour, the faces of a sky, how often it is added, and
        whether its texels are sRGB. What lights the scene from everywhere is not what is seen behind it."""
        if self.is_in_sky:
            return np.zeros(3), self._sky_faces, 0.0 if shows_sky else -1.0, self.look.linear
        if self.sky is None or not shows_sky:
            return -self._around, None, 0.0, False
        return -self._around, self._sky_faces, 1.0, self.look.linear

    def haze(self, source: Any, camera: Camera, size: Tuple[int, int]) -> Optional[Dict[str, Any]]:
        """What with_backdrop() takes of the haze around a plane without an end, but for `surfaces`; None where none is seen in a
        picture of this size."""
        planes = {key: place for key, place in self._endless.items() if np.all(place[0][:2] <= 0)}
        share = float(np.clip(self.model.vis.map.haze, 0.0, 1.0))
        if not planes or share <= 0.0 or camera.half_height is not None:
            return None
        _, _, turn, position = next(iter(planes.values()))
        height = float((camera.world_from_camera[:3, 3] - position) @ turn[:, 2])
        end = _SKY * float(source.camera[0].frustum_far)
        if height <= 0.0 or not _sees_haze(camera, size, turn[:, 2], height / end, share):
            return None
        is_endless = np.zeros(len(self.objects), np.uint8)
        is_endless[[0, *(self._shown[key].surface_id for key in planes)]] = 1
        return {"is_endless": is_endless, "color": np.asarray(self.look.color(self.model.vis.rgba.haze[:3])), "up": turn[:, 2],
                "height": height, "end": end, "share": share}

    # ---- instances ----

    def _descriptions(self, wanted: Mapping[_Key, Any]) -> Tuple[Array, Array, Array]:
        meshes = np.array([self._geometry[w[0]] for w in wanted.values()], np.uint32)
        materials = np.array([self._number_of_material(w[1]) for w in wanted.values()], np.uint32)
        return meshes, materials, np.array([w[2] for w in wanted.values()])

    def _number_of_material(self, key: Any) -> int:
        if self.is_solid and key not in self._materials:
            self._materials[key] = self.scene.add_material(unlit=True, double_sided=key[1])
        return self._materials[key]

    def _add(self, wanted: Mapping[_Key, Any]) -> None:
        if not wanted:
            return
        meshes, materials, transforms = self._descriptions(wanted)
        fresh = len(self._shown) + len(self._free) + 1
        ids = [self._free.pop() if self._free else (fresh := fresh + 1) - 1 for _ in wanted]
        names = self.scene._edited().add_instances(meshes, materials, transforms, np.array(ids, np.uint32),
                                                   np.full(len(ids), VISIBLE_ALL, np.uint32))
        for (key, (mesh, material, _, _)), name, number in zip(wanted.items(), names, ids):
            self._shown[key] = _Shown(int(name), mesh, material, number)
        self._transforms = np.empty((0, 12))

    def _replace(self, wanted: Mapping[_Key, Any]) -> None:
        if not wanted:
            return
        meshes, materials, transforms = self._descriptions(wanted)
        shown = [self._shown[key] for key in wanted]
        self.scene._edited().replace_instances(
            np.array([s.instance for s in shown], np.uint32), meshes, materials, transforms,
            np.array([s.surface_id for s in shown], np.uint32), np.full(len(shown), VISIBLE_ALL, np.uint32))
        for s, (mesh, material, _, _) in zip(shown, wanted.values()):
            s.mesh, s.material = mesh, material

    def _move(self, wanted: Mapping[_Key, Any]) -> None:
        if not wanted:
            self._transforms = np.empty((0, 12))
            return
        transforms = np.array([w[2] for w in wanted.values()])
        if transforms.shape == self._transforms.shape and np.array_equal(transforms, self._transforms):
            return
        names = np.array([self._shown[key].instance for key in wanted], np.uint32)
        self.scene._edited().move_instances(names, transforms)
        self._transforms = transforms

    def _number(self, wanted: Mapping[_Key, Any]) -> None:
        largest = max((s.surface_id for s in self._shown.values()), default=0)
        self.objects = np.full((largest + 1, 2), -1, np.int32)
        for key, (_, _, _, what) in wanted.items():
            self.objects[self._shown[key].surface_id] = what

    def _forget(self, meshes: Any, materials: Any) -> None:
        if len(self._geometry) > len(meshes) + _KEPT:
            for key in [key for key in self._geometry if key not in meshes]:
                self.scene.remove_geometry(self._geometry.pop(key))
        if len(self._materials) > len(materials) + _KEPT:
            for key in [key for key in self._materials if key not in materials]:
                self.scene.remove_material(self._materials.pop(key))
        if len(self._materials_seen) > 16 * _KEPT:
            self._materials_seen.clear()

    # ---- light ----

    def _made_sky(self) -> Optional[Array]:
        skies = np.nonzero(self.model.tex_type == mujoco.mjtTexture.mjTEXTURE_SKYBOX)[0]
        if not len(skies) or self.is_solid:
            return None
        self._sky_faces = np.ascontiguousarray(_textures.cube(self.model, int(skies[0])))
        return self.look.color(_textures.sky(self._sky_faces)).astype(np.float32)

    def _set_lights(self, source: Any) -> None:
        lights: List[Dict[str, Any]] = []
        for light in source.lights[:source.nlight]:
            if np.any(light.dir):  # it has none before mj_forward()
                lights.append(self._light(light, (light.pos, light.dir), source.camera[0].forward))
        if str(lights) != str(self._lights):
            self.scene.lights = lights
            self._lights = lights

    def _set_surroundings(self) -> None:
        around = self._around.astype(np.float32)
        told = self.is_in_sky, tuple(around.tolist())
        if told == self._surroundings:
            return
        self._surroundings = told
        if self.is_in_sky:
            self.scene.set_environment(self.sky)
        else:
            self.scene.set_environment(np.broadcast_to(around, (2, 4, 3)) if around.any() else None)

    def _light(self, light: Any, placed: Tuple[Any, Any], forward: Any) -> Dict[str, Any]:
        """placed: its position and direction. forward: of the camera, which the headlight shines along."""
        diffuse = np.pi * self.look.color(light.diffuse)
        if light.headlight:  # from where the camera is, whatever the scene says
            return {"type": "directional", "name": "headlight", "direction": tuple(map(float, forward)),
                    "intensity": tuple(diffuse)}
        position, direction = (np.asarray(part, np.float64) for part in placed)
        kind = self._kind(light)
        if kind == "directional":
            return {"type": kind, "direction": tuple(direction), "intensity": tuple(diffuse)}
        # Light of MuJoCo need not fall off; here it does, and is as bright in the middle of the model.
        away = max(float(np.linalg.norm(position - self.model.stat.center)), 0.1 * float(self.model.stat.extent))
        a = light.attenuation
        fall = 1.0 / max(float(a[0] + a[1] * away + a[2] * away * away), 1e-6)
        fields = {"type": kind, "position": tuple(position), "direction": tuple(direction),
                  "intensity": tuple(diffuse * fall * away * away), "radius": float(getattr(light, "bulbradius", 0.0))}
        if kind == "spot":
            outer = float(np.radians(np.clip(light.cutoff, 1.0, 90.0)))
            # A cone that fades to its edge as cos^10 does where the exponent is 10, and with a hard edge at 0.
            fields.update(outer_cone=outer, inner_cone=outer * 0.98 * max(0.0, 1.0 - float(light.exponent) / 10.0))
        return fields

    @staticmethod
    def _kind(light: Any) -> str:
        if hasattr(light, "type"):
            return {0: "spot", 1: "directional", 2: "point"}.get(int(light.type), "directional")
        if light.directional:
            return "directional"
        return "spot" if light.cutoff < 90 else "point"
