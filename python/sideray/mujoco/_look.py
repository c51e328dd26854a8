"""How colours and names of a model are read."""

from __future__ import annotations

import dataclasses
import fnmatch
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from .._arrays import Array


@dataclasses.dataclass
class Look:
    """How colours of a model become materials.

    linear: rgba are sRGB, as people choose colours, and the picture is tone mapped; else all numbers are taken as they are
    and shown as they come out, as MuJoCo does. glass: fields of the materials that names match. surrounded: ambient light comes
    from around the scene, where things can hide it; else it reaches everything.
    """

    linear: bool
    glass: Mapping[str, Mapping[str, Any]]
    surrounded: bool

    def color(self, rgb: Any) -> Array:
        values = np.asarray(rgb, np.float64)
        if not self.linear:
            return values
        return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)

    def glass_of(self, names: Sequence[str]) -> Optional[Mapping[str, Any]]:
        for pattern, fields in self.glass.items():
            if any(fnmatch.fnmatch(name.lower(), pattern.lower()) for name in names if name):
                return fields
        return None
