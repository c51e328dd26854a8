#!/usr/bin/env python3
"""Makes a small data set of glassware on a table, with ground truth of what glass does to light.

    make_dataset.py DIR [--count N] [--first I] [--seed S] [--size WxH] [--bop] [--layered] [--threads N] [--option NAME=VALUE]...

DIR/rgb/NNNNNN.png           the picture, sRGB
DIR/channels/NNNNNN.exr      its channels: what is seen, glass, behind and refraction (docs/ground-truth.md)
DIR/scenes/NNNNNN.glb        the scene
DIR/annotations.json         COCO: box and mask of every object, its amodal box and mask, coverage, visible fraction; categories
                             are shapes
DIR/bop/                     --bop: BOP, the poses of the glasses with depth and masks; the first picture's number is that of the scene
DIR/layered/                 --layered: LayeredDepth, the depth of eight layers along the bent paths, and tuples of points

The same seed and size give the same scenes and channels. Needs the Python package sideray, and Debian's python3-numpy and python3-pil.
--option: of Renderer.render, as docs/cli.md names them.
"""
import argparse
import contextlib
import os
import sys

import glassware
import numpy as np

import sideray
from sideray import datasets

SHAPES = list(glassware.SHAPES)  # models are numbered from 1
CATEGORIES = [*SHAPES, *glassware.LIQUIDS, "opaque", "table"]
OPTIONS = {"translucency": "raytraced", "layers": "unlimited", "samples": 4}
# BOP models stand on the XY plane, with the origin in the middle of their box.
Y_UP_FROM_Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def shape_of(name):
    return name.rsplit("_", 1)[0]


def surfaces_by_name(scene):
    found = {}
    for surface, name in scene.names.items():
        found.setdefault(name, []).append(surface)
    return found


def object_from_model(shape):
    """(4, 4): where a model's coordinates are in those of its mesh."""
    positions = glassware.lathe(glassware.SHAPES[shape])[0]
    moved = np.eye(4)
    moved[:3, 3] = 0.5 * (positions.min(0) + positions.max(0))
    return moved @ Y_UP_FROM_Z_UP


def add_models(bop):
    for number, shape in enumerate(SHAPES, 1):
        positions, normals, triangles = glassware.lathe(glassware.SHAPES[shape])
        to_model = np.linalg.inv(object_from_model(shape))
        bop.add_model(number, positions @ to_model[:3, :3].T + to_model[:3, 3], triangles, normals @ to_model[:3, :3].T)


def posed_glasses(places, surfaces):
    for name, place in places.items():
        if shape_of(name) in SHAPES:
            world = np.eye(4)
            world[:3, 3] = place
            yield datasets.BopObject(SHAPES.index(shape_of(name)) + 1, surfaces[name], world @ object_from_model(shape_of(name)))


class DataSet:
    """The files of a data set."""

    def __init__(self, args, renderer, files):
        self.args, self.renderer = args, renderer
        self.coco = files.enter_context(datasets.CocoWriter(self.path("annotations.json"), amodal=True, hidden=True, categories=CATEGORIES))
        self.bop = files.enter_context(datasets.BopWriter(self.path("bop"), scene_id=args.first)) if args.bop else None
        self.layered = datasets.LayeredDepthWriter(self.path("layered")) if args.layered else None
        if self.bop:
            add_models(self.bop)

    def path(self, *parts):
        return os.path.join(self.args.dir, *parts)

    def add(self, number):
        name, size = f"{number:06d}", self.args.size
        places = glassware.write_scene(self.path("scenes", name + ".glb"), self.args.seed, number)
        scene = sideray.load(self.path("scenes", name + ".glb"))
        picture = self.renderer.render(scene, size, aov="first,glass,behind,refraction", **{**OPTIONS, **dict(self.args.option)})
        picture.save(self.path("channels", name + ".exr"))
        picture.save(self.path("rgb", name + ".png"))
        surfaces = surfaces_by_name(scene)
        self.annotate(scene, surfaces, f"rgb/{name}.png", number)
        if self.bop:
            self.bop.add(scene, scene.get_camera(aspect=size[0] / size[1]), picture, picture["first.Z"],
                         list(posed_glasses(places, surfaces)), image_id=number)
        if self.layered:
            self.layered.add(name, picture, scene.layered_depth(size, bent=True), tuples=100, seed=number)

    def annotate(self, scene, surfaces, file_name, number):
        names = dict(enumerate(surfaces, 1))
        truths = scene.object_truth(self.args.size, objects={i: surfaces[n] for i, n in names.items()})
        camera = scene.get_camera(aspect=self.args.size[0] / self.args.size[1])
        self.coco.add(file_name, self.args.size, truths, {i: shape_of(n) for i, n in names.items()}, image_id=number,
                      image={"camera": {"K": camera.intrinsics(self.args.size).ravel().tolist(),
                                        "world_from_camera": camera.world_from_camera[:3].T.ravel().tolist()}},
                      details={i: {"name": n, "surfaces": surfaces[n]} for i, n in names.items()})


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dir")
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", type=lambda text: tuple(int(side) for side in text.split("x")), default=(640, 480), metavar="WxH")
    parser.add_argument("--bop", action="store_true")
    parser.add_argument("--layered", action="store_true")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--option", type=lambda text: tuple(text.split("=", 1)), action="append", default=[], metavar="NAME=VALUE")
    return parser.parse_args()


def main():
    args = arguments()
    for folder in ("scenes", "channels", "rgb"):
        os.makedirs(os.path.join(args.dir, folder), exist_ok=True)
    with sideray.Renderer(threads=args.threads) as renderer, contextlib.ExitStack() as files:
        dataset = DataSet(args, renderer, files)
        for number in range(args.first, args.first + args.count):
            dataset.add(number)
    print(f"{args.count} pictures: {args.dir}")


if __name__ == "__main__":
    try:
        main()
    except sideray.Error as error:
        sys.exit(f"make_dataset.py: {error}")
