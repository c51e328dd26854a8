"""Draws glassware.xml by MuJoCo and by Sideray, side by side: mujoco_glass.py [PICTURE.png] [WIDTH HEIGHT]

It needs `pip install mujoco`; MuJoCo's own half needs MUJOCO_GL=egl or osmesa without a display.
"""

import os
import pathlib
import sys
import time

os.environ.setdefault("MUJOCO_GL", "egl")
import mujoco
import numpy as np

import sideray.mujoco

path = sys.argv[1] if len(sys.argv) > 1 else "mujoco.png"
width, height = map(int, sys.argv[2:4]) if len(sys.argv) > 3 else (640, 480)
model = mujoco.MjModel.from_xml_path(str(pathlib.Path(__file__).with_name("glassware.xml")))
data = mujoco.MjData(model)
for _ in range(80):
    mujoco.mj_step(model, data)


def draw(renderer):
    with renderer:
        renderer.update_scene(data)
        renderer.render()  # the first picture includes building the scene
        begin = time.perf_counter()
        pixels = renderer.render()
        print(f"{type(renderer).__module__:40}{1000 * (time.perf_counter() - begin):8.1f} ms")
        return pixels


pictures = [draw(mujoco.Renderer(model, height, width)),
            draw(sideray.mujoco.Renderer(model, height, width, samples=4, shadows="exact"))]
draw(sideray.mujoco.Renderer(model, height, width))
sideray.save_png(path, np.concatenate(pictures, axis=1))
