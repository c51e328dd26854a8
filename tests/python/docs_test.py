"""The code of docs/python.md and the examples run, in the order of the page."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

import sideray

SOURCE = pathlib.Path(os.environ.get("SIDERAY_SOURCE", pathlib.Path(__file__).parents[2]))
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a scene.glb, where the page's code leaves its files."""
    program = os.environ.get("SIDERAY_PROGRAM")
    if not program:
        pytest.skip("SIDERAY_PROGRAM names no program to make scene.glb with")
    subprocess.run([program, "make", "panes", "-o", tmp_path / "scene.glb"], check=True, stdout=subprocess.DEVNULL)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_code_of_the_page(folder):
    blocks = BLOCK.findall((SOURCE / "docs/python.md").read_text())
    assert len(blocks) >= 6 and len(blocks[0].splitlines()) == 5, "it starts with five lines"
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert (folder / "picture.png").stat().st_size > 1000


def test_code_of_the_page_of_mujoco(tmp_path, monkeypatch):
    pytest.importorskip("mujoco", "3.0", reason="the package mujoco is not installed: pip install mujoco")
    monkeypatch.chdir(tmp_path)
    shutil.copy(SOURCE / "examples/python/glassware.xml", tmp_path)
    blocks = BLOCK.findall((SOURCE / "docs/mujoco.md").read_text())
    assert len(blocks) >= 3
    names = {}
    for block in blocks:
        exec(compile(block, "docs/mujoco.md", "exec"), names)
    assert names["pixels"].shape == (240, 320, 3) and names["first"].shape == (240, 320, 2)


def test_tables_of_the_page_name_what_there_is():
    page = (SOURCE / "docs/python.md").read_text()
    for name in re.findall(r"`sideray\.(\w+)", page):
        assert hasattr(sideray, name), name
    for name in re.findall(r"`picture\.(\w+)", page):
        assert hasattr(sideray.Picture, name), name


def test_example_of_a_chart(folder):
    script = SOURCE / "examples/python/chart.py"
    run = subprocess.run([sys.executable, script, "panes", "64", "36", "chart.png"], check=True, capture_output=True,
                         text=True)
    assert "hybrid" in run.stdout and "raster" in run.stdout
    assert (folder / "chart.png").exists() == ("matplotlib is not installed" not in run.stderr)
