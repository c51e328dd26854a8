"""The programs that script/scoreboard compares: what each needs, how it is run, and what it cannot draw."""
import dataclasses
import json
import os
import pathlib
import shutil
import subprocess
import sys

from processes import Failure, run

HERE = pathlib.Path(__file__).resolve().parent
SOFTWARE = {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "llvmpipe"}


@dataclasses.dataclass
class Job:
    """What a program draws: the files of a folder, at a size."""

    folder: pathlib.Path
    width: int
    height: int
    limit_s: float

    def size(self):
        return f"{self.width}x{self.height}"

    def sky(self, name="sky"):
        path = self.folder / f"{name}.hdr"
        return path if path.is_file() else None

    def run(self, command, environment=None):
        return run(command, self.limit_s, {**SOFTWARE, **(environment or {})})


@dataclasses.dataclass
class Result:
    """Times of one process in ms: of the whole, and of each frame after the first, wall and processor time."""

    run: object
    version: str
    gl: str
    frames_ms: list
    processor_ms: list


class Program:
    """One point of the chart. `install` is the command that installs it, `lacks` lists what it cannot draw."""

    family = install = lacks = ""
    suffix = ".png"

    def __init__(self, name):
        self.name = name
        self.file = name.replace(" --", "-").replace(", ", "-").replace(" ", "-").replace("/", "-")

    def is_there(self):
        raise NotImplementedError

    def draw(self, job, picture, frames):
        """Draws `picture`, then as many timed frames."""
        raise NotImplementedError


def printed(done):
    """The result that a program of this folder prints as its last line."""
    values = json.loads(done.out.strip().splitlines()[-1])
    return Result(done, values["version"], values.get("gl", ""), values["frames_ms"], values["processor_ms"])


class Sideray(Program):
    family, install = "Sideray", "script/build"

    def __init__(self, program, name, words, reference=False):
        super().__init__(name)
        self.program, self.words, self.reference = program, words, reference
        self.lacks = "" if reference else "caustics; more than one reflection"
        self.suffix = ".exr" if reference else ".png"

    def is_there(self):
        return self.program.is_file()

    def command(self, job, verb):
        gl = ["--device", "egl:software"] if "--gl" not in self.words and not self.reference else []
        return [self.program, verb, job.folder / "scene.glb", "--size", job.size(), "--env", job.sky() or "none",
                "--default-light", "off", *gl, *self.words]

    def draw(self, job, picture, frames):
        version = run([self.program, "--version"], 60).out.split()[1]
        if not frames:
            tone = [] if self.reference else ["--tonemap", "none"]
            return Result(job.run([*self.command(job, "render"), *tone, "-o", picture]), version, "", [], [])
        stats = picture.with_suffix(".stats")

        def bench(count):
            """A process that draws so many frames after an untimed one, and the median of their times by the clock."""
            done = job.run([*self.command(job, "bench"), "--repeat", count, "--json", stats])
            return done, json.loads(stats.read_text())

        few, values = bench(1)
        more = 1 if self.reference else min(20, max(frames, int(4000 / values["stages_ms"]["total_frame"])))
        many, values = bench(1 + more)
        stages = values["stages_ms"]
        # Each time the frame is drawn stage by stage, as a whole, and as one that has a past: processor time is shared out by the clock.
        drawn = sum(ms for stage, ms in stages.items() if stage not in ("load", "build"))
        share = stages["total_frame"] / drawn if not self.reference else 1
        return Result(many, version, (values.get("device") or {}).get("renderer", ""), [stages["total_frame"]],
                      [1000 * share * (many.processor_s - few.processor_s) / more])


class Three(Program):
    family, install = "three.js", "apt-get install nodejs npm chromium; npm install --prefix FOLDER three puppeteer-core"
    lacks = "glass behind glass, shadows by glass, ambient occlusion, reflections of the scene"

    def __init__(self, folder):
        super().__init__("three.js")
        self.modules = folder / "node_modules"
        self.chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

    def is_there(self):
        has = all((self.modules / name).is_dir() for name in ("three", "puppeteer-core"))
        return bool(has and self.chromium and shutil.which("node"))

    def draw(self, job, picture, frames):
        done = job.run(["node", HERE / "three_frames.mjs", json.dumps({
            "modules": str(self.modules.resolve()), "chromium": self.chromium, "scene": str(job.folder / "scene.glb"),
            "sky": str(job.sky() or ""), "picture": str(picture), "width": job.width, "height": job.height, "camera": 0,
            "frames": frames})], {"TMPDIR": str(job.folder)})  # where the browser's profile goes
        result = printed(done)
        result.version = json.loads((self.modules / "three" / "package.json").read_text())["version"]
        return result


class Scripted(Program):
    """A program that a Python script of this folder drives."""

    script = module = ""
    before = ()
    scene, sky_name = "flat", "sky"

    def __init__(self, name, pythons, words=()):
        super().__init__(name)
        self.words = list(words)
        self.python = next((p for p in pythons if has_module(p, self.module)), None)

    def is_there(self):
        return self.python is not None

    def draw(self, job, picture, frames):
        sky = job.sky(self.sky_name)
        return printed(job.run([*self.before, self.python, HERE / self.script, job.folder / f"{self.scene}.glb", "-o", picture, "--size",
                                job.size(), "--frames", frames, *(["--sky", sky] if sky else []), *self.words]))


def pythons_of(folder):
    """The interpreters that may have a module: a virtual environment's, then this one."""
    return [str(folder / "bin" / "python3"), sys.executable]


