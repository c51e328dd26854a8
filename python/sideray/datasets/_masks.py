"""Masks in the forms of COCO: compressed run lengths, and polygons."""

from __future__ import annotations

from typing import Dict, List, Set, Tuple

import numpy as np

from .._arrays import Array

Point = Tuple[int, int]
# Steps along the grid lines between pixels, each a right turn of the one before; y is downward.
_TURNS = ((1, 0), (0, 1), (-1, 0), (0, -1))


def compressed(runs: Array) -> str:
    """COCO's text of run lengths: groups of five bits, the lowest first, each of which says whether more follow. From the fourth on,
    a length is told as the difference to the one two before it."""
    lengths = [int(length) for length in runs]
    text = []
    for i, length in enumerate(lengths):
        rest = length - lengths[i - 2] if i > 2 else length
        more = True
        while more:
            group = rest & 31
            rest >>= 5
            more = rest != (-1 if group & 16 else 0)
            text.append(chr(48 + group + (32 if more else 0)))
    return "".join(text)


def polygons(mask: Array) -> List[List[int]]:
    """Outlines of a (height, width) bool mask along the edges of its pixels, [x, y, x, y, ...] from the top left corner of the
    picture. A part that is connected by the sides of pixels has one outline. Its holes are in it too, joined by a cut that is gone
    along forth and back: whoever counts crossings (even-odd, as pycocotools does) finds every pixel of the mask and no other."""
    rings = _rings(mask)
    outer = [ring for ring in rings if _doubled_area(ring) > 0]
    joined: Dict[int, List[Point]] = {i: list(ring) for i, ring in enumerate(outer)}
    for hole in (ring for ring in rings if _doubled_area(ring) < 0):
        around = min((i for i, ring in enumerate(outer) if _contains(ring, _inside(hole))),
                     key=lambda i: _doubled_area(outer[i]))
        joined[around] += [outer[around][0], *hole, hole[0]]
    return [[coordinate for point in ring for coordinate in point] for ring in joined.values()]


def _rings(mask: Array) -> List[List[Point]]:
    """Corners of closed outlines, with the mask on the right hand: parts clockwise as seen, holes the other way."""
    steps = _border_steps(mask)
    rings = []
    while steps:
        start = next(iter(steps))
        at, way, ring = start, next(iter(steps[start])), []
        first = way
        while True:
            steps[at].discard(way)
            if not steps[at]:
                del steps[at]
            at = (at[0] + _TURNS[way][0], at[1] + _TURNS[way][1])
            ways = steps.get(at, ())
            # Where two pixels touch at a corner alone, the right turn stays with the same one.
            onward = next((w for w in ((way + 1) % 4, way, (way + 3) % 4) if w in ways), first)
            if onward != way:
                ring.append(at)
            if at == start and onward == first and onward not in ways:
                break
            way = onward
        rings.append(ring)
    return rings


def _border_steps(mask: Array) -> Dict[Point, Set[int]]:
    """From which corners which steps go along the mask, in the order of rows."""
    padded = np.pad(mask, 1)
    inner = padded[1:-1, 1:-1]
    steps: Dict[Point, Set[int]] = {}
    # Of each pixel the side that a step follows, where the neighbour beyond it is outside; and the corner that it starts at.
    sides = ((padded[:-2, 1:-1], 0, (0, 0)), (padded[1:-1, 2:], 1, (1, 0)), (padded[2:, 1:-1], 2, (1, 1)),
             (padded[1:-1, :-2], 3, (0, 1)))
    for beyond, way, (right, down) in sides:
        rows, columns = np.nonzero(inner & ~beyond)
        for y, x in zip(rows.tolist(), columns.tolist()):
            steps.setdefault((x + right, y + down), set()).add(way)
    return steps


def _doubled_area(ring: List[Point]) -> int:
    """Above 0 where it is clockwise as seen."""
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1]))


def _inside(hole: List[Point]) -> Tuple[float, float]:
    """The middle of a pixel in a hole: its highest row's first, whose corner is the least."""
    x, y = min(hole, key=lambda point: (point[1], point[0]))
    return x + 0.5, y + 0.5


def _contains(ring: List[Point], point: Tuple[float, float]) -> bool:
    px, py = point
    crossed = False
    for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1]):
        if x0 == x1 and x0 > px and min(y0, y1) < py < max(y0, y1):
            crossed = not crossed
    return crossed
