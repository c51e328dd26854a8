"""Scenes: from arrays, from files, or both."""

from __future__ import annotations

import os
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _layered, _native, _truth
from ._arrays import Array
from ._camera import Camera, matrix
from ._convert import ArrayLike, MaterialLike, array, lat_long, material_fields, mesh_arrays, texels, transform_columns
from ._errors import InvalidArgument
from ._objects import VISIBLE_ALL, Object, Particles

# The light of files and scenes without one, as the program has it.
_DEFAULT_SUN = {"type": "directional", "direction": (-0.4, -0.8, -0.45), "intensity": (3.0, 3.0, 3.0),
                "angular_diameter_deg": 0.53}


class Scene:
    """What is drawn: meshes, objects, materials, textures, lights and surroundings.

    Space is right-handed, in any unit (call it metre), +Y up by default; colours are linear Rec.709. One thread edits a
    scene at a time; what was edited counts from the next render or query on, without a call.

    env: surroundings, as for set_environment. default_light: a scene without lights has a sun.
    """

    def __init__(self, *, env: Union[str, ArrayLike, None] = "sky", env_scale: float = 1.0, env_rotate: float = 0.0,
                 default_light: bool = True) -> None:
        self._scene = _native.Scene()
        self._content: Optional[_native.Content] = None
        self._tracer: Optional[_native.Tracer] = None
        self._default_material: Optional[int] = None
        self._default_light = default_light
        self._lights: List[Dict[str, Any]] = []
        self._light_names: List[str] = []
        self._next_id, self._time = 1, 0.0
        self._is_dirty, self._lights_changed, self._has_objects = True, default_light, False
        self._ray_traced = "auto"
        #: Names of objects by surface id.
        self.names: Dict[int, str] = {}
        #: The camera of renders that name none; None: the file's first, or one that frames the scene.
        self.camera: Optional[Camera] = None
        self.set_environment(env, scale=env_scale, rotate=env_rotate)

    # ---- what is in it ----

    @classmethod
    def from_trimesh(cls, source: Any, *, smooth: bool = True, **surroundings: Any) -> Scene:
        """A scene of a trimesh.Trimesh or trimesh.Scene: meshes, transforms, materials, textures, colours, the camera.

        smooth: with trimesh's normals at vertices; False: flat faces. surroundings: as for Scene(). Colours of vertices and
        faces are read as sRGB. Paths and points are left out, and lights are Sideray's.
        """
        from ._trimesh import fill
        scene = cls(**surroundings)
        fill(scene, source, smooth)
        return scene

    def add_mesh(self, positions: ArrayLike, triangles: Optional[ArrayLike] = None, normals: Optional[ArrayLike] = None,
                 uv: Optional[ArrayLike] = None, *, uv1: Optional[ArrayLike] = None, colors: Optional[ArrayLike] = None,
                 tangents: Optional[ArrayLike] = None, material: MaterialLike = None,
                 transform: Optional[ArrayLike] = None, surface_id: Optional[int] = None, name: str = "",
                 visibility: int = VISIBLE_ALL) -> Object:
        """Adds a mesh and shows it once: add_geometry and add_instance.

        positions: (n, 3), object space; triangles: (m, 3) whole numbers below n, counter-clockwise faces front, or None:
        every three vertices are a triangle; normals: (n, 3) of unit length, or None: flat shading; uv, uv1: (n, 2), origin
        at the top left of the image; colors: (n, 3) or (n, 4), linear, multiplied onto base_color; tangents: (n, 4), w is
        the sign of the bitangent. material: what add_material returned, or a mapping of its fields, or None: white.
        transform: (4, 4) world from object, mirroring allowed. surface_id: unique, above 0; None: the next that is free.
        Everything is copied.
        """
        mesh = self.add_geometry(positions, triangles, normals, uv, uv1=uv1, colors=colors, tangents=tangents)
        return self.add_instance(mesh, material=material, transform=transform, surface_id=surface_id, name=name,
                                 visibility=visibility)

    def add_geometry(self, positions: ArrayLike, triangles: Optional[ArrayLike] = None,
                     normals: Optional[ArrayLike] = None, uv: Optional[ArrayLike] = None, *,
                     uv1: Optional[ArrayLike] = None, colors: Optional[ArrayLike] = None,
                     tangents: Optional[ArrayLike] = None) -> int:
        """Adds a mesh that nothing shows yet, and returns its number for add_instance. Arrays as for add_mesh."""
        arrays = mesh_arrays(positions, triangles, normals, uv, uv1, colors, tangents)
        return self._edited().add_mesh(arrays)[0]

    def replace_geometry(self, mesh: int, positions: ArrayLike, triangles: Optional[ArrayLike] = None,
                         normals: Optional[ArrayLike] = None, uv: Optional[ArrayLike] = None, *,
                         uv1: Optional[ArrayLike] = None, colors: Optional[ArrayLike] = None,
                         tangents: Optional[ArrayLike] = None) -> None:
        """Gives a mesh another shape; everything that shows it changes with it. Arrays as for add_mesh."""
        self._edited().replace_mesh(mesh, mesh_arrays(positions, triangles, normals, uv, uv1, colors, tangents))

    def set_vertices(self, mesh: int, positions: ArrayLike, normals: Optional[ArrayLike] = None,
                     uv: Optional[ArrayLike] = None, *, uv1: Optional[ArrayLike] = None,
                     colors: Optional[ArrayLike] = None, tangents: Optional[ArrayLike] = None) -> None:
        """Moves the vertices of a mesh, as many as it has; its triangles stay, which is faster than replace_geometry."""
        self._edited().set_vertices(mesh, mesh_arrays(positions, None, normals, uv, uv1, colors, tangents))

    def remove_geometry(self, mesh: int) -> None:
        """Removes a mesh that nothing shows; one that is shown is refused."""
        self._edited().remove_mesh(mesh)

    def add_instance(self, mesh: int, *, material: MaterialLike = None, transform: Optional[ArrayLike] = None,
                     surface_id: Optional[int] = None, name: str = "", visibility: int = VISIBLE_ALL) -> Object:
        """Shows a mesh in one more place. Arguments as for add_mesh."""
        placed, number = transform_columns(transform), self._material(material)
        given = self._next_id if surface_id is None else int(surface_id)

        def one(value: int) -> Array:
            return array([value], np.uint32, "surface_id")

        names = self._edited().add_instances(one(mesh), one(number), placed[None], one(given), one(visibility))
        self._next_id, self._has_objects = max(self._next_id, given + 1), True
        if name:
            self.names[given] = name
        return Object(self, int(names[0]), mesh, number, given, visibility, placed)

    def move(self, objects: Sequence[Object], transforms: ArrayLike) -> None:
        """Moves many objects in one call. transforms: (n, 4, 4) or (n, 3, 4), world from object."""
        placed = array(transforms, np.float64, "transforms")
        if placed.ndim != 3 or len(placed) != len(objects) or placed.shape[1:] not in ((4, 4), (3, 4)):
            raise InvalidArgument(f"transforms: the array has the shape {placed.shape}; give ({len(objects)}, 4, 4)")
        columns = np.ascontiguousarray(placed[:, :3].transpose(0, 2, 1)).reshape(len(objects), 12)
        self._edited().move_instances(np.array([o.instance for o in objects], np.uint32), columns)
        for moved, column in zip(objects, columns):
            moved._transform = column

    def add_material(self, **fields: Any) -> int:
        """Adds a material and returns its number.

        Fields are those of `sideray_material_desc` (sideray/scene.h), glTF's metallic-roughness model: base_color (4,)
        linear, metallic, roughness 0..1, emissive (3,) radiance, alpha_mode "opaque", "mask" or "blend", alpha_cutoff,
        blend_mode, double_sided, unlit, transmission 0..1, ior, thickness (world units; above 0 the mesh is a solid that
        bends light), attenuation_distance, attenuation_color, clearcoat, ... Textures: base_color_texture=t and so on, t
        from add_texture, or a mapping of texture, uv_set, wrap_u, wrap_v ("repeat", "clamp", "mirror"), filter
        ("trilinear", "bilinear", "nearest"), texture_from_uv (6,).
        """
        return self._edited().add_material(material_fields(fields))

    def replace_material(self, material: int, **fields: Any) -> None:
        """Gives a material other properties; fields that are not given have their defaults."""
        self._edited().replace_material(material, material_fields(fields))

    def remove_material(self, material: int) -> None:
        """Removes a material that nothing uses; one that is used is refused."""
        self._edited().remove_material(material)

    def add_texture(self, image: ArrayLike, *, srgb: bool = True) -> int:
        """Adds a texture and returns its number for materials.

        image: (height, width, 1, 3 or 4), top row first, uint8, or floats of 0..1. srgb: RGB goes through the transfer
        function of sRGB, as colours do; False for roughness, normals and other numbers.
        """
        return self._edited().add_texture(texels(image), srgb)

    def replace_texture(self, texture: int, image: ArrayLike, *, srgb: bool = True) -> None:
        """Gives a texture other texels. As for add_texture."""
        self._edited().replace_texture(texture, texels(image), srgb)

    def remove_texture(self, texture: int) -> None:
        """Removes a texture that nothing uses; one that is used is refused."""
        self._edited().remove_texture(texture)

    def add_light(self, type: str = "directional", *, name: str = "", **fields: Any) -> None:
        """Adds a light: "directional", "point" or "spot".

        position (3,): point and spot; direction (3,): the way the light travels, directional and spot; intensity (3,) or
        one number: irradiance of directional ones, radiant intensity of others; range: world units, 0 = unlimited;
        inner_cone, outer_cone: half angles in radians; radius: world units, angular_diameter_deg: of soft shadows by
        rays. The first light takes the place of the sun that scenes without one have.
        """
        self.lights = [*self._lights, {"type": type, "name": name, **fields}]

    @property
    def lights(self) -> List[Dict[str, Any]]:
        """All lights, as mappings of what add_light takes. Assign a list to replace them."""
        return [dict(light, name=name) for light, name in zip(self._lights, self._light_names)]

    @lights.setter
    def lights(self, lights: Sequence[Mapping[str, Any]]) -> None:
        fields = [dict(light) for light in lights]
        names = [light.pop("name", "") for light in fields]
        for light in fields:
            if np.isscalar(light.get("intensity")):
                light["intensity"] = (light["intensity"],) * 3
        self._scene.set_lights(fields)
        self._lights, self._light_names = fields, [n or f"light{i}" for i, n in enumerate(names)]
        self._is_dirty, self._lights_changed = True, not fields and self._default_light

    def set_environment(self, env: Union[str, ArrayLike, None], *, scale: float = 1.0, rotate: float = 0.0) -> None:
        """Sets the surroundings.

        env: "sky", which is built in; "none" or None; the path of a lat-long `.exr` or `.hdr`; or an array (height, width,
        3) of linear radiance, top row (+Y) first, its middle in the direction -Z, u growing toward +X. scale: factor on
        radiance. rotate: degrees, counter-clockwise about +Y seen from above.
        """
        if env is None or (isinstance(env, str) and env == "none"):
            rgb = None
        elif isinstance(env, str) and env == "sky":
            rgb = _native.sky()
        elif isinstance(env, (str, os.PathLike)):
            rgb = lat_long(os.fspath(env))
        else:
            rgb = array(env, np.float32, "env")
        self._edited().set_environment(rgb, scale, rotate)

    def add_particles(self, *, texture: int = 0, columns: int = 1, rows: int = 1, blend_mode: str = "alpha",
                      soft_distance: float = 0.0, lit: bool = False) -> Particles:
        """Adds a system of sprites; Particles.set says where they are.

        texture: 0 = white; columns, rows: cells of its flip-book; blend_mode: "alpha", "premultiplied", "additive";
        soft_distance: world units over which sprites fade before opaque surfaces; lit: colours are albedo, not radiance.
        """
        fields = {"texture": texture, "columns": columns, "rows": rows, "blend_mode": blend_mode,
                  "soft_distance": soft_distance, "lit": lit}
        self._has_objects = True
        return Particles(self, self._edited().add_particles(fields))

    def __repr__(self) -> str:
        parts = [f"{len(self.names)} named objects", f"{len(self._lights)} lights", f"{len(self.cameras)} cameras",
                 f"{len(self.animations)} animations"]
        return f"<sideray.Scene: {', '.join(parts)}, at {self._time:g} s>"

    # ---- what a file says ----

    @property
    def warnings(self) -> List[str]:
        """What was read from the file otherwise than it is written: one line each."""
        return self._content.warnings if self._content else []

    @property
    def cameras(self) -> List[str]:
        """The names of the file's cameras, "" where it gives none."""
        return self._content.cameras if self._content else []

    @property
    def animations(self) -> List[str]:
        """The names of the file's animations."""
        return self._content.animations if self._content else []

    @property
    def variants(self) -> List[str]:
        """The variants of the file's materials (KHR_materials_variants), which load(variant=...) takes."""
        return self._content.variants if self._content else []

    @property
    def time(self) -> float:
        """The moment that is shown, in seconds. Assign another to move what the file's animation moves."""
        return self._time

    @time.setter
    def time(self, time: float) -> None:
        self.set_time(time)

    def set_time(self, time: float, previous: Optional[float] = None) -> None:
        """Moves what the file's animation moves. previous: seconds of the picture before, for motion vectors."""
        before = time if previous is None else previous
        for moment in (time, before):
            if not abs(moment) <= 1e9:
                raise InvalidArgument(f"time {moment}: give seconds from -1e9 to 1e9")
        if self._content is None:
            self._scene.set_time(time, before)
        elif (time, before) != (self._time, self._time):
            self._content.move(self._scene, time, before)
            # The file's lights may have moved; what was added to them stays.
            own = self._lights[len(self._content.light_names):]
            if own:
                self.lights = [*self._file_lights(), *own]
            else:
                self._lights = self._content.lights
        self._is_dirty, self._time = True, time

    def get_camera(self, camera: Union[Camera, str, int, ArrayLike, None] = None, *, aspect: float = 16 / 9) -> Camera:
        """The camera that render(camera=...) takes for a name or a number of the file's, a Camera, a matrix, or None.

        None: Scene.camera, else the file's first, else one that frames the scene in a picture of this width / height.
        """
        if isinstance(camera, Camera):
            return camera
        if camera is None and self.camera is not None:
            return self.camera
        if camera is None:
            return self._first_camera(aspect)
        if isinstance(camera, (str, int, np.integer)):
            return self._camera_of_file(camera if isinstance(camera, str) else int(camera), aspect)
        return Camera(matrix(camera, "camera"))

    # ---- what it is ----

    @property
    def bounds(self) -> Optional[Tuple[Array, Array]]:
        """Lowest and highest corner in world space, (3,) each; None where the scene is empty."""
        self._commit()
        corners = self._scene.bounds()
        return (np.array(corners[0]), np.array(corners[1])) if corners else None

    @property
    def facts(self) -> Dict[str, Any]:
        """Counts of what is in it: triangles, instances, materials, translucent_objects, lit_lights, ..."""
        self._commit()
        return self._scene.facts()

    def trace_rays(self, origins: ArrayLike, directions: ArrayLike, *, t_near: ArrayLike = 0.0,
                   t_far: ArrayLike = np.inf, layers: int = 1, translucent: bool = False) -> Array:
        """The nearest surfaces along rays, without OpenGL.

        origins: (..., 3) world; directions: (..., 3), need not be of unit length: distances are in their lengths; both
        broadcast against each other, t_near and t_far against their rays. layers: 1 to 64 hits of a ray. translucent:
        of translucent surfaces instead of opaque ones.

        Returns an array of the rays' shape, with (layers,) behind it where there is more than one, and the fields
        distance (+inf: nothing), normal (3,; geometric, unit, on the side of the front face), barycentric (2,; weights of
        the second and third vertex), surface_id (0: nothing), instance, primitive (triangle number within the mesh).
        """
        from_, along = np.broadcast_arrays(np.asarray(origins, np.float64), np.asarray(directions, np.float32))
        if from_.ndim == 0 or from_.shape[-1] != 3:
            raise InvalidArgument(f"origins and directions have the shape {from_.shape} together; give (..., 3)")
        shape = from_.shape[:-1]

        def spread(values: ArrayLike) -> Array:
            return np.ascontiguousarray(np.broadcast_to(np.asarray(values, np.float32), shape)).reshape(-1)

        hits = self._committed_tracer().trace_rays(from_.reshape(-1, 3), along.reshape(-1, 3), spread(t_near),
                                                   spread(t_far), translucent, layers)
        return hits.reshape(shape if layers == 1 else (*shape, layers))

    def object_truth(self, size: Sequence[int], camera: Union[Camera, str, int, ArrayLike, None] = None, *,
                     samples_per_side: int = 4, through_glass: bool = False,
                     objects: Optional[Mapping[int, Iterable[int]]] = None) -> List[_truth.ObjectTruth]:
        """Visible and amodal masks, boxes and coverage of every object, without OpenGL (docs/ground-truth.md).

        size: (width, height) in pixels. camera: as for Renderer.render. samples_per_side: fractions are counted at this
        square of places in each pixel, 1 to 16. through_glass: opaque surfaces alone hide what is straight behind them.
        objects: {number: [surface id, ...]}, which surfaces are one object; without it each surface is an object of its id.
        Returns all objects, ascending by number, those out of sight too.
        """
        width, height = int(size[0]), int(size[1])
        view = self.get_camera(camera, aspect=width / height)
        return _truth.trace(self._committed_tracer(), view._fields(), (width, height), samples_per_side, through_glass, objects)

    def layered_depth(self, size: Sequence[int], camera: Union[Camera, str, int, ArrayLike, None] = None, *, layers: int = 8,
                      bent: bool = False) -> _layered.LayeredDepth:
        """Every surface that each pixel looks at, opaque and translucent in one order, without OpenGL (docs/ground-truth.md).

        size: (width, height) in pixels. camera: as for Renderer.render. layers: 1 to 64, as many are kept of each pixel, the
        nearest. bent: along the path that light takes, which volumes refract and which ends at the first opaque surface;
        otherwise along the straight ray, through everything.
        """
        width, height = int(size[0]), int(size[1])
        view = self.get_camera(camera, aspect=width / height)
        return _layered.trace(self._committed_tracer(), view._fields(), (width, height), int(layers), bent)

    # ---- for the package ----

    def _committed_tracer(self) -> _native.Tracer:
        self._commit()
        if self._tracer is None:
            self._tracer = _native.Tracer(self._scene, 0, "")
        return self._tracer

    def _edited(self) -> _native.Scene:
        self._is_dirty = True
        return self._scene

    def _commit(self) -> None:
        if not self._is_dirty:
            return
        self._is_dirty = False
        if self._lights_changed and not self._lights:
            self._scene.set_lights([_DEFAULT_SUN] if self._default_light else [])
            self._lights_changed = False
        self._scene.commit()

    def _select(self, selection: str, camera: Camera, size: Tuple[int, int]) -> None:
        """Which translucent objects of the file have layers (`--ray-traced`)."""
        if self._content is None:
            if selection not in ("auto", "all"):
                raise InvalidArgument(f"ray_traced: \"{selection}\" chooses among the objects of a file, and this scene "
                                      "is made of arrays; set the visibility of its objects")
        elif selection != self._ray_traced or selection.startswith("largest:"):
            self._commit()
            self._content.select(self._scene, selection, camera._fields(), *size)
            self._ray_traced = selection

    def _fill(self, content: _native.Content) -> None:
        self._content = content
        content.fill(self._scene, "auto", content.camera(0, 16 / 9), 1280, 720)
        self.names = dict(enumerate(content.objects, 1))
        self._next_id = len(content.objects) + 1
        self._lights, self._light_names, self._lights_changed = content.lights, content.light_names, False
        self._is_dirty = True

    def _file_lights(self) -> List[Dict[str, Any]]:
        assert self._content
        return [dict(light, name=name) for light, name in zip(self._content.lights, self._content.light_names)]

    def _material(self, material: MaterialLike) -> int:
        if isinstance(material, Mapping):
            return self.add_material(**material)
        if material is not None:
            return int(material)
        if self._default_material is None:
            self._default_material = self.add_material()
        return self._default_material

    def _first_camera(self, aspect: float) -> Camera:
        if self._content and (self._content.cameras or not self._has_objects):
            return Camera._of_fields(self._content.camera(0, aspect))
        return self._framing_camera(aspect)

    def _framing_camera(self, aspect: float) -> Camera:
        """As docs/cli.md (Camera) defines it."""
        corners = self.bounds
        low, high = corners if corners else (-np.ones(3), np.ones(3))
        center, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low)) or 1.0
        half = 0.5 * np.radians(45.0)
        distance = 1.05 * radius / np.sin(min(half, np.arctan(np.tan(half) * aspect)))
        direction = np.array([1.0, 0.6, 1.4])
        eye = center + distance * direction / np.linalg.norm(direction)
        return Camera.look_at(eye, center, z_near=0.5 * (distance - radius))

    def _camera_of_file(self, camera: Union[str, int], aspect: float) -> Camera:
        names = self.cameras
        if isinstance(camera, str) and camera in names:
            return Camera._of_fields(self._content.camera(names.index(camera), aspect))  # type: ignore[union-attr]
        index = int(camera) if isinstance(camera, int) or camera.isdigit() else -1
        if 0 <= index < len(names):
            return Camera._of_fields(self._content.camera(index, aspect))  # type: ignore[union-attr]
        known = ", ".join(repr(name) for name in names) or "none"
        raise InvalidArgument(f"camera {camera!r}: no such camera; the scene has {len(names)}: {known}")
