#!/usr/bin/python3
"""viewer_test.py PROGRAM [LOST_CONTEXT]: the window of `sideray view` on a display of its own (Xvfb), used by real keys and a real
mouse (xdotool).

Titles say how far a picture is, and pictures of the screen what is seen. LOST_CONTEXT is the library of lost_context.c. Skipped
(77) without Xvfb, xdotool or the window, which fails instead where SIDERAY_REQUIRE_CONTEXTS is set.
"""
import os
import pathlib
import re
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

import scene_files
from display import Display

PROGRAM = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
LOST_CONTEXT = pathlib.Path(sys.argv[2]).resolve() if len(sys.argv) > 2 and sys.argv[2] else None
needs_lost_context = unittest.skipUnless(LOST_CONTEXT, "the library that loses contexts is not built with sanitizers")
SCREEN = (1000, 600)
PANEL = 380
# Middles of the panel's rows, in pixels below its top.
ROWS = {"shows": 169, "camera": 194, "variant": 219, "quality": 224, "translucency": 249, "layers": 274}
# Until its picture is at rest a window is drawn anew all the time, with its panel: what is high costs most.
SMALL, SMALL_PICTURE = "80x60", (0, 30, 80, 60)
# What makes large pictures come to rest soon.
QUICK = ("--shadows", "off", "--ambient", "off", "--reflections", "off")
CHART_ABOVE_END = 78  # the button that makes a chart, above the end of the panel


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


