#!/usr/bin/python3
"""Measures `sideray run` with programs as they are: run_programs.py SIDERAY [PROGRAM ...] [--frames 1000] [--modes off,waiting] [--size 800x600]

Each program plays in a window of --size under an X server of its own (Xvfb, software OpenGL) until it has drawn --frames
frames, or for --seconds; the window of extremetuxracer is always 800x600. A line for each program and mode: frames, those with rays and with shadows, the share of the pixels, milliseconds a
frame by the clock (median) and by the processor time of all threads, and memory at frames 100, 1000 and the end. The mode
`pictures` compares every thirtieth frame with the program's own picture (tests/preload/outside.py).

Programs: bzflag (with bzflag-server), openarena, extremetuxracer (with xdotool) and neverball, of Debian 12.
"""

import argparse
import contextlib
import dataclasses
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
MODES = {"plain": None, "off": ["--off"], "waiting": [], "late": ["--late"], "pictures": ["--pictures", "pictures"]}
PORT = "5164"


@dataclasses.dataclass
class Program:
    command: list
    rules: str
    server: list = dataclasses.field(default_factory=list)  # which runs beside it
    returns: int = 0                                        # how often Return is pressed, to leave the menus


PROGRAMS = {
    "bzflag": Program(
        ["bzflag", "-solo", "4", "-team", "observer", "-window", "{width}x{height}+0+0", "-time", "16:30:00", "-nolist", "-mute", f"obs@127.0.0.1:{PORT}"],
        "sun light 0\nwater guessed ior=1.33 reflectance=0.03\n",
        server=["bzfs", "-world", str(REPOSITORY / "examples/run/pools.bzw"), "-i", "127.0.0.1", "-p", PORT, "-j", "+r"]),
    "openarena": Program(
        ["openarena", "+set", "r_fullscreen", "0", "+set", "r_mode", "-1", "+set", "r_customwidth", "{width}", "+set", "r_customheight", "{height}", "+set", "s_initsound", "0", "+set", "com_hunkMegs", "256",
         "+set", "cl_renderer", "opengl1", "+set", "com_maxfps", "0", "+devmap", "islanddm", "+team", "spectator"],
        "water texture 2fc4b3b3a622bfe5 reflectance=0.05 ior=1.33\n"),
    "extremetuxracer": Program(
        ["etr"], "sun light 0\nwater texture e6ba10544b4b7c23 reflectance=0.1\n", returns=7),
    "neverball": Program(
        ["neverball", "-l", "map-easy/easy.sol"],
        "sun light 0\n" + "".join(f"mirror texture {name} reflectance=0.15\n" for name in (
            "12015b8d7745aa9f", "220840d613952d87", "64c219e433adb8ef", "7333f08fb402abf3", "c8ffa94e67760315"))),
}


@contextlib.contextmanager
def process(*words, **how):
    """A process that is ended when the block is left."""
    child = subprocess.Popen(*words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **how)
    try:
        yield child
    finally:
        child.terminate()
        try:
            child.wait(timeout=20)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


@contextlib.contextmanager
def display(home):
    """The environment of a program on an X server of its own."""
    read, write = os.pipe()
    with process(["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-nolisten", "tcp", "-noreset"], pass_fds=[write]):
        os.close(write)
        with os.fdopen(read) as stream:
            number = stream.readline().strip()
        yield {**os.environ, "DISPLAY": ":" + number, "HOME": str(home), "LIBGL_ALWAYS_SOFTWARE": "1", "SDL_AUDIODRIVER": "dummy",
               "ALSOFT_DRIVERS": "null", "PATH": os.environ["PATH"] + ":/usr/games"}


def figures_of(report):
    """What `--report` has written so far."""
    text = report.read_text() if report.exists() else ""
    return {name: float(value) for name, value in re.findall(r"<tr><td>(\w+)</td><td>([\d.]+)</td></tr>", text)}


def counted_frames(folder):
    """The times of frames that Mesa has written, in milliseconds."""
    path = folder / "frametime_(ms)"
    return [float(line) for line in path.read_text().splitlines()[:-1]] if path.exists() else []


def seconds_of_processor(pid):
    words = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


