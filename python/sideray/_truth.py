"""Masks of whole objects, and how much of them is visible."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple

import numpy as np

from ._arrays import Bools, Uints
from . import _native
from ._errors import InvalidArgument


@dataclasses.dataclass(frozen=True, eq=False)
class Mask:
    """Pixels of a picture, by their centres.

    size: (width, height) of the picture. box: (x, y, width, height) of the least box around them, pixels from the top left; zeros
    where there are none. area: how many there are. runs: (n,) uint32, their lengths down the columns, outside and inside in
    turn, from outside: the uncompressed run-length encoding of COCO.
    """

    size: Tuple[int, int]
    box: Tuple[int, int, int, int]
    area: int
    runs: Uints

    @property
    def pixels(self) -> Bools:
        """(height, width) bool, top row first."""
        width, height = self.size
        inside = np.arange(len(self.runs)) % 2 == 1
        return np.repeat(inside, self.runs).reshape(width, height).T

    @property
    def coco(self) -> Dict[str, Any]:
        """As COCO's JSON has it: size (height, width) and counts."""
        return {"size": [self.size[1], self.size[0]], "counts": self.runs.tolist()}


@dataclasses.dataclass(frozen=True, eq=False)
class ObjectTruth:
    """One object of a picture.

    object: its number. visible: what is seen of it. amodal: what would be seen of it if there were nothing else. coverage: pixels
    that all of it covers, counted at many places in each pixel. visible_fraction: the visible share of those, 0 to 1.
    """

    object: int
    visible: Mask
    amodal: Mask
    coverage: float
    visible_fraction: float


def pairs(objects: Optional[Mapping[int, Iterable[int]]]) -> Optional[Tuple[Uints, Uints]]:
    """Surface ids, and the object of each."""
    if objects is None:
        return None
    named = [(int(surface), int(number)) for number, surfaces in objects.items() for surface in surfaces]
    if any(value < 0 or value >= 1 << 32 for pair in named for value in pair):
        raise InvalidArgument("objects: numbers and surface ids are 1 to 2^32 - 1; give {number: [surface id, ...]}")
    both = np.array(named, np.uint32).reshape(-1, 2)
    return np.ascontiguousarray(both[:, 0]), np.ascontiguousarray(both[:, 1])


def of_native(found: List[Dict[str, Any]], size: Tuple[int, int]) -> List[ObjectTruth]:
    """What the extension found, as objects."""
    def mask(fields: Dict[str, Any]) -> Mask:
        return Mask(size, fields["box"], fields["area"], fields["runs"])

    return [ObjectTruth(f["object"], mask(f["visible"]), mask(f["amodal"]), f["coverage"], f["visible_fraction"]) for f in found]


def trace(tracer: _native.Tracer, camera: Dict[str, Any], size: Tuple[int, int], samples_per_side: int, through_glass: bool,
          objects: Optional[Mapping[int, Iterable[int]]]) -> List[ObjectTruth]:
    """As Scene.object_truth."""
    named = pairs(objects)
    surfaces, numbers = named if named is not None else (None, None)
    found = tracer.object_truths(camera, size[0], size[1], samples_per_side, through_glass, surfaces, numbers)
    return of_native(found, size)
