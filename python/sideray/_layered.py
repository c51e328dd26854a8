"""Layered depth: every surface behind each pixel."""

from __future__ import annotations

import dataclasses
import enum
from typing import Any, Dict, Tuple

import numpy as np

from ._arrays import Bools, Bytes, Floats, Uints
from . import _native
from ._errors import InvalidArgument


class SurfaceKind(enum.IntEnum):
    """What a surface's material is to a ray, `sideray_surface_kind` of sideray/ground_truth.h.

    MASK: opaque, with holes; BLEND: alpha-blended without transmission; THIN: transmission without thickness; VOLUME: transmission
    and thickness, so that it bends rays. Those from BLEND on are translucent.
    """

    NONE = 0
    OPAQUE = 1
    MASK = 2
    BLEND = 3
    THIN = 4
    VOLUME = 5


class SurfaceFace(enum.IntEnum):
    """Which face of a surface a ray hit, `sideray_surface_face` of sideray/ground_truth.h.

    HIDDEN_BACK: the back of a material that is not double sided; pictures show it only from within glass.
    """

    NONE = 0
    FRONT = 1
    BACK = 2
    HIDDEN_BACK = 3


@dataclasses.dataclass(frozen=True, eq=False)
class LayeredDepth:
    """What each pixel of a picture looks at, the nearest surface first; top row first.

    count: (height, width) uint32, how many layers a pixel has. The others are (height, width, layers), those of vectors with (3,)
    behind it; where a pixel has no such layer, z and distance are +inf and all else is 0.
    z: float32, distance along the view axis, world units; distance: float32, length of the way from the camera (orthographic: from
    the near plane). normal, geometric_normal: float32, unit, world space, on the side that the ray comes from; the shading normal
    and the triangle's. surface_id, instance, primitive (triangle number within the mesh): uint32. kind, face: uint8, a SurfaceKind
    and a SurfaceFace.
    """

    count: Uints
    z: Floats
    distance: Floats
    normal: Floats
    geometric_normal: Floats
    surface_id: Uints
    instance: Uints
    primitive: Uints
    kind: Bytes
    face: Bytes

    @property
    def layers(self) -> int:
        """As many there may be of each pixel."""
        return int(self.z.shape[2])

    @property
    def size(self) -> Tuple[int, int]:
        """(width, height) in pixels."""
        return int(self.z.shape[1]), int(self.z.shape[0])

    @property
    def translucent(self) -> Bools:
        """(height, width, layers) bool: the surface is translucent."""
        return self.kind >= SurfaceKind.BLEND


def trace(tracer: _native.Tracer, camera: Dict[str, Any], size: Tuple[int, int], layers: int, bent: bool) -> LayeredDepth:
    """As Scene.layered_depth."""
    if min(*size, layers) < 1:
        raise InvalidArgument(f"layered_depth: {layers} layers of a picture of {size[0]}x{size[1]}; give numbers above 0")
    return LayeredDepth(**tracer.layered_depth(camera, size[0], size[1], layers, bent))
