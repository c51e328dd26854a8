"""A sideray.Scene that follows an mjvScene: what stays there stays here."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, Hashable, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .._arrays import Array
from .._camera import Camera
from .._objects import VISIBLE_ALL
from .._scene import Scene
from ._geoms import FLEX, GEOM, PLACED, SKIN, UNIT, Plane, is_behind, is_drawn, places_of_states, reach
from ._light import Lights, Surroundings
from ._look import Look
from ._materials import Materials
from ._meshes import Meshes
from ._view import sees_haze

# Meshes and materials that no geom uses any more are kept, up to so many.
_KEPT = 256
# Where the sky is, in distances of the far plane: planes without an end are not seen beyond it.
_SKY = 0.7


class _Key(NamedTuple):
    """What a geom is, and its number among those that are the same, from 1."""

    type: int
    dataid: int
    objtype: int
    objid: int
    number: int


class _Wanted(NamedTuple):
    """What is to be seen of a geom. what: objid and objtype."""

    mesh: Hashable
    material: Hashable
    transform: Array
    what: Tuple[int, int]


@dataclasses.dataclass
class _Shown:
    """What an instance shows."""

    instance: int
    mesh: Hashable
    material: Hashable
    surface_id: int


class Mirror:
    """Draws what mjv_updateScene wrote. is_solid: everything is opaque and without light, for depth and segmentation. is_round: with
    the shapes of colour, and all that colour shows; otherwise with MuJoCo's shapes, and what its segmentation has."""

    def __init__(self, model: Any, look: Look, is_solid: bool, is_round: bool) -> None:
        self._model, self._look, self.is_solid, self._is_round = model, look, is_solid, is_round
        self.scene = Scene(env=None, default_light=False)
        #: Of each surface id: (objid, objtype); row 0 is what is behind everything.
        self.objects = np.full((1, 2), -1, np.int32)
        #: Whether something that is drawn is not opaque.
        self.shows_through = False
        self.surroundings = Surroundings(model, look, has_sky=not is_solid)
        self.lights = Lights(model, look)
        self._meshes = Meshes(model, self.scene, is_textured=not is_solid, is_round=is_round)
        self._materials = Materials(model, self.scene, look, is_solid, self.surroundings, self._meshes)
        self._reach = reach(model)
        self._shown: Dict[_Key, _Shown] = {}
        self._free: List[int] = []  # surface ids
        self._wanted: Dict[_Key, _Wanted] = {}
        self._transforms = np.empty((0, 12))  # as the scene has them
        self._scales = np.empty((0, 3))
        self._endless: Dict[_Key, Plane] = {}  # planes of which a side has no end

    def update(self, source: Any) -> None:
        """Follows an mjvScene."""
        if source.enabletransform:
            raise NotImplementedError("enabletransform: a scene with a transform of its own is not drawn; leave it out")
        if not self.is_solid:
            self.surroundings.follow(source)
        self._wanted = self._all_wanted(source)
        self._remove_unwanted()
        self._replace_changed()
        self._add_new()
        self._move()
        self._name_objects()
        self.shows_through = any(self._materials.is_see_through(wanted.material) for wanted in self._wanted.values())
        self._meshes.forget_but({wanted.mesh for wanted in self._wanted.values()}, _KEPT)
        self._materials.forget_but({wanted.material for wanted in self._wanted.values()}, _KEPT)
        if not self.is_solid:
            self.lights.follow(self.scene, source)
            self.surroundings.surround(self.scene)

    # ---- other states of the same model ----

    def moves_alone(self, states: Sequence[Any], eyes: Array) -> bool:
        """Whether other states of the model differ from the one that is drawn in where geoms, sites and lights are, and in nothing
        else."""
        if any(key.objtype not in PLACED or key.number != 1 for key in self._wanted):
            return False
        for key in self._wanted:
            if key.type == GEOM.mjGEOM_PLANE:
                position, turn = places_of_states(states, key.objtype, [key.objid])
                sides = np.einsum("nk,nk->n", eyes - position[:, 0], turn[:, 0, :, 2]) < 0
                if sides.any() and not sides.all():
                    return False
        return True

    def poses(self, states: Sequence[Any], eyes: Array) -> Tuple[Array, Array]:
        """The instances that move from state to state, and (states, instances, 12): where they are. eyes: of the cameras."""
        keys = list(self._wanted)
        placed = np.array([wanted.transform for wanted in self._wanted.values()]).reshape(-1, 4, 3)
        result = np.broadcast_to(placed, (len(states), *placed.shape)).copy()
        for kind in PLACED:
            rows = [row for row, key in enumerate(keys) if key.objtype == kind and key not in self._endless]
            if rows:
                position, turn = places_of_states(states, kind, [keys[row].objid for row in rows])
                result[:, rows, :3] = turn.swapaxes(2, 3) * self._scales[rows, :, None]
                result[:, rows, 3] = position
        for row, key in enumerate(keys):
            if key in self._endless:
                plane = self._endless[key]
                for number, eye in enumerate(eyes):
                    scale, result[number, row, 3] = plane.seen_from(eye, self._reach)
                    result[number, row, :3] = (plane.turn * scale).T
        moving = np.nonzero((result != result[:1]).any((0, 2, 3)))[0]
        instances = np.array([self._shown[keys[row]].instance for row in moving], np.uint32)
        self._transforms = np.empty((0, 12))  # the scene is left in the last state
        return instances, np.ascontiguousarray(result[:, moving]).reshape(len(states), len(moving), 12)

    # ---- what is to be seen ----

    def _all_wanted(self, source: Any) -> Dict[_Key, _Wanted]:
        was_in_sky = self.surroundings.is_in_sky
        wanted = self._wanted_geoms(source)
        # The first glass brings the sky around the scene, which changes the materials.
        return wanted if self.surroundings.is_in_sky == was_in_sky else self._wanted_geoms(source)

    def _wanted_geoms(self, source: Any) -> Dict[_Key, _Wanted]:
        seen: Dict[_Key, Tuple[Any, Hashable, Hashable]] = {}
        counts: Dict[Tuple[int, int, int, int], int] = {}
        self._endless = {}
        for geom in source.geoms[:source.ngeom]:
            if not is_drawn(geom) or (not self._is_round and geom.segid < 0):
                continue
            mesh = self._meshes.key_of(geom, source)
            if mesh is None:
                continue
            same = (geom.type, geom.dataid, geom.objtype, geom.objid)
            counts[same] = counts.get(same, 0) + 1
            key = _Key(*same, counts[same])
            seen[key] = geom, mesh, self._materials.key_of(geom, is_behind(geom, source))
            if geom.type == GEOM.mjGEOM_PLANE and not (plane := Plane.of(geom)).has_end:
                self._endless[key] = plane
        places = self._places([geom for geom, _, _ in seen.values()], source.camera[0].pos)
        return {key: _Wanted(mesh, material, place, (geom.objid, geom.objtype))
                for (key, (geom, mesh, material)), place in zip(seen.items(), places)}

    def _places(self, geoms: Sequence[Any], eye: Any) -> Array:
        """World from object of each as twelve numbers, column by column. Keeps the scales along the objects' axes that are in it."""
        if not geoms:
            return np.empty((0, 12))
        turns = np.array([geom.mat for geom in geoms], np.float64).reshape(-1, 3, 3)
        positions = np.array([geom.pos for geom in geoms], np.float64)
        scales = np.ones((len(geoms), 3))
        for row, geom in enumerate(geoms):
            if geom.type in (FLEX, SKIN):  # their vertices are in the world already
                turns[row], positions[row] = np.eye(3), 0.0
            elif geom.type == GEOM.mjGEOM_PLANE:
                scales[row], positions[row] = Plane.of(geom).seen_from(eye, self._reach)
            elif geom.type == GEOM.mjGEOM_LINE:
                thin = 0.001 * self._model.stat.meansize
                scales[row] = thin, thin, geom.size[2]
            elif geom.type in UNIT:
                scales[row] = geom.size
        self._scales = np.where(np.abs(scales) < 1e-9, 1e-9, scales)
        columns = (turns * self._scales[:, None, :]).swapaxes(1, 2).reshape(-1, 9)
        return np.concatenate([columns, positions], 1)

    # ---- instances ----

    def _remove_unwanted(self) -> None:
        gone = [self._shown.pop(key) for key in list(self._shown) if key not in self._wanted]
        if gone:
            self.scene._edited().remove_instances(np.array([shown.instance for shown in gone], np.uint32))
            self._free += [shown.surface_id for shown in gone]

    def _replace_changed(self) -> None:
        changed = {key: wanted for key, wanted in self._wanted.items() if key in self._shown and
                   wanted[:2] != (self._shown[key].mesh, self._shown[key].material)}
        if not changed:
            return
        shown = [self._shown[key] for key in changed]
        self.scene._edited().replace_instances(
            np.array([one.instance for one in shown], np.uint32), *self._descriptions(changed),
            np.array([one.surface_id for one in shown], np.uint32), np.full(len(shown), VISIBLE_ALL, np.uint32))
        for one, wanted in zip(shown, changed.values()):
            one.mesh, one.material = wanted.mesh, wanted.material

    def _add_new(self) -> None:
        new = {key: wanted for key, wanted in self._wanted.items() if key not in self._shown}
        if not new:
            return
        fresh = len(self._shown) + len(self._free) + 1
        ids = [self._free.pop() if self._free else (fresh := fresh + 1) - 1 for _ in new]
        instances = self.scene._edited().add_instances(*self._descriptions(new), np.array(ids, np.uint32),
                                                       np.full(len(ids), VISIBLE_ALL, np.uint32))
        for (key, wanted), instance, surface_id in zip(new.items(), instances, ids):
            self._shown[key] = _Shown(int(instance), wanted.mesh, wanted.material, surface_id)
        self._transforms = np.empty((0, 12))

    def _descriptions(self, wanted: Mapping[_Key, _Wanted]) -> Tuple[Array, Array, Array]:
        """Meshes, materials and transforms."""
        return (np.array([self._meshes.number(one.mesh) for one in wanted.values()], np.uint32),
                np.array([self._materials.number(one.material) for one in wanted.values()], np.uint32),
                np.array([one.transform for one in wanted.values()]))

    def _move(self) -> None:
        if not self._wanted:
            self._transforms = np.empty((0, 12))
            return
        transforms = np.array([wanted.transform for wanted in self._wanted.values()])
        if np.array_equal(transforms, self._transforms):
            return
        instances = np.array([self._shown[key].instance for key in self._wanted], np.uint32)
        self.scene._edited().move_instances(instances, transforms)
        self._transforms = transforms

    def _name_objects(self) -> None:
        largest = max((shown.surface_id for shown in self._shown.values()), default=0)
        self.objects = np.full((largest + 1, 2), -1, np.int32)
        for key, wanted in self._wanted.items():
            self.objects[self._shown[key].surface_id] = wanted.what

    # ---- haze ----

    def haze(self, source: Any, camera: Camera, size: Tuple[int, int]) -> Optional[Dict[str, Any]]:
        """What with_backdrop() takes of the haze around a plane without an end, but for `surfaces`; None where none is seen in a
        picture of this size."""
        planes = {key: plane for key, plane in self._endless.items() if plane.is_endless}
        share = float(np.clip(self._model.vis.map.haze, 0.0, 1.0))
        if not planes or share <= 0.0 or camera.half_height is not None:
            return None
        plane = next(iter(planes.values()))
        up = plane.turn[:, 2]
        height = float((camera.world_from_camera[:3, 3] - plane.position) @ up)
        end = _SKY * float(source.camera[0].frustum_far)
        if height <= 0.0 or not sees_haze(camera, size, up, height / end, share):
            return None
        is_endless = np.zeros(len(self.objects), np.uint8)
        is_endless[[0, *(self._shown[key].surface_id for key in planes)]] = 1
        return {"is_endless": is_endless, "color": np.asarray(self._look.color(self._model.vis.rgba.haze[:3])), "up": up,
                "height": height, "end": end, "share": share}
