"""Files: cameras, animations, warnings, pictures, comparisons."""

import base64
import json
import math
import os
import struct
import subprocess

import numpy as np
import pytest
from conftest import plain_scene

import sideray

PROGRAM = os.environ.get("SIDERAY_PROGRAM", "")


@pytest.fixture(scope="module")
def smoke():
    return sideray.load("smoke")


def test_cameras_by_name_and_number(renderer):
    scene = sideray.load("panes")
    assert scene.cameras == ["front"] and scene.names[1] == "wall"
    named = renderer.render(scene, (32, 18), "front").rgb
    assert np.array_equal(named, renderer.render(scene, (32, 18), 0).rgb)
    assert np.array_equal(named, renderer.render(scene, (32, 18)).rgb)
    with pytest.raises(sideray.InvalidArgument, match="no such camera; the scene has 1: 'front'"):
        renderer.render(scene, (32, 18), "back")
    scene.camera = sideray.Camera.look_at((1, 1, 5), (0, 0, 0))
    assert not np.array_equal(named, renderer.render(scene, (32, 18)).rgb)
    own = renderer.render(scene, (32, 18), eye=(1, 1, 5), target=(0, 0, 0)).rgb
    assert np.array_equal(own, renderer.render(scene, (32, 18)).rgb)


@pytest.mark.skipif(not PROGRAM, reason="SIDERAY_PROGRAM names no program to compare with")
@pytest.mark.parametrize("options", [[], ["--translucency", "raytraced", "--layers", "4", "--ambient", "ao"],
                                     ["--reference", "--light-samples", "4"], ["--ray-traced", "pane[01]"],
                                     ["--env", "none", "--shadows", "map", "--samples", "2"],
                                     ["--eye", "1,1,6", "--target", "0,0,0", "--fov", "50"]])
def test_pictures_are_the_program_s_to_the_last_bit(renderer, tmp_path, options):
    path = tmp_path / "picture.exr"
    subprocess.run([PROGRAM, "render", "panes", "-o", path, "--size", "48x27", "--aov", "Z,id", *options], check=True)
    keywords = {}
    for name, value in zip(options[::1], options[1:] + [""]):
        if name.startswith("--"):
            keywords[name[2:].replace("-", "_")] = True if value.startswith("--") or not value else value
    for name in ("eye", "target"):
        if name in keywords:
            keywords[name] = [float(part) for part in keywords[name].split(",")]
    if "fov" in keywords:
        keywords["fov"] = float(keywords["fov"])
    drawn = renderer.render(sideray.load("panes"), (48, 27), **keywords)
    written = sideray.read_image(path)
    for name in "RGBA":
        assert np.array_equal(np.float32(np.float16(drawn[name])), written[name]), name
    assert np.array_equal(drawn.depth, written["Z"]) and np.array_equal(drawn.ids, written["id.surface"])


@pytest.mark.skipif(not PROGRAM, reason="SIDERAY_PROGRAM names no program to compare with")
@pytest.mark.parametrize("scene", ["frosted", "solids"])
def test_objects_without_layers_are_drawn_as_by_the_program(renderer, tmp_path, scene):
    path = tmp_path / "picture.exr"
    subprocess.run([PROGRAM, "render", scene, "-o", path, "--size", "48x27", "--translucency", "raytraced"], check=True)
    drawn, written = renderer.render(sideray.load(scene), (48, 27), translucency="raytraced"), sideray.read_image(path)
    for name in "RGBA":
        assert np.array_equal(np.float32(np.float16(drawn[name])), written[name]), name


def test_time_moves_what_the_animation_moves(renderer, smoke):
    first = renderer.render(smoke, (48, 27), time=1.0).rgb
    assert smoke.time == 1.0
    second = renderer.render(smoke, (48, 27), time=2.0).rgb
    assert not np.array_equal(first, second)
    assert np.array_equal(renderer.render(smoke, (48, 27), time=1.0).rgb, first)


def test_sequences_follow_each_other(renderer):
    scene = plain_scene()
    sideways = np.eye(4)
    drawn = renderer.frames(scene, range(3), (48, 48), fps=10, aov="motion")
    assert not next(drawn)["motion"].any()
    sideways[0, 3] = 0.1
    square = scene.add_mesh([[-1, -1, 1], [1, -1, 1], [0, 1, 1]])
    next(drawn)
    square.transform = sideways
    motion = next(drawn)["motion"]
    # 0.1 units at a distance of 2, in a picture whose half height is 24 pixels and tan(22.5 degrees).
    assert motion[24, 24, 0] == pytest.approx(0.1 / 2 / np.tan(np.radians(22.5)) * 24, rel=1e-3)
    assert motion[24, 24, 1] == pytest.approx(0, abs=1e-3)
    with pytest.raises(StopIteration):
        next(drawn)


