"""Textures of a model: pictures, and cubes, for which materials have no sampler."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from .._arrays import Array
from ._shapes import Shape

# Of each face of OpenGL's cubes (+X, -X, +Y, -Y, +Z, -Z): its axis, its sign, and the axes with signs that s and t follow.
_FACES = (((0, 1), (2, -1), (1, -1)), ((0, -1), (2, 1), (1, -1)), ((1, 1), (0, 1), (2, 1)),
          ((1, -1), (0, 1), (2, -1)), ((2, 1), (0, 1), (1, -1)), ((2, -1), (0, -1), (1, -1)))
# How exactly triangles follow a cube, and at which expense.
_TEXELS_OFF, _HALVINGS, _MOST_TRIANGLES = 0.25, 6, 100000


def image(model: Any, number: int) -> Array:
    """(height, width, channels) uint8: the texels as they lie in memory."""
    height, width = int(model.tex_height[number]), int(model.tex_width[number])
    channels = int(model.tex_nchannel[number]) if hasattr(model, "tex_nchannel") else 3
    data = model.tex_data if hasattr(model, "tex_data") else model.tex_rgb
    begin = int(model.tex_adr[number])
    return np.asarray(data[begin:begin + height * width * channels]).reshape(height, width, channels)


def cube(model: Any, number: int) -> Array:
    """(6, side, side, channels): the faces of a cube or a sky; one that is given is on all sides."""
    texels = image(model, number)
    side = texels.shape[1]
    count = texels.shape[0] // side
    return texels[:6 * side].reshape(6, side, side, -1) if count >= 6 else np.repeat(texels[None, :side], 6, axis=0)


def faces_of(directions: Array) -> Tuple[Array, Array]:
    """Which face directions (n, 3) lead to, and where on it, (n, 2) of 0..1."""
    axis = np.abs(directions).argmax(-1)
    sign = np.take_along_axis(directions, axis[:, None], -1)[:, 0] < 0
    face = 2 * axis + sign
    return face, on_face(directions, face)


def on_face(directions: Array, face: Array) -> Array:
    """Where on a face, (n, 2): beyond 0..1 where another face would be the one."""
    place = np.empty((len(directions), 2))
    for number, (main, s, t) in enumerate(_FACES):
        rows = face == number
        d = directions[rows]
        length = np.maximum(np.abs(d[:, main[0]]), 1e-12)
        place[rows, 0] = 0.5 * (s[1] * d[:, s[0]] / length + 1)
        place[rows, 1] = 0.5 * (t[1] * d[:, t[0]] / length + 1)
    return place


def sky(faces: Array) -> Array:
    """A sky as a lat-long image, (height, width, 3) float32 of 0..1, in the world's axes, +y as its top.

    MuJoCo's z is up, and the sky's cube has y for it.
    """
    side = faces.shape[1]
    height = int(np.clip(2 * side, 16, 1024))
    width = 2 * height
    polar, around = np.pi * (np.arange(height) + 0.5) / height, 2 * np.pi * ((np.arange(width) + 0.5) / width - 0.5)
    sine = np.sin(polar)[:, None]
    world = np.stack([sine * np.sin(around), np.broadcast_to(np.cos(polar)[:, None], (height, width)),
                      -sine * np.cos(around)], -1).reshape(-1, 3)
    return look_up(faces, world).reshape(height, width, 3)


def look_up(faces: Array, directions: Array) -> Array:
    """A sky in directions of the world (n, 3) of any length: (n, 3) float32 of 0..1."""
    face, place = faces_of(directions @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    return _bilinear(faces, face, place)[:, :3].astype(np.float32) / np.float32(255)


def _bilinear(faces: Array, face: Array, place: Array) -> Array:
    side = faces.shape[1]
    at = np.clip(place * side - 0.5, 0, side - 1)
    low = np.floor(at).astype(int)
    high = np.minimum(low + 1, side - 1)
    share = (at - low)[:, :, None]
    columns = faces[face, low[:, 1], low[:, 0]] * (1 - share[:, 0]) + faces[face, low[:, 1], high[:, 0]] * share[:, 0]
    below = faces[face, high[:, 1], low[:, 0]] * (1 - share[:, 0]) + faces[face, high[:, 1], high[:, 0]] * share[:, 0]
    texels: Array = columns * (1 - share[:, 1]) + below * share[:, 1]
    return texels


def strip(faces: Array) -> Array:
    """The faces of a cube as one image, one below the other. Each has a margin of its outermost texels, so that neither filters nor
    the first mip levels mix it with the next."""
    before, after = _margins(faces.shape[1])
    padded = np.pad(faces, ((0, 0), (before, after), (before, after), (0, 0)), mode="edge")
    return padded.reshape(-1, *padded.shape[2:])


def _margins(side: int) -> Tuple[int, int]:
    """Texels before and after each row of a face in a strip: 8 at least, and faces begin on texels of the fifth mip level."""
    margin = (side + 16 + 31) // 32 * 32 - side
    return margin // 2, margin - margin // 2


def onto_cube(shape: Shape, scale: Array, side: int) -> Shape:
    """A shape with texture coordinates into strip() of a cube whose faces are `side` texels wide.

    scale: of the shape where it is looked up. A look-up of a cube divides by the distance along a face's axis; triangles
    interpolate without. So they are cut along the edges of the cube, and their own edges are halved until the difference is
    a fraction of a texel. Neighbours halve the edge that they share.
    """
    positions, triangles, normals, _ = shape
    rows = triangles.ravel() if triangles is not None else np.arange(len(positions))
    parts = [positions * scale, positions] + ([] if normals is None else [normals])
    corners = np.concatenate(parts, -1)[rows].reshape(-1, 3, 3 * len(parts))
    for one, other in ((0, 1), (0, 2), (1, 2)):
        for sign in (1.0, -1.0):
            corners = _cut(corners, corners[..., one] + sign * corners[..., other])
    for _ in range(_HALVINGS):
        is_split = _errors(corners[..., :3]) * side > _TEXELS_OFF
        if not is_split.any() or len(corners) + is_split.sum() > _MOST_TRIANGLES:
            break
        corners = _halved(corners, is_split)
    face, place = _places(corners[..., :3])
    before, after = _margins(side)
    place = (before + np.clip(place.reshape(-1, 2), 0, 1) * side) / (before + side + after)
    uv = np.stack([place[:, 0], (place[:, 1] + np.repeat(face, 3)) / 6], -1)
    flat = corners.reshape(-1, corners.shape[-1])
    return flat[:, 3:6], None, None if normals is None else flat[:, 6:9], uv


def _cut(corners: Array, side: Array) -> Array:
    """Triangles, none of which has corners on both sides; `side`: of each corner its distance, with a sign."""
    side = np.where(np.abs(side) < 1e-9 * np.abs(side).max(initial=1e-9), 0.0, side)
    crosses = (side > 0).any(1) & (side < 0).any(1)
    cut, distance = corners[crosses], side[crosses]
    # The corner that is alone on its side comes first.
    is_lone = np.where((distance > 0).sum(1, keepdims=True) == 1, distance > 0, distance < 0)
    turn = (is_lone.argmax(1)[:, None] + np.arange(3)) % 3
    cut = np.take_along_axis(cut, turn[:, :, None], 1)
    distance = np.take_along_axis(distance, turn, 1)
    a, b, c = cut[:, 0], cut[:, 1], cut[:, 2]
    p = a + (b - a) * (distance[:, 0] / (distance[:, 0] - distance[:, 1]))[:, None]
    q = a + (c - a) * (distance[:, 0] / (distance[:, 0] - distance[:, 2]))[:, None]
    # Where the plane meets a corner, the piece there has no area.
    pieces = np.stack((a, p, q), 1), np.stack((p, b, c), 1)[distance[:, 1] != 0], np.stack((p, c, q), 1)[distance[:, 2] != 0]
    return np.concatenate([corners[~crosses], *pieces])


def _places(looked: Array) -> Tuple[Array, Array]:
    """The face of each triangle, (n,), and where on it its corners are, (n, 3, 2)."""
    face = faces_of(looked.mean(1))[0]
    return face, on_face(looked.reshape(-1, 3), np.repeat(face, 3)).reshape(-1, 3, 2)


def _errors(looked: Array) -> Array:
    """How far, in faces, the middle of each edge (n, 3), from each corner to the next, is from where interpolation has it."""
    face, place = _places(looked)
    middles = 0.5 * (looked + np.roll(looked, -1, 1))
    exact = on_face(middles.reshape(-1, 3), np.repeat(face, 3)).reshape(-1, 3, 2)
    errors: Array = np.abs(exact - 0.5 * (place + np.roll(place, -1, 1))).max(-1)
    return errors


def _halved(corners: Array, is_split: Array) -> Array:
    """Triangles whose edges are halved where `is_split`, (n, 3) from each corner to the next, says so."""
    count = is_split.sum(1)
    # The only edge that is split, or that is not, comes first or last.
    turn = np.where(count == 1, is_split.argmax(1), is_split.argmin(1) + 1)
    a, b, c = (corners[np.arange(len(corners)), (turn + k) % 3] for k in range(3))
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    ways = {0: [(a, b, c)], 1: [(a, ab, c), (ab, b, c)], 2: [(ab, b, bc), (a, ab, bc), (a, bc, c)],
            3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]}
    return np.concatenate([np.stack([corner[count == halves] for corner in piece], 1)
                           for halves, pieces in ways.items() for piece in pieces])
