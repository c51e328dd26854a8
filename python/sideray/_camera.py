"""Cameras."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Dict, Optional, Sequence, Tuple, Union

import numpy as np

from ._arrays import Array, Doubles, Floats
from ._errors import InvalidArgument

Vector = Union[Sequence[float], Array]  # of three numbers


def matrix(transform: Any, what: str) -> Doubles:
    """A transform of shape (4, 4) or (3, 4) as float64 of shape (4, 4). Refuses others, naming `what`."""
    try:
        given = np.asarray(transform, np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape not in ((4, 4), (3, 4)):
        raise InvalidArgument(f"{what}: the array has the shape {given.shape}; give (4, 4) or (3, 4), "
                              "which columns are multiplied by")
    if not np.isfinite(given).all():
        raise InvalidArgument(f"{what}: holds numbers that are not finite")
    full = np.eye(4)
    full[:3] = given[:3]
    return full


def _vector(values: Vector, what: str) -> Doubles:
    try:
        given = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != (3,) or not np.isfinite(given).all():
        raise InvalidArgument(f"{what}: {values!r}; give three finite numbers")
    return given


@dataclasses.dataclass(frozen=True, eq=False)
class Camera:
    """Where pictures are seen from.

    world_from_camera: (4, 4), rigid: the camera looks along its -Z, +Y is up.
    yfov: full vertical angle, radians; of perspective cameras.
    half_height: world units from the middle of the picture to its upper edge; given: the camera is orthographic.
    z_near, z_far: world units along the view axis, > 0; z_far = inf: there is none (perspective only).
    fx_per_fy: focal length in pixels along rows by that along columns, 0.001 to 1000; 1: pixels are square.
    shift: the principal point from the middle of the picture, right in widths and down in heights of the picture.
    """

    world_from_camera: Doubles = dataclasses.field(default_factory=lambda: np.eye(4))
    yfov: float = math.radians(45.0)
    z_near: float = 0.1
    z_far: float = math.inf
    half_height: Optional[float] = None
    fx_per_fy: float = 1.0
    shift: Tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "world_from_camera", matrix(self.world_from_camera, "world_from_camera"))
        if self.half_height is None and not 0.0 < self.yfov < math.pi:
            raise InvalidArgument(f"yfov: {math.degrees(self.yfov):g} degrees; give more than 0 and less than 180")
        if self.half_height is not None and not 0.0 < self.half_height < math.inf:
            raise InvalidArgument(f"half_height: {self.half_height}; give a finite length above 0")
        if not 1e-3 <= self.fx_per_fy <= 1e3:
            raise InvalidArgument(f"fx_per_fy: {self.fx_per_fy}; give 0.001 to 1000")
        try:
            right, down = (float(part) for part in self.shift)
        except (TypeError, ValueError):
            right = down = math.nan
        if not (abs(right) <= 100.0 and abs(down) <= 100.0):
            raise InvalidArgument(f"shift: {self.shift!r}; give two numbers, -100 to 100 widths and heights of the picture")
        object.__setattr__(self, "shift", (right, down))

    @classmethod
    def look_at(cls, eye: Vector, target: Vector = (0.0, 0.0, 0.0), *, fov: float = 45.0,
                up: Vector = (0.0, 1.0, 0.0), z_near: Optional[float] = None, z_far: float = math.inf,
                half_height: Optional[float] = None) -> Camera:
        """A camera at `eye` that looks at `target`; world units. fov: full vertical angle in degrees.

        up: world direction that is upward in the picture; along the view it counts as (0, 0, -1), or (0, 1, 0). z_near: a hundredth of
        the distance to the target, at most 0.1, where it is not given.
        """
        from_, to = _vector(eye, "eye"), _vector(target, "target")
        distance = float(np.linalg.norm(from_ - to))
        back = (from_ - to) / distance if distance > 0 else np.array([0.0, 0.0, 1.0])
        above = _vector(up, "up")
        if not np.linalg.norm(above) > 0.0:
            raise InvalidArgument("up: has no length; give a direction")
        above = above / np.linalg.norm(above)
        if abs(back @ above) > 0.999999:
            # Along the view: any other direction will do.
            above = np.array([0.0, 0.0, -1.0 if back[1] > 0 else 1.0]) if abs(back[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
        right = np.cross(above, back)
        right /= np.linalg.norm(right)
        world = np.eye(4)
        world[:3, 0], world[:3, 1], world[:3, 2], world[:3, 3] = right, np.cross(back, right), back, from_
        near = z_near if z_near is not None else min(0.1, 0.01 * distance) or 0.1
        return cls(world, math.radians(fov), near, z_far, half_height)

    @classmethod
    def from_intrinsics(cls, world_from_camera: Any, fx: float, fy: float, cx: float, cy: float,
                        size: Tuple[int, int], *, z_near: float = 0.1, z_far: float = math.inf) -> Camera:
        """A pinhole camera of computer vision: any fx, fy and principal point.

        fx, fy, cx, cy: pixels, measured from the outer corner of the top left pixel; size: (width, height) of the picture.
        world_from_camera: looks along -Z with +Y up; from OpenCV's (+Z, +Y down) multiply it by diag(1, -1, -1, 1).
        """
        width, height = size
        for name, value in (("fx", fx), ("fy", fy), ("size", width), ("size", height)):
            if not 0.0 < value < math.inf:
                raise InvalidArgument(f"{name}: {value}; give a finite number of pixels above 0")
        for name, value in (("cx", cx), ("cy", cy)):
            if not math.isfinite(value):
                raise InvalidArgument(f"{name}: {value}; give a finite number of pixels")
        return cls(world_from_camera, 2.0 * math.atan(0.5 * height / fy), z_near, z_far, fx_per_fy=fx / fy,
                   shift=(cx / width - 0.5, cy / height - 0.5))

    def intrinsics(self, size: Tuple[int, int]) -> Doubles:
        """The pinhole's (3, 3) matrix of a picture of this (width, height): pixels from the outer corner of the top left pixel.

        From the middle of that pixel, as OpenCV counts, cx and cy are half a pixel less. Orthographic cameras have none.
        """
        if self.half_height is not None:
            raise InvalidArgument("intrinsics: the camera is orthographic, and has no focal length; give a perspective one")
        width, height = size
        fy = 0.5 * height / math.tan(0.5 * self.yfov)
        return np.array([[fy * self.fx_per_fy, 0.0, (0.5 + self.shift[0]) * width], [0.0, fy, (0.5 + self.shift[1]) * height],
                         [0.0, 0.0, 1.0]])

    def rays(self, size: Tuple[int, int]) -> Tuple[Doubles, Floats]:
        """Rays through the centres of the pixels of a picture of this (width, height), top row first.

        Returns origins, (height, width, 3) float64, and directions, the same in float32, both in world space. A
        direction's length along the view axis is 1: distances along the ray are depths.
        """
        width, height = size
        half = math.tan(0.5 * self.yfov) if self.half_height is None else self.half_height
        right, down = self.shift
        x = 2.0 * ((np.arange(width) + 0.5) / width - 0.5 - right) * half * width / (height * self.fx_per_fy)
        y = 2.0 * (0.5 + down - (np.arange(height) + 0.5) / height) * half
        across, up = np.meshgrid(x, y)
        zero, world = np.zeros_like(across), self.world_from_camera
        if self.half_height is None:
            local = np.stack([across, up, zero - 1.0], -1)
            return np.broadcast_to(world[:3, 3], local.shape).copy(), (local @ world[:3, :3].T).astype(np.float32)
        start = np.stack([across, up, zero], -1) @ world[:3, :3].T + world[:3, 3]
        return start, np.broadcast_to(-world[:3, 2], start.shape).astype(np.float32)

    def _directions(self, size: Tuple[int, int]) -> Tuple[Doubles, Doubles, Doubles]:
        """Of the top left pixel's centre, and what is added for each column and each row."""
        width, height = size
        world = self.world_from_camera[:3, :3]
        if self.half_height is not None:
            return -world[:, 2], np.zeros(3), np.zeros(3)
        pixel = 2.0 * math.tan(0.5 * self.yfov) / height
        right, down = self.shift
        corner = np.array([pixel / self.fx_per_fy * (0.5 - width * (0.5 + right)), pixel * (height * (0.5 + down) - 0.5), -1.0])
        return world @ corner, world @ [pixel / self.fx_per_fy, 0.0, 0.0], world @ [0.0, -pixel, 0.0]

    def _fields(self) -> Dict[str, Any]:
        """As the extension takes it."""
        return {
            "world_from_camera": self.world_from_camera[:3].T.ravel(),
            "orthographic": self.half_height is not None,
            "yfov": self.yfov,
            "half_height": self.half_height if self.half_height is not None else 1.0,
            "z_near": self.z_near,
            "z_far": 0.0 if math.isinf(self.z_far) else self.z_far,
            "fx_per_fy": self.fx_per_fy,
            "shift_x": self.shift[0],
            "shift_y": self.shift[1],
        }

    @classmethod
    def _of_fields(cls, fields: Dict[str, Any]) -> Camera:
        world = np.eye(4)
        world[:3] = np.reshape(fields["world_from_camera"], (4, 3)).T
        return cls(world, fields["yfov"], fields["z_near"], fields["z_far"] or math.inf,
                   fields["half_height"] if fields["orthographic"] else None, fields["fx_per_fy"] or 1.0,
                   (fields["shift_x"], fields["shift_y"]))
