"""What lights an mjvScene: its lights, ambient light, and the sky.

MuJoCo's sky is seen and lights nothing; here what surrounds a scene lights it. With linear colours that is wanted. Else
nothing surrounds it, the sky is put behind the picture, and everything emits the model's ambient light. Where glass must see
the sky, a texture occludes it for everything else: wholly, and for what mirrors down to the ambient light.
"""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from .._arrays import Array
from .._scene import Scene
from . import _textures
from ._look import Look
from ._untyped import mujoco

# As _native.with_backdrop() takes what is put behind a picture.
Backdrop = Tuple[Array, Optional[Array], float, bool]


class Surroundings:
    """The ambient light and the sky. has_sky: of a model that has one."""

    def __init__(self, model: Any, look: Look, has_sky: bool) -> None:
        self._look = look
        #: (height, width, 3), lat-long.
        self.sky: Optional[Array] = None
        self.ambient = np.zeros(3)
        #: Whether something refracts the sky.
        self.has_glass = False
        self._told: Any = None  # as Scene.set_environment() was told
        skies = np.nonzero(model.tex_type == mujoco.mjtTexture.mjTEXTURE_SKYBOX)[0]
        if len(skies) and has_sky:
            self._faces = np.ascontiguousarray(_textures.cube(model, int(skies[0])))
            self.sky = look.color(_textures.sky(self._faces)).astype(np.float32)

    @property
    def is_in_sky(self) -> bool:
        """Whether the sky surrounds the scene, so that the picture has it already."""
        return self.sky is not None and (self._look.linear or self.has_glass)

    @property
    def _around(self) -> Array:
        """The ambient light that surrounds the scene, where the sky does not."""
        return self.ambient if self._look.linear or self._look.surrounded else np.zeros(3)

    def follow(self, source: Any) -> None:
        """Takes the ambient light of an mjvScene."""
        self.ambient = sum((self._look.color(light.ambient) for light in source.lights[:source.nlight]), np.zeros(3))

    def surround(self, scene: Scene) -> None:
        around = self._around.astype(np.float32)
        told = self.is_in_sky, tuple(around.tolist())
        if told == self._told:
            return
        self._told = told
        if self.is_in_sky:
            scene.set_environment(self.sky)
        else:
            scene.set_environment(np.broadcast_to(around, (2, 4, 3)) if around.any() else None)

    def share_around(self, geom: Any) -> float:
        """The share of the sky's light that reaches a geom from around it: what ambient light is of the sky, or nothing."""
        if not self.lights_from_around(geom):
            return 0.0
        assert self.sky is not None
        return float(self.ambient.mean() / max(float(self.sky.mean()), 1e-6))

    def lights_from_around(self, geom: Any) -> bool:
        """Whether ambient light reaches a geom from around it; else the geom emits it."""
        return bool(self._look.linear or self._look.surrounded or (geom.reflectance > 0 and self.is_in_sky))

    def backdrop(self, shows_sky: bool) -> Backdrop:
        """What is put behind the picture, as with_backdrop() takes it: a colour, the faces of a sky, how often it is added, and
        whether its texels are sRGB. What lights the scene from everywhere is not what is seen behind it."""
        if self.is_in_sky:
            return np.zeros(3), self._faces, 0.0 if shows_sky else -1.0, self._look.linear
        if self.sky is None or not shows_sky:
            return -self._around, None, 0.0, False
        return -self._around, self._faces, 1.0, self._look.linear


class Lights:
    """The lights of a scene."""

    def __init__(self, model: Any, look: Look) -> None:
        self._model, self._look = model, look
        self._told: List[Dict[str, Any]] = []

    def follow(self, scene: Scene, source: Any) -> None:
        """Lights a scene as an mjvScene is lit."""
        lights: List[Dict[str, Any]] = []
        for light in source.lights[:source.nlight]:
            if np.any(light.dir):  # it has none before mj_forward()
                lights.append(self._light(light, (light.pos, light.dir), source.camera[0].forward))
        if str(lights) != str(self._told):
            scene.lights = lights
            self._told = lights

    def of_states(self, source: Any, states: Sequence[Any], forwards: Array) -> Optional[List[List[Dict[str, Any]]]]:
        """The lights of each state, whose camera looks along `forwards`; None where it is not known which they are."""
        shown = source.lights[:source.nlight]
        numbers = iter(np.nonzero(self._model.light_active)[0].tolist() if self._model.nlight else [])
        of_model = [None if light.headlight else next(numbers, None) for light in shown]
        first = states[0]
        for light, number in zip(shown, of_model):
            if light.headlight:
                continue
            if number is None or not (np.allclose(light.pos, first.light_xpos[number], atol=1e-4) and
                                      np.allclose(light.dir, first.light_xdir[number], atol=1e-4)):
                return None
        self._told = [{"of": "the last state"}]

        def placed(light: Any, number: Optional[int], state: Any) -> Tuple[Any, Any]:
            if number is None:
                return light.pos, light.dir
            return np.float32(state.light_xpos[number]), np.float32(state.light_xdir[number])

        return [[self._light(light, placed(light, number, state), forward) for light, number in zip(shown, of_model)
                 if np.any(light.dir)] for state, forward in zip(states, forwards)]

    def _light(self, light: Any, placed: Tuple[Any, Any], forward: Any) -> Dict[str, Any]:
        """placed: its position and direction. forward: of the camera, which the headlight shines along."""
        diffuse = np.pi * self._look.color(light.diffuse)
        if light.headlight:  # from where the camera is, whatever the scene says
            return {"type": "directional", "name": "headlight", "direction": tuple(map(float, forward)),
                    "intensity": tuple(diffuse)}
        position, direction = (np.asarray(part, np.float64) for part in placed)
        kind = _kind(light)
        if kind == "directional":
            return {"type": kind, "direction": tuple(direction), "intensity": tuple(diffuse)}
        # Light of MuJoCo need not fall off; here it does, and is as bright in the middle of the model.
        away = max(float(np.linalg.norm(position - self._model.stat.center)), 0.1 * float(self._model.stat.extent))
        a = light.attenuation
        fall = 1.0 / max(float(a[0] + a[1] * away + a[2] * away * away), 1e-6)
        fields = {"type": kind, "position": tuple(position), "direction": tuple(direction),
                  "intensity": tuple(diffuse * fall * away * away), "radius": float(getattr(light, "bulbradius", 0.0))}
        if kind == "spot":
            outer = float(np.radians(np.clip(light.cutoff, 1.0, 90.0)))
            # A cone that fades to its edge as cos^10 does where the exponent is 10, and with a hard edge at 0.
            fields.update(outer_cone=outer, inner_cone=outer * 0.98 * max(0.0, 1.0 - float(light.exponent) / 10.0))
        return fields


def _kind(light: Any) -> str:
    if hasattr(light, "type"):
        return {0: "spot", 1: "directional", 2: "point"}.get(int(light.type), "directional")
    if light.directional:
        return "directional"
    return "spot" if light.cutoff < 90 else "point"
