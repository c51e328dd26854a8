"""try_wheel.py [PICTURE.png]: what a stranger does first with an installed wheel, in an empty folder.

Five lines draw a glass picture, with whatever OpenGL there is and by rays alone; the program draws the same scene as a module
and as a command. Prints what drew and how long it took.
"""
import pathlib
import subprocess
import sys
import sysconfig
import time

picture_file = sys.argv[1] if len(sys.argv) > 1 else "glass.png"
began = time.perf_counter()

import sideray
scene = sideray.load("solids")
picture = sideray.Renderer().render(scene, size=(640, 270), samples=4, aov="glass")
picture.save(picture_file)
glass = picture["glass.primitive"] > 0

seconds = time.perf_counter() - began
import numpy
print(f"Python {sys.version.split()[0]}, numpy {numpy.__version__}, sideray {sideray.__version__}: "
      f"{glass.sum()} pixels of glass in {seconds:.1f} s by {sideray.Renderer().device}")

assert pathlib.Path(picture_file).read_bytes().startswith(b"\x89PNG") and 5000 < glass.sum() < 90000
# The view through the glass must not be a constant.
assert picture.rgb[glass].std() > 0.05 and numpy.isfinite(picture.rgb).all()
alone = sideray.Renderer(gl="none")
assert alone.device["gl"] == "none"
assert numpy.abs(alone.render(scene, size=(160, 90)).display().astype(float).mean() - 128) < 100


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 0, (command, done.stderr)
    return done.stdout + done.stderr


console = str(pathlib.Path(sysconfig.get_path("scripts"), "sideray"))
assert run(console, "--version").split() == run(sys.executable, "-m", "sideray", "--version").split()
run(console, "make", "solids", "-o", "scene.glb")
began = time.perf_counter()
warned = run(sys.executable, "-m", "sideray", "render", "scene.glb", "--size", "320x180", "-o", "x.png")
print(f"python -m sideray render: {time.perf_counter() - began:.1f} s", *warned.splitlines(), sep="\n  ")
assert pathlib.Path("x.png").read_bytes().startswith(b"\x89PNG")
