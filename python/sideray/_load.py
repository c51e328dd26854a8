"""Reads files and makes built-in scenes."""

from __future__ import annotations

import difflib
import os
from typing import Union

from . import _native
from ._convert import ArrayLike
from ._errors import InvalidArgument, SceneNotFound
from ._scene import Scene


def load(path: Union[str, "os.PathLike[str]"], *, animation: str = "", variant: str = "", time: float = 0.0,
         default_light: bool = True, env: Union[str, ArrayLike, None] = "sky", env_scale: float = 1.0, env_rotate: float = 0.0,
         max_seconds: float = 0.0, max_gb: float = 0.0) -> Scene:
    """Reads a `.gltf` or `.glb` file, or makes a built-in scene ("panes", "forest?count=1000").

    animation: "" = the first, "all", or a name; they loop. variant: of the materials, one of Scene.variants. time: seconds.
    default_light: a file without lights gets a sun.
    env, env_scale, env_rotate: surroundings, as for Scene.set_environment. The surface id of the i-th object is i + 1;
    Scene.names has their names, Scene.warnings what was read otherwise than it is written. max_seconds of processor time,
    max_gb of memory (10^9 bytes): a file that takes more is refused; 0 = what SIDERAY_LOAD_SECONDS and SIDERAY_LOAD_GB say,
    else 20 and 2.
    """
    name = os.fsdecode(path)
    if not _native.is_builtin(os.fsencode(name)) and not os.path.exists(name):
        known = [row["name"] for row in _native.builtin_table()]
        near = difflib.get_close_matches(name, known, 1)
        hint = f"did you mean the built-in scene {near[0]}?" if near else f"built-in scenes are {', '.join(known)}"
        raise SceneNotFound(f"cannot read {name}: there is no such file; {hint}")
    for key, limit in (("max_seconds", max_seconds), ("max_gb", max_gb)):
        if not 0.0 <= limit <= 1e6:
            raise InvalidArgument(f"{key}: {limit} is not a number from 0 to 10^6; leave it out for the default")
    content = _native.Content(os.fsencode(name), animation, variant, time, default_light, max_seconds, max_gb)
    scene = Scene(env=env, env_scale=env_scale, env_rotate=env_rotate, default_light=default_light)
    scene._time = time
    scene._scene.set_time(time, time)
    scene._fill(content)
    return scene
