"""pyrender's OffscreenRenderer, for scripts that move over.

A script changes `pyrender.OffscreenRenderer` into `sideray.OffscreenRenderer` and keeps its scene. Of a pyrender.Scene is
drawn: nodes and their poses; triangle meshes with normals, tangents, texture coordinates, vertex colours and instances
(`poses`); metallic-roughness materials with their textures and alpha modes, and, where a script sets them as attributes, the
fields of glass that pyrender has none of (transmission, ior, thickness, attenuation_color, attenuation_distance, ...);
directional, point and spot lights; ambient light; the background colour; the main camera, perspective, orthographic or of
intrinsics. Not drawn: points, lines, wireframes, normals. Depth is that of what is opaque: pyrender's includes what is blended.
"""

from __future__ import annotations

import enum
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from ._arrays import Array
from . import _native
from ._camera import Camera
from ._errors import InvalidArgument, Unsupported
from ._objects import Object
from ._picture import Picture
from ._renderer import Renderer
from ._scene import Scene

_TRIANGLES = 4  # GLTF.TRIANGLES
# What pyrender's materials lack, read where a script has set it.
_OF_GLASS = ("transmission", "ior", "thickness", "attenuation_distance", "attenuation_color", "specular",
             "specular_color", "clearcoat", "clearcoat_roughness", "dispersion", "iridescence", "iridescence_ior",
             "iridescence_thickness_min", "iridescence_thickness_max", "anisotropy", "anisotropy_rotation")


class RenderFlags(enum.IntFlag):
    """pyrender's. DEPTH_ONLY, RGBA, SEG and the SHADOWS are obeyed; those that draw something else are refused."""

    NONE = 0
    DEPTH_ONLY = 1
    OFFSCREEN = 2
    FLIP_WIREFRAME = 4
    ALL_WIREFRAME = 8
    ALL_SOLID = 16
    SHADOWS_DIRECTIONAL = 32
    SHADOWS_POINT = 64
    SHADOWS_SPOT = 128
    SHADOWS_ALL = 224
    VERTEX_NORMALS = 256
    FACE_NORMALS = 512
    SKIP_CULL_FACES = 1024
    RGBA = 2048
    FLAT = 4096
    SEG = 8192


_REFUSED = (RenderFlags.FLIP_WIREFRAME | RenderFlags.ALL_WIREFRAME | RenderFlags.VERTEX_NORMALS |
            RenderFlags.FACE_NORMALS | RenderFlags.FLAT)


