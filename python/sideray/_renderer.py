"""Renderers, options by name, devices and queries."""

from __future__ import annotations

import atexit
import difflib
import os
import warnings
import weakref
from typing import TYPE_CHECKING, Any, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from ._arrays import Array
from . import _native
from ._camera import Camera, Vector
from ._convert import ArrayLike
from ._errors import InvalidArgument, Unsupported
from ._objects import Object
from ._picture import Picture
from ._pictures import Pictures, columns_of, groups_of
from ._scene import Scene

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import FrameOptions, RenderOptions
else:
    # The stub is for type checkers alone, and typing.get_type_hints() must find the names, too.
    Unpack, FrameOptions, RenderOptions = Optional, Any, Any

_TABLE: Dict[str, Dict[str, Any]] = {row["name"]: row for row in _native.option_table()}
# Always drawn, so that Picture.depth and Picture.ids are there.
_ALWAYS = ("Z", "id")
# Options of the program that belong to something else here.
_ELSEWHERE = {
    "animation": "sideray.load(path, animation=...)", "variant": "sideray.load(path, variant=...)",
    "default-light": "sideray.load(path, default_light=...)",
    "gl": "sideray.Renderer(gl=...)", "device": "sideray.Renderer(device=...)",
    "threads": "sideray.Renderer(threads=...)", "o": "Picture.save(path)", "frames": "Renderer.frames(scene, frames=...)",
    "fps": "Renderer.frames(scene, fps=...)", "stats": "Picture.stats and Picture.times",
    "compare": "sideray.compare(picture, reference)",
}


def option_names() -> List[str]:
    """The names that Renderer.render takes as keywords, besides its own, in the order of docs/cli.md."""
    return [name.replace("-", "_") for name in _TABLE if name != "size"]


def option(name: str) -> Dict[str, Any]:
    """What an option is: type, choices, minimum, maximum, default, applies (when it has an effect), exact, help."""
    row = _TABLE.get(name.replace("_", "-"))
    if row is None:
        raise _unknown(name)
    return dict(row)


def _unknown(name: str) -> InvalidArgument:
    if name.replace("_", "-") in _ELSEWHERE:
        return InvalidArgument(f"{name}: is not an option of a render; use {_ELSEWHERE[name.replace('_', '-')]}")
    near = difflib.get_close_matches(name.replace("-", "_"), option_names(), 1)
    hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(option_names())}"
    return InvalidArgument(f"{name}: no such option; {hint}")


def _text(row: Dict[str, Any], value: Any) -> str:
    """A value as the command line writes it."""
    if value is None:
        return ""
    if isinstance(value, (bool, np.bool_)):
        if row["type"] == "flag":
            return "true" if value else "false"
        return "on" if value else "off"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return str(int(value)) if row["type"] == "integer" and float(value).is_integer() else repr(float(value))
    if isinstance(value, (tuple, list)):
        return ("x" if row["type"] == "size" else ",").join(str(part) for part in value)
    return str(value)


def _sides(size: Any) -> Tuple[int, int]:
    try:
        width, height = (int(side) for side in size)
    except (TypeError, ValueError):
        raise InvalidArgument(f"size: {size!r} is not (width, height); give for example (1280, 720)") from None
    return width, height


def _options(size: Sequence[int], options: Dict[str, Any]) -> _native.Options:
    chosen = _native.Options()
    for name, value in {"size": tuple(size), **options}.items():
        row = _TABLE.get(name.replace("_", "-"))
        now = _native.option_read_as(name.replace("_", "-"), value if isinstance(value, str) else "")
        if now is not None:
            what = f"{name} {value} is {now}" if now else f"{name} has no effect"
            warnings.warn(f"{what} since 0.3, and is refused from 0.4 on", DeprecationWarning, stacklevel=3)
            if not now:
                continue
        if row is None:
            raise _unknown(name)
        chosen.set(row["name"], _text(row, value))
    chosen.check()
    return chosen


# Contexts are given back before the interpreter is gone, and before others terminate a display that they share.
_open: "weakref.WeakSet[Renderer]" = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    for renderer in list(_open):
        renderer.close()


# An OpenGL driver hangs in the child of a process that has used it; rays alone work there.
_has_used_gl = _is_child_of_gl = False


def _after_fork() -> None:
    global _is_child_of_gl
    _is_child_of_gl = _has_used_gl
    _open.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def _refuse_fork() -> None:
    raise Unsupported("this process was forked from one that uses OpenGL, which works in one of them alone; start workers by "
                      'multiprocessing\'s "spawn", or draw in both with gl="none"')


