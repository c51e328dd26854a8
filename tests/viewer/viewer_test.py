#!/usr/bin/python3
"""viewer_test.py PROGRAM: the window of `sideray view` on a display of its own (Xvfb), used by real keys and a real mouse (xdotool).

Titles say how far a picture is, and pictures of the screen what is seen. Skipped (77) without Xvfb, xdotool or the window, which
fails instead where SIDERAY_REQUIRE_CONTEXTS is set.
"""
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

PROGRAM = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
SCREEN = (1000, 600)
PANEL = 380


def png_rows(path):
    """The rows of an RGB PNG of 8 bits."""
    data, at, packed, size = path.read_bytes(), 8, b"", (0, 0)
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            size = struct.unpack(">II", body[:8])
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    stride, raw, rows, above = 3 * size[0], zlib.decompress(packed), [], bytes(3 * size[0])
    for y in range(size[1]):
        filtered, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left, up, corner = (row[i - 3], above[i], above[i - 3]) if i >= 3 else (0, above[i], 0)
            if filtered == 1:
                row[i] = (row[i] + left) & 255
            elif filtered == 2:
                row[i] = (row[i] + up) & 255
            elif filtered == 3:
                row[i] = (row[i] + (left + up) // 2) & 255
            elif filtered == 4:
                guess = left + up - corner
                nearest = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
                row[i] = (row[i] + nearest) & 255
        rows.append(bytes(row))
        above = rows[-1]
    return rows


class Display:
    """An X server whose screen is a file."""

    def __init__(self, folder):
        self.folder = folder
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "%dx%dx24" % SCREEN, "-fbdir", str(folder),
                                        "-nolisten", "tcp", "-noreset"], pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as stream:
            self.environment = {**os.environ, "DISPLAY": ":" + stream.readline().strip()}

    def end(self):
        self.server.terminate()
        self.server.wait()

    def use(self, *words):
        return subprocess.run(["xdotool", *map(str, words)], env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, check=False).stdout.strip()

    def screen(self, box):
        """Bytes of the pixels in (left, top, right, bottom)."""
        data = (self.folder / "Xvfb_screen0").read_bytes()
        header = struct.unpack(">25I", data[:100])
        begin, stride = header[0] + 12 * header[19], header[12]
        left, top, right, bottom = box
        return b"".join(data[begin + y * stride + 4 * left:begin + y * stride + 4 * right] for y in range(top, bottom))


class Viewer(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.display = Display(self.folder)
        self.window = None

    def tearDown(self):
        if self.window and self.window.poll() is None:
            self.window.kill()
            self.window.wait()
        if self.window:
            self.window.stderr.close()
        self.display.end()
        shutil.rmtree(self.folder)

    def open(self, scene, size="160x90", *options):
        self.window = subprocess.Popen([PROGRAM, "view", scene, "--size", size, "--threads", "2", *options], cwd=self.folder,
                                       env=self.display.environment, stderr=subprocess.PIPE, text=True)

    def title(self):
        return self.display.use("search", "--onlyvisible", "--name", "Sideray", "getwindowname")

    def wait_for(self, text, seconds=60, title=None):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.window.poll() is not None:
                break
            if text in (title or self.title)():
                return
            time.sleep(0.05)
        self.fail(f"{text!r} did not come within {seconds} s; the title is {self.title()!r}; "
                  f"{self.window.stderr.read() if self.window.poll() is not None else ''}")

    def close(self):
        """Closes the window; the seconds that it took."""
        begin = time.monotonic()
        self.display.use("key", "ctrl+q")
        code = self.window.wait(20)
        self.assertEqual(code, 0)
        return time.monotonic() - begin

    def cpu_seconds(self):
        fields = pathlib.Path(f"/proc/{self.window.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def pictures(self):
        return sorted(self.folder.glob("*.png"))

    def save(self):
        before = len(self.pictures())
        self.display.use("key", "ctrl+s")
        self.wait_for("True", 10, lambda: str(len(self.pictures()) > before))
        return self.pictures()[-1]

    def test_what_stands_still_is_the_picture_of_64_samples_and_then_costs_nothing(self):
        self.open("panes")
        self.display.use("mousemove", 80, 45)
        self.wait_for("64/64")
        saved = self.save()
        subprocess.run([PROGRAM, "render", "panes", "--gl", "none", "--size", "160x90", "--samples", "64", "-o",
                        self.folder / "render.png.tmp.png"], check=True)
        self.assertEqual(png_rows(saved), png_rows(self.folder / "render.png.tmp.png"))
        time.sleep(1)
        before = self.cpu_seconds()
        time.sleep(3)
        self.assertLessEqual(self.cpu_seconds() - before, 0.03, "an idle window used the CPU")
        self.assertLess(self.close(), 3)

    def test_mouse_and_keys_move_the_camera_and_compare(self):
        self.open("panes")
        self.wait_for("64/64")
        still = self.display.screen((0, 30, 160, 90))
        self.display.use("mousemove", 60, 60, "mousedown", 1, "mousemove", 90, 60, "mousemove", 110, 60, "mouseup", 1)
        self.wait_for(" 0/64", 10, lambda: self.title() + (" 0/64" if self.display.screen((0, 30, 160, 90)) != still else ""))
        self.assertNotEqual(self.display.screen((0, 30, 160, 90)), still, "a drag did not turn the view")
        self.display.use("key", "c")
        self.wait_for("reference ")
        self.wait_for("64/64")
        self.display.use("key", "Tab")
        self.wait_for("reference ")
        self.close()

    def test_a_scene_that_cannot_be_read_leaves_the_old_one(self):
        subprocess.run([PROGRAM, "make", "panes", "-o", self.folder / "scene.glb"], check=True)
        self.open("scene.glb")
        self.wait_for("64/64")
        (self.folder / "scene.glb").write_bytes(b"no scene")
        panel = (165, 25, 165 + PANEL - 40, 75)
        before = self.display.screen(panel)
        self.wait_for("changed", 20, lambda: "changed" if self.display.screen(panel) != before else "")
        self.assertIn("64/64", self.title(), "the old scene did not stay")
        picture = (0, 30, 160, 90)
        old = self.display.screen(picture)
        subprocess.run([PROGRAM, "make", "solids", "-o", self.folder / "scene.glb"], check=True)
        self.wait_for("changed", 20, lambda: "changed" if self.display.screen(picture) != old else "")
        self.close()

    def test_tiny_and_hidden_windows_and_closing_in_the_middle_of_a_picture(self):
        self.open("bistro", "600x500")
        self.wait_for("bistro")
        window = self.display.use("search", "--onlyvisible", "--name", "Sideray")
        self.display.use("windowsize", window, 1, 1)
        time.sleep(0.5)
        self.display.use("windowunmap", window)
        time.sleep(0.3)
        self.display.use("windowmap", window)
        self.display.use("windowsize", window, 900, 500)
        time.sleep(1.5)
        self.assertIsNone(self.window.poll())
        self.assertLess(self.close(), 5, "closing waited for a picture")


if __name__ == "__main__":
    missing = [name for name in ("Xvfb", "xdotool") if not shutil.which(name)]
    if missing:
        print(f"viewer_test: {' and '.join(missing)} not found; install xvfb and xdotool")
        sys.exit(1 if os.environ.get("SIDERAY_REQUIRE_CONTEXTS") else 77)
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