class OffscreenRenderer:
    """Draws scenes of pyrender, or of this package, into arrays.

    options: of Renderer.render, for every picture. `picture` is the last one, with all its channels.
    """

    def __init__(self, viewport_width: int, viewport_height: int, point_size: float = 1.0, **options: Any) -> None:
        self.viewport_width, self.viewport_height = viewport_width, viewport_height
        self.point_size = point_size
        self.options = options
        self.picture: Optional[Picture] = None
        self._renderer: Optional[Renderer] = Renderer()
        self._mirror: Optional[_Mirror] = None

    def render(self, scene: Any, flags: int = RenderFlags.NONE,
               seg_node_map: Optional[Mapping[Any, Any]] = None) -> Any:
        """(color, depth): (height, width, 3) uint8, with RGBA 4 of them, and (height, width) float32.

        depth: distance along the view axis, world units, 0 where there is nothing opaque. DEPTH_ONLY: depth alone. SEG:
        color is that of seg_node_map for pixels of its nodes, and black elsewhere; without shading.
        """
        if self._renderer is None:
            raise InvalidArgument("the renderer is deleted; make another")
        wanted = RenderFlags(flags)
        if wanted & _REFUSED:
            raise Unsupported(f"flags: {RenderFlags(wanted & _REFUSED)!r} are not drawn; leave them out")
        if isinstance(scene, Scene):
            mirror, drawn, camera = None, scene, None
        else:
            if self._mirror is None or self._mirror.source is not scene:
                self._mirror = _Mirror(scene)
            mirror = self._mirror
            mirror.update(bool(wanted & RenderFlags.SKIP_CULL_FACES))
            drawn, camera = mirror.scene, mirror.camera((self.viewport_width, self.viewport_height))
        options = dict(self.options)
        if mirror is not None and not wanted & RenderFlags.SHADOWS_ALL:
            options.setdefault("shadows", "off")
        if mirror is not None:
            # Ambient light reaches everything in pyrender, and nothing is mirrored.
            for light in ("ambient", "reflections"):
                options.setdefault(light, False)
        if wanted & (RenderFlags.DEPTH_ONLY | RenderFlags.SEG):
            options.update(translucency="off", shadows="off", ambient=False, reflections=False)
        options.setdefault("tonemap", "none" if mirror is not None else "pbr-neutral")
        size = (self.viewport_width, self.viewport_height)
        self.picture = self._renderer.render(drawn, size, camera, **options)
        depth = np.where(np.isinf(self.picture.depth), np.float32(0), self.picture.depth)
        if wanted & RenderFlags.DEPTH_ONLY:
            return depth
        if wanted & RenderFlags.SEG:
            return self._segmented(mirror, seg_node_map or {}, bool(wanted & RenderFlags.RGBA)), depth
        return self._color(mirror, options, bool(wanted & RenderFlags.RGBA)), depth

    def delete(self) -> None:
        """Gives back the context."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = None

    def _color(self, mirror: Optional[_Mirror], options: Mapping[str, Any], with_alpha: bool) -> Array:
        assert self.picture is not None
        rgb, alpha = self.picture.rgb, self.picture["A"]
        if mirror is not None:
            # What is seen behind everything is the background, and what lights the scene is ambient.
            rgb = rgb + (1 - alpha)[:, :, None] * (mirror.background - mirror.ambient).astype(np.float32)
        color = _native.display(np.maximum(rgb, 0), options.get("exposure", 0.0), options["tonemap"])
        if not with_alpha:
            return color
        return np.dstack([color, np.floor(np.clip(alpha, 0, 1) * 255 + 0.5).astype(np.uint8)])

    def _segmented(self, mirror: Optional[_Mirror], colors: Mapping[Any, Any], with_alpha: bool) -> Array:
        assert self.picture is not None
        if mirror is None:
            raise InvalidArgument("SEG: a scene of this package has no nodes; use Picture.ids")
        ids = self.picture.ids
        result = np.zeros((*ids.shape, 4 if with_alpha else 3), np.uint8)
        for node, color in colors.items():
            mask = np.isin(ids, mirror.ids_of(node))
            result[mask] = np.broadcast_to(color, 3) if not with_alpha else (*np.broadcast_to(color, 3), 255)
        return result


class _Mirror:
    """A Scene that follows a pyrender.Scene: what stays there stays here."""

    def __init__(self, source: Any) -> None:
        self.source = source
        self.scene = Scene(env=None, default_light=False)
        self.background = self.ambient = np.zeros(3)
        self._objects: Dict[Tuple[int, int, int], Object] = {}
        self._nodes: Dict[int, Any] = {}
        self._geometry: Dict[int, Tuple[Any, int]] = {}
        self._materials: Dict[int, Tuple[Any, Dict[str, Any], int]] = {}
        self._textures: Dict[int, Tuple[Any, int]] = {}

    def update(self, double_sided: bool) -> None:
        seen = set()
        for node in self.source.mesh_nodes:
            world = np.asarray(self.source.get_pose(node))
            for i, primitive in enumerate(node.mesh.primitives if node.mesh.is_visible else ()):
                if primitive.mode != _TRIANGLES:
                    continue
                poses = primitive.poses if primitive.poses is not None else [np.eye(4)]
                for k, pose in enumerate(poses):
                    key = (id(node), i, k)
                    seen.add(key)
                    self._place(key, node, primitive, world @ pose, double_sided)
        for key in set(self._objects) - seen:
            self._objects.pop(key).remove()
        self._set_lights()
        self._set_background()

    def ids_of(self, node: Any) -> List[int]:
        return [shown.surface_id for key, shown in self._objects.items() if key[0] == id(node)]

    def camera(self, size: Tuple[int, int]) -> Camera:
        node = self.source.main_camera_node
        if node is None:
            raise InvalidArgument("the scene has no main camera; add one before rendering")
        camera, pose = node.camera, np.asarray(self.source.get_pose(node))
        near = camera.znear
        far = camera.zfar if camera.zfar is not None else np.inf
        if hasattr(camera, "ymag"):
            return Camera(pose, z_near=near, z_far=far, half_height=camera.ymag)
        if hasattr(camera, "fx"):
            return Camera.from_intrinsics(pose, camera.fx, camera.fy, camera.cx, camera.cy, size, z_near=near, z_far=far)
        return Camera(pose, camera.yfov, near, far)

    def _place(self, key: Tuple[int, int, int], node: Any, primitive: Any, world: Array,
               double_sided: bool) -> None:
        mesh, material = self._mesh(primitive), self._material(primitive, double_sided)
        shown = self._objects.get(key)
        if shown is not None and shown.mesh != mesh:
            shown.remove()
            shown = None
        if shown is None:
            self._nodes[key[0]] = node  # so that no other takes its id()
            self._objects[key] = self.scene.add_instance(mesh, material=material, transform=world, name=node.name or "")
            return
        if shown.material != material:
            shown.material = material
        if not np.array_equal(shown.transform, world):
            shown.transform = world

    def _mesh(self, primitive: Any) -> int:
        known = self._geometry.get(id(primitive))
        if known is None:
            mesh = self.scene.add_geometry(primitive.positions, primitive.indices, primitive.normals,
                                           _flipped(primitive.texcoord_0), colors=primitive.color_0,
                                           tangents=primitive.tangents)
            known = self._geometry[id(primitive)] = (primitive, mesh)
        return known[1]

    def _texture(self, texture: Any, srgb: bool) -> Optional[int]:
        if texture is None or texture.source is None:
            return None
        known = self._textures.get(id(texture))
        if known is None:
            known = self._textures[id(texture)] = (texture, self.scene.add_texture(np.asarray(texture.source), srgb=srgb))
        return known[1]

    def _material(self, primitive: Any, double_sided: bool) -> int:
        source = primitive.material
        fields = self._fields(source, primitive.color_0, double_sided)
        known = self._materials.get(id(source))
        if known is not None and known[1] == fields:
            return known[2]
        if known is None:
            number = self.scene.add_material(**fields)
        else:
            number = known[2]
            self.scene.replace_material(number, **fields)
        self._materials[id(source)] = (source, fields, number)
        return number

    def _alpha_mode(self, source: Any, colors: Optional[Array]) -> str:
        """BLEND is pyrender's default, for what is opaque too, and would be left out of depth."""
        mode = source.alphaMode.lower()
        texels = source.baseColorTexture.source if source.baseColorTexture is not None else None
        has_alpha = [float(source.baseColorFactor[3]) < 1]
        if texels is not None and np.ndim(texels) == 3 and np.shape(texels)[2] == 4:
            has_alpha.append(bool(np.asarray(texels)[..., 3].min() < (255 if np.asarray(texels).dtype == np.uint8 else 1)))
        if colors is not None and np.shape(colors)[1] == 4:
            has_alpha.append(bool(np.min(colors[:, 3]) < 1))
        return "opaque" if mode == "blend" and not any(has_alpha) else mode

    def _fields(self, source: Any, colors: Optional[Array], double_sided: bool) -> Dict[str, Any]:
        fields: Dict[str, Any] = {
            "base_color": tuple(map(float, source.baseColorFactor)), "metallic": float(source.metallicFactor),
            "roughness": float(source.roughnessFactor), "alpha_mode": self._alpha_mode(source, colors),
            "alpha_cutoff": float(source.alphaCutoff), "double_sided": bool(source.doubleSided or double_sided),
            "emissive": tuple(map(float, np.broadcast_to(source.emissiveFactor, 3))),
            "base_color_texture": self._texture(source.baseColorTexture, True),
            "metallic_roughness_texture": self._texture(source.metallicRoughnessTexture, False),
            "normal_texture": self._texture(source.normalTexture, False),
            "occlusion_texture": self._texture(source.occlusionTexture, False),
            "emissive_texture": self._texture(source.emissiveTexture, True),
        }
        fields.update({name: getattr(source, name) for name in _OF_GLASS if hasattr(source, name)})
        return fields

    def _set_lights(self) -> None:
        lights = []
        for node in self.source.light_nodes:
            pose, light = np.asarray(self.source.get_pose(node)), node.light
            kind = {"DirectionalLight": "directional", "PointLight": "point", "SpotLight": "spot"}[type(light).__name__]
            fields: Dict[str, Any] = {"type": kind, "name": node.name or "", "direction": tuple(-pose[:3, 2]),
                                      "position": tuple(pose[:3, 3]),
                                      "intensity": tuple(np.broadcast_to(light.color, 3) * light.intensity)}
            if kind != "directional" and light.range:
                fields["range"] = light.range
            if kind == "spot":
                fields["inner_cone"], fields["outer_cone"] = light.innerConeAngle, light.outerConeAngle
            lights.append(fields)
        self.scene.lights = lights

    def _set_background(self) -> None:
        ambient = np.zeros(3) if self.source.ambient_light is None else np.asarray(self.source.ambient_light, float)[:3]
        color = np.ones(3) if self.source.bg_color is None else np.asarray(self.source.bg_color, float)[:3]
        self.background = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
        if not np.array_equal(ambient, self.ambient):
            self.scene.set_environment(np.broadcast_to(ambient.astype(np.float32), (2, 4, 3)))
        self.ambient = ambient


def _flipped(uv: Optional[Array]) -> Optional[Array]:
    """pyrender's coordinates begin at the bottom left of the image."""
    return None if uv is None else np.stack([uv[:, 0], 1 - uv[:, 1]], -1)
