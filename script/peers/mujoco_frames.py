"""Draws a .glb with MuJoCo's classic renderer and prints what it took as JSON: run by script/scoreboard."""
import json
import os
import pathlib
import sys

os.environ.setdefault("MUJOCO_GL", "egl")
import mujoco  # noqa: E402
from PIL import Image  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import parser_of, timed  # noqa: E402
from gltf import Glb  # noqa: E402
from mujoco_model import Builder  # noqa: E402


def main():
    options = parser_of("mujoco_frames.py", __doc__).parse_args()
    width, height = options.size
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
