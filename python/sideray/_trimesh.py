"""What trimesh holds, as a Scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Dict, Optional

import numpy as np

from ._arrays import Array
from ._camera import Camera
from ._errors import InvalidArgument

if TYPE_CHECKING:
    from ._scene import Scene

# Fields of trimesh's PBRMaterial and of ours: numbers, then images and whether they hold sRGB.
_TEXTURES = (("baseColorTexture", "base_color_texture", True),
             ("metallicRoughnessTexture", "metallic_roughness_texture", False),
             ("normalTexture", "normal_texture", False), ("occlusionTexture", "occlusion_texture", False),
             ("emissiveTexture", "emissive_texture", True))


def fill(scene: Scene, source: Any, smooth: bool) -> None:
    """Adds the meshes of a trimesh.Trimesh or trimesh.Scene, and takes the Scene's camera."""
    if hasattr(source, "faces"):
        scene.add_instance(_mesh(scene, source, smooth), material=_material(scene, source))
        return
    if not hasattr(source, "graph") or not hasattr(source, "geometry"):
        raise InvalidArgument(f"source: {type(source).__name__}; give a trimesh.Trimesh or a trimesh.Scene")
    known: Dict[str, Any] = {}
    for node in source.graph.nodes_geometry:
        transform, name = source.graph[node]
        geometry = source.geometry[name]
        if not hasattr(geometry, "faces"):
            continue  # paths and points
        if name not in known:
            known[name] = _mesh(scene, geometry, smooth), scene.add_material(**_material(scene, geometry))
        mesh, material = known[name]
        scene.add_instance(mesh, material=material, transform=transform, name=str(node))
    if source.has_camera:
        camera = source.camera
        scene.camera = Camera(source.camera_transform, math.radians(float(camera.fov[1])), float(camera.z_near))


def _mesh(scene: Scene, mesh: Any, smooth: bool) -> int:
    uv = getattr(mesh.visual, "uv", None)
    colors: Optional[Array] = None
    if mesh.visual.kind == "vertex":
        colors = _linear(np.asarray(mesh.visual.vertex_colors))
    elif mesh.visual.kind == "face":
        # A colour of its own needs corners of its own.
        colors = np.repeat(_linear(np.asarray(mesh.visual.face_colors)), 3, axis=0)
        corners = np.asarray(mesh.faces).reshape(-1)
        return scene.add_geometry(mesh.vertices[corners], None, mesh.vertex_normals[corners] if smooth else None,
                                  colors=colors)
    if uv is not None:
        uv = np.stack([uv[:, 0], 1.0 - uv[:, 1]], -1)  # trimesh's begin at the bottom left of the image
    if smooth:
        return scene.add_geometry(mesh.vertices, mesh.faces, mesh.vertex_normals, uv, colors=colors)
    corners = np.asarray(mesh.faces).reshape(-1)
    return scene.add_geometry(mesh.vertices[corners], None, None, None if uv is None else uv[corners],
                              colors=None if colors is None else colors[corners])


def _linear(colors: Array) -> Array:
    """Bytes that trimesh shows as they are, as linear numbers; alpha is linear already."""
    values = colors.astype(np.float64) / 255.0
    values[:, :3] = np.where(values[:, :3] <= 0.04045, values[:, :3] / 12.92, ((values[:, :3] + 0.055) / 1.055) ** 2.4)
    return values


def _material(scene: Scene, mesh: Any) -> Dict[str, Any]:
    material = getattr(mesh.visual, "material", None)
    fields: Dict[str, Any] = {"metallic": 0.0, "roughness": 0.8}
    if material is None:
        if mesh.visual.transparency:
            fields["alpha_mode"] = "blend"
        return fields
    if hasattr(material, "to_pbr"):
        material = material.to_pbr()  # of an .obj or a .ply
    if material.baseColorFactor is not None:
        factor = np.asarray(material.baseColorFactor)
        fields["base_color"] = tuple(map(float, factor / 255.0 if factor.dtype == np.uint8 else factor))
    for theirs, ours in (("metallicFactor", "metallic"), ("roughnessFactor", "roughness"), ("alphaCutoff", "alpha_cutoff")):
        value = getattr(material, theirs, None)
        if value is not None:
            fields[ours] = float(value)
    if material.emissiveFactor is not None:
        fields["emissive"] = tuple(map(float, material.emissiveFactor))
    if material.alphaMode is not None:
        fields["alpha_mode"] = material.alphaMode.lower()
    if material.doubleSided is not None:
        fields["double_sided"] = bool(material.doubleSided)
    for theirs, ours, srgb in _TEXTURES:
        image = getattr(material, theirs, None)
        if image is not None:
            is_plain = image.mode in ("L", "RGB", "RGBA")
            fields[ours] = scene.add_texture(np.asarray(image if is_plain else image.convert("RGBA")), srgb=srgb)
    return fields
