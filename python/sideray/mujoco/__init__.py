"""MuJoCo's Renderer, drawn by Sideray: a script changes `mujoco.Renderer` into `sideray.mujoco.Renderer`.

It needs the package `mujoco` (3.0 or later) and no OpenGL context of MuJoCo's: neither MUJOCO_GL nor a display. docs/mujoco.md
is the manual.
"""

from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence, Tuple, Union

try:
    import mujoco
except ImportError as _error:
    raise ImportError("sideray.mujoco: the package mujoco is not installed; pip install mujoco") from _error
import numpy as np

from .. import _native
from .._camera import Camera
from .._picture import Picture
from .._renderer import Renderer as _Renderer
from ._mirror import Look, Mirror

__all__ = ["Renderer"]

_FLAG = mujoco.mjtRndFlag


class Renderer:
    """Renders scenes of a model into arrays, as mujoco.Renderer does.

    model, height, width, max_geom, font_scale: as there; the picture may be larger than `offwidth` and `offheight`. Labels
    are not drawn. glass: what is glass, as patterns of names of materials or geoms ("*glass*"), or a mapping from patterns
    to fields of Scene.add_material ({"cup*": {"ior": 1.45}}); of them those whose alpha is below 1 bend light. linear:
    colours of the model are sRGB and the picture is tone mapped, as light works; False: numbers are taken and shown as they
    are, as MuJoCo does. Further keywords are options of sideray.Renderer.render: samples=4, translucency="raytraced", ...
    """

    def __init__(self, model: mujoco.MjModel, height: int = 240, width: int = 320, max_geom: int = 10000,
                 font_scale: Any = None, *, glass: Union[Sequence[str], Mapping[str, Mapping[str, Any]]] = ("*glass*",),
                 linear: bool = False, gl: str = "auto", device: str = "", threads: int = 0, **options: Any) -> None:
        del font_scale  # of labels, which are not drawn
        self._renderer: Optional[_Renderer] = None
        patterns = dict(glass) if isinstance(glass, Mapping) else {pattern: {} for pattern in
                                                                   ((glass,) if isinstance(glass, str) else glass)}
        self._model, self._height, self._width = model, height, width
        self._look = Look(linear, patterns)
        self._options = options
        self._scene = mujoco.MjvScene(model=model, maxgeom=max_geom)
        self._scene_option = mujoco.MjvOption()
        self._renderer = _Renderer(gl, device, threads)
        self._drawn: Optional[Mirror] = None
        self._solid: Optional[Mirror] = None
        self._depth_rendering = self._segmentation_rendering = False
        self._picture: Optional[Picture] = None

    @property
    def model(self) -> mujoco.MjModel:
        """What the renderer was made for."""
        return self._model

    @property
    def scene(self) -> mujoco.MjvScene:
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
        """The last colour picture with all its channels; options such as aov="all" ask for more."""
        return self._picture

    @property
    def objects(self) -> np.ndarray:
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

    def update_scene(self, data: mujoco.MjData, camera: Union[int, str, mujoco.MjvCamera] = -1,
                     scene_option: Optional[mujoco.MjvOption] = None) -> None:
        """Updates what is drawn. camera: a number, a name, an MjvCamera, or -1, the free camera."""
        if not isinstance(camera, mujoco.MjvCamera):
            camera = self._camera_of(camera)
        mujoco.mjv_updateScene(self._model, data, scene_option or self._scene_option, None, camera,
                               mujoco.mjtCatBit.mjCAT_ALL.value, self._scene)

    def render(self, *, out: Optional[np.ndarray] = None) -> np.ndarray:
        """Draws the scene.

        Returns colour, (height, width, 3) uint8; depth, (height, width) float32, world units along the view axis, the far
        plane where there is nothing; or segmentation, (height, width, 2) int32, objid and objtype, (-1, -1) where there is
        nothing. Glass counts in depth and segmentation, as in MuJoCo. out: colour and depth are written there; its shape is
        that of what is returned, for segmentation (height, width, 3), and segmentation is returned in an array of its own.
        """
        if self._renderer is None:
            raise RuntimeError("render cannot be called after close.")
        shape = (self._height, self._width) if self._depth_rendering else (self._height, self._width, 3)
        if out is not None and out.shape != shape:
            raise ValueError(f"Expected `out.shape == {shape}`. Got `out.shape={out.shape}` instead.")
        if not self._has_camera():
            return self._nothing(out)
        if self._segmentation_rendering:
            return self._segmentation()
        drawn = self._depth() if self._depth_rendering else self._color()
        if out is None:
            return drawn
        out[:] = drawn
        return out

    def _has_camera(self) -> bool:
        """False before update_scene(), and where a camera of the model has no place yet, before mj_forward()."""
        eye = self._scene.camera[0]
        return eye.frustum_top != eye.frustum_bottom and bool(np.any(eye.forward) and np.any(eye.up))

    def _nothing(self, out: Optional[np.ndarray]) -> np.ndarray:
        """What MuJoCo draws then: black, the far plane, no object."""
        if self._segmentation_rendering:
            return np.full((self._height, self._width, 2), -1, np.int32)
        far = self._scene.camera[0].frustum_far or self._model.vis.map.zfar * self._model.stat.extent
        drawn = (np.full((self._height, self._width), far, np.float32) if self._depth_rendering
                 else np.zeros((self._height, self._width, 3), np.uint8))
        if out is None:
            return drawn
        out[:] = drawn
        return out

    def close(self) -> None:
        """Gives back the context."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = None

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _camera_of(self, camera: Union[int, str]) -> mujoco.MjvCamera:
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

    def _render(self, mirror: Mirror, options: Mapping[str, Any]) -> Tuple[Picture, Camera]:
        """The picture and its camera."""
        assert self._renderer is not None
        mirror.update(self._scene)
        size = (self._width, self._height)
        camera = mirror.camera(self._scene, size)
        return self._renderer.render(mirror.scene, size, camera, **options), camera

    def _color(self) -> np.ndarray:
        if self._drawn is None:
            self._drawn = Mirror(self._model, self._look, False)
        options = dict(self._options)
        flags = self._scene.flags
        if not flags[_FLAG.mjRND_SHADOW] or not any(l.castshadow for l in self._scene.lights[:self._scene.nlight]):
            options.setdefault("shadows", "off")
        mirrors = flags[_FLAG.mjRND_REFLECTION] and any(g.reflectance > 0 for g in self._scene.geoms[:self._scene.ngeom])
        options.setdefault("reflections", bool(mirrors))
        options.setdefault("ao", False)  # ambient light reaches everything in MuJoCo
        options.setdefault("tonemap", "pbr-neutral" if self._look.linear else "none")
        self._picture, camera = self._render(self._drawn, options)
        rgb = self._with_background(self._picture, self._drawn, camera, bool(flags[_FLAG.mjRND_SKYBOX]))
        if self._look.linear:
            return _native.display(np.maximum(rgb, 0), options.get("exposure", 0.0), options["tonemap"])
        return (np.clip(rgb, 0, 1) * 255 + np.float32(0.5)).astype(np.uint8)

    def _with_background(self, picture: Picture, mirror: Mirror, camera: Camera, shows_sky: bool) -> np.ndarray:
        """What lights the scene from everywhere is not what is seen behind it."""
        clear = 1 - picture["A"].reshape(-1)
        rows = np.nonzero(clear > 0)[0]
        if not len(rows) or (mirror.is_in_sky and shows_sky):
            return picture.rgb
        missing = -mirror.ambient
        if mirror.sky is not None:
            sky = mirror.sky_behind(camera, picture.size, rows)
            missing = -sky if mirror.is_in_sky else sky + missing if shows_sky else missing
        rgb = picture.rgb.copy()
        rgb.reshape(-1, 3)[rows] += clear[rows, None] * missing.astype(np.float32)
        return rgb

    def _solid_picture(self) -> Tuple[Picture, Mirror]:
        if self._solid is None:
            self._solid = Mirror(self._model, self._look, True)
        options = {"translucency": "off", "shadows": "off", "ao": False, "reflections": False}
        return self._render(self._solid, options)[0], self._solid

    def _depth(self) -> np.ndarray:
        picture, _ = self._solid_picture()
        far = np.float32(self._scene.camera[0].frustum_far)
        return np.minimum(picture.depth, far)

    def _segmentation(self) -> np.ndarray:
        picture, mirror = self._solid_picture()
        return mirror.objects[picture.ids]
