"""The package mujoco, which says nothing of its types to type checkers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    mujoco: Any
    MjData = Any
    MjModel = Any
    MjvCamera = Any
    MjvOption = Any
    MjvScene = Any
else:
    try:
        import mujoco
        from mujoco import MjData, MjModel, MjvCamera, MjvOption, MjvScene
    except ImportError as error:
        raise ImportError("sideray.mujoco: the package mujoco is not installed; pip install mujoco") from error
