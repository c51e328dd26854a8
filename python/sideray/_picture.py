"""What a render returns."""

from __future__ import annotations

import os
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union

import numpy as np

from ._arrays import Array, Bytes, Floats, Uints
from . import _native
from ._errors import InvalidArgument, UnknownChannel


class _Unpickled:
    """What is left of a drawn picture in another process: the channels are arrays of their own."""

    def __init__(self, width: int, height: int, stats: Dict[str, Any], times: Dict[str, Tuple[float, float, float]]) -> None:
        self.width, self.height, self._stats, self._times = width, height, stats, times

    def stats(self) -> Dict[str, Any]:
        return self._stats

    def times(self) -> Dict[str, Tuple[float, float, float]]:
        return self._times


class Picture:
    """A drawn picture: channels as arrays by name, top row first, statistics and times.

    Channels have the shape (height, width) and lie in the picture's own memory: nothing is copied, and each array keeps
    that memory for itself. Arrays of numpy have the buffer protocol and `__dlpack__`, so that
    `torch.from_dlpack(picture["Z"])` copies nothing either. Colours and vectors are planes of their own; `rgb` and the
    groups ("N", "albedo") put them side by side once, in a copy that is kept.
    """

    def __init__(self, drawn: _native.Picture, *, exposure: float = 0.0, tonemap: str = "pbr-neutral",
                 light_names: Tuple[str, ...] = ()) -> None:
        self._drawn: Union[_native.Picture, _Unpickled] = drawn
        self._exposure, self._tonemap = exposure, tonemap
        self._planes: Dict[str, Array] = {_named(name, light_names): plane for name, plane in drawn.channels().items()}
        self._groups: Dict[str, Array] = {}

    def __getstate__(self) -> Dict[str, Any]:
        return {"drawn": (self.width, self.height, self.stats, self.times), "shown": (self._exposure, self._tonemap),
                "planes": self._planes}

    def __setstate__(self, state: Dict[str, Any]) -> None:
        self._drawn = _Unpickled(*state["drawn"])
        self._exposure, self._tonemap = state["shown"]
        self._planes, self._groups = state["planes"], {}

    @property
    def width(self) -> int:
        """Pixels."""
        return self._drawn.width

    @property
    def height(self) -> int:
        """Pixels."""
        return self._drawn.height

    @property
    def size(self) -> Tuple[int, int]:
        """(width, height) in pixels."""
        return self.width, self.height

    @property
    def rgb(self) -> Floats:
        """(height, width, 3) float32: linear Rec.709 radiance, without exposure and tone mapping."""
        return self._stacked("rgb", ("R", "G", "B"))

    @property
    def rgba(self) -> Floats:
        """(height, width, 4) float32: rgb, and 1 minus the product of transmittances over the background."""
        return self._stacked("rgba", ("R", "G", "B", "A"))

    @property
    def depth(self) -> Floats:
        """(height, width) float32: distance along the view axis of what is opaque, world units; +inf where it is nothing."""
        return self["Z"]

    @property
    def ids(self) -> Uints:
        """(height, width) uint32: surface id of what is opaque; 0 where it is nothing."""
        return self["id.surface"]

    @property
    def channels(self) -> List[str]:
        """The names of all channels."""
        return list(self._planes)

    @property
    def stats(self) -> Dict[str, Any]:
        """Counters by the names of `sideray_render_stats` (sideray/renderer.h); with `repeat` above 0 at render."""
        return self._drawn.stats()

    @property
    def times(self) -> Dict[str, Tuple[float, float, float]]:
        """Milliseconds of each stage by name: first quartile, median, third quartile over the repeats."""
        return self._drawn.times()

    def __getitem__(self, name: str) -> Array:
        """A channel, or the channels of an additional output side by side.

        "Z" and "N.X" are (height, width), "N" is (height, width, 3). Where the parts are of different types
        ("layer0": colour, distance, surface id) the array has a field for each: picture["layer0"]["distance"]. "layers"
        is all layers, (layers, height, width).
        """
        plane = self._planes.get(name)
        return plane if plane is not None else self._group(name)

    def __contains__(self, name: object) -> bool:
        return name in self._planes or (isinstance(name, str) and (bool(self._parts(name)) or self._is_layers(name)))

    def __iter__(self) -> Iterator[str]:
        return iter(self._planes)

    def __len__(self) -> int:
        return len(self._planes)

    def keys(self) -> List[str]:
        """The names of all channels."""
        return self.channels

    def display(self, *, exposure: Optional[float] = None, tonemap: Optional[str] = None) -> Bytes:
        """(height, width, 3) uint8: sRGB of tonemap(2^exposure * rgb), as the program writes a PNG.

        exposure: stops; tonemap: none, reinhard, aces, aces-filmic or pbr-neutral. Where they are not given they are those
        of the render.
        """
        return _native.display(self.rgb, self._exposure if exposure is None else exposure,
                               self._tonemap if tonemap is None else tonemap)

    def save(self, path: Any, *, exposure: Optional[float] = None, tonemap: Optional[str] = None) -> None:
        """Writes the picture whole or not at all. `.png`: as display() shows it; `.exr`: every channel, linear."""
        name = os.fsdecode(path)
        kind = os.path.splitext(name)[1].lower()
        if kind == ".exr":
            _native.write_exr(os.fsencode(name), self._planes)
        elif kind == ".png":
            _native.write_png(os.fsencode(name), self.display(exposure=exposure, tonemap=tonemap))
        else:
            raise InvalidArgument(f"{name}: pictures are written as .png or .exr; give one of them, or write Picture.rgb yourself")

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Array:
        """The picture is its rgb for numpy."""
        return self.rgb.astype(dtype, copy=bool(copy)) if dtype is not None else self.rgb

    def _repr_png_(self) -> bytes:
        return _native.encode_png(self.display())

    def __repr__(self) -> str:
        return f"<sideray.Picture {self.width}x{self.height}: {', '.join(self._planes)}>"

    def _planes_of(self, name: str) -> List[Array]:
        """The channels that a name stands for, as they lie in memory."""
        own = [name] if name in self._planes else self._parts(name)
        parts = {"rgb": ["R", "G", "B"], "rgba": ["R", "G", "B", "A"]}.get(name, own)
        if not parts:
            self._made_group(name)  # says that there is none
        return [self[part] for part in parts]

    def _stacked(self, name: str, parts: Tuple[str, ...]) -> Array:
        if name not in self._groups:
            self._groups[name] = _native.interleaved([self[part] for part in parts])
        return self._groups[name]

    def _parts(self, name: str) -> List[str]:
        return [channel for channel in self._planes if channel.startswith(name + ".")]

    def _is_layers(self, name: str) -> bool:
        return name == "layers" and bool(self._parts("layer0"))

    def _group(self, name: str) -> Array:
        if name not in self._groups:
            self._groups[name] = self._made_group(name)
        return self._groups[name]

    def _made_group(self, name: str) -> Array:
        if self._is_layers(name):
            count = next(k for k in range(1, 1000) if not self._parts(f"layer{k}"))
            return np.stack([self[f"layer{k}"] for k in range(count)])
        parts = self._parts(name)
        if not parts:
            if name in ("R", "G", "B", "A"):
                raise UnknownChannel(f"{name}: the picture was drawn without colours; render with color=True")
            raise UnknownChannel(f"{name}: the picture has no such channel; it has {', '.join(self._planes)}; render with "
                                 f"aov=\"{name}\" where that is an additional output")
        planes = [self._planes[part] for part in parts]
        if len({plane.dtype.str for plane in planes}) == 1:
            return _native.interleaved(planes)
        fields = np.empty(planes[0].shape, [(part[len(name) + 1:], plane.dtype) for part, plane in zip(parts, planes)])
        for part, plane in zip(parts, planes):
            fields[part[len(name) + 1:]] = plane
        return fields


def _named(channel: str, light_names: Tuple[str, ...]) -> str:
    """The library counts the lights of its masks; whatever knows their names puts them there."""
    group, _, part = channel.partition(".")
    if group in ("shadow", "hitdist") and part.isdigit() and int(part) < len(light_names):
        return f"{group}.{light_names[int(part)]}"
    return channel
