"""Models of objects as BOP has them: PLY in millimetres, boxes and diameters."""

from __future__ import annotations

from typing import Dict, Optional

import numpy as np

from .._arrays import Array
from .._errors import InvalidArgument


def ply(points: Array, faces: Array, normals: Optional[Array]) -> bytes:
    """points: millimetres."""
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not np.isfinite(points).all():
        raise InvalidArgument(f"positions: the array has the shape {points.shape}; give (n, 3) finite numbers")
    if faces.size and (faces.min() < 0 or faces.max() >= len(points)):
        raise InvalidArgument(f"triangles: numbers from {faces.min()} to {faces.max()}; give 0 to {len(points) - 1}")
    facing = _vertex_normals(points, faces) if normals is None else np.asarray(normals, np.float64)
    if facing.shape != points.shape:
        raise InvalidArgument(f"normals: the array has the shape {facing.shape}; give {points.shape}, that of positions")
    header = ["ply", "format ascii 1.0", f"element vertex {len(points)}",
              *(f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")), f"element face {len(faces)}",
              "property list uchar int vertex_indices", "end_header"]
    vertices = [" ".join(f"{number:.9g}" for number in row) for row in np.concatenate([points, facing], axis=1).astype(np.float32)]
    return ("\n".join([*header, *vertices, *(f"3 {a} {b} {c}" for a, b, c in faces.tolist())]) + "\n").encode()


def info(points: Array) -> Dict[str, float]:
    """Box and diameter, millimetres."""
    low, size = points.min(0), np.ptp(points, axis=0)
    return {"diameter": diameter(points), **{f"min_{c}": float(v) for c, v in zip("xyz", low)},
            **{f"size_{c}": float(v) for c, v in zip("xyz", size)}}


def diameter(points: Array) -> float:
    """The largest distance between two points."""
    reach = np.linalg.norm(points - points.mean(0), axis=1)
    a = points[reach.argmax()]
    b = points[np.linalg.norm(points - a, axis=1).argmax()]
    # Two points that are as far apart as these reach as far from the middle, together; others need not be compared.
    longest = float(np.linalg.norm(a - b))
    far = points[reach >= (longest - reach.max()) * (1 - 1e-9)]
    for first in range(0, len(far), 512):
        apart = np.linalg.norm(far[first:first + 512, None] - far[None, first:], axis=2)
        longest = max(longest, float(apart.max()))
    return longest


def _vertex_normals(points: Array, faces: Array) -> Array:
    """Unit; of the triangles around each vertex, weighted by their areas; (0, 0, 1) where there are none."""
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros_like(points)
    for k in range(3):
        np.add.at(sums, faces[:, k], across)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), (0.0, 0.0, 1.0))
