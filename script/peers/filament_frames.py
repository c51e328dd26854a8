"""Draws a .glb with Filament, as MuJoCo 4 brings it, and prints what it took as JSON: run by script/scoreboard."""
import abc
import collections.abc
import json
import pathlib
import sys

import mujoco
import numpy
from mujoco import mjrf
from PIL import Image

if not hasattr(collections.abc, "Buffer"):  # before Python 3.12
    collections.abc.Buffer = abc.ABCMeta("Buffer", (), {"__subclasshook__": classmethod(lambda cls, kind: kind is numpy.ndarray)})
import mujoco.studio._studio  # noqa: E402, F401  brings Filament's materials
from mujoco.rendering.filament.model_scene import ModelScene  # noqa: E402
from mujoco.rendering.filament.renderer import Renderer, View  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import parser_of, timed  # noqa: E402
from gltf import Glb  # noqa: E402
from mujoco_model import Builder  # noqa: E402


def main():
    options = parser_of("filament_frames.py", __doc__).parse_args()
    width, height = options.size
    model = Builder(Glb(options.scene), options.sky, width, height).model()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    config = mjrf.ContextConfig()
    config.graphics_api = mjrf.GraphicsApi.GRAPHICS_API_OPENGL
    config.software_rendering = True
    context = mjrf.Context(config)
    renderer = Renderer(context)
    scene = ModelScene(context, model, renderer.scene("scene"))
    pixels = numpy.zeros((height, width, 3), numpy.uint8)
    renderer.target("picture", pixels)
    option, camera, view = mujoco.MjvOption(), mujoco.MjvCamera(), mujoco.MjvScene(model, 2 * model.ngeom + 100)
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    start = model.cam_pos[0].copy()

    def frame(number):
        model.cam_pos[0] = start + [1e-5 * number, 0, 0]
        mujoco.mj_camlight(model, data)
        scene.update(data)
        mujoco.mjv_updateScene(model, data, option, None, camera, mujoco.mjtCatBit.mjCAT_ALL, view)
        eye = mujoco.mjv_averageCamera(view.camera[0], view.camera[1])
        renderer.render([View("scene", "picture", camera=eye)])

    frame(0)
    Image.fromarray(pixels).save(options.o)
    print(json.dumps({"version": mujoco.__version__, "gl": "", **timed(frame, options.frames)}))


main()
