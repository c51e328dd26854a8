"""Files that are written whole or not at all: JSON, and PNG of 8 and 16 bits."""

from __future__ import annotations

import json
import os
import struct
import zlib
from typing import Any, Mapping, Union

import numpy as np

from .._arrays import Array
from .._errors import InvalidArgument
from .._picture import Picture

_COLOR_TYPES = {1: 0, 3: 2}  # of PNG, by channels


def write_whole(path: str, content: bytes) -> None:
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    beside = f"{path}.{os.getpid()}.part"
    try:
        with open(beside, "wb") as file:
            file.write(content)
        os.replace(beside, path)
    except BaseException:
        if os.path.exists(beside):
            os.remove(beside)
        raise


def write_json(path: str, value: Mapping[str, Any]) -> None:
    """An entry a line; of entries that are lists, an element a line."""
    def text(entry: Any) -> str:
        if isinstance(entry, list) and entry and isinstance(entry[0], dict):
            return "[\n" + ",\n".join(json.dumps(element) for element in entry) + "\n]"
        return json.dumps(entry)

    lines = ",\n".join(f"{json.dumps(str(key))}: {text(entry)}" for key, entry in value.items())
    write_whole(path, ("{\n" + lines + "\n}\n").encode())


def png(pixels: Array) -> bytes:
    """(height, width) or (height, width, 3) of uint8, or (height, width) of uint16, as a PNG."""
    height, width = pixels.shape[:2]
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    rows = pixels.astype(pixels.dtype.newbyteorder(">")).reshape(height, -1).view(np.uint8).reshape(height, -1)
    step = channels * pixels.dtype.itemsize
    filtered = rows.copy()
    filtered[:, step:] -= rows[:, :-step]  # each byte less the one of the pixel before: filter 1
    lines = np.concatenate([np.ones((height, 1), np.uint8), filtered], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">2I5B", width, height, 8 * pixels.dtype.itemsize, _COLOR_TYPES[channels], 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines.tobytes(), 6)) +
            chunk(b"IEND", b""))


def write_png(path: str, pixels: Array) -> None:
    write_whole(path, png(np.ascontiguousarray(pixels)))


def colors(rgb: Union[Picture, Array]) -> Array:
    """(height, width, 3) uint8 of a picture, as it is displayed, or of such an array."""
    shown = rgb.display() if isinstance(rgb, Picture) else np.asarray(rgb)
    if shown.dtype != np.uint8 or shown.ndim != 3 or shown.shape[2] != 3:
        raise InvalidArgument(f"rgb: the array holds {shown.dtype} of the shape {shown.shape}; give a Picture or (height, width, 3) "
                              "of uint8")
    return shown


def millimetres(depth: Array, mm_per_step: float, mm_per_unit: float) -> Array:
    """Depths in world units as 16-bit steps; 0 where there is none, or it does not fit."""
    steps = np.rint(np.nan_to_num(np.asarray(depth, np.float64), nan=0.0, posinf=0.0, neginf=0.0) * (mm_per_unit / mm_per_step))
    return np.where((steps >= 1) & (steps <= 65535), steps, 0).astype(np.uint16)


def positive(value: float, what: str) -> float:
    if not 0.0 < value < float("inf"):
        raise InvalidArgument(f"{what}: {value}; give a finite number above 0")
    return float(value)
