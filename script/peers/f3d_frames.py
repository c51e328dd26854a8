"""Draws a .glb with F3D and prints what it took as JSON: run by script/scoreboard."""
import argparse
import json
import pathlib
import sys

import f3d

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import timed  # noqa: E402


def main():
    parser = argparse.ArgumentParser(prog="f3d_frames.py", description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("-o", required=True, help="the .png to write")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--sky", help="a lat-long .hdr")
    parser.add_argument("--frames", type=int, default=0, help="how many frames are timed after the first")
    options = parser.parse_args()
    f3d.Engine.autoload_plugins()
    engine = f3d.Engine.create(True)
    window = engine.window
    window.size = tuple(map(int, options.size.split("x")))
    engine.options.update({"render.effect.blending.mode": "ddp", "render.effect.antialiasing.mode": "fxaa",
                           "render.effect.ambient_occlusion": True, "render.grid.enable": False, "ui.axis": False,
                           "ui.filename": False, "render.effect.tone_mapping": False, "scene.camera.index": 0})
    if options.sky:
        engine.options.update({"render.hdri.ambient": True, "render.background.skybox": "hdri", "render.hdri.file": options.sky})
    engine.scene.add(options.scene)
    window.render()
    window.render_to_image().save(options.o)
    camera = window.camera
    start = camera.position

    def frame(number):
        camera.position = (start[0] + 1e-5 * number, *start[1:])
        window.render()
        window.render_to_image()  # waits for the picture

    print(json.dumps({"version": f3d.__version__, "gl": "", **timed(frame, options.frames)}))


main()
