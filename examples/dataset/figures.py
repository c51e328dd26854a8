#!/usr/bin/env python3
"""Regenerates the pictures of docs/ground-truth.md: figures.py [DIR for the data set]

It draws the data set of examples/dataset. Needs the Python package sideray, and Debian's python3-numpy and python3-pil.
"""
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

import sideray

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SIZE, COUNT, SHOWN = (320, 240), 8, 4
IMAGES = os.path.join(ROOT, "docs", "images")


def colored(ids):
    """Each number has a colour of its own; 0 is black."""
    hues = np.stack([np.sin(ids * 2.4 + phase) * 0.4 + 0.55 for phase in (0, 2.1, 4.2)], axis=-1)
    return np.where((ids > 0)[..., None], hues, 0)


def shades(depth, low, high, shown=None):
    t = np.clip((high - depth) / (high - low), 0, 1) * 0.9 + 0.1
    t = np.where(np.isfinite(depth) & (True if shown is None else shown), t, 0)
    return np.stack([t, t, t], axis=-1)


def normals(planes, prefix, shown):
    n = np.stack([planes[f"{prefix}.N.{c}"] for c in "XYZ"], axis=-1) * 0.5 + 0.5
    return np.where(shown[..., None], n, 0)


def bytes_of(values):
    return np.round(np.clip(values, 0, 1) * 255).astype(np.uint8)


def unbent(planes, rgb):
    """What the picture shows where each bent path ends: the picture fetched by the correspondence."""
    height, width = planes["refraction.X"].shape
    x = np.clip(np.nan_to_num(planes["refraction.X"]).astype(int), 0, width - 1)
    y = np.clip(np.nan_to_num(planes["refraction.Y"]).astype(int), 0, height - 1)
    fetched = rgb[y, x] / 255.0
    unseen = {2: (0.2, 0.3, 0.9), 3: (0.9, 0.25, 0.2)}
    for state, color in unseen.items():
        fetched[planes["refraction.state"] == state] = color
    fetched[planes["refraction.state"] == 0] = 0
    return np.where((planes["behind.turns"] > 0)[..., None], fetched, 0.4 * fetched)


def outlined(rgb, truths):
    """The amodal outline of every object, and its visible part in colour."""
    picture = rgb / 255.0 * 0.6
    for number, truth in enumerate(truths, 1):
        color = colored(np.array(number))
        visible, amodal = truth.visible.pixels, truth.amodal.pixels
        picture[visible] = 0.6 * picture[visible] + 0.4 * color
        inside = np.pad(amodal, 1)
        edge = amodal & ~(inside[:-2, 1:-1] & inside[2:, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:])
        picture[edge] = color
    return picture


def save(name, rows, palette=False):
    image = np.concatenate([np.concatenate(row, axis=1) for row in rows], axis=0)
    path = os.path.join(IMAGES, name)
    small = Image.fromarray(image).quantize(256) if palette else Image.fromarray(image & 0xf8 | image >> 5)
    small.save(path, "PNG", optimize=True)
    print(path, os.path.getsize(path))


def channel_tiles(folder, number):
    planes = sideray.read_image(os.path.join(folder, "channels", f"{number:06d}.exr"))
    rgb = np.array(Image.open(os.path.join(folder, "rgb", f"{number:06d}.png")))
    glass = planes["glass.primitive"] > 0
    low, high = np.percentile(planes["first.Z"][glass], 1), np.percentile(planes["first.Z"][glass], 99) + 0.25
    bent = unbent(planes, rgb)
    scene = sideray.load(os.path.join(folder, "scenes", f"{number:06d}.glb"))
    truths = [truth for truth in scene.object_truth(SIZE) if scene.names[truth.object] != "table"]
    tiles = [rgb / 255.0, colored(planes["first.surface"]), shades(planes["glass.Z"], low, high, glass), normals(planes, "glass", glass),
             outlined(rgb, truths), colored(planes["behind.surface"]), shades(planes["behind.Z"], low, high),
             bent]
    tiles = [bytes_of(t) for t in tiles]
    return [tiles[:4], tiles[4:]]


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="glassware-")
    subprocess.run([sys.executable, os.path.join(ROOT, "examples", "dataset", "make_dataset.py"), folder, "--size",
                    f"{SIZE[0]}x{SIZE[1]}", "--count", str(COUNT)], check=True)
    save("ground-truth-channels.png", channel_tiles(folder, SHOWN))
    pictures = [np.array(Image.open(os.path.join(folder, "rgb", f"{n:06d}.png")).resize((160, 120), Image.Resampling.BOX))
                for n in range(1, COUNT + 1)]
    save("ground-truth-dataset.png", [pictures[:COUNT // 2], pictures[COUNT // 2:]], palette=True)


if __name__ == "__main__":
    main()
