"""Reads the OpenEXR files that `sideray render` writes: scanlines, ZIP, one part. Needs numpy alone."""
import struct
import zlib

import numpy as np

TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
LINES_OF_BLOCK = {0: 1, 2: 1, 3: 16}  # uncompressed, ZIPS, ZIP


def _string(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _attributes(data):
    at, found = 8, {}
    while data[at] != 0:
        name, at = _string(data, at)
        _, at = _string(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data):
    at, found = 0, []
    while data[at] != 0:
        name, at = _string(data, at)
        found.append((name, TYPES[struct.unpack_from("<i", data, at)[0]]))
        at += 16
    return found


def _unpacked(block, size):
    if len(block) == size:
        return block  # stored uncompressed: ZIP would not shrink it
    raw = np.frombuffer(zlib.decompress(block), np.uint8)
    # Each byte is the difference to the one before, and even bytes come before odd ones.
    values = (np.cumsum(raw.astype(np.int64)) - 128 * np.arange(len(raw))).astype(np.uint8)
    result = np.empty_like(values)
    half = (len(values) + 1) // 2
    result[0::2], result[1::2] = values[:half], values[half:]
    return result.tobytes()


def read(path):
    """Channels by name, each an array of (height, width); top row first."""
    with open(path, "rb") as file:
        data = file.read()
    attributes, at = _attributes(data)
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = LINES_OF_BLOCK[attributes["compression"][0]]
    channels = _channels(attributes["channels"])
    planes = {name: np.empty((height, width), kind) for name, kind in channels}
    bytes_of_line = width * sum(kind.itemsize for _, kind in channels)
    count = -(-height // lines)
    for offset in struct.unpack_from(f"<{count}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        rows = min(lines, height - (y - y0))
        block = _unpacked(data[offset + 8:offset + 8 + size], rows * bytes_of_line)
        position = 0
        for row in range(y - y0, y - y0 + rows):
            for name, kind in channels:
                planes[name][row] = np.frombuffer(block, kind, width, position)
                position += width * kind.itemsize
    return planes
