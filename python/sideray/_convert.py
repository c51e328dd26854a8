"""What callers give, as the C interface takes it."""

from __future__ import annotations

import os
from typing import Any, Dict, Mapping, Optional, Union

import numpy as np

from . import _native
from ._arrays import Array
from ._camera import matrix
from ._errors import InvalidArgument, SceneNotFound

ArrayLike = Any  # what numpy.asarray takes
MaterialLike = Union[int, Mapping[str, Any], None]


def transform_columns(transform: Optional[ArrayLike]) -> Array:
    """Twelve numbers, column by column, as the C interface takes them."""
    return matrix(np.eye(4) if transform is None else transform, "transform")[:3].T.ravel()


def array(values: ArrayLike, dtype: Any, what: str) -> Array:
    try:
        given = np.asarray(values)
        if np.issubdtype(dtype, np.unsignedinteger):
            if given.size and not np.issubdtype(given.dtype, np.integer) and not (given == np.floor(given)).all():
                raise InvalidArgument(f"{what}: the array holds {given.dtype} with fractions; give whole numbers")
            if given.size and (given.min() < 0 or given.max() > np.iinfo(dtype).max):
                raise InvalidArgument(f"{what}: numbers from {given.min()} to {given.max()} are out of range; "
                                      f"give 0 to {np.iinfo(dtype).max}")
        result = np.ascontiguousarray(given, dtype)
        if np.issubdtype(dtype, np.floating) and not np.isfinite(result).all():
            raise InvalidArgument(f"{what}: {int((~np.isfinite(result)).sum())} of {result.size} numbers are not finite; "
                                  "remove or repair them")
        return result
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, InvalidArgument):
            raise
        raise InvalidArgument(f"{what}: {error}; give an array of numbers") from None


def mesh_arrays(positions: ArrayLike, triangles: Optional[ArrayLike] = None, normals: Optional[ArrayLike] = None,
                 uv: Optional[ArrayLike] = None, uv1: Optional[ArrayLike] = None, colors: Optional[ArrayLike] = None,
                 tangents: Optional[ArrayLike] = None) -> _native.MeshArrays:
    def optional(values: Optional[ArrayLike], dtype: Any, what: str) -> Optional[Array]:
        return None if values is None else array(values, dtype, what)

    rgba = optional(colors, np.float32, "colors")
    if rgba is not None and rgba.ndim == 2 and rgba.shape[1] == 3:
        rgba = np.concatenate([rgba, np.ones((len(rgba), 1), np.float32)], axis=1)
    return _native.MeshArrays(
        array(positions, np.float32, "positions"), optional(triangles, np.uint32, "triangles"),
        optional(normals, np.float32, "normals"), optional(tangents, np.float32, "tangents"),
        optional(uv, np.float32, "uv"), optional(uv1, np.float32, "uv1"), rgba)


def texels(image: ArrayLike) -> Array:
    """(height, width, 4) uint8 of an image with 1, 3 or 4 channels, of uint8 or of floats 0..1."""
    given = np.asarray(image)
    if given.dtype != np.uint8:
        given = np.floor(np.clip(np.nan_to_num(np.asarray(given, np.float64)), 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
    if given.ndim == 2:
        given = given[:, :, None]
    if given.ndim != 3 or given.shape[2] not in (1, 3, 4):
        raise InvalidArgument(f"image: the array has the shape {given.shape}; give (height, width) or (height, width, 1, 3 "
                              "or 4)")
    if given.shape[2] == 1:
        given = np.repeat(given, 3, axis=2)
    if given.shape[2] == 3:
        given = np.concatenate([given, np.full_like(given[:, :, :1], 255)], axis=2)
    return np.ascontiguousarray(given)


def material_fields(fields: Mapping[str, Any]) -> Dict[str, Any]:
    """base_color of three numbers is opaque; a mapping with None leaves a field at its default."""
    given = {name: value for name, value in fields.items() if value is not None}
    color = given.get("base_color")
    if color is not None and np.shape(color) == (3,):
        given["base_color"] = (*color, 1.0)
    return given


def lat_long(path: str) -> Array:
    if not os.path.exists(path):
        raise SceneNotFound(f"env: there is no file {path}; give \"sky\", \"none\", or a lat-long .exr or .hdr")
    planes, _ = _native.read_image(os.fsencode(path))
    if not all(c in planes for c in "RGB"):
        raise InvalidArgument(f"{path}: has no channels R, G, B; use a lat-long colour image")
    return np.stack([planes[c] for c in "RGB"], -1)
