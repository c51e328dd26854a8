"""The contract of the package, by the letter: what other programs rely on may grow, not change."""

import inspect
import re

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


def test_load_and_options_of_the_command_line(renderer):
    scene = sideray.load("panes")
    assert isinstance(scene, sideray.Scene)
    picture = sideray.Renderer().render(scene, (64, 36), None, translucency="raytraced", cache_rate="full", layers=4,
                                        shadows="exact", ao=True, second_wave=False, samples=1, seed=3)
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