def test_warnings_of_files(tmp_path):
    path = tmp_path / "odd.gltf"
    path.write_text('{"asset": {"version": "2.0"}, "extensionsUsed": ["EXT_unheard_of"], "scenes": [{"nodes": []}], "scene": 0}')
    scene = sideray.load(path)
    assert any("EXT_unheard_of" in line for line in scene.warnings)
    assert scene.bounds is None


def test_files_that_are_not_there_or_broken(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no such file"):
        sideray.load(tmp_path / "none.glb")
    with pytest.raises(sideray.Error, match="did you mean the built-in scene panes"):
        sideray.load("pane")
    broken = tmp_path / "broken.glb"
    broken.write_bytes(b"glTF" + bytes(20))
    with pytest.raises(sideray.InvalidArgument, match="broken.glb"):
        sideray.load(broken)
    with pytest.raises(sideray.Error, match="no animation walk"):
        sideray.load("panes", animation="walk")


def test_names_of_files_need_not_be_utf_8(renderer, tmp_path, square):
    folder = os.fsencode(tmp_path)
    scene = glowing_square(tmp_path / os.fsdecode(b"scene\xff.gltf"), animated=False)
    assert sideray.load(os.fspath(scene)).variants == ["on"]
    picture = renderer.render(square, (8, 6))
    for name in (b"a\xff.png", b"a\xff.exr"):
        picture.save(folder + b"/" + name)
        assert sideray.read_image(os.fsdecode(folder + b"/" + name))["R"].shape == (6, 8)
    sideray.save_png(os.fsdecode(folder + b"/b\xff.png"), picture.display())
    square.set_environment(os.fsdecode(folder + b"/a\xff.exr"))
    (tmp_path / os.fsdecode(b"broken\xff.glb")).write_bytes(b"glTF")
    with pytest.raises(sideray.InvalidArgument, match="broken\udcff.glb: the file ends inside its header"):
        sideray.load(folder + b"/broken\xff.glb")


def test_moments_and_counts_are_checked_before_anything_changes(renderer, square):
    for scene in (square, sideray.load("panes")):
        for wrong in (math.nan, math.inf, -2e9):
            with pytest.raises(sideray.InvalidArgument, match="give seconds"):
                scene.set_time(wrong)
        assert scene.time == 0
    for fps in (0, -1, math.nan):
        with pytest.raises(sideray.InvalidArgument, match="fps"):
            next(renderer.frames(square, [0], (8, 6), fps=fps))
    with pytest.raises(sideray.InvalidArgument, match="repeat: -1"):
        renderer.render(square, (8, 6), repeat=-1)
    for threads in (-1, 5000):
        with pytest.raises(sideray.InvalidArgument, match="threads"):
            sideray.Renderer(gl="none", threads=threads)


def glowing_square(path, *, animated):
    """A square that fills the picture. Its glow changes at 1 s where it is animated, else by its variants."""
    corners = struct.pack("<12f", -9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0)
    keys = struct.pack("<3f9f", 0, 1, 9, 0, 0, 0, 1, 1, 1, 1, 1, 1)
    data = base64.b64encode(corners + struct.pack("<6I", 0, 1, 2, 0, 2, 3) + keys).decode()
    views = [(0, 48), (48, 24), (72, 12), (84, 36)]
    accessors = [(4, "VEC3", 5126), (6, "SCALAR", 5125), (3, "SCALAR", 5126), (3, "VEC3", 5126)]
    black = {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}, "emissiveFactor": [0, 0, 0]}
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "material": 0}
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}], "meshes": [{"primitives": [primitive]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
        "materials": [black, {**black, "emissiveFactor": [1, 1, 1]}],
        "buffers": [{"byteLength": 120, "uri": "data:application/octet-stream;base64," + data}],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in views],
        "accessors": [{"bufferView": i, "count": count, "type": kind, "componentType": component}
                      for i, (count, kind, component) in enumerate(accessors)]}
    if animated:
        pointer = {"KHR_animation_pointer": {"pointer": "/materials/0/emissiveFactor"}}
        document["animations"] = [{"samplers": [{"input": 2, "output": 3, "interpolation": "STEP"}],
                                   "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": pointer}}]}]
    else:
        document["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "on"}]}}
        primitive["extensions"] = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}
    path.write_text(json.dumps(document))
    return path


