#!/usr/bin/env python3
"""The data set of examples/dataset: dataset_test.py SIDERAY SOURCE. Exits with 77 where numpy or Pillow is missing."""
import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
    from PIL import Image
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

SIDERAY, SOURCE = sys.argv[1:3]
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
                    "--sideray", SIDERAY, "--", "--threads", "2"], check=True, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})


def decoded(mask):
    height, width = mask["size"]
    return np.repeat(np.arange(len(mask["counts"])) % 2, mask["counts"]).reshape(width, height).T.astype(bool)


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


check_shapes()
with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
    make(one), make(two)
    check_files(one)
    for name in ("annotations.json", "scenes/000004.glb", "channels/000004.exr", "rgb/000004.png"):
        with open(os.path.join(one, name), "rb") as a, open(os.path.join(two, name), "rb") as b:
            assert a.read() == b.read(), name
print("ok")
