"""LayeredDepth (arXiv 2503.11633): depth of the layers behind glass, and tuples of points in the order of their depth."""

from __future__ import annotations

import os
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np

from .._arrays import Array
from .._errors import InvalidArgument
from .._layered import LayeredDepth
from .._picture import Picture
from . import _files

_LAYERS = 8  # of the published data
_TUPLES = (("pairs", 2), ("trips", 3), ("quads", 4))


class LayeredDepthWriter:
    """Writes pictures with the depth of their layers, as the data of LayeredDepth have them.

    folder: where KEY.image.png, KEY.depth_1.png to KEY.depth_8.png and, where they are asked for, KEY.tuples.json are written: in an
    archive (`tar`) they are a web data set with the columns of the published ones. mm_per_unit: how long the scene's unit is. Depths
    are 16 bits of whole millimetres along the view axis; 0: the pixel has no such layer.
    """

    def __init__(self, folder: Union[str, "os.PathLike[str]"], *, mm_per_unit: float = 1000.0) -> None:
        self._folder = os.fspath(folder)
        self._mm = _files.positive(mm_per_unit, "mm_per_unit")

    def add(self, key: str, rgb: Union[Picture, Array], layers: LayeredDepth, *, tuples: int = 0, seed: int = 0,
            gap: float = 0.01) -> None:
        """Writes one picture.

        key: its name. rgb: a Picture, or (height, width, 3) uint8. layers: of Scene.layered_depth(size, bent=True), which follows
        glass as the published data do; the first eight are written. tuples: as many pairs, triples and quadruples of points are drawn
        at random from `seed`, in the order of their depths, which differ by the share `gap` at least.
        """
        shown = _files.colors(rgb)
        if shown.shape[:2] != layers.z.shape[:2]:
            raise InvalidArgument(f"layers: of a picture of {layers.size}, and rgb is {shown.shape[1]}x{shown.shape[0]}; give both of one "
                                  "size")
        depth = np.zeros((*layers.z.shape[:2], _LAYERS), np.uint16)
        count = min(_LAYERS, layers.layers)
        depth[..., :count] = _files.millimetres(layers.z[..., :count], 1.0, self._mm)
        _files.write_png(self._path(key, "image.png"), shown)
        for k in range(_LAYERS):
            _files.write_png(self._path(key, f"depth_{k + 1}.png"), depth[..., k])
        if tuples:
            rng = np.random.default_rng(seed)
            _files.write_json(self._path(key, "tuples.json"), {
                "layer_all": _draw_tuples(rng, depth, tuples, gap), "layer_first": _draw_tuples(rng, depth[..., :1], tuples, gap)})

    def _path(self, key: str, name: str) -> str:
        return os.path.join(self._folder, f"{key}.{name}")


def _draw_tuples(rng: np.random.Generator, depth: Array, count: int, gap: float) -> Dict[str, List[Dict[str, Any]]]:
    """Points are [x, y, layer], layers from 1 on. Odd ones alone: those are where glass is entered, and what is behind it."""
    # An opaque surface behind an even number of crossings is an odd layer as well.
    odd = depth[..., ::2]
    places = np.argwhere(odd > 0)
    drawn: Dict[str, List[Dict[str, Any]]] = {}
    for name, points in _TUPLES:
        drawn[name] = []
        for _ in range(20 * count if len(places) >= points else 0):  # tries
            if len(drawn[name]) == count:
                break
            one = _tuple_of(places[rng.choice(len(places), points, replace=False)], odd, gap)
            if one:
                drawn[name].append(one)
    return drawn


def _tuple_of(chosen: Array, odd: Array, gap: float) -> Optional[Dict[str, Any]]:
    values = odd[tuple(chosen.T)].astype(np.float64)
    order: Tuple[int, ...] = tuple(np.argsort(values, kind="stable").tolist())
    near = [values[i] for i in order]
    if any(b < a * (1 + gap) or b == a for a, b in zip(near, near[1:])):
        return None
    points = {f"p{n}": [int(chosen[i][1]), int(chosen[i][0]), int(2 * chosen[i][2] + 1)] for n, i in enumerate(order, 1)}
    return {**points, "is_real": True}
