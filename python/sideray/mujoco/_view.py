"""The cameras of an mjvScene."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from .._arrays import Array
from .._camera import Camera


def camera_of(source: Any, size: Tuple[int, int]) -> Camera:
    """The camera between both eyes, of a picture of this (width, height)."""
    eyes = source.camera
    position = 0.5 * (np.asarray(eyes[0].pos, np.float64) + eyes[1].pos)
    forward = np.asarray(eyes[0].forward, np.float64) + eyes[1].forward
    up = np.asarray(eyes[0].up, np.float64) + eyes[1].up
    world = np.eye(4)
    world[:3, 2] = -forward / np.linalg.norm(forward)
    world[:3, 0] = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
    world[:3, 1] = np.cross(world[:3, 2], world[:3, 0])
    world[:3, 3] = position
    eye = eyes[0]
    half = 0.5 * (eye.frustum_top - eye.frustum_bottom)
    center = 0.5 * (eyes[0].frustum_center + eyes[1].frustum_center)
    # MuJoCo's frustums have a width of their own only where the camera has intrinsics.
    square = half * size[0] / size[1]
    half_width = getattr(eye, "frustum_width", 0.0) or square
    shift = (-0.5 * center / half_width, 0.25 * (eye.frustum_top + eye.frustum_bottom) / half)
    return Camera(world, 2.0 * np.arctan(half / eye.frustum_near), eye.frustum_near, eye.frustum_far,
                  half if eye.orthographic else None, square / half_width, shift)


def sees_haze(camera: Camera, size: Tuple[int, int], up: Array, edge: float, share: float) -> bool:
    """Whether some of a picture looks between the horizon and where the haze begins. edge: how steeply one looks at its middle."""
    corner, across, down = camera._directions(size)
    x, y = np.meshgrid(np.linspace(0, size[0], 17), np.linspace(0, size[1], 17))
    looks = corner + x[..., None] * across + y[..., None] * down
    falls = -(looks @ up)
    along = np.linalg.norm(looks + falls[..., None] * up, axis=-1)
    return bool(((falls > 0) & (1.05 * along * edge > (1.0 - share) * falls)).any())
