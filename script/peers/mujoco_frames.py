"""Draws a .glb with MuJoCo's classic renderer and prints what it took as JSON: run by script/scoreboard."""
import argparse
import json
import os
import pathlib
import sys

os.environ.setdefault("MUJOCO_GL", "egl")
import mujoco  # noqa: E402
from PIL import Image  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import timed  # noqa: E402
from gltf import Glb  # noqa: E402
from mujoco_model import Builder  # noqa: E402


def main():
    parser = argparse.ArgumentParser(prog="mujoco_frames.py", description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("-o", required=True, help="the .png to write")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--sky", help="a lat-long .hdr, whose mean is the constant light")
    parser.add_argument("--frames", type=int, default=0, help="how many frames are timed after the first")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    model = Builder(Glb(options.scene), options.sky, width, height).model()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = model.cam_pos[0].copy()
    with mujoco.Renderer(model, height, width, max_geom=max(1000, 2 * model.ngeom)) as renderer:
        def frame(number):
            model.cam_pos[0] = start + [1e-5 * number, 0, 0]
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera="camera")
            return renderer.render()

        Image.fromarray(frame(0)).save(options.o)
        result = timed(frame, options.frames)
    print(json.dumps({"version": mujoco.__version__, "gl": "", **result}))


main()
