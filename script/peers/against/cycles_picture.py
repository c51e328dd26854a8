"""Renders a .glb in Blender's Cycles, with direct light only or by paths: run by script/peers/against/cycles."""
import argparse
import pathlib
import sys

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
sys.dont_write_bytecode = True
from blender_scene import Look, add_world, build  # noqa: E402
from gltf import Glb  # noqa: E402


def set_up(options):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.seed = options.samples, options.seed
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    # Direct light, or all that bounces; as many transparent surfaces as there are.
    bounces = 0 if options.bounces == "1" else 1024
    scene.cycles.max_bounces = scene.cycles.glossy_bounces = bounces
    scene.cycles.diffuse_bounces = scene.cycles.transmission_bounces = scene.cycles.volume_bounces = bounces
    scene.cycles.transparent_max_bounces = 256
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = True
    scene.cycles.light_sampling_threshold = 0
    scene.cycles.pixel_filter_type = "BOX"
    width, height = (int(n) for n in options.size.split("x"))
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.film_transparent = False
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGB"
    add_world(None)
    if options.threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", options.threads


def main():
    parser = argparse.ArgumentParser(prog="cycles_picture.py", description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("-o", required=True, help="the .exr to write")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bounces", choices=["1", "unlimited"], default="1")
    parser.add_argument("--schlick", action="store_true", help="bodies of glass reflect by glTF's term in place of Fresnel's")
    parser.add_argument("--threads", type=int, default=0)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    set_up(options)
    build(Glb(options.scene), Look(options.bounces != "1", options.schlick))
    bpy.context.scene.render.filepath = str(pathlib.Path(options.o).resolve())
    bpy.ops.render.render(write_still=True)


main()
