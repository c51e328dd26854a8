"""What a render of many pictures returns."""

from __future__ import annotations

from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union, overload

import numpy as np

from ._arrays import Array, Bytes, Doubles, Floats, Uints
from . import _native
from ._errors import InvalidArgument
from ._picture import Picture


class Pictures(Sequence[Picture]):
    """Pictures of one size with the same channels: `pictures[3]` is a Picture, `pictures["Z"]` that channel of all of them.

    Arrays of all pictures have one more dimension in front: (pictures, height, width), or (pictures, height, width, parts) for
    what is put side by side. They are made once, when they are first asked for, and kept.
    """

    def __init__(self, pictures: Sequence[Picture], out: Optional[Mapping[str, Array]] = None) -> None:
        self._pictures = list(pictures)
        self._stacks: Dict[str, Array] = {}
        for name, array in (out or {}).items():
            self._stacks[name] = self._stacked(name, array)

    @property
    def rgb(self) -> Floats:
        """(pictures, height, width, 3) float32, as Picture.rgb."""
        return self["rgb"]

    @property
    def depth(self) -> Floats:
        """(pictures, height, width) float32, as Picture.depth."""
        return self["Z"]

    @property
    def ids(self) -> Uints:
        """(pictures, height, width) uint32, as Picture.ids."""
        return self["id.surface"]

    @property
    def channels(self) -> List[str]:
        """The names of all channels."""
        return self._pictures[0].channels if self._pictures else []

    def display(self, *, exposure: Optional[float] = None, tonemap: Optional[str] = None) -> Bytes:
        """(pictures, height, width, 3) uint8, as Picture.display."""
        return np.stack([picture.display(exposure=exposure, tonemap=tonemap) for picture in self._pictures])

    @overload
    def __getitem__(self, index: int) -> Picture: ...
    @overload
    def __getitem__(self, index: slice) -> "Pictures": ...
    @overload
    def __getitem__(self, index: str) -> Array: ...

    def __getitem__(self, index: Union[int, slice, str]) -> Union[Picture, "Pictures", Array]:
        if isinstance(index, slice):
            return Pictures(self._pictures[index])
        if not isinstance(index, str):
            return self._pictures[index]
        if index not in self._stacks:
            self._stacks[index] = self._stacked(index, None)
        return self._stacks[index]

    def __len__(self) -> int:
        return len(self._pictures)

    def __iter__(self) -> Iterator[Picture]:
        return iter(self._pictures)

    def __repr__(self) -> str:
        size = "{}x{}".format(*self._pictures[0].size) if self._pictures else "none"
        return f"<sideray.Pictures {len(self)} of {size}: {', '.join(self.channels)}>"

    def _stacked(self, name: str, out: Optional[Array]) -> Array:
        planes = [picture._planes_of(name) for picture in self._pictures]
        if not planes:
            raise InvalidArgument(f"{name}: there is no picture; give cameras")
        if len({plane.dtype.str for plane in planes[0]}) > 1:
            if out is not None:
                raise InvalidArgument(f"out[\"{name}\"]: its parts are of several types; give an array for each of them")
            return np.stack([picture[name] for picture in self._pictures])
        shape: Tuple[int, ...] = (len(planes), *planes[0][0].shape)
        if len(planes[0]) > 1:
            shape += (len(planes[0]),)
        result = np.empty(shape, planes[0][0].dtype) if out is None else out
        if not isinstance(result, np.ndarray) or result.shape != shape or result.dtype != planes[0][0].dtype:
            raise InvalidArgument(f"out[\"{name}\"]: give a numpy array of {planes[0][0].dtype} with the shape {shape}")
        _native.stacked(planes, result)
        return result


def groups_of(poses: Optional[Array], lights: Optional[Sequence[Any]],
              count: int) -> Tuple[Optional[Array], Optional[List[Any]], List[int]]:
    """Cameras in a row that share a pose and lights are drawn together: poses and lights of the groups, and the camera that each
    ends before."""
    def differs(i: int) -> bool:
        return ((poses is not None and not np.array_equal(poses[i], poses[i - 1])) or
                (lights is not None and lights[i] != lights[i - 1]))

    begins = [0] + [i for i in range(1, count) if differs(i)]
    return (None if poses is None else np.ascontiguousarray(poses[begins]),
            None if lights is None else [[{name: value for name, value in light.items() if name != "name"} for light in lights[i]]
                                         for i in begins], [*begins[1:], count])


def columns_of(transforms: Any, cameras: int, objects: int) -> Doubles:
    """(cameras, objects, 12) as the C interface takes transforms, of (cameras, objects, 3 or 4, 4)."""
    given = np.asarray(transforms, np.float64)
    if given.ndim != 4 or given.shape[:2] != (cameras, objects) or given.shape[2:] not in ((3, 4), (4, 4)):
        raise InvalidArgument(f"transforms: the array has the shape {given.shape}; give ({cameras}, {objects}, 3, 4): of each camera "
                              "those of the objects")
    if not np.isfinite(given).all():
        raise InvalidArgument(f"transforms: {int((~np.isfinite(given)).sum())} of {given.size} numbers are not finite; remove or repair "
                              "them")
    return np.ascontiguousarray(given[:, :, :3].swapaxes(2, 3)).reshape(cameras, objects, 12)
