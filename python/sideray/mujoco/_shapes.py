"""Triangles of what mjvScene consists of, tessellated as MuJoCo does, so that outlines are the same.

A shape is a tuple of arrays for Scene.add_geometry: positions, triangles or None, normals or None, uv or None. Primitives are
unit objects (-1..1), which the transform of their instance scales.
"""

from __future__ import annotations

from typing import Any, List, Optional, Tuple

import numpy as np

from .._arrays import Array

Shape = Tuple[Array, Optional[Array], Optional[Array], Optional[Array]]


def _grid(columns: int, rows: int) -> Array:
    """Triangles of a grid of (columns + 1) x (rows + 1) vertices, row by row, counter-clockwise where rows go up."""
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    right, up = corner + 1, corner + columns + 1
    halves: Array = np.stack([np.stack([corner, right, up + 1], -1), np.stack([corner, up + 1, up], -1)], 1)
    return halves.reshape(-1, 3)


def _ring(slices: int) -> Array:
    angles = np.linspace(0.0, 2.0 * np.pi, slices + 1)
    ring: Array = np.stack([np.cos(angles), np.sin(angles)], -1)
    ring[-1] = ring[0]
    return ring


def _turned(profile: Array, slopes: Array, slices: int, v: Optional[Array] = None) -> Shape:
    """A surface of revolution about z. profile: (n, 2) radius and height, upward; slopes: (n, 2) of its normals; v: (n,)
    texture coordinates; u goes around once."""
    ring = _ring(slices)
    positions = np.concatenate([profile[:, None, :1] * ring[None], np.repeat(profile[:, None, 1:], slices + 1, 1)], -1)
    normals = np.concatenate([slopes[:, None, :1] * ring[None], np.repeat(slopes[:, None, 1:], slices + 1, 1)], -1)
    triangles = _grid(slices, len(profile) - 1)
    points = positions.reshape(-1, 3)
    corners = points[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    kept = triangles[area > 1e-12 * max(1.0, float(np.abs(points).max()))]
    uv = np.empty((len(profile), slices + 1, 2))
    uv[..., 0] = np.linspace(0.0, 1.0, slices + 1)
    uv[..., 1] = (np.linspace(1.0, 0.0, len(profile)) if v is None else v)[:, None]
    return points, kept, normals.reshape(-1, 3), uv.reshape(-1, 2)


def _joined(*shapes: Shape) -> Shape:
    offsets = np.cumsum([0] + [len(shape[0]) for shape in shapes])
    return (np.concatenate([shape[0] for shape in shapes]),
            np.concatenate([shape[1] + offset for shape, offset in zip(shapes, offsets) if shape[1] is not None]),
            np.concatenate([shape[2] for shape in shapes if shape[2] is not None]),
            np.concatenate([shape[3] if shape[3] is not None else np.zeros((len(shape[0]), 2)) for shape in shapes]))


def _disc(z: float, slices: int) -> Shape:
    rim = np.concatenate([_ring(slices)[:-1], np.full((slices, 1), z)], -1)
    points = np.concatenate([[[0.0, 0.0, z]], rim])
    first = np.arange(slices) + 1
    second = first % slices + 1
    triangles = np.stack([np.zeros(slices, int), first, second] if z > 0 else [np.zeros(slices, int), second, first], -1)
    return (points, triangles, np.tile([0.0, 0.0, 1.0 if z > 0 else -1.0], (len(points), 1)),
            0.5 + 0.5 * points[:, :2])


def _arc(first: float, last: float, steps: int) -> Array:
    angles = np.linspace(first, last, steps + 1)
    arc: Array = np.stack([np.cos(angles), np.sin(angles)], -1)
    arc[np.abs(np.abs(angles) - np.pi / 2) < 1e-9, 0] = 0.0
    return arc


def plane() -> Shape:
    """A square that faces +z."""
    points = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    uv = 0.5 + 0.5 * points[:, :2] * [1, -1]
    return points, np.array([[0, 1, 2], [0, 2, 3]]), np.tile([0.0, 0, 1], (4, 1)), uv


def box(parts: int = 1) -> Shape:
    """A cube whose sides are `parts` x `parts` squares."""
    u, v = (side.ravel() for side in np.meshgrid(np.linspace(-1, 1, parts + 1), np.linspace(-1, 1, parts + 1)))
    sides: List[Shape] = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            points = np.empty((len(u), 3))
            points[:, axis], points[:, (axis + 1) % 3], points[:, (axis + 2) % 3] = sign, sign * u, v
            normals = np.zeros_like(points)
            normals[:, axis] = sign
            across_and_up = [(1, 2), (0, 2), (0, 1)][axis]  # alike on opposite sides
            sides.append((points, _grid(parts, parts), normals, 0.5 + 0.5 * points[:, across_and_up] * [1, -1]))
    return _joined(*sides)


def sphere(slices: int, stacks: int) -> Shape:
    """A ball with its poles on z."""
    arc = _arc(-np.pi / 2, np.pi / 2, stacks)
    return _turned(arc, arc, slices)


def cylinder(slices: int) -> Shape:
    """A cylinder along z with both ends closed."""
    side = _turned(np.array([[1.0, -1.0], [1.0, 1.0]]), np.array([[1.0, 0.0], [1.0, 0.0]]), slices)
    return _joined(side, _disc(1.0, slices), _disc(-1.0, slices))


def capsule(radius: float, half_length: float, slices: int, stacks: int) -> Shape:
    """A capsule along z, in its own size."""
    low, high = _arc(-np.pi / 2, 0.0, max(stacks // 2, 1)), _arc(0.0, np.pi / 2, max(stacks // 2, 1))
    profile = np.concatenate([low * radius - [0, half_length], high * radius + [0, half_length]])
    rings = max(stacks // 2, 1)
    dome = np.linspace(1.0, 0.0, rings + 1)
    # The two rings between the domes are twice there: sides and domes have coordinates of their own.
    side = _turned(profile[[rings, rings + 1]], np.concatenate([low, high])[[rings, rings + 1]], slices)
    return _joined(_turned(profile[:rings + 1], low, slices, dome), side, _turned(profile[rings + 1:], high, slices, dome))


def arrow(heads: int, width: float, slices: int) -> Shape:
    """A shaft of radius 1 along z from 0 to 1/3, or from -1/3, with a head of that width and a length of 1/6 at its end, or at
    both ends."""
    end, tip = 1.0 / 3.0, 0.5
    begin = -end if heads == 2 else 0.0
    shapes = [_turned(np.array([[1.0, begin], [1.0, end]]), np.array([[1.0, 0.0], [1.0, 0.0]]), slices),
              _cone(end, tip, width, slices)]
    if heads == 2:
        shapes.append(_cone(-end, -tip, width, slices))
    return _joined(*shapes)


def line() -> Shape:
    """A thin prism along z from 0 to 1."""
    return _turned(np.array([[1.0, 0.0], [1.0, 1.0]]), np.array([[1.0, 0.0], [1.0, 0.0]]), 6)


def _cone(base: float, tip: float, radius: float, slices: int) -> Shape:
    slope = np.array([abs(tip - base), radius * np.sign(tip - base)])
    slope /= np.linalg.norm(slope)
    profile = np.array([[radius, base], [0.0, tip]]) if tip > base else np.array([[0.0, tip], [radius, base]])
    cap = _disc(1.0 if tip < base else -1.0, slices)
    cap[0][:, :2] *= radius
    cap[0][:, 2] = base
    return _joined(_turned(profile, np.stack([slope, slope]), slices), cap)


def triangle() -> Shape:
    """Half of a unit square, seen from both sides."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    return (np.concatenate([points, points]), np.array([[0, 1, 2], [3, 5, 4]]),
            np.repeat([[0.0, 0, 1], [0, 0, -1]], 3, axis=0), None)


def mesh(model: Any, number: int, with_uv: bool) -> Shape:
    """A mesh of the model, corner by corner: positions, normals and texture coordinates have faces of their own."""
    begin, count = model.mesh_faceadr[number], model.mesh_facenum[number]
    rows = slice(begin, begin + count)
    corners = model.mesh_vert[model.mesh_vertadr[number] + model.mesh_face[rows].ravel()]
    normals = model.mesh_normal[model.mesh_normaladr[number] + model.mesh_facenormal[rows].ravel()]
    uv = None
    if with_uv and model.mesh_texcoordadr[number] >= 0:
        uv = model.mesh_texcoord[model.mesh_texcoordadr[number] + model.mesh_facetexcoord[rows].ravel()]
    return corners, None, normals, uv


def reach_inside(corners: Array) -> float:
    """How far light goes in a closed mesh, whose triangles have three corners each, (3 n, 3): one and a half times its mean chord,
    4 volume / surface (Cauchy), so that it is the diameter of a ball, and three times the thickness of a wall."""
    a, b, c = corners[0::3], corners[1::3], corners[2::3]
    surface = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    volume = abs(float(np.einsum("nk,nk->", a, np.cross(b, c)))) / 6.0
    return 6.0 * volume / surface if surface > 0 else 0.0


def hull(model: Any, number: int) -> Optional[Shape]:
    """The convex hull of a mesh; None where the model has none."""
    address = model.mesh_graphadr[number]
    if address < 0:
        return None
    graph = model.mesh_graph[address:]
    vertices, faces = int(graph[0]), int(graph[1])
    begin = 2 + 2 * vertices + vertices + 3 * faces
    corners = model.mesh_vert[model.mesh_vertadr[number] + graph[begin:begin + 3 * faces]]
    return corners, None, None, None


def height_field(model: Any, number: int) -> Shape:
    """The surface of a height field, its four sides and its bottom."""
    rows, columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
    address = model.hfield_adr[number]
    width, depth, top, bottom = model.hfield_size[number]
    heights = np.asarray(model.hfield_data[address:address + rows * columns], np.float64).reshape(rows, columns) * top
    x, y = np.meshgrid(np.linspace(-width, width, columns), np.linspace(-depth, depth, rows))
    surface = np.stack([x, y, heights], -1)
    down, across = np.gradient(heights, 2 * depth / (rows - 1), 2 * width / (columns - 1))
    normals = np.stack([-across, -down, np.ones_like(heights)], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    uv = np.stack([0.5 + 0.5 * x / width, 0.5 - 0.5 * y / depth], -1)
    sides = [_skirt(edge, -bottom) for edge in (surface[0], surface[:, -1], surface[-1, ::-1], surface[::-1, 0])]
    floor = plane()
    assert floor[1] is not None and floor[2] is not None
    flat = (floor[0] * [width, depth, 0] - [0, 0, bottom], floor[1][:, ::-1], -floor[2], floor[3])
    top_part = (surface.reshape(-1, 3), _grid(columns - 1, rows - 1), normals.reshape(-1, 3), uv.reshape(-1, 2))
    return _joined(top_part, *((*side[:3], 0.5 + 0.5 * side[0][:, :2] / [width, -depth]) for side in sides), flat)


def _skirt(edge: Array, bottom: float) -> Shape:
    """A wall below an edge, which is followed counter-clockwise as seen from above."""
    low = edge.copy()
    low[:, 2] = bottom
    along = edge[-1] - edge[0]
    normal = np.cross(along, [0.0, 0.0, 1.0])
    points = np.concatenate([low, edge])
    return points, _grid(len(edge) - 1, 1), np.tile(normal / np.linalg.norm(normal), (len(points), 1)), None
