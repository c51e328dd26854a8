#!/usr/bin/env python3
"""Times sideray.mujoco.Renderer beside mujoco.Renderer, step by step in turn: mujoco_speed.py MODEL.xml ... [--size 256x256,640x480]

Of each model, size and way of drawing: the median processor time, of all threads, of a simulated step's update_scene() and
render() by either, and their ratio. It is the same on a busy machine as on a quiet one, but for what threads wait for in turn.
It needs PyPI's mujoco; MuJoCo's own half needs MUJOCO_GL=egl or osmesa without a display.
"""

import argparse
import os
import pathlib
import statistics
import time

os.environ.setdefault("MUJOCO_GL", "egl")
import mujoco
import numpy as np

import sideray.mujoco

CHANNELS = ("rgb", "depth", "segmentation")


class Way:
    """What a loop draws in each step."""

    def __init__(self, name, channels=("rgb",), lit=True):
        self.name, self.channels, self.lit = name, channels, lit

    def draw(self, renderer, data, camera):
        renderer.update_scene(data, camera)
        flags = renderer.scene.flags
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = self.lit
        if isinstance(renderer, sideray.mujoco.Renderer) and len(self.channels) > 1:
            renderer.render_channels(self.channels)
            return
        for channel in self.channels:
            if channel == "depth":
                renderer.enable_depth_rendering()
            elif channel == "segmentation":
                renderer.enable_segmentation_rendering()
            renderer.render()
            renderer.disable_depth_rendering()
            renderer.disable_segmentation_rendering()


WAYS = (Way("shadows and reflections"), Way("neither", lit=False), Way("depth", ("depth",)),
        Way("rgb, depth, segmentation", CHANNELS))


def measure(path, size, ways, steps, options):
    model = mujoco.MjModel.from_xml_path(str(path))
    width, height = size
    model.vis.global_.offwidth, model.vis.global_.offheight = max(width, 640), max(height, 480)
    data = mujoco.MjData(model)
    camera = 0 if model.ncam else -1
    ours = sideray.mujoco.Renderer(model, height, width, **options)
    theirs = mujoco.Renderer(model, height, width)
    with ours, theirs:
        for way in ways:
            mujoco.mj_resetData(model, data)
            mujoco.mj_forward(model, data)
            times = ([], [])
            for step in range(steps + 2):
                mujoco.mj_step(model, data)
                for renderer, kept in zip((ours, theirs), times):
                    begin = time.process_time()
                    way.draw(renderer, data, camera)
                    if step >= 2:
                        kept.append(1000 * (time.process_time() - begin))
            mine, other = map(statistics.median, times)
            print(f"| {path.parent.name}/{path.stem} | {width}x{height} | {way.name} | {other:.1f} | {mine:.1f} | "
                  f"{mine / other:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="+", type=pathlib.Path)
    parser.add_argument("--size", default="256x256,640x480")
    parser.add_argument("--steps", type=int, default=15)
    parser.add_argument("--gl", default="none")
    parser.add_argument("--ways", default="", help="their numbers, 0 to 3: all")
    given = parser.parse_args()
    sizes = [tuple(map(int, size.split("x"))) for size in given.size.split(",")]
    ways = [WAYS[int(number)] for number in given.ways.split(",")] if given.ways else WAYS
    print("| model | size | drawn | mujoco.Renderer [ms] | sideray.mujoco.Renderer [ms] | ratio |\n|---|---|---|---|---|---|")
    for path in given.models:
        for size in sizes:
            measure(path, size, ways, given.steps, {"gl": given.gl})


if __name__ == "__main__":
    main()
