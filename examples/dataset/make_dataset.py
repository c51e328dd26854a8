#!/usr/bin/env python3
"""Makes a small data set of glassware on a table, with ground truth of what glass does to light.

    make_dataset.py DIR [--count N] [--first I] [--seed S] [--size WxH] [--sideray PROGRAM] [-- OPTIONS OF sideray render]

DIR/rgb/NNNNNN.png           the picture, sRGB
DIR/channels/NNNNNN.exr      its channels: what is seen, glass, behind and refraction (docs/ground-truth.md)
DIR/scenes/NNNNNN.glb        the scene
DIR/annotations.json         COCO: box and mask of every visible object, its amodal box and mask, coverage, visible fraction;
                             categories are shapes

The same seed and size give the same scenes and channels. Needs Debian's python3-numpy and python3-pil.
"""
import argparse
import json
import os
import subprocess
import sys

import exr
import glassware
import numpy as np
from PIL import Image

CHANNELS = "Z,id,first,glass,behind,refraction"


def to_srgb(linear):
    x = np.clip(np.nan_to_num(linear), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def rgb_of(planes):
    linear = np.stack([planes[c].astype(np.float64) for c in "RGB"], axis=-1)
    return np.round(to_srgb(linear / (1 + 0.25 * linear)) * 255).astype(np.uint8)


def shape_of(name):
    return name.rsplit("_", 1)[0]


def add_annotations(dataset, truth, file_name, number):
    """Takes over the annotations of one picture; ids are unique in the data set, and categories are shapes."""
    image = dict(truth["images"][0], id=number, file_name=file_name)
    dataset["images"].append(image)
    categories = {c["name"]: c["id"] for c in dataset["categories"]}
    for annotation in truth["annotations"]:
        shape = shape_of(annotation["name"])
        if shape not in categories:
            categories[shape] = len(categories) + 1
            dataset["categories"].append({"id": categories[shape], "name": shape})
        dataset["annotations"].append(dict(annotation, id=len(dataset["annotations"]) + 1, image_id=number, category_id=categories[shape]))


def make_picture(args, number, dataset):
    name = f"{number:06d}"
    scene, channels = (os.path.join(args.dir, *p) for p in (("scenes", name + ".glb"), ("channels", name + ".exr")))
    objects = os.path.join(args.dir, "channels", name + ".json")
    glassware.write_scene(scene, args.seed, number)
    subprocess.run([args.sideray, "render", scene, "-o", channels, "--size", args.size, "--aov", CHANNELS, "--truth", objects,
                    "--translucency", "raytraced", "--layers", "unlimited", "--samples", "4", *args.options], check=True)
    Image.fromarray(rgb_of(exr.read(channels))).save(os.path.join(args.dir, "rgb", name + ".png"))
    with open(objects, encoding="utf-8") as file:
        add_annotations(dataset, json.load(file), f"rgb/{name}.png", number)
    os.remove(objects)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dir")
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--sideray", default="sideray")
    at = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    args = parser.parse_args(sys.argv[1:at])
    args.options = sys.argv[at + 1:]
    for folder in ("scenes", "channels", "rgb"):
        os.makedirs(os.path.join(args.dir, folder), exist_ok=True)
    dataset = {"images": [], "categories": [], "annotations": []}
    for number in range(args.first, args.first + args.count):
        make_picture(args, number, dataset)
    with open(os.path.join(args.dir, "annotations.json"), "w", encoding="utf-8") as file:
        json.dump(dataset, file)
    print(f"{len(dataset['images'])} pictures, {len(dataset['annotations'])} objects: {args.dir}")


if __name__ == "__main__":
    main()