class Run:
    """One program in one mode."""

    def __init__(self, sideray, program, mode, size, folder):
        self.program, self.mode, self.folder = program, mode, folder
        (folder / "rules").write_text(program.rules)
        (folder / ".neverball").mkdir()
        (folder / ".neverball/neverballrc").write_text("fullscreen 0\nwidth {}\nheight {}\n".format(*size))
        (folder / "pictures").mkdir()
        options = MODES[mode]
        self.words = [word.replace("{width}", size[0]).replace("{height}", size[1]) for word in program.command]
        if options is not None:
            self.words[:0] = [sideray, "run", "--report", "report.html", "--rules", "rules", *options, "--"]

    def frames(self):
        """How many frames have been drawn."""
        if self.mode == "plain":
            return len(counted_frames(self.folder))
        return int(figures_of(self.folder / "report.html").get("frames", 0))

    def play(self, frames, seconds):
        """Runs until there are `frames`. Returns milliseconds of processor time a frame, of the second half of that time."""
        with contextlib.ExitStack() as stack:
            environment = stack.enter_context(display(self.folder))
            if self.mode == "plain":
                environment |= {"GALLIUM_HUD": "frametime", "GALLIUM_HUD_VISIBLE": "false", "GALLIUM_HUD_PERIOD": "0",
                                "GALLIUM_HUD_DUMP_DIR": str(self.folder)}
            if self.program.server:
                stack.enter_context(process(self.program.server, env=environment))
                time.sleep(1)
            child = stack.enter_context(process(self.words, env=environment, cwd=self.folder))
            return self.watch(child, environment, frames, seconds)

    def watch(self, child, environment, frames, seconds):
        began, pressed, samples = time.monotonic(), 0, []
        while child.poll() is None and time.monotonic() < began + seconds:
            time.sleep(1)
            if pressed < self.program.returns and time.monotonic() > began + 6 + 2.5 * pressed:
                subprocess.run(["xdotool", "key", "Return"], env=environment, check=False)
                pressed += 1
            now = self.frames()
            if not samples or now != samples[-1][0]:
                samples.append((now, seconds_of_processor(child.pid)))
            if now >= frames:
                break
        first, last = samples[len(samples) // 2], samples[-1]
        return 1e3 * (last[1] - first[1]) / max(1, last[0] - first[0])


def measure(sideray, name, mode, frames, seconds, size):
    with tempfile.TemporaryDirectory() as work:
        folder = pathlib.Path(work)
        processor_ms = Run(sideray, PROGRAMS[name], mode, size, folder).play(frames, seconds)
        if mode == "plain":
            times = counted_frames(folder)
            print(f"{name} plain: {len(times)} frames, {statistics.median(times):.1f} ms", flush=True)
            return
        f = figures_of(folder / "report.html")
        print(f"{name} {mode}: {f['frames']:.0f} frames, {f['frames_with_rays']:.0f} with rays ({100 * f['mean_share_of_pixels']:.1f} %), "
              f"{f['frames_with_shadows']:.0f} with shadows ({100 * f['mean_share_in_shadow']:.1f} %, of what is held back "
              f"{100 * f['mean_share_of_held_in_shadow']:.1f} %), {f['median_frame_ms']:.1f} ms, "
              f"{processor_ms:.0f} ms of processor time, {f['memory_mb_at_frame_100']:.0f}, {f['memory_mb_at_frame_1000']:.0f}, "
              f"{f['memory_mb']:.0f} MB, {f['meshes_kept']:.0f} meshes", flush=True)
        if mode == "pictures":
            outside = [sys.executable, "-B", REPOSITORY / "tests/preload/outside.py", sideray, folder / "pictures"]
            lines = subprocess.run(outside, stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
            print(lines[-1] if lines else "no picture has rays", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sideray", type=pathlib.Path)
    parser.add_argument("programs", nargs="*", choices=[[], *PROGRAMS], default=list(PROGRAMS))
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=600, help="at most, of each run")
    parser.add_argument("--size", default="800x600")
    parser.add_argument("--modes", default="plain,off,waiting,late,pictures")
    arguments = parser.parse_args()
    for name in arguments.programs or PROGRAMS:
        for mode in arguments.modes.split(","):
            measure(arguments.sideray.resolve(), name, mode, arguments.frames, arguments.seconds, arguments.size.split("x"))


if __name__ == "__main__":
    main()