def test_variants_of_materials(renderer, tmp_path):
    path = glowing_square(tmp_path / "square.gltf", animated=False)
    scene = sideray.load(path, variant="on")
    assert scene.variants == ["on"] and sideray.load("panes").variants == []
    assert renderer.render(scene, (32, 18)).rgb[9, 16, 0] > renderer.render(sideray.load(path), (32, 18)).rgb[9, 16, 0] + 0.9
    with pytest.raises(sideray.Error, match="no variant off: the scene has others; choose one of on"):
        sideray.load(path, variant="off")


def test_time_changes_what_pointers_name(renderer, tmp_path):
    scene = sideray.load(glowing_square(tmp_path / "square.gltf", animated=True))
    dark = renderer.render(scene, (32, 18)).rgb
    scene.time = 2.0
    assert renderer.render(scene, (32, 18)).rgb[9, 16, 0] > dark[9, 16, 0] + 0.9
    scene.time = 0.0
    assert np.array_equal(renderer.render(scene, (32, 18)).rgb, dark)
    frames = [frame.rgb[9, 16, 0] for frame in renderer.frames(scene, range(3), (32, 18), fps=1, taa=False)]
    assert frames[1] > frames[0] + 0.9 and frames[2] > frames[0] + 0.9


def test_arrays_join_a_file(renderer):
    scene = sideray.load("panes")
    before = renderer.render(scene, (32, 18)).ids
    added = scene.add_mesh([[-9, -9, -2], [9, -9, -2], [0, 9, -2]], name="added")
    picture = renderer.render(scene, (32, 18), "front")
    assert added.surface_id == 7 and (picture.ids == 7).any() and not (before == 7).any()
    assert scene.names[7] == "added"


def test_saving_and_reading_pictures(renderer, tmp_path, square):
    picture = renderer.render(square, (24, 16), exposure=1.0)
    picture.save(tmp_path / "a.exr")
    picture.save(tmp_path / "a.png")
    read = sideray.read_image(tmp_path / "a.exr")
    assert np.array_equal(read["Z"], picture.depth) and np.array_equal(read["id.surface"], picture.ids)
    assert np.array_equal(read["R"], np.float32(np.float16(picture["R"])))
    shown = np.stack([sideray.read_image(tmp_path / "a.png")[c] for c in "RGB"], -1)
    assert np.array_equal(np.round(shown * 255).astype(np.uint8), picture.display())
    assert (picture.display(exposure=0.0) < picture.display()).any()
    assert picture._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(sideray.Error):
        picture.save(tmp_path / "no folder" / "a.png")


def test_comparisons_are_the_program_s(renderer, tmp_path, square):
    a = renderer.render(square, (32, 24))
    b = renderer.render(plain_scene(base_color=(0.5, 0.4, 0.3)), (32, 24))
    same = sideray.compare(a, a)
    assert same["flip"] == 0 and same["psnr"] == 999 and same.flip_map.shape == (24, 32)
    other = sideray.compare(a.rgb, b)
    assert 0 < other["flip"] < 1 and other["relmse"] > 0
    assert other.flip_map.mean() == pytest.approx(other["flip"], rel=1e-5)
    a.save(tmp_path / "a.png"), b.save(tmp_path / "b.png")
    shown = sideray.compare(tmp_path / "a.png", b.display())
    assert "hdr_flip" not in shown.metrics and shown["flip"] == pytest.approx(other["flip"], abs=0.01)
    with pytest.raises(sideray.InvalidArgument, match=r"\(24, 32, 3\) and \(8, 8, 3\) differ"):
        sideray.compare(a, np.zeros((8, 8, 3)))


def test_statistics_and_times(renderer, square):
    picture = renderer.render(square, (24, 16), repeat=1, shadows="exact")
    assert picture.stats["pixels_total"] == 24 * 16 and picture.stats["rays_shadow"] > 0
    first, median, third = picture.times["total_frame"]
    assert 0 < first <= median <= third
    assert square.facts["triangles"] == 2 and square.facts["lit_lights"] == 1
