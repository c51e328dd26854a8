"""MuJoCo's Renderer, drawn by Sideray: a script changes `mujoco.Renderer` into `sideray.mujoco.Renderer`.

It needs the package `mujoco` (3.0 or later) and no OpenGL context of MuJoCo's: neither MUJOCO_GL nor a display. docs/mujoco.md
is the manual.
"""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union, cast

import numpy as np

from ._untyped import MjData, MjModel, MjvCamera, MjvOption, MjvScene, mujoco  # first: says that it is not installed
from .. import _native
from .._arrays import Array, Bytes, Ints
from .._camera import Camera
from .._picture import Picture
from .._pictures import Pictures
from .._renderer import Renderer as _Renderer
from ._light import Backdrop
from ._look import Look
from ._mirror import Mirror
from ._view import camera_of

__all__ = ["Renderer"]

_FLAG = mujoco.mjtRndFlag


class Renderer:
    """Renders scenes of a model into arrays, as mujoco.Renderer does.

    model, height, width, max_geom, font_scale: as there; the picture may be larger than `offwidth` and `offheight`. Labels
    are not drawn. glass: what is glass, as patterns of names of materials or geoms ("*glass*"), or a mapping from patterns
    to fields of Scene.add_material ({"cup*": {"ior": 1.45}}); of them those whose alpha is below 1 bend light. linear:
    colours of the model are sRGB and the picture is tone mapped, as light works; False: numbers are taken and shown as they
    are, as MuJoCo does. gl: "none" draws with rays alone, the same bits on every machine, in forked processes too; others as in
    sideray.Renderer. batch: how many states of the model are drawn at once, for vectors of environments; 0: one, and arrays
    have no dimension for it. Further keywords are options of sideray.Renderer.render: samples=4, translucency="raytraced", ...
    """

    def __init__(self, model: MjModel, height: int = 240, width: int = 320, max_geom: int = 10000,
                 font_scale: Any = None, *, glass: Union[Sequence[str], Mapping[str, Mapping[str, Any]]] = ("*glass*",),
                 linear: bool = False, gl: str = "none", device: str = "", threads: int = 0, batch: int = 0,
                 **options: Any) -> None:
        del font_scale  # of labels, which are not drawn
        self._renderer: Optional[_Renderer] = None
        patterns = dict(glass) if isinstance(glass, Mapping) else {pattern: {} for pattern in
                                                                   ((glass,) if isinstance(glass, str) else glass)}
        if batch < 0:
            raise ValueError(f"batch: {batch}; give the number of states, or 0 for one without a dimension of its own")
        self._model, self._height, self._width, self._batch = model, height, width, batch
        self._states: Sequence[MjData] = ()
        self._update: Any = None  # what update_scene() was called with
        self._look = Look(linear, patterns, surrounded=options.get("ambient") not in (None, False, "off"))
        self._options = options
        self._scene = mujoco.MjvScene(model=model, maxgeom=max_geom)
        self._scene_option = mujoco.MjvOption()
        self._renderer = _Renderer(gl, device, threads)
        self._drawn: Optional[Mirror] = None
        self._solid: Optional[Mirror] = None
        self._round: Optional[Mirror] = None  # solid, with the shapes of what is drawn
        self._depth_rendering = self._segmentation_rendering = False
        self._pictures: Optional[Pictures] = None
        self._seen: Optional[Tuple[Optional[Pictures], Pictures, Mirror]] = None  # of colour pictures, their first surfaces

    @property
    def model(self) -> MjModel:
        """What the renderer was made for."""
        return self._model

    @property
    def scene(self) -> MjvScene:
        """What is drawn: update_scene fills it, and a script may add geoms and change flags before render."""
        return self._scene

    @property
    def height(self) -> int:
        """Pixels."""
        return self._height

    @property
    def width(self) -> int:
        """Pixels."""
        return self._width

    @property
    def picture(self) -> Optional[Picture]:
        """The last colour picture with all its channels; options such as aov="all" ask for more. With `batch`, the first."""
        return self._pictures[0] if self._pictures is not None else None

    @property
    def pictures(self) -> Optional[Pictures]:
        """The last colour pictures, one of each state."""
        return self._pictures

    @property
    def objects(self) -> Ints:
        """(n, 2) int32: objid and objtype of each surface id of `picture`, (-1, -1) for 0, which is the background."""
        return self._drawn.objects if self._drawn is not None else np.full((1, 2), -1, np.int32)

    def enable_depth_rendering(self) -> None:
        """render() returns depth from now on."""
        self._segmentation_rendering, self._depth_rendering = False, True

    def disable_depth_rendering(self) -> None:
        """render() returns colour from now on."""
        self._depth_rendering = False

    def enable_segmentation_rendering(self) -> None:
        """render() returns objid and objtype from now on."""
        self._segmentation_rendering, self._depth_rendering = True, False

    def disable_segmentation_rendering(self) -> None:
        """render() returns colour from now on."""
        self._segmentation_rendering = False

    def update_scene(self, data: Union[MjData, Sequence[MjData]],
                     camera: Union[int, str, MjvCamera, Sequence[Union[int, str, MjvCamera]]] = -1,
                     scene_option: Optional[MjvOption] = None) -> None:
        """Updates what is drawn. camera: a number, a name, an MjvCamera, or -1, the free camera.

        With `batch`: data is a sequence of so many states, camera is one for all of them or a sequence, and `scene` is that of the
        first state.
        """
        states = list(data) if self._batch else [data]
        if self._batch and len(states) != self._batch:
            raise ValueError(f"update_scene: {len(states)} states for a batch of {self._batch}; give one for each picture")
        is_many = self._batch and not isinstance(camera, (int, str, mujoco.MjvCamera))
        cameras: List[Any] = list(cast(Sequence[Any], camera)) if is_many else [camera] * len(states)
        if len(cameras) != len(states):
            raise ValueError(f"update_scene: {len(cameras)} cameras for a batch of {self._batch}; give one, or one for each picture")
        chosen = [one if isinstance(one, mujoco.MjvCamera) else self._camera_of(one) for one in cameras]
        self._states, self._update = states, (chosen, scene_option or self._scene_option)
        self._show(0)

    def _show(self, number: int) -> None:
        """Makes `scene` that of a state."""
        cameras, option = self._update
        mujoco.mjv_updateScene(self._model, self._states[number], option, None, cameras[number], mujoco.mjtCatBit.mjCAT_ALL.value,
                               self._scene)

    def render(self, *, out: Optional[Array] = None) -> Array:
        """Draws the scene.

        Returns colour, (height, width, 3) uint8; depth, (height, width) float32, world units along the view axis, the far
        plane where there is nothing; or segmentation, (height, width, 2) int32, objid and objtype, (-1, -1) where there is
        nothing. Glass counts in depth and segmentation, as in MuJoCo. out: colour and depth are written there; its shape is
        that of what is returned, for segmentation (height, width, 3), and segmentation is returned in an array of its own. With
        `batch` all shapes have it in front.
        """
        if self._renderer is None:
            raise RuntimeError("render cannot be called after close.")
        shape = self._shape if self._depth_rendering else (*self._shape, 3)
        if out is not None and out.shape != shape:
            raise ValueError(f"Expected `out.shape == {shape}`. Got `out.shape={out.shape}` instead.")
        if not self._has_camera():
            drawn = self._nothing(self._channel)
        elif self._channel == "rgb":
            drawn = self._color()
        else:
            drawn = self._depth_or_segmentation(self._channel)
        if out is None or self._channel == "segmentation":
            return drawn
        out[:] = drawn
        return out

    def render_channels(self, channels: Sequence[str] = ("rgb", "depth", "segmentation")) -> Dict[str, Array]:
        """Draws one picture and returns several channels of it, each as render() returns it, by name.

        It takes little longer than colour alone. Depth and segmentation are of colour's shapes, which are rounder than those that
        render() draws for them alone, and have objects of a script's own and markers, too.
        """
        if self._renderer is None:
            raise RuntimeError("render_channels cannot be called after close.")
        for name in channels:
            if name not in ("rgb", "depth", "segmentation"):
                raise ValueError(f"channels: {name!r} is none; give some of 'rgb', 'depth' and 'segmentation'")
        if not self._has_camera():
            return {name: self._nothing(name) for name in channels}
        drawn: Dict[str, Array] = {"rgb": self._color()} if "rgb" in channels else {}
        others = [name for name in channels if name != "rgb"]
        if others:
            pictures, mirror = self._surfaces(bool(drawn))
            drawn.update({name: self._shown_surfaces(name, pictures, mirror) for name in others})
        return {name: drawn[name] for name in channels}

    def _surfaces(self, has_color: bool) -> Tuple[Pictures, Mirror]:
        """Pictures of the first surfaces of what colour shows: those of colour, where all of it is opaque and seen through the
        middle of each pixel."""
        if has_color and self._drawn and self._pictures and not self._drawn.shows_through and self._options.get("samples", 1) == 1:
            return self._pictures, self._drawn
        if has_color and self._seen and self._seen[0] is self._pictures:
            return self._seen[1:]
        if self._round is None:
            self._round = Mirror(self._model, self._look, is_solid=True, is_round=True)
        self._round.update(self._scene)
        self._seen = self._pictures, self._render(self._round, {"color": False})[0], self._round
        return self._seen[1:]

    def _shown_surfaces(self, channel: str, pictures: Pictures, mirror: Mirror) -> Array:
        if channel == "segmentation":
            objects: Array = mirror.objects[self._of(pictures, "id.surface")]
            return objects
        depth: Array = np.minimum(self._of(pictures, "Z"), np.float32(self._scene.camera[0].frustum_far))
        return depth

    @property
    def _channel(self) -> str:
        return "depth" if self._depth_rendering else "segmentation" if self._segmentation_rendering else "rgb"

    @property
    def _shape(self) -> Tuple[int, ...]:
        return (self._batch, self._height, self._width) if self._batch else (self._height, self._width)

    def _of(self, pictures: Pictures, name: str) -> Array:
        """A channel in the shape that this renderer returns."""
        return pictures[name] if self._batch else pictures[0][name]

    def _has_camera(self) -> bool:
        """False before update_scene(), and where a camera of the model has no place yet, before mj_forward()."""
        eye = self._scene.camera[0]
        return eye.frustum_top != eye.frustum_bottom and bool(np.any(eye.forward) and np.any(eye.up))

    def _nothing(self, channel: str) -> Array:
        """What MuJoCo draws then: black, the far plane, no object."""
        if channel == "segmentation":
            return np.full((*self._shape, 2), -1, np.int32)
        if channel == "rgb":
            return np.zeros((*self._shape, 3), np.uint8)
        far = self._scene.camera[0].frustum_far or self._model.vis.map.zfar * self._model.stat.extent
        return np.full(self._shape, far, np.float32)

    def close(self) -> None:
        """Gives back the context."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = None

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _camera_of(self, camera: Union[int, str]) -> MjvCamera:
        number = camera
        if isinstance(number, str):
            number = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_CAMERA.value, number)
            if number == -1:
                raise ValueError(f'The camera "{camera}" does not exist.')
        if number < -1 or number >= self._model.ncam:
            raise ValueError(f"The camera id {number} is out of range [-1, {self._model.ncam}).")
        chosen = mujoco.MjvCamera()
        chosen.fixedcamid = number
        if number == -1:
            chosen.type = mujoco.mjtCamera.mjCAMERA_FREE
            mujoco.mjv_defaultFreeCamera(self._model, chosen)
        else:
            chosen.type = mujoco.mjtCamera.mjCAMERA_FIXED
        return chosen

    def _cameras(self) -> Tuple[List[Camera], Array, Array]:
        """Of each state; where they are and where they look as the scene has it, (states, 3) each."""
        size = (self._width, self._height)
        cameras, eyes, forwards = [], [], []
        for number, (state, chosen) in enumerate(zip(self._states, self._update[0])):
            if number > 0:
                mujoco.mjv_updateCamera(self._model, state, chosen, self._scene)
            cameras.append(camera_of(self._scene, size))
            eyes.append(np.array(self._scene.camera[0].pos))
            forwards.append(np.array(self._scene.camera[0].forward))
        if len(self._states) > 1:
            mujoco.mjv_updateCamera(self._model, self._states[0], self._update[0][0], self._scene)
        return cameras, np.array(eyes), np.array(forwards)

    def _render(self, mirror: Mirror, options: Mapping[str, Any]) -> Tuple[Pictures, List[Camera]]:
        """A picture of each state, and its camera. The mirror shows the first one."""
        assert self._renderer is not None
        size, (cameras, eyes, forwards) = (self._width, self._height), self._cameras()
        if len(cameras) == 1:
            return Pictures([self._renderer.render(mirror.scene, size, cameras[0], **options)]), cameras
        lights = None if mirror.is_solid else mirror.lights.of_states(self._scene, self._states, forwards)
        if mirror.moves_alone(self._states, eyes) and (mirror.is_solid or lights is not None):
            names, poses = mirror.poses(self._states, eyes)
            return self._renderer._draw_many(mirror.scene, cameras, size, names, poses, lights, **options), cameras
        pictures = [self._renderer.render(mirror.scene, size, cameras[0], **options)]
        for number in range(1, len(cameras)):
            self._show(number)
            mirror.update(self._scene)
            pictures.append(self._renderer.render(mirror.scene, size, cameras[number], **options))
        self._show(0)
        return Pictures(pictures), cameras

    def _color(self) -> Array:
        if self._drawn is None:
            self._drawn = Mirror(self._model, self._look, is_solid=False, is_round=True)
        self._drawn.update(self._scene)
        options = dict(self._options)
        flags = self._scene.flags
        if not flags[_FLAG.mjRND_SHADOW] or not any(l.castshadow for l in self._scene.lights[:self._scene.nlight]):
            options.setdefault("shadows", "off")
        mirrors = flags[_FLAG.mjRND_REFLECTION] and any(g.reflectance > 0 for g in self._scene.geoms[:self._scene.ngeom])
        options.setdefault("reflections", bool(mirrors))
        options.setdefault("ambient", False)  # ambient light reaches everything in MuJoCo
        options.setdefault("tonemap", "pbr-neutral" if self._look.linear else "none")
        self._pictures, cameras = self._render(self._drawn, options)
        backdrop = self._drawn.surroundings.backdrop(bool(flags[_FLAG.mjRND_SKYBOX]))
        hazes = self._hazes(cameras)
        shown = [self._shown(*of_one, backdrop, options) for of_one in zip(self._pictures, cameras, hazes)]
        return np.stack(shown) if self._batch else shown[0]

    def _hazes(self, cameras: Sequence[Camera]) -> List[Optional[Dict[str, Any]]]:
        """What each picture shows of the haze around an endless plane: in pixels in which nothing else is seen."""
        assert self._drawn is not None
        flags, size = self._scene.flags, (self._width, self._height)
        has_haze = flags[_FLAG.mjRND_HAZE] and flags[_FLAG.mjRND_SKYBOX] and self._drawn.surroundings.sky is not None
        if not has_haze or not any(self._drawn.haze(self._scene, camera, size) for camera in cameras):
            return [None] * len(cameras)
        pictures, mirror = self._surfaces(has_color=True)
        hazes = [mirror.haze(self._scene, camera, size) for camera in cameras]
        return [None if haze is None else {**haze, "surfaces": picture.ids} for haze, picture in zip(hazes, pictures)]

    def _shown(self, picture: Picture, camera: Camera, haze: Optional[Dict[str, Any]], backdrop: Backdrop,
               options: Mapping[str, Any]) -> Array:
        rgb = _native.with_backdrop([picture[name] for name in "RGBA"], backdrop, camera._directions(picture.size),
                                    picture.stats["threads"], haze, as_bytes=not self._look.linear)
        if self._look.linear:
            return _native.display(np.maximum(rgb, 0), options.get("exposure", 0.0), options["tonemap"])
        return rgb

    def _depth_or_segmentation(self, channel: str) -> Array:
        if self._solid is None:
            self._solid = Mirror(self._model, self._look, is_solid=True, is_round=False)
        self._solid.update(self._scene)
        return self._shown_surfaces(channel, self._render(self._solid, {"color": False})[0], self._solid)
