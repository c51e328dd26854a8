"""The example that uses the whole package runs, and type checkers in strict mode find nothing in it nor in the package."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import sideray

SOURCE = pathlib.Path(os.environ.get("SIDERAY_SOURCE", pathlib.Path(__file__).parents[2]))
TOUR = SOURCE / "examples/python/tour.py"
PACKAGE = pathlib.Path(sideray.__file__).parent


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def checker(module):
    return pytest.importorskip(module, reason=f"the package {module} is not installed: pip install {module}")


def test_the_tour_runs(tmp_path):
    printed = run(sys.executable, TOUR, tmp_path)
    assert "rays alone" in printed and "ball" in printed
    made = {path.name for path in tmp_path.iterdir()}
    assert {"picture.png", "picture.exr", "annotations.json", "bop", "layered"} <= made


def test_the_tour_names_all_there_is():
    text = TOUR.read_text()
    unused = {"OffscreenRenderer", "RenderFlags",  # pyrender's own scenes are their subject
              "VISIBLE_ALL", "VISIBLE_AO", "VISIBLE_LAYERS", "VISIBLE_REFLECTION", "VISIBLE_SHADOW", "load", "read_image"}
    returned = {"Comparison", "LayeredDepth", "Mask", "Object", "ObjectTruth", "Particles", "Pictures", "SurfaceFace", "SurfaceKind"}
    errors = {name for name in sideray.__all__ if isinstance(getattr(sideray, name), type) and
              issubclass(getattr(sideray, name), sideray.Error)}
    assert [name for name in sideray.__all__ if f"sideray.{name}" not in text and name not in unused | returned | errors
            and f"import {name}" not in text] == []


def test_mypy(tmp_path):
    checker("mypy")
    shutil.copy(TOUR, tmp_path)
    # The package, and as users import it; mypy finds what is installed by itself.
    is_installed = PACKAGE.parent.name in ("site-packages", "dist-packages")
    search = {**os.environ, **({} if is_installed else {"MYPYPATH": str(PACKAGE.parent)})}
    for what in (("-p", "sideray"), ("tour.py",)):
        run(sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", *what, cwd=tmp_path, env=search)


def test_pyright(tmp_path):
    checker("pyright")
    shutil.copy(TOUR, tmp_path)
    # PYTHONPATH is not looked at.
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(
        {"include": ["tour.py"], "typeCheckingMode": "strict", "extraPaths": [str(PACKAGE.parent)]}))
    printed = run(sys.executable, "-m", "pyright", "-p", tmp_path, "--pythonpath", sys.executable, cwd=tmp_path)
    assert "0 errors" in printed and "No source files" not in printed
