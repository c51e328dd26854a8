"""Options by name, devices, and errors as Python's own exceptions."""

import pytest
from conftest import quad

import sideray


def test_values_of_python_are_values_of_the_command_line(renderer, square):
    square.set_environment("sky")
    positions, triangles = quad(z=-0.2, half=2.0)
    # Grey, since what hides the surroundings of white surfaces throws as much back.
    square.add_mesh(positions, triangles, material={"base_color": (0.3, 0.3, 0.3, 1)})

    def drawn(**options):
        return renderer.render(square, (16, 16), **options).rgb.tobytes()

    assert drawn(shadows="exact", ambient="ao", layers=2, cull_angle=0.5, seed=3) == \
        drawn(shadows="exact", ambient="ao", layers="2", cull_angle="0.5", seed="3")
    assert drawn(ambient=None) == drawn() == drawn(ambient="auto") == drawn(ambient="bounce") and drawn(ambient=False) != drawn()
    assert square.facts["auto_ao"] and not square.facts["auto_reflections"]
    assert drawn(reference=True, light_samples=2.0) == drawn(reference="true", light_samples="2")


@pytest.mark.parametrize("options, message", [
    ({"layer": 2}, "layer: no such option; did you mean layers"),
    ({"gl": "egl"}, "use sideray.Renderer\\(gl=...\\)"),
    ({"shadows": "soft"}, "shadows"),
    ({"ambient": 2}, "ambient"),
    ({"samples": 2.5}, "samples: \"2.5\" is not a whole number"),
    ({"reference": True, "layers": 2}, "reference: contradicts 'layers'"),
    ({"aov": "depth"}, "^aov: unknown name \"depth\"; there are Z, N"),
    ({"aov": "layers", "translucency": "raster"}, "use translucency hybrid"),
    ({"size": (0, 1)}, "size: 0 is out of range"),
    ({"size": 64}, "size: 64 is not \\(width, height\\)"),
    ({"tonemap": "filmic", "size": (8, 8)}, "tonemap: unknown value"),
    ({"ray_traced": "none"}, "this scene is made of arrays"),
    ({"eye": (0, 0, 1)}, "give both"),
    ({"camera": "front"}, "no such camera"),
])
def test_wrong_options_are_named(renderer, square, options, message):
    with pytest.raises(sideray.InvalidArgument, match=message):
        renderer.render(square, **{"size": (8, 8), **options}).display()


def test_a_scene_is_a_scene(renderer):
    with pytest.raises(TypeError, match="str is not a sideray.Scene; make one with sideray.load"):
        renderer.render("panes")


def test_channels_that_were_not_asked_for(renderer, square):
    picture = renderer.render(square, (8, 8))
    assert "N" not in picture
    with pytest.raises(KeyError) as caught:
        picture["N"]
    assert str(caught.value).startswith("N: the picture has no such channel; it has Z,")
    assert "aov=\"N\"" in str(caught.value)


def test_quality_is_a_set_of_values(renderer):
    panes = sideray.load("panes")
    drawn = [renderer.render(panes, (32, 18), quality=quality, **given).rgb
             for quality, given in ((None, {}), ("balanced", {}), ("draft", {}), ("draft", {"layers": 4, "shadows": "inexact"}),
                                    ("best", {}))]
    assert (drawn[0] == drawn[1]).all()
    for other in drawn[2:]:
        assert not (drawn[0] == other).all()
    same = renderer.render(panes, (32, 18), layers=2, refraction=False, shadows="map", poses="rest", reflections=False,
                           ambient=False).rgb
    assert (drawn[2] == same).all()
    assert (drawn[4] == renderer.render(panes, (32, 18), layers=8, ray_reuse=0, ray_traced="all").rgb).all()
    with pytest.raises(sideray.Error, match="draft, balanced, best"):
        renderer.render(panes, (32, 18), quality="good")
    with pytest.raises(sideray.Error, match="contradicts 'quality'"):
        renderer.render(panes, (32, 18), quality="best", reference=True)


def test_options_describe_themselves():
    row = sideray.option("cache_rate")
    assert row["default"] == "full" and "quarter" in row["choices"] and row["help"]
    assert "layers" in sideray.option_names() and "size" not in sideray.option_names()
    with pytest.raises(sideray.Error, match="did you mean cache_rate"):
        sideray.option("cache_rates")


def test_names_of_earlier_versions_are_read_as_what_they_are_now(renderer):
    panes = sideray.load("panes")
    now = renderer.render(panes, (32, 18), cache_rate="full").rgb
    with pytest.warns(DeprecationWarning, match="cache_rate temporal4 is full since 0.3") as caught:
        assert (renderer.render(panes, (32, 18), cache_rate="temporal4").rgb == now).all()
    assert caught[0].filename == __file__
    with pytest.warns(DeprecationWarning, match="shading_reuse has no effect since 0.3"):
        assert (renderer.render(panes, (32, 18), shading_reuse=0.5).rgb == now).all()
    assert "shading_reuse" not in sideray.option_names() and "temporal4" not in sideray.option("cache_rate")["choices"]


def test_devices_and_what_is_closed(square):
    assert any(device["usable"] for device in sideray.devices())
    with pytest.raises(sideray.Error, match="device"):
        sideray.Renderer(device="egl:nowhere")
    with sideray.Renderer() as made:
        picture = made.render(square, (8, 8))
        assert made.device["gl"] in ("egl", "osmesa")
    with pytest.raises(sideray.Error, match="the renderer is closed"):
        made.render(square, (8, 8))
    made.close()
    assert picture.depth.max() > 0


def test_statuses_are_classes():
    from sideray import _errors

    for status, builtin in ((-1, ValueError), (-2, MemoryError), (-3, NotImplementedError), (-4, RuntimeError)):
        error = _errors.of_status(status, "text")
        assert isinstance(error, (sideray.Error, builtin)) and isinstance(error, builtin)
        assert error.status == status and str(error) == "text"
    assert type(_errors.of_status(-7, "text")) is sideray.Error


def test_the_raster_look_and_layers_without_opengl():
    scene, size = sideray.load("solids"), (64, 36)
    with sideray.Renderer(gl="none") as renderer:
        raster = renderer.render(scene, size, translucency="raster").rgb.tobytes()
        hybrid = renderer.render(scene, size, layers=2, aov="layers")
        assert raster == renderer.render(scene, size, layers=0).rgb.tobytes() != hybrid.rgb.tobytes()
        assert {"layer0.surface", "layer1.surface"} <= set(hybrid.channels)
        assert hybrid["layer0.surface"].max() > 0