class Renderer:
    """Draws scenes into pictures, without a window, a display or a GPU.

    gl: "auto" (EGL, then OSMesa, then "none"), "egl", "osmesa" or "none", which draws with rays alone; device: an id from
    sideray.devices(); threads: of the tracer, 0 = all; isa: "sse4.2", "avx2" or "avx512" pins Embree's instruction set. It keeps its OpenGL context until close(), the
    end of a `with` block, or the end of its life. Calls on one renderer from several threads follow each other; those of
    several renderers run at the same time.
    """

    def __init__(self, gl: str = "auto", device: str = "", threads: int = 0, isa: str = "") -> None:
        global _has_used_gl
        if _is_child_of_gl and gl != "none":
            _refuse_fork()
        if not 0 <= threads <= 1024:
            raise InvalidArgument(f"threads: {threads} is out of range; give 1 to 1024, or 0 for all")
        self._renderer = _native.Renderer(gl, device, threads, isa)
        self._process, self._uses_gl = os.getpid(), self._renderer.device()["gl"] != "none"
        _has_used_gl = _has_used_gl or self._uses_gl
        _open.add(self)

    def render(self, scene: Scene, size: Sequence[int] = (1280, 720),
               camera: Union[Camera, str, int, ArrayLike, None] = None, *, eye: Optional[Vector] = None,
               target: Optional[Vector] = None, fov: float = 45.0, time: Optional[float] = None,
               aov: Union[str, Iterable[str]] = (), color: bool = True, repeat: int = 0, continues: bool = False,
               exposure: float = 0.0,
               tonemap: str = "pbr-neutral", ray_traced: Optional[str] = None, env: Union[str, ArrayLike, None] = None,
               env_scale: float = 1.0, env_rotate: float = 0.0, **options: Unpack[RenderOptions]) -> Picture:
        """Draws the scene.

        size: (width, height) in pixels. camera: a Camera, the name or number of one of the file's, a (4, 4) matrix world
        from camera, or None: Scene.camera, else the file's first, else one that frames the scene. eye, target, fov: a
        camera instead of it, as Camera.look_at. time: seconds, sets Scene.time. aov: additional outputs as on the command
        line: "N,albedo", ["N", "albedo"] or "all"; Z and id are always there. color: False leaves colour out, and all that only
        colour needs: depth, ids and `aov` alone are sooner there. repeat: how often the frame is timed, for
        Picture.stats and times. continues: the picture follows the last one that this renderer drew, as the next of a
        sequence. exposure, tonemap: how the picture is going to be shown (Picture.display, Picture.save); radiance stays
        linear. ray_traced: which objects of a file have layers [as quality says]. env, env_scale, env_rotate: as
        Scene.set_environment.

        Further options are those of the command line, with _ for -: quality="draft", translucency="raytraced", layers=4,
        shadows="exact", reflections=True, ambient="bounce", samples=16, reference=True, ... sideray.option_names() lists them,
        sideray.option(name) describes one, docs/cli.md defines them. True and False are on and off; None is the default,
        which quality ("draft", "balanced" or "best") chooses for many.
        """
        self._check(scene)
        if not 0 <= repeat <= 10000:
            raise InvalidArgument(f"repeat: {repeat} is out of range; give 0 to 10000")
        width, height = _sides(size)
        chosen = _options((width, height), dict(options))
        if time is not None:
            scene.set_time(float(time))
        if env is not None or env_scale != 1.0 or env_rotate != 0.0:
            scene.set_environment("sky" if env is None else env, scale=env_scale, rotate=env_rotate)
        view = _view(scene, camera, eye, target, fov, width / height)
        scene._select(_text(_TABLE["ray-traced"], ray_traced) or chosen.get("ray-traced"), view, (width, height))
        scene._commit()
        bits = _native.aov_bits(",".join(_names(aov)), scene._scene, chosen)
        drawn = self._renderer.render(scene._scene, view._fields(), chosen, bits, repeat, continues, exposure, color)
        return Picture(drawn, exposure=exposure, tonemap=tonemap, light_names=tuple(scene._light_names))

    def render_many(self, scene: Scene, cameras: Sequence[Union[Camera, str, int, ArrayLike]],
                    size: Sequence[int] = (1280, 720), *, objects: Sequence[Object] = (), transforms: Optional[ArrayLike] = None,
                    out: Optional[Mapping[str, Array]] = None, aov: Union[str, Iterable[str]] = (),
                    color: bool = True, exposure: float = 0.0, tonemap: str = "pbr-neutral", ray_traced: Optional[str] = None,
                    **options: Unpack[RenderOptions]) -> Pictures:
        """Draws the scene from many cameras at once: each picture has the bits that render() gives it alone.

        cameras: each as in render. size, aov, color, exposure, tonemap, ray_traced, options: as in render, of all pictures;
        `ray_traced` chooses as the first camera sees the scene. objects, transforms: (cameras, objects, 3, 4) or (cameras, objects, 4, 4), world
        from object of each of `objects` in each picture; the scene is left as the last one shows it. Cameras in a row with the
        same transforms are drawn with one update of the scene. out: arrays by the names of channels ("rgb", "Z", "id.surface",
        ...), which are filled and are those of the Pictures returned: (cameras, height, width), with a last dimension for what has
        several parts.

        Without OpenGL (gl="none") small pictures are drawn side by side, one a thread; it is the way to draw thousands of them.
        """
        self._check(scene)
        width, height = _sides(size)
        views = [_view(scene, camera, None, None, 45.0, width / height) for camera in cameras]
        moved = None if transforms is None else columns_of(transforms, len(views), len(objects))
        names = np.array([shown.instance for shown in objects], np.uint32)
        drawn = self._draw_many(scene, views, (width, height), names, moved, aov=aov, color=color, exposure=exposure, tonemap=tonemap,
                                ray_traced=ray_traced, **options)
        if moved is not None:
            for shown, placed in zip(objects, moved[-1]):
                shown._transform = placed
        return Pictures(list(drawn), out) if out else drawn

    def _draw_many(self, scene: Scene, views: Sequence[Camera], size: Tuple[int, int], instances: Array,
                   moved: Optional[Array], lit: Optional[Sequence[Any]] = None, *, aov: Union[str, Iterable[str]] = (), color: bool = True, exposure: float = 0.0,
                   tonemap: str = "pbr-neutral", ray_traced: Optional[str] = None, **options: Any) -> Pictures:
        """As render_many, of instances by their numbers. moved: (cameras, instances, 12), their transforms. lit: the lights of each
        camera, as Scene.lights."""
        if not views:
            return Pictures([])
        width, height = size
        chosen = _options((width, height), options)
        scene._select(_text(_TABLE["ray-traced"], ray_traced) or chosen.get("ray-traced"), views[0], (width, height))
        scene._commit()
        bits = _native.aov_bits(",".join(_names(aov)), scene._scene, chosen)
        placed, lights, ends = groups_of(moved, lit, len(views))
        drawn = self._renderer.render_many(scene._scene, [view._fields() for view in views], chosen, bits, exposure, color, instances,
                                           placed, lights, ends)
        return Pictures([Picture(one, exposure=exposure, tonemap=tonemap, light_names=tuple(scene._light_names)) for one in drawn])

    def frames(self, scene: Scene, frames: Iterable[int], size: Sequence[int] = (1280, 720),
               camera: Union[Camera, str, int, ArrayLike, None] = None, *, fps: float = 30.0,
               **options: Unpack[FrameOptions]) -> Iterator[Picture]:
        """Draws a sequence: frame n is the moment n / fps, and each picture follows the one before.

        Arguments as for render. A camera of the file moves as its animation says.
        """
        if not fps > 0.0:
            raise InvalidArgument(f"fps: {fps} is not above 0; give for example 30")
        before: Optional[int] = None
        for frame in frames:
            follows = before is not None and frame == before + 1
            scene.set_time(frame / fps, before / fps if follows and before is not None else None)
            yield self.render(scene, size, camera, continues=follows, **options)
            before = frame

    def _check(self, scene: Scene) -> None:
        if not isinstance(scene, Scene):
            raise TypeError(f"scene: {type(scene).__name__} is not a sideray.Scene; make one with sideray.load(path) or "
                            "sideray.Scene()")
        if self._uses_gl and self._process != os.getpid():
            _refuse_fork()

    @property
    def device(self) -> Dict[str, str]:
        """id, gl, renderer and version of what it draws with; and reason, where "auto" found no OpenGL: why."""
        return self._renderer.device()

    def cancel(self) -> None:
        """Ends what another thread draws: its call raises Error. Does nothing where nothing is drawn."""
        self._renderer.cancel()

    def close(self) -> None:
        """Gives back the context and everything in it. Pictures that were drawn stay."""
        self._renderer.close()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _names(aov: Union[str, Iterable[str]]) -> List[str]:
    given = aov.split(",") if isinstance(aov, str) else list(aov)
    return [*_ALWAYS, *(name.strip() for name in given if name.strip())]


def _view(scene: Scene, camera: Any, eye: Optional[Vector], target: Optional[Vector], fov: float,
          aspect: float) -> Camera:
    if eye is None and target is None:
        return scene.get_camera(camera, aspect=aspect)
    if camera is not None or eye is None or target is None:
        raise InvalidArgument("eye, target: both are a camera of their own; give both, and no camera")
    return Camera.look_at(eye, target, fov=fov)


def devices() -> List[Dict[str, Any]]:
    """Every way to draw without a window: id, gl, renderer, version, usable, and reason, why it is not."""
    return _native.devices()
