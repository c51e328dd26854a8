"""Image files and comparisons."""

from __future__ import annotations

import os
from typing import Any, Dict, NamedTuple, Optional, Union

import numpy as np

from ._arrays import Array
from . import _native
from ._errors import InvalidArgument, SceneNotFound
from ._picture import Picture

ImageLike = Union[Picture, str, "os.PathLike[str]", Array]


class Comparison(NamedTuple):
    """metrics: flip, hdr_flip, relmse, relmse_trimmed, psnr, ssim, nonfinite, those that apply (docs/cli.md defines them).
    flip_map: (height, width) float32 of 0..1, or None where a pixel is not finite."""

    metrics: Dict[str, float]
    flip_map: Optional[Array]

    def __getitem__(self, key: Any) -> Any:
        """A metric by name, too."""
        return self.metrics[key] if isinstance(key, str) else tuple.__getitem__(self, key)


def read_image(path: Union[str, "os.PathLike[str]"]) -> Dict[str, Array]:
    """The channels of a `.png`, `.exr` or `.hdr` by name, (height, width) each, top row first.

    R, G and B of a PNG are display values of 0..1, of the others linear radiance.
    """
    planes: Dict[str, Array] = _read(path)[0]
    return planes


def save_png(path: Union[str, "os.PathLike[str]"], rgb: Array) -> None:
    """Writes (height, width, 3) uint8 as a PNG, whole or not at all."""
    _native.write_png(os.fsencode(path), np.ascontiguousarray(rgb))


def compare(test: ImageLike, reference: ImageLike, *, exposure: float = 0.0, tonemap: str = "pbr-neutral") -> Comparison:
    """How far a picture is from a reference, as `sideray compare` says it.

    Both are a Picture, a path, or an array (height, width, 3): floats are linear radiance, uint8 is sRGB. exposure,
    tonemap: how linear ones are shown to the metrics that look at display values.
    """
    (a, a_linear), (b, b_linear) = _rgb(test, "test"), _rgb(reference, "reference")
    if a.shape != b.shape:
        raise InvalidArgument(f"test against reference: shapes {a.shape} and {b.shape} differ; compare images of one size")
    return Comparison(*_native.compare(a, a_linear, b, b_linear, exposure, tonemap))


def _read(path: Union[str, "os.PathLike[str]"]) -> Any:
    name = os.fsdecode(path)
    if not os.path.exists(name):
        raise SceneNotFound(f"cannot read {name}: there is no such file; give a .png, .exr or .hdr")
    return _native.read_image(os.fsencode(name))


def _rgb(image: ImageLike, what: str) -> Any:
    """(height, width, 3) float32, and whether they are linear."""
    if isinstance(image, Picture):
        return image.rgb, True
    if isinstance(image, (str, os.PathLike)):
        planes, linear = _read(image)
        if not all(c in planes for c in "RGB"):
            raise InvalidArgument(f"{os.fspath(image)}: has no channels R, G, B; compare images with them")
        return np.stack([planes[c] for c in "RGB"], -1), linear
    array = np.asarray(image)
    if array.ndim != 3 or array.shape[2] != 3:
        raise InvalidArgument(f"{what}: the array has the shape {array.shape}; give (height, width, 3)")
    if array.dtype == np.uint8:
        return array.astype(np.float32) / np.float32(255), False
    return np.ascontiguousarray(array, np.float32), True
