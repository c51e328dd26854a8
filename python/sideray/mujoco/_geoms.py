"""What the geoms of an mjvScene are, and where."""

from __future__ import annotations

import dataclasses
from typing import Any, Sequence, Tuple

import numpy as np

from .._arrays import Array
from ._untyped import mujoco

GEOM = mujoco.mjtGeom
#: Shapes of size 1, which their places scale.
UNIT = {int(GEOM.mjGEOM_PLANE), int(GEOM.mjGEOM_SPHERE), int(GEOM.mjGEOM_ELLIPSOID), int(GEOM.mjGEOM_CYLINDER),
        int(GEOM.mjGEOM_BOX), int(GEOM.mjGEOM_ARROW), int(GEOM.mjGEOM_ARROW1), int(GEOM.mjGEOM_ARROW2), int(GEOM.mjGEOM_LINE),
        int(GEOM.mjGEOM_TRIANGLE)}
MESHES = {int(GEOM.mjGEOM_MESH), int(getattr(GEOM, "mjGEOM_SDF", GEOM.mjGEOM_MESH))}
#: Shapes whose vertices the scene has anew at each update, in the world.
FLEX, SKIN = int(getattr(GEOM, "mjGEOM_FLEX", -1)), int(GEOM.mjGEOM_SKIN)
#: What a state places by itself.
PLACED = (int(mujoco.mjtObj.mjOBJ_GEOM), int(mujoco.mjtObj.mjOBJ_SITE))


def is_drawn(geom: Any) -> bool:
    """Whether it is seen and has a place: before mj_forward() it has none."""
    return bool(geom.rgba[3] != 0 and (geom.type in (FLEX, SKIN) or geom.mat.any()))


def is_behind(geom: Any, source: Any) -> bool:
    """Whether the camera is on the other side of a plane."""
    if geom.type != GEOM.mjGEOM_PLANE:
        return False
    normal = np.asarray(geom.mat).reshape(3, 3)[:, 2]
    return bool((np.asarray(source.camera[0].pos) - geom.pos) @ normal < 0)


def is_of_model(geom: Any) -> bool:
    """Whether it is a geom of the model, rather than a site or a marker."""
    return bool(geom.objtype == mujoco.mjtObj.mjOBJ_GEOM and geom.objid >= 0)


def has_flat_texture(model: Any, geom: Any) -> bool:
    """Whether its texture is an image, rather than a cube around it."""
    return bool(geom.texid >= 0 and model.tex_type[geom.texid] == mujoco.mjtTexture.mjTEXTURE_2D)


def reach(model: Any) -> float:
    """How far planes without an end reach: beyond what is seen."""
    return 1.05 * float(model.vis.map.zfar) * float(model.stat.extent)


@dataclasses.dataclass
class Plane:
    """A plane. Sides of length 0 have no end. repeat: of its texture, in a length of 1."""

    sides: Array
    repeat: Array
    turn: Array
    position: Array

    @classmethod
    def of(cls, geom: Any) -> Plane:
        return cls(np.array(geom.size, np.float64), np.array(geom.texrepeat), np.array(geom.mat, np.float64).reshape(3, 3),
                   np.array(geom.pos, np.float64))

    @property
    def has_end(self) -> bool:
        return bool(np.all(self.sides[:2] > 0))

    @property
    def is_endless(self) -> bool:
        """Whether neither side has an end."""
        return bool(np.all(self.sides[:2] <= 0))

    def seen_from(self, eye: Any, reach: float) -> Tuple[Array, Array]:
        """Its scale and position. A side without an end reaches as far as is seen, around where the camera is, in whole repeats of
        its texture."""
        repeat = np.where(self.repeat > 0, self.repeat, 1.0)
        scale, offset = np.ones(3), self.turn.T @ (np.asarray(eye) - self.position)
        for axis in range(2):
            if self.sides[axis] > 0:
                scale[axis], offset[axis] = self.sides[axis], 0.0
            else:
                period = 2.0 / repeat[axis]
                scale[axis] = max(np.ceil(reach / period), 1) * period
                offset[axis] = np.round(offset[axis] / period) * period
        offset[2] = 0.0
        return scale, self.position + self.turn @ offset


def places_of_states(states: Sequence[Any], what: int, numbers: Sequence[int]) -> Tuple[Array, Array]:
    """Where geoms or sites are in each state: positions (states, numbers, 3) and rotations (states, numbers, 3, 3)."""
    positions, turns = (("geom_xpos", "geom_xmat") if what == PLACED[0] else ("site_xpos", "site_xmat"))
    # Scenes of MuJoCo have them in single precision.
    return (np.stack([getattr(state, positions)[numbers] for state in states]).astype(np.float32),
            np.stack([getattr(state, turns)[numbers] for state in states]).astype(np.float32).reshape(len(states), -1, 3, 3))
