"""What stands in a scene: objects and particles."""

from __future__ import annotations

from typing import Dict, Protocol, Tuple

import numpy as np

from . import _native
from ._arrays import Array
from ._convert import ArrayLike, MaterialLike, array, transform_columns
from ._errors import InvalidArgument

# Which rays may hit an object. LAYERS counts only for translucent materials, SHADOW only for opaque ones.
VISIBLE_LAYERS, VISIBLE_REFLECTION, VISIBLE_SHADOW, VISIBLE_AO, VISIBLE_ALL = 1, 2, 4, 8, 15


class Owner(Protocol):
    """The Scene that objects stand in, as they see it."""

    names: Dict[int, str]

    def _edited(self) -> _native.Scene: ...
    def _material(self, material: MaterialLike) -> int: ...


class Object:
    """A mesh in its place in a scene: what Scene.add_mesh and add_instance return.

    surface_id: what Picture.ids shows; material, mesh: the numbers that the scene's add functions gave.
    """

    def __init__(self, scene: Owner, instance: int, mesh: int, material: int, surface_id: int, visibility: int,
                 transform: Array) -> None:
        self._scene = scene
        self.instance, self.mesh, self.surface_id = instance, mesh, surface_id
        self._material, self._visibility, self._transform = material, visibility, transform

    @property
    def transform(self) -> Array:
        """(4, 4) float64, world from object. Assign a new one to move the object."""
        world = np.eye(4)
        world[:3] = self._transform.reshape(4, 3).T
        return world

    @transform.setter
    def transform(self, transform: ArrayLike) -> None:
        placed = transform_columns(transform)
        self._scene._edited().move_instances(np.array([self.instance], np.uint32), placed[None])
        self._transform = placed

    @property
    def material(self) -> int:
        """The number of its material. Assign another, or a mapping of fields, which become a new one."""
        return self._material

    @material.setter
    def material(self, material: MaterialLike) -> None:
        self._replace(self._scene._material(material), self._visibility)

    @property
    def visibility(self) -> int:
        """VISIBLE_*: which rays hit it."""
        return self._visibility

    @visibility.setter
    def visibility(self, visibility: int) -> None:
        self._scene._edited().set_visibility(self.instance, visibility)
        self._visibility = visibility

    def remove(self) -> None:
        """Takes the object out of its scene; its mesh and material stay."""
        self._scene._edited().remove_instances(np.array([self.instance], np.uint32))
        self._scene.names.pop(self.surface_id, None)

    def _replace(self, material: int, visibility: int) -> None:
        def one(value: int) -> Array:
            return np.array([value], np.uint32)

        self._scene._edited().replace_instances(one(self.instance), one(self.mesh), one(material), self._transform[None],
                                                one(self.surface_id), one(visibility))
        self._material, self._visibility = material, visibility


class Particles:
    """Camera-facing sprites that share a texture. Rays never hit them, except where an option says so."""

    def __init__(self, scene: Owner, particles: int) -> None:
        self._scene, self._particles = scene, particles

    def set(self, positions: ArrayLike, sizes: ArrayLike = 1.0, colors: ArrayLike = (1.0, 1.0, 1.0, 1.0),
            rotations: ArrayLike = 0.0, cells: ArrayLike = 0.0) -> None:
        """Replaces the sprites, 0 to 2^20 of them; their order does not matter.

        positions: (n, 3), world, of their centres; sizes: world units, (n, 2) width and height, or numbers that
        broadcast to it; colors: (n, 4) linear, multiplied onto the texel, RGB >= 0, A 0..1; rotations: (n,) radians,
        counter-clockwise as seen; cells: (n,) of the flip-book, rounded down.
        """
        placed = array(positions, np.float64, "positions")
        count = len(placed)

        def spread(values: ArrayLike, shape: Tuple[int, ...], what: str) -> Array:
            given = array(values, np.float32, what)
            if given.ndim == 1 and len(shape) == 2 and given.shape == (count,) and count != shape[1]:
                given = given[:, None]
            try:
                return np.ascontiguousarray(np.broadcast_to(given, shape))
            except ValueError:
                raise InvalidArgument(f"{what}: the array has the shape {given.shape}; give {shape}") from None

        self._scene._edited().set_sprites(
            self._particles, placed, spread(sizes, (count, 2), "sizes"), spread(colors, (count, 4), "colors"),
            spread(rotations, (count,), "rotations"), spread(cells, (count,), "cells"))