class Viewer(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.display = Display(self.folder, SCREEN)
        self.client = self.display.client()
        self.window = None

    def tearDown(self):
        if self.window and self.window.poll() is None:
            self.window.kill()
            self.window.wait()
        if self.window:
            self.window.stderr.close()
        self.client.close()
        self.display.end()
        shutil.rmtree(self.folder)

    def open(self, scene, size="160x90", *options, **environment):
        self.start([PROGRAM, "view", scene, "--size", size, "--threads", "2", *options], **environment)

    def start(self, words, **environment):
        self.window = subprocess.Popen(words, cwd=self.folder, env={**self.display.environment, **environment},
                                       stderr=subprocess.PIPE, text=True)

    def title(self):
        return self.client.title(self.client.window("Sideray"))

    def number_of_pictures(self):
        found = re.search(r"picture (\d+):", self.title())
        return int(found[1]) if found else 0

    def frame_all(self):
        """Draws the view anew that has all of the scene in it."""
        before = self.number_of_pictures()
        self.client.press("f")
        self.wait_until(lambda: self.number_of_pictures() > before, "nothing was drawn")
        self.wait_for("64/64")

    def drag(self, *places):
        """As a hand does: not all of it between two frames of the window."""
        self.display.use("mousemove", *places[0], "sleep", 0.2, "mousedown", 1, "sleep", 0.3)
        for place in places[1:]:
            self.display.use("mousemove", *place, "sleep", 0.3)
        self.display.use("mouseup", 1, "sleep", 0.3)

    def choose(self, row, item, left):
        """Opens a list of the panel, which begins at `left`, and chooses the item of that number."""
        below = (left + 140, ROWS[row] + 15, left + 230, ROWS[row] + 40)
        closed = self.display.screen(below)
        self.client.click(left + 180, ROWS[row], seconds=0.2)
        self.wait_until(lambda: self.display.screen(below) != closed, f"the list of {row} does not open")
        time.sleep(0.3)
        self.client.click(left + 180, ROWS[row] + 25 + 19 * item, seconds=0.2)

    def color(self, x, y):
        """Red, green and blue on the screen."""
        return tuple(reversed(self.display.screen((x, y, x + 1, y + 1))[:3]))

    def wait_until(self, holds, message, seconds=20):
        end = time.monotonic() + seconds
        while time.monotonic() < end and self.window.poll() is None:
            if holds():
                return
            time.sleep(0.05)
        self.fail(f"{message}; the title is {self.title()!r}")

    def wait_for(self, text, seconds=150, title=None):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.window.poll() is not None:
                break
            if text in (title or self.title)():
                return
            time.sleep(0.05)
        self.fail(f"{text!r} did not come within {seconds} s; the title is {self.title()!r}; "
                  f"{self.window.stderr.read() if self.window.poll() is not None else ''}")

    def turn(self):
        """Drags the view to another side of things."""
        still = self.display.screen(SMALL_PICTURE)
        self.drag((20, 40), (50, 40), (70, 46))
        self.wait_until(lambda: self.display.screen(SMALL_PICTURE) != still, "a drag did not turn the view")
        time.sleep(1)
        self.wait_for("64/64")

    def copied(self):
        """What the window has copied: one line."""
        for _ in range(50):
            if text := self.client.copied_text(1):
                return text
            time.sleep(0.1)
        self.fail("nothing was copied")

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

    def at_rest(self, box):
        """The pixels in the box once they are those of the saved picture: titles tell of a picture before the screen shows it."""
        self.wait_for("64/64")
        rows = png_rows(self.save())
        picture = b"".join(row[3 * box[0]:3 * box[2]] for row in rows[box[1]:box[3]])

        def is_shown():
            screen = self.display.screen(box)
            return all(screen[2 - k::4] == picture[k::3] for k in range(3))
        self.wait_until(is_shown, "the screen does not show the picture of 64 samples")
        return self.display.screen(box)

    def test_what_stands_still_is_the_picture_of_64_samples_and_then_costs_nothing(self):
        self.open("panes", SMALL)
        self.display.use("mousemove", 40, 45)
        self.wait_for("64/64")
        saved = self.save()
        subprocess.run([PROGRAM, "render", "panes", "--gl", "none", "--size", SMALL, "--samples", "64", "-o",
                        self.folder / "render.png.tmp.png"], check=True)
        self.assertEqual(png_rows(saved), png_rows(self.folder / "render.png.tmp.png"))
        time.sleep(1)
        before = self.cpu_seconds()
        time.sleep(3)
        self.assertLessEqual(self.cpu_seconds() - before, 0.03, "an idle window used the CPU")
        self.assertLess(self.close(), 3)

    def test_the_copied_command_line_draws_the_same_picture(self):
        self.open("panes", SMALL, "--quality", "draft", "--ambient", "ao")
        self.wait_for("64/64")
        self.turn()
        saved = self.save()
        self.client.press("Control_L", "c")
        words = shlex.split(self.copied())
        self.assertEqual(words[:3], ["sideray", "render", "panes"])
        subprocess.run([PROGRAM, *words[1:], "--gl", "none"], cwd=self.folder, check=True, stdout=subprocess.DEVNULL)
        self.assertEqual(png_rows(saved), png_rows(self.folder / "picture.png"))
        self.close()

    def test_keys_fly_and_the_list_has_cameras(self):
        self.open("empty", "120x260", *QUICK)
        picture = (10, 40, 110, 250)
        views = [self.at_rest(picture)]
        for key in ("w", "d", "e"):
            self.client.hold(key, True)
            time.sleep(0.5)
            self.client.hold(key, False)
            self.wait_until(lambda: self.display.screen(picture) != views[-1], f"{key} did not move the view")
            views.append(self.display.screen(picture))
        self.choose("camera", 0, 120)
        self.wait_until(lambda: self.display.screen(picture) == views[0], "the file's camera is not shown", 150)
        self.choose("camera", 1, 120)
        self.wait_until(lambda: self.display.screen(picture) != views[0], "not all of the scene is shown")
        self.close()

    def test_blinking_shows_a_and_b_in_turn(self):
        self.open("panes", "160x90", "--translucency", "raytraced", *QUICK)
        picture = (0, 30, 160, 90)
        a = self.at_rest(picture)
        self.client.press("b")
        self.wait_for("reference ")
        for _ in range(2):
            self.wait_until(lambda: self.display.screen(picture) != a, "B is not shown", 60)
            self.wait_until(lambda: self.display.screen(picture) == a, "A is not shown", 60)
        self.close()

    def charting(self):
        """The words of the program that charts for the window; none where none does."""
        for child in pathlib.Path(f"/proc/{self.window.pid}/task/{self.window.pid}/children").read_text().split():
            words = pathlib.Path(f"/proc/{child}/cmdline").read_text().split("\0")[1:-1]
            if words[:1] == ["chart"]:
                return words
        return []

    def press_chart_button(self):
        """Of a panel at 160 that is 580 high: the button is above its end."""
        self.client.move(300, 400)
        for _ in range(30):
            self.client.button(5, True)
            self.client.button(5, False)
            time.sleep(0.02)
        time.sleep(0.5)
        self.client.click(160 + 55, 580 - CHART_ABOVE_END)

    def test_a_chart_of_the_view_is_made_until_the_window_is_closed(self):
        self.open("panes", "160x580", "--ambient", "ao")
        self.wait_for("picture")
        self.press_chart_button()
        self.wait_until(self.charting, "no chart is made")
        words = self.charting()
        self.assertEqual((words[1], words[-2:]), ("panes", ["-o", "panes-001-chart"]))
        self.assertIn("160x580", words)
        self.close()
        self.assertEqual(subprocess.run(["pgrep", "-f", "panes-001-chart"], stdout=subprocess.PIPE).stdout, b"", "it goes on")

    def script(self, name, text):
        (self.folder / name).write_text("#!/bin/sh\n" + text)
        (self.folder / name).chmod(0o755)

    def test_a_browser_that_shows_a_chart_does_not_stop_the_window(self):
        self.script("sideray", "exit 0\n")  # the program beside the window, which charts
        self.script("xdg-open", f"echo $1 > {self.folder}/opened.txt\nexec sleep 4\n")
        window = shutil.copy(PROGRAM.parent / "sideray-view", self.folder)
        self.start([window, "panes", "--size", "160x580", "--threads", "2"], PATH=f"{self.folder}:{os.environ['PATH']}")
        self.wait_for("picture")
        self.press_chart_button()
        self.wait_until((self.folder / "opened.txt").exists, "no page is opened")
        self.client.press("c")
        self.wait_for("reference ", 3)
        self.close()
        self.assertEqual((self.folder / "opened.txt").read_text(), "panes-001-chart/index.html\n")

    def test_mouse_and_keys_move_the_camera_and_compare(self):
        self.open("panes", SMALL, *QUICK)
        self.wait_for("64/64")
        still = self.display.screen(SMALL_PICTURE)
        self.drag((20, 45), (50, 45), (70, 45))
        self.wait_until(lambda: self.display.screen(SMALL_PICTURE) != still, "a drag did not turn the view")
        self.display.use("key", "c")
        self.wait_for("reference ")
        self.wait_for("64/64")
        self.display.use("key", "Tab")
        self.wait_for("reference ")
        self.display.use("key", "m")
        self.wait_until(lambda: len({self.color(x, y) for x in range(5, 80, 15) for y in range(32, 60, 5)}) > 5,
                        "the map of differences did not come", 60)
        self.close()

    def test_a_scene_that_cannot_be_read_leaves_the_old_one(self):
        subprocess.run([PROGRAM, "make", "panes", "-o", self.folder / "scene.glb"], check=True)
        self.open("scene.glb", "160x90", *QUICK)
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

    def test_a_command_whose_control_key_is_released_first_does_not_fly(self):
        self.open("panes", "160x90", *QUICK)
        self.wait_for("64/64")
        self.client.hold("Control_L", True)
        self.client.hold("s", True)
        self.wait_until(self.pictures, "nothing was saved")
        still = self.display.screen((0, 30, 160, 90))
        self.client.hold("Control_L", False)
        time.sleep(1)
        self.client.hold("s", False)
        time.sleep(0.5)
        self.assertIn("64/64", self.title())
        self.assertEqual(self.display.screen((0, 30, 160, 90)), still)
        self.close()

    def test_dropped_files_are_shown_together(self):
        scene_files.gltf(self.folder / "a square.gltf")
        scene_files.hdr(self.folder / "red.hdr", 200, 20, 20)
        scene_files.hdr(self.folder / "green.hdr", 20, 200, 20)
        (self.folder / "broken.glb").write_bytes(b"no scene")
        self.open("panes", "120x100", *QUICK)
        self.wait_for("64/64")
        window = self.client.window("Sideray")
        self.assertTrue(self.client.drop(window, [self.folder / "a square.gltf", self.folder / "red.hdr"]))
        self.wait_for("a square.gltf")
        self.wait_for("64/64")
        red, green, _ = self.color(20, 80)
        self.assertGreater(red, 2 * green, "the surroundings are not those that were dropped with the scene")
        self.assertTrue(self.client.drop(window, [self.folder / "green.hdr"]))
        self.wait_until(lambda: self.color(20, 80)[1] > 2 * self.color(20, 80)[0], "the second surroundings did not come")
        self.wait_for("a square.gltf")
        self.wait_for("64/64")
        panel = self.display.screen((130, 30, 470, 80))
        self.assertTrue(self.client.drop(window, [self.folder / "broken.glb"]))
        self.wait_until(lambda: self.display.screen((130, 30, 470, 80)) != panel, "the panel does not say what is wrong")
        self.assertIn("a square.gltf", self.title(), "the old scene did not stay")
        self.assertIn("64/64", self.title(), "the old scene did not stay")
        self.close()

    def test_the_space_bar_plays_and_pauses(self):
        scene_files.gltf(self.folder / "square.gltf")
        self.open("square.gltf", "120x90", *QUICK)
        self.wait_for("64/64")
        picture = (0, 30, 120, 90)
        for _ in range(2):
            still = self.display.screen(picture)
            self.client.press("space")
            self.wait_until(lambda: self.display.screen(picture) != still, "nothing moves")
            self.client.press("space")
            time.sleep(1)
            self.wait_for("64/64")
        self.close()

    def test_variants_of_materials_are_chosen_in_the_panel(self):
        scene_files.gltf(self.folder / "square.gltf")
        self.open("square.gltf", "160x300", *QUICK)
        self.wait_for("64/64")
        self.assertLess(max(self.color(80, 150)) - min(self.color(80, 150)), 40, "the file's own material is grey")
        for item, channel in ((1, 0), (2, 2)):
            self.choose("variant", item, 160)
            self.wait_until(lambda: self.color(80, 150)[channel] > 2 * self.color(80, 150)[2 - channel],
                            f"variant {item} is not shown")
            self.wait_for("64/64")
        saved = self.save()
        subprocess.run([PROGRAM, "render", "square.gltf", "--variant", "blue", "--gl", "none", "--size", "160x300", "--samples", "64",
                        *QUICK, "-o", "render.png"], cwd=self.folder, check=True)
        self.assertEqual(png_rows(saved), png_rows(self.folder / "render.png"))
        self.close()

    def help_of(self, row, left):
        """What stands beside the panel while the mouse is on the row's name: (the pixels, whether some have the colour of a reason)."""
        beside = (0, 150, left, 350)
        self.client.move(left + 200, 400)
        time.sleep(0.3)
        without = self.display.screen(beside)
        self.client.move(left + 20, ROWS[row])
        self.wait_until(lambda: self.display.screen(beside) != without, f"{row} has no help")
        time.sleep(0.3)
        pixels = self.display.screen(beside)
        colors = {(pixels[i + 2], pixels[i + 1], pixels[i]) for i in range(0, len(pixels), 4)}
        return pixels, any(red > 220 and 165 < green < 195 and 90 < blue < 110 for red, green, blue in colors)

    def test_the_mouse_on_an_option_shows_its_help_and_why_it_is_grey(self):
        self.open("panes?count=1", "400x360", "--translucency", "raster", *QUICK)
        self.wait_for("64/64")
        helps = {row: self.help_of(row, 400) for row in ("quality", "translucency", "layers")}
        self.assertEqual(len({pixels for pixels, _ in helps.values()}), 3, "options have the same help")
        self.assertEqual([row for row, (_, has_reason) in helps.items() if has_reason], ["layers"])
        grey = self.display.screen((400, 250, 780, 300))
        self.client.click(400 + 180, ROWS["layers"])
        time.sleep(0.5)
        self.client.move(420, ROWS["layers"])
        time.sleep(0.3)
        self.assertEqual(self.display.screen((400, 250, 780, 300)), grey, "a grey option takes input")
        self.close()

    def test_the_age_of_answers_is_shown_and_the_pixel_inspected(self):
        self.open("panes", "120x600")
        self.wait_for("picture")
        self.choose("shows", 17, 120)  # age of light
        traced, no_rays = (70, 150, 90), (30, 30, 32)
        self.wait_until(lambda: self.color(60, 300) == traced, "light is not traced in a picture without a budget", 60)
        rows = png_rows(self.save())
        self.assertEqual({tuple(row[i:i + 3]) for row in rows for i in range(0, len(row), 3)} - {traced, no_rays}, set())
        self.client.move(60, 200)
        before = self.display.screen((0, 500, 120, 600))
        self.client.press("i")
        self.wait_until(lambda: self.display.screen((0, 500, 120, 600)) != before, "nothing is said of the pixel")
        self.close()

    def test_the_button_of_the_window_ends_a_picture_in_the_middle(self):
        self.open("bistro", "600x500", "--quality", "best")
        self.wait_for("picture")
        self.drag((200, 200), (300, 220))
        time.sleep(0.6)  # the whole picture has begun
        begin = time.monotonic()
        self.client.ask_to_close(self.client.window("Sideray"))
        self.assertEqual(self.window.wait(20), 0)
        self.assertLess(time.monotonic() - begin, 5, "closing waited for a picture")

    def lose(self, lose, reason):
        """Moves, saves a picture, loses the window, and goes on where it was."""
        self.turn()
        saved = self.save()
        lose()
        self.assertEqual(self.window.wait(20), 1)
        # Libraries have lines of their own: without XDG_RUNTIME_DIR libwayland, which GLFW 3.4 loads.
        said = [line for line in self.window.stderr.read().splitlines() if line.startswith("sideray:")]
        self.assertEqual(len(said), 1, said)
        self.assertIn(reason, said[0])
        self.assertEqual(sorted(file.name for file in self.folder.iterdir() if ".tmp" in file.name), [])
        self.window.stderr.close()
        words = shlex.split(said[0].split("go on with: ")[1])
        self.assertEqual(words[:2], ["sideray", "view"])
        return saved, [PROGRAM, *words[1:]]

    def go_on(self, saved, words):
        self.start(words)
        self.wait_for("64/64")
        self.assertEqual(png_rows(self.save()), png_rows(saved))
        self.close()

    def test_a_display_that_goes_away_leaves_a_command_that_goes_on(self):
        self.open("panes", SMALL, *QUICK)
        self.wait_for("64/64")
        lost = self.display

        def kill():
            lost.server.send_signal(signal.SIGKILL)
            lost.server.wait()
        saved, words = self.lose(kill, "its display is gone")
        self.display = Display(self.folder, SCREEN)
        self.client = self.display.client()
        self.go_on(saved, words)

    @needs_lost_context
    def test_a_lost_context_leaves_a_command_that_goes_on(self):
        lost = self.folder / "lost"
        self.open("panes", SMALL, *QUICK, LD_PRELOAD=str(LOST_CONTEXT), SIDERAY_LOSE_WINDOW=str(lost))
        self.wait_for("64/64")
        self.go_on(*self.lose(lambda: (lost.touch(), self.client.move(50, 45)), "its OpenGL context was reset"))

    @needs_lost_context
    def test_a_lost_window_ends_although_a_picture_does_not(self):
        lost, hang = self.folder / "lost", self.folder / "hang"
        self.open("panes", SMALL, "--gl", "egl", *QUICK, LD_PRELOAD=str(LOST_CONTEXT), SIDERAY_LOSE_WINDOW=str(lost),
                  SIDERAY_HANG_RENDERER=str(hang))
        self.wait_for("64/64")
        hang.touch()
        self.client.press("f")
        self.wait_for(" 0/64")
        lost.touch()
        self.client.move(50, 45)
        self.assertEqual(self.window.wait(5), 1)
        self.assertIn("its OpenGL context was reset", self.window.stderr.read())

    @needs_lost_context
    def test_a_renderer_whose_context_is_lost_is_made_anew(self):
        lost = self.folder / "lost"
        self.open("panes", SMALL, "--gl", "egl", *QUICK, LD_PRELOAD=str(LOST_CONTEXT), SIDERAY_LOSE_RENDERER=str(lost))
        self.wait_for("64/64")
        self.frame_all()
        saved = self.save()
        lost.touch()
        self.frame_all()
        self.assertFalse(lost.exists(), "no context was lost")
        self.assertEqual(png_rows(self.save()), png_rows(saved))
        self.close()


if __name__ == "__main__":
    missing = [name for name in ("Xvfb", "xdotool") if not shutil.which(name)]
    if missing:
        print(f"viewer_test: {' and '.join(missing)} not found; install xvfb and xdotool")
        sys.exit(1 if os.environ.get("SIDERAY_REQUIRE_CONTEXTS") else 77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
