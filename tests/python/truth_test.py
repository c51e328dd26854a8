"""Ground truth: channels by name, and masks of objects."""

import numpy as np
import pytest
from conftest import quad

import sideray


def scene_of_two():
    """A large opaque square, and a small pane before it; both face the camera."""
    scene = sideray.Scene(env=None)
    positions, triangles = quad(0.0, 5.0)
    scene.add_mesh(positions, triangles, name="wall")
    positions, triangles = quad(1.0, 0.5)
    scene.add_mesh(positions, triangles, material={"alpha_mode": "blend", "base_color": (1, 1, 1, 0.5)}, name="pane")
    scene.camera = sideray.Camera.look_at((0, 0, 3), (0, 0, 0))
    return scene


def test_channels_have_their_names(renderer):
    picture = renderer.render(scene_of_two(), (32, 24), aov="first,glass,behind,refraction")
    glass = picture["glass.surface"] == 2
    assert 50 < glass.sum() < 500
    assert np.array_equal(picture["first.surface"], np.where(glass, 2, 1))
    assert np.allclose(picture["glass.Z"][glass], 2) and np.isinf(picture["glass.Z"][~glass]).all()
    assert picture["glass.N"].shape == (24, 32, 3) and np.allclose(picture["glass.N"][glass], (0, 0, 1))
    assert (picture["behind.surface"] == 1).all() and np.allclose(picture["behind.Z"], 3)
    x, y = np.meshgrid(np.arange(32) + 0.5, np.arange(24) + 0.5)
    assert np.array_equal(picture["refraction.X"], x) and np.array_equal(picture["refraction.Y"], y)
    assert (picture["refraction.state"] == 1).all()


def test_masks_are_those_of_the_channels(renderer):
    scene = scene_of_two()
    first = renderer.render(scene, (32, 24), aov="first")["first.surface"]
    wall, pane = scene.object_truth((32, 24))
    assert (wall.object, pane.object) == (1, 2)
    assert np.array_equal(wall.visible.pixels, first == 1) and np.array_equal(pane.visible.pixels, first == 2)
    assert wall.amodal.pixels.all() and wall.amodal.area == 32 * 24 and wall.amodal.box == (0, 0, 32, 24)
    rows, columns = np.nonzero(first == 2)
    assert pane.visible.box == (columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1)
    assert pane.visible_fraction == 1 and wall.visible_fraction == pytest.approx(1 - pane.coverage / (32 * 24))
    assert sum(pane.visible.coco["counts"]) == 32 * 24 and pane.visible.coco["size"] == [24, 32]


def test_objects_are_what_the_caller_says():
    scene = scene_of_two()
    (both,) = scene.object_truth((32, 24), objects={9: [1, 2]})
    assert both.object == 9 and both.visible.area == 32 * 24
    wall, _ = scene.object_truth((32, 24), through_glass=True, samples_per_side=1)
    assert wall.visible.pixels.all() and wall.visible_fraction == 1


def test_wrong_objects_are_refused():
    scene = scene_of_two()
    with pytest.raises(sideray.InvalidArgument, match="surface id 5"):
        scene.object_truth((8, 8), objects={1: [5]})
    with pytest.raises(sideray.InvalidArgument, match="named twice"):
        scene.object_truth((8, 8), objects={1: [2], 2: [2]})
    with pytest.raises(sideray.InvalidArgument, match="samples_per_side"):
        scene.object_truth((8, 8), samples_per_side=0)
    with pytest.raises(sideray.InvalidArgument, match="2\\^32"):
        scene.object_truth((8, 8), objects={1: [-2]})


def test_channels_change_no_other_in_a_sequence():
    """Rays of the truth meet swaying plants; those of the frame, and what is kept of it, do not notice."""
    drawn = []
    for aov in ("", "first,behind"):
        with sideray.Renderer() as own:
            frames = own.frames(sideray.load("forest?count=20"), range(3), (48, 27), aov=aov, shadows="exact",
                                poses="rest")
            drawn.append([picture.rgb.copy() for picture in frames])
    assert np.array_equal(*drawn)
