"""The materials of geoms."""

from __future__ import annotations

from typing import Any, Collection, Dict, Hashable, Tuple

import numpy as np

from .._arrays import Array
from .._scene import Scene
from . import _shapes, _textures
from ._geoms import FLEX, GEOM, MESHES, SKIN, has_flat_texture, is_of_model, reach
from ._light import Surroundings
from ._look import Look
from ._meshes import Meshes
from ._untyped import mujoco

# The alpha of planes that are seen from behind, as MuJoCo has it.
_SEEN_FROM_BELOW = 0.5


class Materials:
    """Adds the materials of a model's geoms to a scene, each once. is_solid: as Mirror has it."""

    def __init__(self, model: Any, scene: Scene, look: Look, is_solid: bool, surroundings: Surroundings,
                 meshes: Meshes) -> None:
        self._model, self._scene, self._look, self._is_solid = model, scene, look, is_solid
        self._surroundings, self._meshes = surroundings, meshes
        self._numbers: Dict[Hashable, int] = {}
        self._seen: Dict[Hashable, Hashable] = {}  # keys by all that they depend on
        self._textures: Dict[Tuple[int, bool], int] = {}
        self._occlusions: Dict[int, int] = {}  # textures by their texel

    def number(self, key: Hashable) -> int:
        return self._numbers[key]

    def key_of(self, geom: Any, is_behind: bool) -> Hashable:
        """The key of its material, which is made where it is new."""
        if self._is_solid:
            return self._solid(is_behind)
        seen = (is_behind, geom.matid, geom.texid, geom.rgba.tobytes(), geom.emission, geom.specular, geom.shininess,
                geom.reflectance, geom.type, geom.size.tobytes(), geom.texrepeat.tobytes(), geom.texuniform, geom.objtype, geom.objid,
                self._surroundings.is_in_sky, self._surroundings.ambient.tobytes())
        key = self._seen.get(seen)
        if key not in self._numbers:
            key = self._seen[seen] = self._new(geom, is_behind)
        return key

    def is_see_through(self, key: Any) -> bool:
        return not self._is_solid and bool(key[0] or key[3][3] < 1)

    def forget_but(self, wanted: Collection[Hashable], kept: int) -> None:
        """Removes the materials that are not wanted any more, once they are more than `kept`."""
        if len(self._numbers) > len(wanted) + kept:
            for key in [key for key in self._numbers if key not in wanted]:
                self._scene.remove_material(self._numbers.pop(key))
        if len(self._seen) > 16 * kept:
            self._seen.clear()

    def _solid(self, is_behind: bool) -> Hashable:
        key = "solid", is_behind
        if key not in self._numbers:
            self._numbers[key] = self._scene.add_material(unlit=True, double_sided=is_behind)
        return key

    def _new(self, geom: Any, is_behind: bool) -> Hashable:
        key = (is_behind, int(geom.matid), int(geom.texid), tuple(np.round(geom.rgba, 6).tolist()), float(geom.emission),
               float(geom.specular), float(geom.shininess), float(geom.reflectance), self._texture_map(geom),
               self._is_glass(geom), self._surroundings.is_in_sky, tuple(self._surroundings.ambient.tolist()))
        if key not in self._numbers:
            fields = self._fields(geom)
            if is_behind:
                fields.update(double_sided=True, alpha_mode="blend",
                              base_color=(*fields["base_color"][:3], _SEEN_FROM_BELOW * fields["base_color"][3]))
            self._numbers[key] = self._scene.add_material(**fields)
        return key

    def _texture_map(self, geom: Any) -> Tuple[float, ...]:
        """texture_from_uv: what texrepeat and texuniform come to."""
        if not has_flat_texture(self._model, geom):
            return (1, 0, 0, 1, 0, 0)
        repeat = np.where(np.asarray(geom.texrepeat, np.float64) > 0, geom.texrepeat, 1.0)
        size = np.asarray(geom.size[:2], np.float64)
        is_infinite = (size <= 0) & (geom.type == GEOM.mjGEOM_PLANE)
        if geom.texuniform and geom.type not in (*MESHES, SKIN, FLEX):
            repeat = repeat * np.where(size > 0, size, 1.0)
        whole = np.maximum(np.ceil(reach(self._model) * repeat / 2.0), 1) * 2.0
        repeat = np.where(is_infinite, whole, repeat)
        # Where MuJoCo has no coordinates it makes some from the middle on, and else from a corner.
        is_made = geom.type == GEOM.mjGEOM_HFIELD or (geom.type in MESHES and not geom.texcoord)
        offset = np.where(is_infinite | is_made, -0.5 * repeat - 0.5, 0.0)
        return (float(repeat[0]), 0, 0, float(repeat[1]), float(offset[0]), float(offset[1]))

    def _names(self, geom: Any) -> Tuple[str, str]:
        """Of its material and of itself."""
        number = self._number_in_model(geom)
        material = mujoco.mj_id2name(self._model, mujoco.mjtObj.mjOBJ_MATERIAL, number) if number >= 0 else ""
        own = mujoco.mj_id2name(self._model, mujoco.mjtObj.mjOBJ_GEOM, geom.objid) if is_of_model(geom) else ""
        return material or "", own or ""

    def _is_glass(self, geom: Any) -> bool:
        return geom.rgba[3] < 1 and self._look.glass_of(self._names(geom)) is not None

    def _number_in_model(self, geom: Any) -> int:
        """Of its material; -1: it has none. The scene has the material of textured geoms alone."""
        if geom.matid >= 0:
            return int(geom.matid)
        return int(self._model.geom_matid[geom.objid]) if is_of_model(geom) else -1

    def _fields(self, geom: Any) -> Dict[str, Any]:
        color = self._look.color(geom.rgba[:3])
        number = self._number_in_model(geom)
        metallic = float(self._model.mat_metallic[number]) if number >= 0 and hasattr(self._model, "mat_metallic") else -1.0
        roughness = float(self._model.mat_roughness[number]) if number >= 0 and hasattr(self._model, "mat_roughness") else -1.0
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
        glass = self._look.glass_of(self._names(geom)) if geom.rgba[3] < 1 else None
        if glass is not None:
            fields.update(self._of_glass(geom, color), **glass)
            self._surroundings.has_glass = True
        return fields

    def _of_mirror(self, geom: Any, color: Array) -> Dict[str, Any]:
        """MuJoCo adds what is mirrored, from all angles alike, and takes nothing away for it."""
        share = min(float(geom.reflectance), 0.98)
        if self._look.linear:
            return {"ior": (1 + share ** 0.5) / (1 - share ** 0.5), "specular": 1.0}
        # `specular` is what grazing angles mirror, and this much of an index of 1.5 makes it what is mirrored from above.
        return {"ior": 1.5, "specular_color": (25.0, 25.0, 25.0), "specular": share, "metallic": 0.0,
                "base_color": (*(color / (1.0 - share)), float(geom.rgba[3]))}

    def _of_glass(self, geom: Any, color: Array) -> Dict[str, Any]:
        """A solid that light of its colour passes through, over a length of its own size."""
        length = float(geom.modelrbound) if geom.modelrbound > 0 else float(np.max(geom.size))
        distance = 2.0 * length
        if geom.type in MESHES and geom.dataid >= 0:  # walls are thinner than what they enclose
            distance = min(distance, _shapes.reach_inside(self._meshes.corners(geom)))
        return {"base_color": (1.0, 1.0, 1.0, 1.0), "alpha_mode": "opaque", "transmission": 1.0, "ior": 1.5,
                "thickness": max(length, 1e-6), "roughness": 0.0, "metallic": 0.0, "specular": 1.0,
                "attenuation_color": tuple(np.clip(color, 0.01, 1.0)), "attenuation_distance": max(distance, 1e-6),
                "emissive": tuple(float(geom.emission) * color), "occlusion_texture": None}

    def _texture(self, number: int) -> int:
        key = int(number), self._look.linear
        if key not in self._textures:
            is_flat = self._model.tex_type[number] == mujoco.mjtTexture.mjTEXTURE_2D
            texels = _textures.image(self._model, number) if is_flat else _textures.strip(_textures.cube(self._model, number))
            self._textures[key] = self._scene.add_texture(texels, srgb=self._look.linear)
        return self._textures[key]

    def _of_ambient(self, geom: Any, color: Array) -> Dict[str, Any]:
        """What makes ambient light reach it as it reaches everything in MuJoCo."""
        emitted = np.zeros(3) if self._surroundings.lights_from_around(geom) else self._surroundings.ambient
        occlusion = None
        if self._surroundings.is_in_sky and not self._look.linear:
            occlusion = self._occlusion(int(255 * min(self._surroundings.share_around(geom), 1.0) + 0.5))
        return {"emissive": tuple((float(geom.emission) + emitted) * color), "occlusion_texture": occlusion}

    def _occlusion(self, texel: int) -> int:
        if texel not in self._occlusions:
            self._occlusions[texel] = self._scene.add_texture(np.full((1, 1, 3), texel, np.uint8), srgb=False)
        return self._occlusions[texel]