def has_module(python, module):
    look = f"import importlib.util, sys; sys.exit(not importlib.util.find_spec('{module}'))"
    return os.access(python, os.X_OK) and subprocess.run([python, "-c", look], check=False,
                                                         stderr=subprocess.DEVNULL).returncode == 0


class Vtk(Scripted):
    family, install, script, module, sky_name = "VTK", "pip install vtk", "vtk_frames.py", "vtk", "turned"
    lacks = ("refraction (glass has an alpha of 0.25 and a tint), shadows, ambient occlusion, reflections of the scene, emissive strength")


class F3d(Scripted):
    family, install, script, module, sky_name = "F3D", "pip install f3d", "f3d_frames.py", "f3d", "turned"
    scene = "dimmed"
    lacks = "glass (it is opaque), shadows, falloff of lamps (they are dimmed to 2 candela), reflections of the scene"


class Blender(Scripted):
    install, script, module, suffix = "pip install bpy", "blender_frames.py", "bpy", ".exr"


class Eevee(Blender):
    family = "EEVEE"
    lacks = "what is outside the picture in refraction and reflections, absorption inside bodies (they get a tint)"


class Cycles(Blender):
    family = "Cycles"
    lacks = "nothing of these scenes; caustics are noisy"


class Mitsuba(Scripted):
    family, install, suffix = "Mitsuba", "pip install mitsuba pillow; apt-get install libllvm19", ".npy"
    script, module = "mitsuba_frames.py", "mitsuba"
    lacks = "nothing of these scenes; caustics are noisy"


class Pyrender(Scripted):
    family, install, script, module = "pyrender", "pip install pyrender", "pyrender_frames.py", "pyrender"
    lacks = ("refraction (as VTK), an order of what is translucent within an object, the sky as light (it is constant), shadows of "
             "point lights")


class Mujoco(Scripted):
    family, script, module = "MuJoCo", "mujoco_frames.py", "mujoco"
    install = "pip install mujoco; after pyrender, which asks for 3.1.0, pip install --no-deps --upgrade pyopengl"
    lacks = ("materials beyond a texture and a highlight, alpha from textures, refraction (as VTK), the sky as light (it is constant), "
             "light as linear numbers")


class Filament(Scripted):
    family, install, script, module = "Filament", "pip install mujoco (4.0); apt-get install xvfb xauth", "filament_frames.py", "mujoco._render_filament"
    before = ("xvfb-run", "-a")  # opens a display even where it draws into memory
    lacks = "refraction (MuJoCo's materials have none), the sky as light"


LOOK = ["--translucency", "raster", "--shadows", "map", "--ambient", "off", "--reflections", "off"]


def programs(sideray, folder):
    """All points of the chart, installed or not."""
    pythons = pythons_of(folder)
    ours = [("raster look", LOOK), ("draft", ["--quality", "draft"]), ("balanced", []), ("best", ["--quality", "best"]),
            ("best, 4 samples", ["--quality", "best", "--samples", "4"])]
    found = [Sideray(sideray, name, words) for name, words in ours]
    found += [Sideray(sideray, f"{name} --gl none", [*words, "--gl", "none"]) for name, words in ours]
    found += [Sideray(sideray, f"paths, {n}", ["--reference", "--bounces", "unlimited", "--caustics", "on", "--samples", n,
                                               "--light-samples", "4"], reference=True) for n in (1, 4, 16)]
    found += [Three(folder), Vtk("VTK", pythons), F3d("F3D", pythons), Pyrender("pyrender", pythons),
              Mujoco("MuJoCo classic", pythons), Filament("MuJoCo Filament", pythons)]
    found += [Eevee(f"EEVEE, {n}", pythons, ["--engine", "eevee", "--samples", str(n)]) for n in (1, 4)]
    found += [Cycles(f"Cycles, {n}", pythons, ["--samples", str(n)]) for n in (1, 4, 16)]
    found += [Cycles(f"Cycles, {n}, denoised", pythons, ["--samples", str(n), "--denoise"]) for n in (1, 4, 16)]
    found += [Mitsuba(f"Mitsuba, {n}", pythons, ["--samples", str(n)]) for n in (1, 4, 16, 64)]
    return found


def panes_programs(sideray, there):
    """Those that count on stacks of panes: one of each kind that draws unlit panes, and Sideray with another order of fragments."""
    kinds = ("raster look", "balanced", "balanced --gl none", "three.js", "VTK", "F3D", "pyrender", "MuJoCo classic", "EEVEE, 1", "Cycles, 16")
    return [Sideray(sideray, "balanced --oit abuffer", ["--oit", "abuffer"]), *(p for p in there if p.name in kinds)]


def tracer_of(folder, sideray, tracer, samples, seed="7"):
    """The program that draws a truth: a path tracer with many samples, 'Cycles', 'Mitsuba' or 'Sideray'."""
    if tracer == "Sideray":
        return Sideray(sideray, "paths", ["--reference", "--bounces", "unlimited", "--caustics", "on", "--samples", str(samples),
                                          "--light-samples", "8", "--seed", seed], reference=True)
    pythons, words = pythons_of(folder), ["--samples", str(samples), "--seed", seed]
    found = Mitsuba(tracer, pythons, [*words, "--robust"]) if tracer == "Mitsuba" else Cycles(tracer, pythons, [*words, "--denoise"])
    if not found.is_there():
        raise Failure(f"{tracer} is not there: {found.install}")
    return found
