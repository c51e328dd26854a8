#!/usr/bin/python3
"""random_input.py PROGRAM SECONDS SEED SCENE: uses the window of sideray-view (PROGRAM) at random for so many seconds.

Keys, drags, the wheel, clicks in the panel, sizes, minimising and dropped files follow from the seed. The window has to stay
alive, to close when it is asked to, and to say nothing of sanitizers. Skipped (77) without Xvfb and xdotool's libXtst.
"""
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

import scene_files
from display import Display

SCREEN = (1000, 700)
KEYS = ["c", "b", "m", "i", "f", "space", "Tab", "Escape", "Return", "BackSpace", "1", "5", "0", "comma", "Left", "Right"]
FLIGHT = ["w", "a", "s", "d", "q", "e", "Shift_L"]
SECONDS_TO_CLOSE = 60  # a sanitizer's last picture takes long


class Hand:
    """Does one thing after the other with a window."""

    def __init__(self, client, window, seed, files):
        self.client, self.window, self.random, self.files = client, window, random.Random(seed), files
        self.done = {}

    def place(self):
        return self.random.randrange(SCREEN[0]), self.random.randrange(SCREEN[1])

    def key(self):
        self.client.press(self.random.choice(KEYS))

    def command(self):
        self.client.press("Control_L", self.random.choice("scr"))

    def fly(self):
        keys = self.random.sample(FLIGHT, self.random.randint(1, 3))
        for key in keys:
            self.client.hold(key, True)
        time.sleep(self.random.uniform(0.02, 0.4))
        for key in keys:
            self.client.hold(key, False)

    def drag(self):
        button = self.random.randint(1, 3)
        self.client.move(*self.place())
        self.client.button(button, True)
        for _ in range(self.random.randint(1, 12)):
            self.client.move(*self.place())
            time.sleep(0.02)
        self.client.button(button, False)

    def wheel(self):
        self.client.move(*self.place())
        number = self.random.choice([4, 5])
        for _ in range(self.random.randint(1, 8)):
            self.client.button(number, True)
            self.client.button(number, False)

    def click(self):
        self.client.click(*self.place(), seconds=0.05)

    def click_panel(self):
        self.client.click(self.random.randrange(SCREEN[0] - 370, SCREEN[0]), self.random.randrange(SCREEN[1]), seconds=0.05)

    def resize(self):
        width, height = self.random.choice([(1, 1), (60, 40), (SCREEN), (400, 300), (SCREEN[0], 120), (399, 650)])
        self.client.resize(self.window, width, height)
        time.sleep(0.05)
        if self.random.random() < 0.7:
            self.client.resize(self.window, *SCREEN)

    def minimise(self):
        self.client.show(self.window, False)
        time.sleep(self.random.uniform(0, 0.3))
        self.client.show(self.window, True)

    def drop(self):
        self.client.drop(self.window, self.random.sample(self.files, self.random.randint(1, 2)), seconds=1)

    def act(self):
        actions = {self.key: 6, self.fly: 4, self.drag: 6, self.wheel: 3, self.click: 3, self.click_panel: 10, self.command: 1,
                   self.resize: 1, self.minimise: 1, self.drop: 1}
        action = self.random.choices(list(actions), list(actions.values()))[0]
        self.done[action.__name__] = self.done.get(action.__name__, 0) + 1
        action()


def files_in(folder):
    scene_files.gltf(folder / "square.gltf")
    scene_files.hdr(folder / "surroundings.hdr", 120, 90, 60)
    (folder / "broken.glb").write_bytes(b"no scene")
    (folder / "text.txt").write_text("neither")
    return sorted(folder.iterdir())


def use(program, seconds, seed, scene, folder):
    """What is wrong; "" = nothing."""
    display = Display(folder, SCREEN)
    (folder / "files").mkdir()
    files = files_in(folder / "files")
    environment = {**display.environment, "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=0:" + os.environ.get("ASAN_OPTIONS", ""),
                   "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1:" + os.environ.get("UBSAN_OPTIONS", "")}
    with open(folder / "errors", "wb") as errors:
        window = subprocess.Popen([program, scene, "--size", "620x700", "--threads", "2"], cwd=folder, env=environment,
                                  stdout=errors, stderr=errors)
    client = display.client()
    try:
        end = time.monotonic() + 60
        while not client.window("Sideray") and time.monotonic() < end and window.poll() is None:
            time.sleep(0.1)
        hand = Hand(client, client.window("Sideray"), seed, files)
        end = time.monotonic() + seconds
        while time.monotonic() < end and window.poll() is None:
            hand.act()
        print(f"seed {seed}, {scene}: " + ", ".join(f"{count} {name}" for name, count in sorted(hand.done.items())), flush=True)
        said = (folder / "errors").read_text(errors="replace")
        if window.poll() is not None:
            return f"the window ended with {window.returncode}:\n{said[-6000:]}"
        client.show(hand.window, True)
        client.ask_to_close(hand.window)
        code = window.wait(SECONDS_TO_CLOSE)
        said = (folder / "errors").read_text(errors="replace")
        if code != 0 or "Sanitizer" in said or "runtime error" in said:
            return f"it closed with {code}:\n{said[-6000:]}"
        return ""
    except subprocess.TimeoutExpired:
        return f"it did not close within {SECONDS_TO_CLOSE} s"
    finally:
        if window.poll() is None:
            window.kill()
            window.wait()
        client.close()
        display.end()


def main():
    if not shutil.which("Xvfb") or not shutil.which("xdotool"):
        print("random_input: Xvfb or xdotool not found; install xvfb and xdotool")
        return 1 if os.environ.get("SIDERAY_REQUIRE_CONTEXTS") else 77
    program, seconds, seed, scene = pathlib.Path(sys.argv[1]).resolve(), float(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
    with tempfile.TemporaryDirectory() as folder:
        wrong = use(program, seconds, seed, scene, pathlib.Path(folder))
    if wrong:
        print(f"random_input: seed {seed}, {scene}: {wrong}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
