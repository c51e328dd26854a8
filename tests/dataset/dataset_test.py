#!/usr/bin/env python3
"""The data set of examples/dataset: dataset_test.py SOURCE. Exits with 77 where sideray, numpy or Pillow cannot be imported."""
import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import sideray  # noqa: F401
    from PIL import Image
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

SOURCE = sys.argv[1]
EXAMPLE = os.path.join(SOURCE, "examples", "dataset")
sys.path.insert(0, EXAMPLE)
sys.dont_write_bytecode = True
import exr  # noqa: E402
import glassware  # noqa: E402


def volume(positions, triangles):
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def check_shapes():
    """Walls are closed, and their fronts are outside: every edge has two triangles, in opposite ways."""
    outlines = list(glassware.SHAPES.values()) + [glassware.liquid_outline(s, 0.5) for s in glassware.FILLED_FROM]
    for outline in outlines:
        positions, _, triangles = glassware.lathe(outline, 12)
        assert volume(positions, triangles) > 0
        named = np.unique(np.round(positions, 9), axis=0, return_inverse=True)[1].reshape(-1)[triangles]
        edges = [(t[k], t[(k + 1) % 3]) for t in named.tolist() for k in range(3)]
        once = set(edges)
        assert len(once) == len(edges) and all((b, a) in once for a, b in edges)


def make(folder):
    subprocess.run([sys.executable, os.path.join(EXAMPLE, "make_dataset.py"), folder, "--count", "1", "--first", "4", "--size", "80x60",
                    "--bop", "--layered", "--threads", "2", "--option", "samples=2"], check=True,
                   env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})


def runs_of(text):
    """COCO's compressed run lengths: groups of five bits; from the fourth on a length is a difference to the one two before it."""
    numbers, value, shift = [], 0, 0
    for character in text:
        group = ord(character) - 48
        value |= (group & 31) << shift
        shift += 5
        if not group & 32:
            value -= (1 << shift) if group & 16 else 0
            numbers.append(value + (numbers[-2] if len(numbers) > 2 else 0))
            value = shift = 0
    return numbers


def decoded(mask):
    height, width = mask["size"]
    runs = runs_of(mask["counts"])
    return np.repeat(np.arange(len(runs)) % 2, runs).reshape(width, height).T.astype(bool)


def check_files(folder):
    with open(os.path.join(folder, "annotations.json"), encoding="utf-8") as file:
        dataset = json.load(file)
    planes = exr.read(os.path.join(folder, "channels", "000004.exr"))
    assert planes["first.surface"].shape == (60, 80)
    assert np.array(Image.open(os.path.join(folder, "rgb", "000004.png"))).shape == (60, 80, 3)
    for annotation in dataset["annotations"]:
        visible, amodal = decoded(annotation["segmentation"]), decoded(annotation["amodal_segmentation"])
        assert np.array_equal(visible, np.isin(planes["first.surface"], annotation["surfaces"]))
        assert not (visible & ~amodal).any() and visible.sum() == annotation["area"] and amodal.sum() == annotation["amodal_area"]
    glass = planes["glass.surface"] > 0
    assert glass.sum() > 200 and (planes["behind.turns"][glass] > 0).mean() > 0.9 and not (planes["behind.turns"][~glass] > 0).any()
    # The table lies on y = 0 behind most of the glass, and its normal points up.
    table = next(a for a in dataset["annotations"] if a["name"] == "table")["surfaces"][0]
    seen = planes["behind.surface"] == table
    assert np.allclose(planes["behind.N.Y"][seen], 1)
    assert (seen & glass).sum() > 100


def image(*parts):
    return np.array(Image.open(os.path.join(*parts))).astype(int)


def check_bop(folder):
    """Masks are those of the annotations, and the middle of a model's box is projected into the box of its whole silhouette."""
    with open(os.path.join(folder, "annotations.json"), encoding="utf-8") as file:
        of_glasses = [a for a in json.load(file)["annotations"] if a["name"].rsplit("_", 1)[0] in glassware.SHAPES]
    scene = os.path.join(folder, "bop", "train_pbr", "000004")
    (camera,), (poses,), (infos,) = (json.load(open(os.path.join(scene, f"scene_{kind}.json"), encoding="utf-8")).values()
                                     for kind in ("camera", "gt", "gt_info"))
    assert len(poses) == len(infos) == len(of_glasses) > 2
    k = np.reshape(camera["cam_K"], (3, 3))
    for i, (pose, info, annotation) in enumerate(zip(poses, infos, of_glasses)):
        assert list(glassware.SHAPES)[pose["obj_id"] - 1] == annotation["name"].rsplit("_", 1)[0]
        mask, visible = (image(scene, kind, f"000004_{i:06d}.png") > 0 for kind in ("mask", "mask_visib"))
        # Rays of the wider canvas differ in bits.
        assert (mask != decoded(annotation["amodal_segmentation"])).sum() <= 2
        assert (visible != decoded(annotation["segmentation"])).sum() <= 2
        x, y, depth = k @ np.array(pose["cam_t_m2c"]) / [1, 1, 1]
        left, top, width, height = info["bbox_obj"]
        assert left < x / depth < left + width and top < y / depth < top + height and 300 < depth < 900
    assert np.abs(image(scene, "depth", "000004.png") * camera["depth_scale"] -
                  1000 * exr.read(os.path.join(folder, "channels", "000004.exr"))["first.Z"]).max() <= 0.51 * camera["depth_scale"]


def check_layers(folder):
    planes = exr.read(os.path.join(folder, "channels", "000004.exr"))
    layers = [image(folder, "layered", f"000004.depth_{n}.png") for n in range(1, 9)]
    assert np.abs(layers[0] - 1000 * planes["first.Z"]).max() <= 0.51 and (layers[2] > 0).sum() > 200
    assert all((deeper[layer == 0] == 0).all() for layer, deeper in zip(layers, layers[1:]))
    with open(os.path.join(folder, "layered", "000004.tuples.json"), encoding="utf-8") as file:
        assert len(json.load(file)["layer_all"]["quads"]) == 100


check_shapes()
with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
    make(one), make(two)
    check_files(one), check_bop(one), check_layers(one)
    written = [os.path.relpath(os.path.join(at, name), one) for at, _, names in os.walk(one) for name in names]
    assert len(written) > 30
    for name in written:
        with open(os.path.join(one, name), "rb") as a, open(os.path.join(two, name), "rb") as b:
            assert a.read() == b.read(), name
print("ok")
