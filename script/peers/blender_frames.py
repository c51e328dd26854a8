"""Draws a .glb with Blender's Cycles or EEVEE and prints what it took as JSON: run by script/scoreboard."""
import json
import pathlib
import sys

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from blender_scene import Look, add_world, build  # noqa: E402
from frames import parser_of, timed  # noqa: E402
from gltf import Glb  # noqa: E402


def set_up(scene, options, width, height):
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.film_transparent = False
    scene.render.use_persistent_data = True  # further frames do not build the scene again
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGB"


def set_up_cycles(scene, options):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed = "CPU", options.samples, options.seed
    cycles.use_adaptive_sampling, cycles.use_denoising = False, options.denoise
    cycles.max_bounces = cycles.glossy_bounces = cycles.diffuse_bounces = cycles.transmission_bounces = options.bounces
    cycles.volume_bounces, cycles.transparent_max_bounces = 0, 64
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type = "BOX"


def set_up_eevee(scene, options):
    scene.render.engine = "BLENDER_EEVEE"
    scene.eevee.taa_render_samples = options.samples
    scene.eevee.use_raytracing = True
    scene.eevee.use_shadows = True


def main():
    parser = parser_of("blender_frames.py", __doc__, picture=".exr")
    parser.add_argument("--engine", choices=["cycles", "eevee"], default="cycles")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bounces", type=int, default=64)
    parser.add_argument("--denoise", action="store_true")
    options = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    set_up(scene, options, *options.size)
    eevee = options.engine == "eevee"
    (set_up_eevee if eevee else set_up_cycles)(scene, options)
    add_world(options.sky)
    build(Glb(options.scene), Look(by_paths=True, culled=eevee, principled=True, rasterized=eevee), sun_where_dark=False)
    scene.render.filepath = str(pathlib.Path(options.o).resolve())
    bpy.ops.render.render(write_still=True)
    start = scene.camera.location.x

    def frame(number):
        scene.camera.location.x = start + 1e-5 * number
        bpy.ops.render.render()

    result = timed(frame, options.frames)
    print("\n" + json.dumps({"version": bpy.app.version_string, **result}))


main()
