#!/usr/bin/env python3
"""Regenerates docs/images/glass-shadows.jpg: scenes without and with the shadows of their glass.

    PYTHONPATH=build/python script/pages/glass_shadows.py GlassTable.glb CupAndWater.glb

Needs Debian's python3-numpy and python3-pil.
"""
import dataclasses
import pathlib
import sys
import tempfile

import numpy as np
from PIL import Image

import sideray

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "examples" / "dataset"))
SIZE, GAP = (512, 288), 6
WITH_SHADOWS = sideray.VISIBLE_ALL
WITHOUT_SHADOWS = sideray.VISIBLE_ALL & ~sideray.VISIBLE_SHADOW


def glass_of(scene, camera):
    """The instances that are translucent where the camera sees them, hidden ones included."""
    layers = scene.layered_depth((256, 144), camera, layers=64)
    return np.unique(layers.instance[layers.kind >= sideray.SurfaceKind.BLEND])


def pair(renderer, scene, camera, zoom):
    """The picture without shadows of glass, and the picture with them."""
    seen = scene.get_camera(camera, aspect=SIZE[0] / SIZE[1])
    seen = dataclasses.replace(seen, yfov=seen.yfov / zoom)
    glass, pictures = glass_of(scene, seen), []
    for visibility in (WITHOUT_SHADOWS, WITH_SHADOWS):
        for instance in glass:
            scene._edited().set_visibility(int(instance), visibility)
        pictures.append(Image.fromarray(renderer.render(scene, SIZE, seen, samples=4).display()))
    return pictures


def on_floor(scene):
    low, high = scene.bounds
    x, z, reach = 0.5 * (low[0] + high[0]), 0.5 * (low[2] + high[2]), 2 * np.max(high - low)
    corners = [[x - reach, low[1], z - reach], [x - reach, low[1], z + reach], [x + reach, low[1], z + reach], [x + reach, low[1], z - reach]]
    scene.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], material={"base_color": (0.7, 0.68, 0.64, 1.0), "roughness": 0.9})
    return scene


def data_set_scene(folder):
    import glassware
    path = str(pathlib.Path(folder) / "glasses.glb")
    glassware.write_scene(path, 1, 8)
    return sideray.load(path)


def scenes(table, cup, folder):
    """Scene, camera and zoom of each row."""
    yield sideray.load("solids"), None, 1.0
    framed = sideray.load(table)
    camera = framed.get_camera(aspect=SIZE[0] / SIZE[1])
    yield on_floor(framed), camera, 1.7
    yield sideray.load(cup), None, 3.0
    yield sideray.load("bistro"), "table", 1.0
    yield data_set_scene(folder), None, 1.0


def main():
    if len(sys.argv) != 3 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder, sideray.Renderer() as renderer:
        rows = [pair(renderer, *scene) for scene in scenes(*sys.argv[1:], folder)]
    page = Image.new("RGB", (2 * SIZE[0] + GAP, len(rows) * (SIZE[1] + GAP) - GAP), "white")
    for row, pictures in enumerate(rows):
        for column, picture in enumerate(pictures):
            page.paste(picture, (column * (SIZE[0] + GAP), row * (SIZE[1] + GAP)))
    page.save(ROOT / "docs" / "images" / "glass-shadows.jpg", quality=85, optimize=True)


if __name__ == "__main__":
    main()
