"""Measures the programs on one scene: their times, their memory and their distance to the truth. Results are files."""
import json
import os
import pathlib
import statistics
import sys
import time

import exr
import numpy
from panes import count_layers, write_panes
from PIL import Image
from processes import Failure, run
from programs import Job, tracer_of
from shared_scene import copy_scene


def radiance(path):
    if path.suffix == ".npy":
        return numpy.load(path)
    planes = exr.read(path)
    return numpy.stack([planes[c].astype("f4") for c in "RGB"], axis=-1)


def write_shown(path, linear):
    """Converts to display values: clamped at white, with the transfer function of sRGB."""
    v = numpy.clip(numpy.nan_to_num(linear), 0, 1)
    v = numpy.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)
    Image.fromarray((v * 255 + 0.5).astype("u1")).save(path)


class Board:
    def __init__(self, setting, options, sideray):
        self.setting, self.options, self.sideray = setting, options, sideray
        self.folder = (options.folder / setting.name).resolve()
        self.folder.mkdir(parents=True, exist_ok=True)
        self.job = Job(self.folder, setting.width, setting.height, options.limit)

    def say(self, text):
        print(f"{time.strftime('%H:%M:%S')} {self.setting.name}: {text}", flush=True)

    def source(self):
        if pathlib.Path(self.setting.source).is_file():
            return pathlib.Path(self.setting.source)
        run([self.sideray, "make", self.setting.source, "-o", self.folder / "made.glb"], self.options.limit)
        return self.folder / "made.glb"

    def truth_of(self, tracer, samples):
        """Linear pixels of one tracer's picture, drawn unless it is there."""
        program = tracer_of(self.options.peers.resolve(), self.sideray, tracer, samples)
        path = self.folder / f"truth-{tracer}-{samples}{program.suffix}"
        if not path.is_file():
            part = path.with_name("part" + path.suffix)
            done = program.draw(self.job, part, 0)
            os.replace(part, path)
            self.say(f"truth by {tracer}, {samples} samples: {done.run.processor_s:.0f} s of processor time")
        shown = path.with_suffix(".png")
        if not shown.is_file():
            write_shown(shown, radiance(path))
        return radiance(path)

    def flip(self, test, reference):
        return json.loads(run([self.sideray, "compare", test, reference, "--json"], 120).out)["flip"]

    def truths(self):
        """Draws them; distances among them go to truth.json."""
        parts = [part.split(":") for part in self.setting.truth.split(",")]
        pictures = [self.truth_of(tracer, int(samples)) for tracer, samples in parts]
        write_shown(self.folder / "truth.png", sum(pictures) / len(pictures))
        self.truth_of("Sideray", self.setting.own_samples)
        shown = {tracer: self.folder / f"truth-{tracer}-{n}.png" for tracer, n in [*parts, ("Sideray", self.setting.own_samples)]}
        names = list(shown)
        apart = {f"{a} to {b}": self.flip(shown[a], shown[b]) for i, a in enumerate(names) for b in names[i + 1:]}
        record = {"truth": self.setting.truth, "apart": apart, "what": self.setting.what,
                  "size": self.job.size(), "own_to_truth": self.flip(shown["Sideray"], self.folder / "truth.png")}
        (self.folder / "truth.json").write_text(json.dumps(record, indent=1) + "\n")
        self.say("truths: " + ", ".join(f"{k} {v:.4f}" for k, v in apart.items()))
        return self.folder / "truth.png", shown["Sideray"]

    def prepare(self):
        if not (self.folder / "scene.glb").is_file():
            copy_scene(self.source(), self.folder, self.setting)

    def measure(self, programs):
        self.prepare()
        truth, own = self.truths()
        for program in programs:
            path = self.folder / f"{program.file}.json"
            if path.is_file() and not self.options.again:
                record = json.loads(path.read_text())
            else:
                record = self.record(program)
            if "error" not in record:
                picture = self.folder / f"{program.file}.png"
                record.update(flip=self.flip(picture, truth), flip_own=self.flip(picture, own))
                self.say(f"{program.name}: FLIP {record['flip']:.4f}, frame {record['processor_ms']:.0f} ms of processor time, "
                         f"wall {record['wall_ms']:.0f}")
            path.write_text(json.dumps(record, indent=1) + "\n")

    def record(self, program):
        """Runs a program; returns its times and memory, or its error."""
        picture = self.folder / (program.file + program.suffix)
        picture.unlink(missing_ok=True)
        try:
            once = frames = program.draw(self.job, picture, 0 if program.suffix == ".png" or program.family == "Sideray" else 1)
            if not once.frames_ms:
                frames = program.draw(self.job, picture, self.options.frames)
            if program.suffix != ".png":
                write_shown(picture.with_suffix(".png"), radiance(picture))
            with Image.open(picture.with_suffix(".png")) as image:
                if image.size != (self.job.width, self.job.height):
                    raise Failure(f"wrote a picture of {image.size}")
        except (Failure, OSError, ValueError, KeyError, IndexError) as failure:
            self.say(f"{program.name} failed: {failure}")
            return {"program": program.name, "error": str(failure)}
        beyond = [sum(times) / 1000 for times in (once.frames_ms, once.processor_ms)]  # slow programs run once, for two frames
        return {"program": program.name, "family": program.family, "version": frames.version, "gl": frames.gl,
                "wall_ms": statistics.median(frames.frames_ms), "processor_ms": statistics.median(frames.processor_ms),
                "process_s": once.run.wall_s - beyond[0], "process_processor_s": once.run.processor_s - beyond[1], "peak_mb": once.run.peak_mb,
                "load": os.getloadavg()[0]}

    def measure_panes(self, programs):
        """Counts the stacks of panes that a program draws right, with a layer missing, or in another order."""
        stacks = write_panes(self.folder / "scene.glb", self.job.width, self.job.height)
        for name in ("flat", "dimmed"):
            (self.folder / f"{name}.glb").write_bytes((self.folder / "scene.glb").read_bytes())
        for program in programs:
            path = self.folder / f"{program.file}.json"
            if path.is_file() and not self.options.again:
                continue
            picture = self.folder / (program.file + program.suffix)
            try:
                program.draw(self.job, picture, 0)
                if program.suffix != ".png":
                    write_shown(picture.with_suffix(".png"), radiance(picture))
                pixels = numpy.asarray(Image.open(picture.with_suffix(".png")).convert("RGB"), dtype="f4") / 255
                counts = count_layers(pixels, stacks)
            except (Failure, OSError, ValueError) as failure:
                counts = {"error": str(failure)}
            path.write_text(json.dumps({"program": program.name, "family": program.family, **counts}, indent=1) + "\n")
            self.say(f"{program.name}: {counts}")
