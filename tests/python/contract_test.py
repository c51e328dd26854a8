"""The contract of the package, by the letter: what other programs rely on may grow, not change."""

import inspect
import os
import pickle
import re
import signal

import numpy as np
import pytest
from conftest import quad

import sideray


def test_version_is_that_of_the_library():
    assert re.fullmatch(r"\d+\.\d+\.\d+", sideray.__version__)


def test_scene_from_arrays_by_the_contract_s_keywords(renderer):
    scene = sideray.Scene()
    positions, triangles = quad()
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    uv = np.array([[0, 1], [1, 1], [1, 0], [0, 0]])
    scene.add_mesh(positions=positions, triangles=triangles, normals=normals, uv=uv)
    picture = sideray.Renderer().render(scene, size=(64, 48), camera=None)
    assert picture.rgb.shape == (48, 64, 3) and picture.rgb.dtype == np.float32
    assert picture.depth.shape == (48, 64) and picture.depth.dtype == np.float32
    assert picture.ids.shape == (48, 64) and picture.ids.dtype == np.uint32
    shown = picture.ids != 0
    assert 0 < shown.sum() < shown.size
    assert np.array_equal(np.isfinite(picture.depth), shown)
    assert picture.rgb[shown].min() > 0, "it is lit without a light of its own"


def test_what_is_no_number_is_refused():
    positions, triangles = quad()
    for bad in (np.nan, np.inf):
        broken = positions.copy()
        broken[1, 2] = bad
        with pytest.raises(sideray.InvalidArgument, match="positions: 1 of 12 numbers are not finite"):
            sideray.Scene().add_mesh(broken, triangles)
        normals = np.tile([0.0, 0.0, 1.0], (4, 1))
        normals[3] = bad
        with pytest.raises(sideray.InvalidArgument, match="normals: 3 of 12"):
            sideray.Scene().add_mesh(positions, triangles, normals)
        with pytest.raises(sideray.InvalidArgument, match="eye"):
            sideray.Camera.look_at((bad, 0, 3))
        with pytest.raises(sideray.InvalidArgument, match="world_from_camera"):
            sideray.Camera(np.full((4, 4), bad))


def test_words_are_no_colours():
    for value in ("#ff0000", b"red", {"r": 1}):
        with pytest.raises(sideray.InvalidArgument, match="base_color: .* are not 4 numbers"):
            sideray.Scene().add_material(base_color=value)


def test_cameras_that_cannot_be_are_refused():
    for fov in (0.0, 180.0, 200.0, -30.0):
        with pytest.raises(sideray.InvalidArgument, match="degrees; give more than 0 and less than 180"):
            sideray.Camera.look_at((0, 0, 3), fov=fov)
    with pytest.raises(sideray.InvalidArgument, match="up: has no length"):
        sideray.Camera.look_at((0, 0, 3), up=(0, 0, 0))


@pytest.mark.parametrize("axis", np.vstack([np.eye(3), -np.eye(3)]).tolist())
def test_up_may_be_along_the_view(axis):
    world = sideray.Camera.look_at(3 * np.array(axis), up=axis).world_from_camera
    assert np.allclose(world[:3, :3].T @ world[:3, :3], np.eye(3)) and np.linalg.det(world[:3, :3]) > 0
    assert np.allclose(world[:3, 2], axis)


def test_pictures_of_other_kinds_are_refused(renderer, tmp_path):
    picture = renderer.render(sideray.load("panes"), (16, 9))
    for name in ("x.jpg", "x.npy", "x"):
        with pytest.raises(sideray.InvalidArgument, match="written as .png or .exr"):
            picture.save(tmp_path / name)
        assert not (tmp_path / name).exists()
    picture.save(tmp_path / "x.PNG")
    assert (tmp_path / "x.PNG").read_bytes()[:4] == b"\x89PNG"


def test_names_in_bytes_are_written_as_text(renderer):
    with pytest.raises(sideray.SceneNotFound, match="^cannot read nothing.glb:"):
        sideray.load(b"nothing.glb")
    with pytest.raises(sideray.InvalidArgument, match="^x.jpg:"):
        renderer.render(sideray.load("panes"), (16, 9)).save(b"x.jpg")


def test_pictures_go_to_other_processes(renderer):
    picture = renderer.render(sideray.load("panes"), (16, 9), aov="N")
    there = pickle.loads(pickle.dumps(picture))
    assert there.channels == picture.channels and there.size == (16, 9)
    assert there.stats == picture.stats and there.times == picture.times
    assert np.array_equal(there.rgb, picture.rgb) and np.array_equal(there["N"], picture["N"])
    assert np.array_equal(there.display(), picture.display())


