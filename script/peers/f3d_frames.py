"""Draws a .glb with F3D and prints what it took as JSON: run by script/scoreboard."""
import json
import pathlib
import sys

import f3d

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import parser_of, timed  # noqa: E402


def main():
    options = parser_of("f3d_frames.py", __doc__).parse_args()
    f3d.Engine.autoload_plugins()
    engine = f3d.Engine.create(True)
    window = engine.window
    window.size = options.size
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
