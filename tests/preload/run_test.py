#!/usr/bin/python3
"""run_test.py PROGRAM FIXED_PROGRAM: `sideray run` with a program of the fixed function on a display of its own (Xvfb).

Skipped (77) without Xvfb, GLX or libsideray_run.so, which fails instead where SIDERAY_REQUIRE_CONTEXTS is set.
"""
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
import outside  # noqa: E402

PROGRAM, FIXED = (pathlib.Path(word).resolve() for word in sys.argv[1:3])


class Display:
    """An X server."""

    def __init__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-nolisten", "tcp", "-noreset"],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as stream:
            self.environment = {**os.environ, "DISPLAY": ":" + stream.readline().strip(), "LIBGL_ALWAYS_SOFTWARE": "1"}

    def end(self):
        self.server.terminate()
        self.server.wait()


class Picture:
    def __init__(self, path):
        line, self.pixels = path.read_bytes().split(b"\n", 1)
        magic, width, height, _ = line.split()
        assert magic == b"P6"
        self.width, self.height = int(width), int(height)

    @classmethod
    def of_png(cls, path):
        """One of `--pictures`."""
        picture = cls.__new__(cls)
        picture.width, picture.height, picture.pixels = outside.read(path)
        return picture

    def at(self, x, y):
        place = 3 * (y * self.width + x)
        return tuple(self.pixels[place:place + 3])

    def largest_difference(self, other):
        return max(abs(a - b) for a, b in zip(self.pixels, other.pixels))

    def changed(self, other):
        """The pixels that differ, as (x, y)."""
        return {(i // 3 % self.width, i // 3 // self.width) for i, (a, b) in enumerate(zip(self.pixels, other.pixels)) if a != b}


# What fixed_program.c draws: the eye is at `eye` and looks down by `pitch`.
EYE, PITCH, SUN = (0, 1.8, 4.5), math.radians(12), (0.3, 1, 0.6)


def pixel_of(x, y, z):
    """Where a place of the world is in the picture."""
    dy, dz = y - EYE[1], z - EYE[2]
    up, depth = math.cos(PITCH) * dy - math.sin(PITCH) * dz, -(math.sin(PITCH) * dy + math.cos(PITCH) * dz)
    return int(160 * (1 + 1.5 * x / depth)), int(120 * (1 - 2 * up / depth))


def depth_of(y, z):
    return -(math.sin(PITCH) * (y - EYE[1]) + math.cos(PITCH) * (z - EYE[2]))


def ray_of(x, y):
    """The direction in which a pixel looks, in the world."""
    across, up = ((x + 0.5) / 160 - 1) / 1.5, (1 - (y + 0.5) / 120) / 2
    return across, math.cos(PITCH) * up - math.sin(PITCH), -math.sin(PITCH) * up - math.cos(PITCH)


def checkers(x, z):
    """The floor's texel, 0..255, or None near an edge of one."""
    u, v = (x + 4) / 0.5, (z + 4) / 0.5
    if min(u % 1, 1 - u % 1, v % 1, 1 - v % 1) < 0.2 or not (0 < u < 16 and 0 < v < 16):
        return None
    return 230 if (int(u) + int(v)) % 2 else 60


class RunTest(unittest.TestCase):
    known = {}

    @classmethod
    def setUpClass(cls):
        cls.display = Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.end()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def start(self, words):
        return subprocess.run([str(word) for word in words], env=self.display.environment, cwd=self.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, timeout=100, check=False)

    def once(self, name, find):
        """What `find` returned for the first test that asked: programs draw the same in each run."""
        if name not in self.known:
            self.known[name] = find()
        return self.known[name]

    def plain(self, *what, frames=3):
        def draw():
            done = self.start([FIXED, frames, "plain.ppm", *what])
            self.assertEqual(done.returncode, 0, done.stderr)
            return Picture(self.folder / "plain.ppm")
        return self.once(("plain", frames, *what), draw)

    def run_fixed(self, *what, frames=3, options=()):
        """The picture, what was said, and the figures of the report."""
        done = self.start([PROGRAM, "run", "--report", "report.html", *options, "--", FIXED, frames, "run.ppm", "error", *what])
        self.assertEqual(done.returncode, 0, done.stderr)
        report = (self.folder / "report.html").read_text()
        figures = {name: float(value) for name, value in re.findall(r"<tr><td>(\w+)</td><td>([\d.]+)</td></tr>", report)}
        return Picture(self.folder / "run.ppm"), done.stderr, figures

    def test_off_changes_no_bit(self):
        plain = self.plain("smoke", "overlay")
        seen, said, figures = self.run_fixed("smoke", "overlay", options=["--off"])
        self.assertEqual(seen.pixels, plain.pixels)
        self.assertEqual(said, "")
        self.assertEqual(figures["draws_held"], 0)

    def test_glass_shows_rays_and_nothing_else_changes(self):
        plain = self.plain()
        seen, said, figures = self.run_fixed()
        self.assertEqual(said, "")
        self.assertEqual(figures["frames_with_rays"], 3)
        # All of the pane has its answers.
        self.assertEqual(figures["fragments_by_rays"], figures["layers_found"])
        self.assertGreater(figures["fragments_by_rays"], 3 * 12000)
        changed = plain.changed(seen)
        self.assertGreater(len(changed), 5000)
        self.assertTrue(all(77 <= x <= 243 and 57 <= y <= 158 for x, y in changed), "outside of the pane")
        # Glass of 4 %: the top of the red box, which stands on the eye's side, is mirrored in the pane; above it the sky.
        top = [min(255, round(255 * c * (0.2 + 0.8305))) for c in (0.9, 0.1, 0.1)]  # ambient, and the sun's cosine
        for place, mirrored in (((150, 100), top), ((150, 60), (76, 128, 204))):
            for channel in range(3):
                expected = 0.96 * plain.at(*place)[channel] + 0.04 * mirrored[channel]
                self.assertAlmostEqual(seen.at(*place)[channel], expected, delta=1)

    def test_what_covers_is_no_glass(self):
        plain = self.plain("solid")
        seen, said, figures = self.run_fixed("solid")
        self.assertEqual((seen.pixels, said, figures["draws_held"]), (plain.pixels, "", 0))

    def test_opened_functions_are_followed(self):
        seen, _, figures = self.run_fixed("opened")
        linked, _, _ = self.run_fixed()
        self.assertGreater(figures["fragments_by_rays"], 0)
        self.assertEqual(seen.pixels, linked.pixels)

    def test_the_order_of_draws_stays(self):
        """Smoke in front of the pane covers its reflections, and an overlay covers both."""
        plain, pane = self.plain("smoke", "overlay"), self.plain()
        seen, _, figures = self.run_fixed("smoke", "overlay")
        self.assertEqual(figures["draws_held"], 6)
        self.assertEqual(figures["batches"], 3)
        without, _, _ = self.run_fixed()
        for x, y in ((150, 90), (170, 90), (200, 80)):
            added = [a - b for a, b in zip(without.at(x, y), pane.at(x, y))]
            layers = (0.5 if x < 185 else 1) * (0.5 if x >= 160 else 1)
            for channel in range(3):
                self.assertAlmostEqual(seen.at(x, y)[channel] - plain.at(x, y)[channel], layers * added[channel], delta=2)

    def test_shaders_are_passed_through(self):
        plain = self.plain("shaders")
        seen, said, figures = self.run_fixed("shaders")
        self.assertEqual(seen.pixels, plain.pixels)
        self.assertEqual(said.count("\n"), 1)
        self.assertIn("uses shaders (glUseProgram)", said)

    def test_several_contexts_are_passed_through(self):
        plain = self.plain("contexts")
        seen, said, _ = self.run_fixed("contexts")
        self.assertEqual(seen.pixels, plain.pixels)
        self.assertEqual(said.count("\n"), 1)
        self.assertIn("several contexts", said)

    def test_the_window_is_resized(self):
        seen, said, figures = self.run_fixed("resize", frames=4)
        self.assertEqual((seen.width, seen.height, said), (400, 200, ""))
        self.assertEqual(figures["frames_with_rays"], 4)

    def test_another_level_leaves_nothing_of_the_first(self):
        """Lists and textures are deleted and made again under the same names, and the window is resized."""
        for options in ((), ("--late",)):
            seen, said, _ = self.run_fixed("levels", "slow", frames=20, options=options)
            fresh, _, _ = self.run_fixed("level2", "slow", frames=20, options=options)
            self.assertEqual((said, seen.width, len(seen.changed(fresh))), ("", 400, 0), options)

    def test_late_answers_are_those_of_a_frame_that_stands_still(self):
        waited, _, all_of_them = self.run_fixed("smoke")
        late, said, figures = self.run_fixed("smoke", "slow", frames=40, options=["--late"])
        self.assertEqual((said, late.pixels), ("", waited.pixels))
        self.assertGreater(figures["fragments_by_rays"], 0.7 * all_of_them["fragments_by_rays"] / 3 * 40)

    def test_late_answers_follow_the_eye(self):
        waited, _, all_of_them = self.run_fixed("turn", frames=40)
        late, _, figures = self.run_fixed("turn", "slow", frames=40, options=["--late"])
        plain = self.plain("turn", frames=40)
        self.assertGreater(figures["fragments_by_rays"], 0.7 * all_of_them["fragments_by_rays"])
        # Nearly all that rays change is changed late too, and alike.
        pane = waited.changed(plain)
        self.assertGreater(len(late.changed(plain) & pane), 0.9 * len(pane))
        alike = sum(1 for x, y in pane if max(abs(a - b) for a, b in zip(late.at(x, y), waited.at(x, y))) <= 3)
        self.assertGreater(alike, 0.95 * len(pane))

    def hash_of_the_floor(self):
        self.run_fixed(options=["--off"])
        hashes = re.findall(r"<code>([0-9a-f]{16})</code></td><td><img", (self.folder / "report.html").read_text())
        self.assertEqual(len(hashes), 1)
        return hashes[0]

    def floor_rule(self):
        """A rules file that makes the floor a mirror."""
        floor = self.once("floor", self.hash_of_the_floor)
        (self.folder / "rules").write_text(f"mirror texture {floor} reflectance=0.5  # the floor\n")
        return ["--rules", "rules"]

    def rule(self, *lines):
        (self.folder / "rules").write_text("\n".join(lines) + "\n")
        return ["--rules", "rules"]

    # On the floor: beside the red box, in its shadow; under the pane's lower edge, in the pane's; in the sun.
    IN_SHADOW, BEHIND_GLASS, IN_THE_SUN = (-0.76, 0, 1.7), (1.35, 0, -0.17), (-2.2, 0, 2.2)

    def test_the_sun_casts_shadows_by_a_rule(self):
        plain = self.plain()
        seen, said, figures = self.run_fixed(options=self.rule("sun light 0"))
        self.assertEqual((said, figures["frames_with_shadows"]), ("", 3))
        # The floor is lit by 1.03, clamped; 0.2 of it is ambient. The pane's alpha of 0.3 takes so much of the sun's part.
        for place, left in ((self.IN_SHADOW, 0.2), (self.BEHIND_GLASS, 0.7 + 0.3 * 0.2), (self.IN_THE_SUN, 1)):
            x, y = pixel_of(*place)
            for channel in range(3):
                self.assertAlmostEqual(seen.at(x, y)[channel], left * plain.at(x, y)[channel], delta=2, msg=str(place))
        # Nothing else is darkened: the sky, and what is lit.
        reflected, _, _ = self.run_fixed()
        darker = seen.changed(reflected)
        self.assertGreater(len(darker), 700)
        self.assertLess(len(darker), 3000)
        self.assertGreater(min(y for _, y in darker), 50)

    # On the pane: in the hanging box's shadow, and in the sun.
    PANE_IN_SHADOW, PANE_IN_THE_SUN = (0.6, 0.8, 0), (-0.6, 1.0, 0)

    def held_back_in_shadow(self, *what, options=()):
        """What shadows take from the pane, at both places, in codes; and what they should take of what is not in fog."""
        rules = self.rule("sun light 0")
        shadowed, said, figures = self.run_fixed("hanging", *what, options=[*rules, *options], frames=40 if options else 3)
        self.assertEqual(said, "")
        self.assertGreater(figures["mean_share_of_held_in_shadow"], 0.005)
        lit, _, _ = self.run_fixed("hanging", *what)
        taken = [[b - a for a, b in zip(shadowed.at(*pixel_of(*place)), lit.at(*pixel_of(*place)))] for place in (self.PANE_IN_SHADOW, self.PANE_IN_THE_SUN)]
        # Glass of 4 % lies over the pane's alpha of 0.3.
        cosine = SUN[2] / math.hypot(*SUN)
        return taken, [0.96 * 0.3 * cosine * 255 * c for c in (0.2, 0.4, 0.3)]

    def test_shadows_fall_on_what_is_held_back(self):
        (in_shadow, in_the_sun), expected = self.held_back_in_shadow()
        self.assertEqual(in_the_sun, [0, 0, 0])
        for a, b in zip(in_shadow, expected):
            self.assertAlmostEqual(a, b, delta=1.5)

    def test_fog_lies_over_shadows_on_what_is_held_back(self):
        (in_shadow, in_the_sun), expected = self.held_back_in_shadow("fog")
        self.assertEqual(in_the_sun, [0, 0, 0])
        clear = (12 - depth_of(*self.PANE_IN_SHADOW[1:])) / 10
        for a, b in zip(in_shadow, expected):
            self.assertAlmostEqual(a, clear * b, delta=1.5)

    def test_late_shadows_fall_on_what_is_held_back(self):
        (in_shadow, in_the_sun), expected = self.held_back_in_shadow("slow", options=["--late"])
        self.assertEqual(in_the_sun, [0, 0, 0])
        for a, b in zip(in_shadow, expected):
            self.assertAlmostEqual(a, b, delta=1.5)

    def test_the_far_side_of_what_is_thin_darkens_nothing(self):
        """What the sun does not light cannot be darker in shadow, though its back, which it lights, is a step of depth behind it."""
        plain = self.plain("thin")
        seen, _, _ = self.run_fixed("thin", options=self.rule("sun light 0"))
        x, y = pixel_of(0, 3.4, -6)
        self.assertGreater(plain.at(x, y)[0], plain.at(x, y)[2])
        for dx in range(-12, 13):
            for a, b in zip(seen.at(x + dx, y), plain.at(x + dx, y)):
                self.assertAlmostEqual(a, b, delta=1)

    def test_shadows_fall_on_a_floor_that_mirrors(self):
        """It is held back, textured, and written into the depth of the picture."""
        mirror = self.floor_rule()
        plain = self.plain()
        without, _, _ = self.run_fixed(options=mirror)
        with (self.folder / "rules").open("a") as rules:
            rules.write("sun light 0\n")
        seen, said, _ = self.run_fixed(options=mirror)
        self.assertEqual(said, "")
        for place, left in ((self.IN_SHADOW, 0.2), (self.IN_THE_SUN, 1)):
            x, y = pixel_of(*place)
            for channel in range(3):
                expected = without.at(x, y)[channel] - 0.5 * (1 - left) * plain.at(x, y)[channel]
                self.assertAlmostEqual(seen.at(x, y)[channel], expected, delta=2, msg=str(place))

    def test_fog_lies_over_shadows(self):
        plain = self.plain("fog")
        seen, _, _ = self.run_fixed("fog", options=self.rule("sun light 0"))
        x, y = pixel_of(*self.IN_SHADOW)
        fog_share = 1 - (12 - depth_of(0, self.IN_SHADOW[2])) / 10
        for channel, fog in enumerate((0.1, 0.2, 0.9)):
            expected = 0.2 * plain.at(x, y)[channel] + 0.8 * fog_share * 255 * fog
            self.assertAlmostEqual(seen.at(x, y)[channel], expected, delta=3)

    def test_late_shadows_are_those_of_a_frame_that_stands_still_and_follow_the_eye(self):
        rules = self.rule("sun light 0")
        # What waits for its answers and stands still is whole in three frames.
        for what, share, waiting, frames in ((), 1, 3, 40), (("turn",), 0.8, 20, 20):
            waited, _, _ = self.run_fixed(*what, frames=waiting, options=rules)
            late, said, _ = self.run_fixed("slow", *what, frames=frames, options=[*rules, "--late"])
            darker = waited.changed(self.run_fixed(*what, frames=waiting)[0])
            alike = sum(1 for x, y in darker if max(abs(a - b) for a, b in zip(late.at(x, y), waited.at(x, y))) <= 3)
            self.assertEqual(said, "")
            self.assertGreaterEqual(alike, share * len(darker), what)

    def test_what_is_far_from_its_origin_does_not_shadow_itself(self):
        rules = self.rule("sun light 0")
        near, _, _ = self.run_fixed(options=rules)
        far, _, figures = self.run_fixed("far", options=rules)
        self.assertEqual(figures["frames_with_shadows"], 3)
        wrong = sum(1 for x, y in far.changed(near) if max(abs(a - b) for a, b in zip(far.at(x, y), near.at(x, y))) > 3)
        self.assertLess(wrong, 300)  # the texture's edges, by a rounding

    def test_shade_of_a_rule_counts_where_nothing_is_lit(self):
        floor = self.once("floor", self.hash_of_the_floor)
        plain = self.plain()
        for shade in (0.5, 1):
            seen, _, _ = self.run_fixed(options=self.rule("sun light 0", f"opaque texture {floor} shade={shade}"))
            x, y = pixel_of(*self.IN_SHADOW)
            for channel in range(3):
                self.assertAlmostEqual(seen.at(x, y)[channel], shade * plain.at(x, y)[channel], delta=1)

    def water_mesh(self):
        return self.once("water", self.hash_of_the_water)

    def hash_of_the_water(self):
        self.run_fixed("water", options=["--off"])
        report = (self.folder / "report.html").read_text()
        rows = re.findall(r"<code>(\w{16})</code></td><td></td><td>\d+</td><td>\d+</td><td>([1-9]\d*)</td>", report[report.index("Meshes of"):])
        self.assertEqual(len(rows), 1, "the only blended mesh")
        return rows[0][0]

    def test_water_bends_what_is_behind_by_a_rule(self):
        water = self.water_mesh()
        straight, _, _ = self.run_fixed("water", options=self.rule(f"water mesh {water}"))
        bent, said, _ = self.run_fixed("water", options=self.rule(f"water mesh {water} ior=1.33"))
        self.assertEqual(said, "")
        self.assertLessEqual(len(bent.changed(straight)), 12000)
        right = wrong = 0
        for y in range(100, 240):
            for x in range(245, 320):  # beside the pane
                dx, dy, dz = ray_of(x, y)
                along = (0.4 - EYE[1]) / dy
                px, pz = along * dx, EYE[2] + along * dz
                if dy >= 0 or not (1.65 < px < 3.55 and -1.95 < pz < 1.95):
                    continue
                length = math.sqrt(dx * dx + dy * dy + dz * dz)
                cosine = -dy / length
                deep = math.sqrt(1 - (1 - cosine * cosine) / 1.33 ** 2)
                before = checkers(px - 0.4 * dx / dy, pz - 0.4 * dz / dy)
                after = checkers(px + 0.4 * dx / length / 1.33 / deep, pz + 0.4 * dz / length / 1.33 / deep)
                if before is None or after is None:
                    continue
                weight = 0.02 + 0.98 * (1 - cosine) ** 5
                expected = straight.at(x, y)[0] + (1 - weight) * 0.8 * (after - before)
                right += abs(bent.at(x, y)[0] - expected) <= 3
                wrong += abs(bent.at(x, y)[0] - expected) > 3
        self.assertGreater(right, 400)
        self.assertLess(wrong, 0.01 * right)

    def test_what_is_guessed_follows_its_rule(self):
        mesh = self.water_mesh()
        named, _, _ = self.run_fixed("water", options=self.rule(f"water mesh {mesh} ior=1.33", "ignore guessed"))
        guessed, _, figures = self.run_fixed("water", options=self.rule("water guessed ior=1.33", f"ignore mesh {mesh}"))
        self.assertNotEqual(named.pixels, guessed.pixels)
        self.assertEqual(figures["frames_with_rays"], 3)
        ignored, _, _ = self.run_fixed("water", options=self.rule("ignore guessed"))
        self.assertEqual(ignored.pixels, self.plain("water").pixels)

    def test_bent_water_is_the_same_late(self):
        rules = self.rule(f"water mesh {self.water_mesh()} ior=1.33", "sun light 0")
        waited, _, _ = self.run_fixed("water", options=rules)
        late, said, _ = self.run_fixed("water", "slow", frames=40, options=[*rules, "--late"])
        self.assertEqual(said, "")
        self.assertLessEqual(sum(1 for a, b in zip(late.pixels, waited.pixels) if abs(a - b) > 1), 0.001 * len(late.pixels))

    def test_generated_coordinates_are_mirrored(self):
        rules = self.floor_rule()
        for mode in ("object", "eye", "sphere"):
            generated, _, _ = self.run_fixed(mode, options=rules)
            explicit, _, _ = self.run_fixed(mode, "explicit", options=rules)
            self.assertLessEqual(generated.largest_difference(explicit), 2, mode)

    def test_fog_lies_over_what_is_mirrored(self):
        plain, (seen, _, _) = self.plain("fog"), self.run_fixed("fog")
        x, y = 150, 100
        # The red box's top, y = 1, behind the mirror: 1.8 below the eye, which looks down by 12 degrees.
        ray_y, pitch = 0.5 * (1 - 2 * (y + 0.5) / 240), math.radians(12)
        depth = -0.8 / (math.cos(pitch) * ray_y - math.sin(pitch))
        share = (12 - depth) / 10
        for channel, (red, fog) in enumerate(zip((0.9, 0.1, 0.1), (0.1, 0.2, 0.9))):
            mirrored = 255 * (share * min(1, red * (0.2 + 0.8305)) + (1 - share) * fog)
            self.assertAlmostEqual(seen.at(x, y)[channel], 0.96 * plain.at(x, y)[channel] + 0.04 * mirrored, delta=1)
            self.assertGreater(abs(mirrored - 255 * min(1, red * 1.0305)), 0)

    def test_egl_is_followed(self):
        seen, said, figures = self.run_fixed("egl", "smoke")
        self.assertEqual((said, seen.pixels), ("", self.run_fixed("smoke")[0].pixels))
        self.assertEqual(figures["frames_with_rays"], 3)

    def test_no_debug_message_is_an_error(self):
        (self.folder / "pictures").mkdir()
        rules = self.rule(f"water mesh {self.water_mesh()} ior=1.33", "sun light 0")
        for options in ((), ("--late",), ("--off",), ("--pictures", "pictures"), rules, (*rules, "--late"), (*rules, "--pictures", "pictures")):
            _, said, figures = self.run_fixed("debug", "water", "smoke", "overlay", "resize", "lists", "fog", "sphere", "hanging", frames=6, options=options)
            self.assertEqual(said, "")
            self.assertEqual(figures["draws_held"] == 0, options == ("--off",))

    def test_lists_are_made_anew(self):
        seen, _, figures = self.run_fixed("lists", frames=200)
        once, _, _ = self.run_fixed()
        self.assertEqual(seen.pixels, once.pixels)
        self.assertLess(figures["meshes_kept"], 8)

    def test_a_killed_program_dies_as_ever(self):
        for how in (signal.SIGTERM, signal.SIGKILL):
            report = self.folder / f"{how.name}.html"
            process = subprocess.Popen([PROGRAM, "run", "--report", report, "--", FIXED, "1000000", "run.ppm"], env=self.display.environment,
                                       cwd=self.folder, stderr=subprocess.PIPE)
            deadline = time.monotonic() + 60
            while not report.exists() and time.monotonic() < deadline:
                time.sleep(0.1)
            process.send_signal(how)
            self.assertEqual(process.wait(timeout=20), -how)
            self.assertEqual(process.stderr.read(), b"")
            process.stderr.close()
            self.assertIn("frames_with_rays", report.read_text())

    def test_a_program_that_leaves_from_a_signal_handler_leaves(self):
        """Also where rays are waited for then, which the overlay makes them be, and where the picture is on its way to X."""
        for repeat in range(10):
            what = "handler" if repeat % 2 else "swap_handler"
            report = self.folder / f"{repeat}.html"
            process = subprocess.Popen([PROGRAM, "run", "--report", report, "--", FIXED, "1000000", "run.ppm", "overlay", what], env=self.display.environment,
                                       cwd=self.folder, stderr=subprocess.PIPE)
            while not report.exists() and process.poll() is None:
                time.sleep(0.05)
            process.terminate()
            try:
                self.assertEqual(process.wait(timeout=20), 3, what)
            finally:
                process.kill()
                process.stderr.close()

    def test_a_program_that_tidies_up_at_exit_has_its_report(self):
        _, said, figures = self.run_fixed("atexit")
        self.assertEqual((said, figures["frames"]), ("", 3))

    def test_a_rule_makes_the_floor_a_mirror(self):
        rules = self.floor_rule()
        plain = self.plain()
        seen, said, figures = self.run_fixed(options=rules)
        self.assertEqual(said, "")
        self.assertEqual(figures["draws_held"], 6)
        # Half of the floor, and half of the sky that stands above it.
        x, y = 20, 180
        for channel, sky in enumerate((76.5, 127.5, 204)):
            self.assertAlmostEqual(seen.at(x, y)[channel], 0.5 * plain.at(x, y)[channel] + 0.5 * sky, delta=2)

    def test_the_scene_is_captured(self):
        self.run_fixed(frames=4, options=["--capture", "scene.glb"])
        done = self.start([PROGRAM, "info", "--json", "scene.glb"])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("28", done.stdout)
        self.assertIn("camera0", done.stdout)

    def test_pictures_without_and_with_rays(self):
        """The program's own picture, the one with rays, and where rays are: all else is the same, and the run goes on."""
        (self.folder / "pictures").mkdir()
        plain, (with_rays, _, _) = self.plain("smoke", "late_box", frames=1), self.run_fixed("smoke", "late_box", frames=1)
        seen, said, _ = self.run_fixed("smoke", "late_box", frames=1, options=["--pictures", "pictures"])
        self.assertEqual(said, "")
        self.assertLessEqual(seen.largest_difference(with_rays), 1)
        self.assertEqual(sorted(path.name for path in (self.folder / "pictures").iterdir()), ["0-marks.png", "0-own.png", "0-rays.png"])
        own, rays, marks = (Picture.of_png(self.folder / "pictures" / f"0-{which}.png") for which in ("own", "rays", "marks"))
        # Vertices that come from arrays may be rounded otherwise.
        self.assertLessEqual(own.largest_difference(plain), 1)
        self.assertLessEqual(rays.largest_difference(with_rays), 1)
        marked = {(x, y) for x in range(marks.width) for y in range(marks.height) if marks.at(x, y) != (0, 0, 0)}
        self.assertGreater(len(marked), 5000)
        self.assertLessEqual(own.changed(rays), marked)

    def test_what_a_held_draw_writes_into_the_stencil_is_waited_for(self):
        """A box that is drawn where the pane has written the stencil."""
        plain, without = self.plain("stencil", "late_box"), self.plain("stencil")
        seen, _, _ = self.run_fixed("stencil", "late_box")
        box = plain.changed(without)
        self.assertGreater(len(box), 300)
        for x, y in box:
            for a, b in zip(plain.at(x, y), seen.at(x, y)):
                self.assertAlmostEqual(a, b, delta=1)

    def test_pictures_keep_the_stencil(self):
        (self.folder / "pictures").mkdir()
        plain = self.plain("stencil", "smoke", frames=1)
        seen, said, _ = self.run_fixed("stencil", "smoke", frames=1, options=["--pictures", "pictures"])
        own = Picture.of_png(self.folder / "pictures" / "0-own.png")
        self.assertEqual(said, "")
        self.assertLessEqual(own.largest_difference(plain), 1)
        # Smoke is where the pane is, after the pictures too.
        self.assertLessEqual(seen.largest_difference(Picture.of_png(self.folder / "pictures" / "0-rays.png")), 0)

    def test_wrong_rules_are_refused_in_one_line(self):
        plain, zeros = self.plain(), "0123456789abcdef"
        for line, what in ((f"glas texture {zeros}", "\"glas\" is no kind"), (f"water texture {zeros} ior=0.5", "\"ior=0.5\" is out of range"),
                           (f"mirror mesh {zeros} ior=1.5", "ior is of glass and water alone"), (f"water mesh {zeros} shade=1", "shade is of opaque alone"),
                           ("sun light 8", "it does not say which light"), (f"sky texture {zeros} shades=1", "\"shades=1\" is not known")):
            seen, said, _ = self.run_fixed(options=self.rule("# glass", line))
            self.assertEqual(seen.pixels, plain.pixels)
            self.assertIn("rules line 2: " + what, said)
            self.assertEqual(said.count("\n"), 1)

    def test_what_cannot_be_run_is_said(self):
        done = self.start([PROGRAM, "run", "--", "no-such-program"])
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, "no-such-program cannot be run: .*; check its name")


def missing():
    if not shutil.which("Xvfb"):
        return "Xvfb"
    if not (PROGRAM.parent / "libsideray_run.so").exists():
        return "libsideray_run.so"
    display = Display()
    with tempfile.TemporaryDirectory() as folder:
        works = subprocess.run([str(FIXED), "1", folder + "/one.ppm"], env=display.environment, stderr=subprocess.DEVNULL, check=False).returncode == 0
    display.end()
    return None if works else "GLX on it"


if __name__ == "__main__":
    lacking = missing()
    if lacking:
        print(f"skipped: there is no {lacking}")
        sys.exit(1 if os.environ.get("SIDERAY_REQUIRE_CONTEXTS") else 77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