def in_child(work):
    """What work() returns in a forked child, as text; an exception is its text."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        try:
            said = work()
        except Exception as error:  # noqa: BLE001
            said = str(error)
        os.write(writer, said.encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as stream:
        said = stream.read()
    assert os.waitpid(child, 0)[1] == 0, "the child hangs"
    return said


def test_a_forked_child_is_told_to_spawn(renderer):
    scene = sideray.load("panes")
    renderer.render(scene, (16, 9))
    if renderer.device["gl"] == "none":
        pytest.skip("no OpenGL here")
    assert "spawn" in in_child(lambda: repr(renderer.render(scene, (16, 9))))
    assert "spawn" in in_child(lambda: repr(sideray.Renderer()))


def test_rays_alone_draw_in_a_forked_child():
    scene, renderer = sideray.load("panes"), sideray.Renderer(gl="none")
    drawn = renderer.render(scene, (16, 9)).rgb
    assert in_child(lambda: str(np.array_equal(renderer.render(scene, (16, 9)).rgb, drawn))) == "True"
    assert in_child(lambda: str(np.array_equal(sideray.Renderer(gl="none").render(scene, (16, 9)).rgb, drawn))) == "True"


def test_scenes_say_what_they_hold():
    scene = sideray.load("panes", time=1.5)
    assert re.fullmatch(rf"<sideray.Scene: {len(scene.names)} named objects, \d+ lights, {len(scene.cameras)} cameras, \d+ "
                        r"animations, at 1.5 s>", repr(scene))


def test_load_and_options_of_the_command_line(renderer):
    scene = sideray.load("panes")
    assert isinstance(scene, sideray.Scene)
    picture = sideray.Renderer().render(scene, (64, 36), None, translucency="raytraced", cache_rate="full", layers=4,
                                        shadows="exact", ambient="ao", second_wave=False, samples=1, seed=3)
    assert isinstance(picture, sideray.Picture) and picture.rgb.shape == (36, 64, 3)


def test_signatures_are_the_contract_s():
    assert list(inspect.signature(sideray.load).parameters)[0] == "path"
    mesh = list(inspect.signature(sideray.Scene.add_mesh).parameters)
    assert mesh[1:5] == ["positions", "triangles", "normals", "uv"]
    render = inspect.signature(sideray.Renderer.render).parameters
    assert list(render)[1:4] == ["scene", "size", "camera"] and render["camera"].default is None
    assert list(render.values())[-1].kind is inspect.Parameter.VAR_KEYWORD


def test_every_option_of_the_library_is_a_keyword(renderer, square):
    for name in sideray.option_names():
        row = sideray.option(name)
        if name in ("ray_traced", "reference", "check"):
            continue
        others = {"translucency": "reference"} if name == "light_samples" else {}
        if row["default"]:
            renderer.render(square, (8, 8), **{name: row["default"]}, **others)
    assert len(sideray.option_names()) > 30


@pytest.mark.parametrize("name", ["Z", "N", "albedo", "material", "id", "mask", "motion", "shadow", "hitdist", "layer0",
                                  "layers"])
def test_every_additional_output_is_there_by_its_name(renderer, name):
    picture = renderer.render(sideray.load("panes"), (32, 18), aov=name, shadows="exact")
    assert picture[name].shape[-2:] == (18, 32) or picture[name].shape[:2] == (18, 32)
    assert name in picture


def test_all_outputs_at_once_and_each_channel_alone(renderer):
    picture = renderer.render(sideray.load("panes"), (32, 18), aov="all", shadows="exact")
    assert {"R", "G", "B", "A", "Z", "N.X", "albedo.G", "id.primitive", "layer0.surface"} <= set(picture.channels)
    for name in picture:
        assert picture[name].shape == (18, 32) and picture[name].dtype in (np.float32, np.uint32)


def test_error_is_an_exception_with_the_library_s_message(renderer, square):
    with pytest.raises(sideray.Error, match="layers: 99 is out of range"):
        renderer.render(square, size=(8, 8), layers=99)
    assert issubclass(sideray.Error, Exception)


def test_top_row_comes_first(renderer):
    scene = sideray.Scene(env=None)
    positions, triangles = quad(half=0.2)
    scene.add_mesh(positions + [0, 1, 0], triangles)
    picture = renderer.render(scene, (32, 32), sideray.Camera.look_at((0, 0, 4), (0, 0, 0)))
    rows = np.nonzero(picture.ids.any(axis=1))[0]
    assert rows.max() < 16
