"""The programs that script/peers compares: what each needs, how it is run, and what it says of itself."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

from processes import Failure, run
from shared_scene import copy_scene, write_sky

HERE = pathlib.Path(__file__).resolve().parent
SOFTWARE = {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "llvmpipe"}


class Job:
    """What every program draws: files below a temporary folder, a size, a camera."""

    def __init__(self, folder, options, sideray):
        self.folder, self.options, self.sideray = folder, options, sideray
        self.scene, self.dimmed, self.sky = folder / "scene.glb", folder / "dimmed.glb", folder / "sky.hdr"
        self.camera = copy_scene(self.source(), self.scene, self.dimmed, options)
        write_sky(self.sky)

    def source(self):
        name = self.options.scene
        if pathlib.Path(name).is_file():
            return pathlib.Path(name)
        if "." in name or "/" in name:
            raise Failure(f"no file {name}")
        path = self.folder / "made.glb"
        run([self.sideray, "make", name, "-o", path], self.options.limit)
        return path

    def run(self, command, environment=None):
        return run(command, self.options.limit, {**SOFTWARE, **(environment or {})})


class Program:
    """One row of the table. `missing` says what installs it; `draw` runs it once."""

    name = file = transparency = shadows = note = ""
    needs_display = False
    times_frames = True

    def __init__(self):
        self.version, self.gl, self.error = "", "", None
        self.frames_ms, self.processes_ms = [], []
        self.complaints = set()

    def missing(self):
        return []

    def draw(self, job, picture, frames):
        """Draws `picture`, then as many timed frames: milliseconds of the process."""
        raise NotImplementedError

    def take(self, output):
        """Takes what a program in script/peer_programs prints."""
        result = json.loads(output.strip().splitlines()[-1])
        self.version, self.gl = result["version"], result["gl"]
        self.frames_ms += result["frames_ms"]

    def complain(self, text):
        """Shows errors of a run that ended well, each once."""
        for line in text.splitlines():
            line = re.sub(r"\x1b\[[0-9;]*m", "", line).strip()
            kind = re.sub(r"[0-9]+", "", line)
            if re.search(r"\berror\b|ERR\|", line, re.IGNORECASE) and kind not in self.complaints:
                self.complaints.add(kind)
                print(f"peers: {self.name} says: {line}", file=sys.stderr)


class Sideray(Program):
    def __init__(self, sideray, name, options, transparency, shadows):
        super().__init__()
        self.sideray, self.name, self.arguments = sideray, f"Sideray, {name}", options
        self.file, self.transparency, self.shadows = f"sideray-{name}", transparency, shadows

    def draw(self, job, picture, frames):
        stats_file = job.folder / "stats.json"
        timed = ["--json", stats_file, "--repeat", frames] if frames else []
        took, _, err = job.run([self.sideray, "bench" if frames else "render", job.scene, "-o", picture, "--device", "egl:software", "--size",
                                job.options.size, "--camera", job.camera, *self.arguments, *timed])
        self.complain(err)
        if frames:
            stats = json.loads(stats_file.read_text())
            self.gl = stats["device"]["renderer"]
            self.version = run([self.sideray, "--version"], 60)[1].split("\n")[0].removeprefix("sideray ")
            self.frames_ms.append(stats["stages_ms"]["total_frame"])
        return took


class Three(Program):
    name, file = "three.js", "threejs"
    transparency = "BLEND sorted by object; transmission shows a second drawing of what is opaque, no glass behind glass"
    shadows = "maps of all lights, 1024 wide (of a sun 2048), drawn each frame"
    note = ("three.js runs on SwiftShader in headless Chromium, the software OpenGL that Chromium comes with, and the others on "
            "Mesa's; its process is node, Chromium and the page. What shows through transmission it draws with 4 samples a "
            "pixel, which it always does.")

    def __init__(self, folder):
        super().__init__()
        self.modules = folder / "node_modules"
        names = ("chromium", "chromium-browser", "google-chrome")
        self.chromium = next(filter(None, map(shutil.which, names)), None)

    def missing(self):
        lacks = [] if shutil.which("node") else ["apt-get install nodejs npm"]
        lacks += [] if self.chromium else ["apt-get install chromium"]
        if not all((self.modules / name).is_dir() for name in ("three", "puppeteer-core")):
            lacks.append("npm install --prefix FOLDER three puppeteer-core, and SIDERAY_PEERS=FOLDER or --peers FOLDER")
        return lacks

    def draw(self, job, picture, frames):
        width, height = map(int, job.options.size.split("x"))
        took, out, err = job.run(["node", HERE / "three_frames.mjs", json.dumps({
            "modules": str(self.modules.resolve()), "chromium": self.chromium, "scene": str(job.scene),
            "sky": str(job.sky), "picture": str(picture), "width": width, "height": height, "camera": job.camera,
            "frames": frames})], {"TMPDIR": str(job.folder)})  # where the browser's profile goes
        self.take(out)
        self.complain(err)
        package = json.loads((self.modules / "three" / "package.json").read_text())
        self.version = package["version"]
        return took


class Vtk(Program):
    name, file = "VTK", "vtk"
    transparency = "depth peeling of all; transmission as alpha 0.25"
    shadows = "none"
    note = ("VTK's shadow maps know no point lights, and it reads neither transmission nor volumes: "
            "script/peer_programs/vtk_frames.py gives such glass an alpha and a tint. VTK 9.1 stops peeling too early in "
            "pictures of 640x360 and less, so its times are only right where vtk.png shows all layers, as at 1280x720.")
    needs_display = True

    def __init__(self, folder):
        super().__init__()
        candidates = [folder / "bin" / "python3", sys.executable]
        candidates += [pathlib.Path(p) / "python3" for p in os.environ.get("PATH", "").split(":") if p]
        self.python = next(filter(self.has_vtk, candidates), None)

    @staticmethod
    def has_vtk(python):
        look = "import importlib.util, sys; sys.exit(not importlib.util.find_spec('vtk'))"
        return os.access(python, os.X_OK) and subprocess.run([python, "-c", look], check=False,
                                                             stderr=subprocess.DEVNULL).returncode == 0

    def missing(self):
        return [] if self.python else ["apt-get install python3-vtk9, or pip install vtk into a virtual environment of "
                                       "--peers FOLDER"]

    def draw(self, job, picture, frames):
        took, out, err = job.run([self.python, HERE / "vtk_frames.py", job.scene, "-o", picture, "--size",
                                  job.options.size, "--camera", job.camera, "--sky", job.sky, "--frames", frames])
        self.take(out)
        self.complain(err)
        return took


class F3d(Program):
    name, file, gl = "F3D", "f3d", ""
    transparency = "none: glass is opaque, even with --depth-peeling"
    shadows = "none"
    note = ("F3D draws one picture and does not say how long the frame took. It draws glass as opaque surfaces, takes light "
            "without a falloff (lamps of more than 2 candela are dimmed to 2 for it), and gets no sky, since filtering one "
            "would take most of its time.")
    needs_display = True
    times_frames = False

    def missing(self):
        return [] if shutil.which("f3d") else ["apt-get install f3d"]

    def draw(self, job, picture, frames):
        took, out, err = job.run(["f3d", job.dimmed, "--dry-run", "--output", picture, "--camera-index",
                                  job.camera, "--resolution", job.options.size.replace("x", ","), "--depth-peeling"])
        self.complain(out + err)
        self.gl = "Mesa's software OpenGL (F3D does not name it)"
        self.version = run(["f3d", "--version"], 60)[1].split()[1]
        return took


def sideray_programs(path):
    return [Sideray(path, "hybrid", [], "ray-traced layers at each pixel, defaults; sorted fragments for the rest",
                    "rays to all lights, with penumbrae, denoised"),
            Sideray(path, "raster", ["--translucency", "raster", "--shadows", "map"], "sorted fragments, by pixel",
                    "maps of all lights, at most 1024 wide (of a sun 2048), drawn each frame")]


def peers(folder):
    return [Three(folder), Vtk(folder), F3d()]


def split(programs):
    """(those that are there, those that are not with what installs them)."""
    there, absent = [], []
    for program in programs:
        lacks = program.missing()
        if program.needs_display and not shutil.which("Xvfb"):
            lacks.append("apt-get install xvfb")
        if lacks:
            absent.append((program, lacks))
        else:
            there.append(program)
    return there, absent
