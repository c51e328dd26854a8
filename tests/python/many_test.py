"""Many pictures in one call: each has the bits that it has alone, the scene is brought up to date once, and nothing grows."""

import os

import numpy as np
import pytest

import sideray

SIZE = (48, 36)


def around(scene, count):
    """Cameras on a circle around the first one's target."""
    first = scene.get_camera(None, aspect=SIZE[0] / SIZE[1])
    cameras = []
    for i in range(count):
        a = 0.05 * i
        turn = np.array([[np.cos(a), 0, np.sin(a), 0], [0, 1, 0, 0], [-np.sin(a), 0, np.cos(a), 0], [0, 0, 0, 1]])
        cameras.append(sideray.Camera(turn @ first.world_from_camera, first.yfov + 0.01 * i, first.z_near))
    return cameras


def same(one, other):
    assert one.channels == other.channels
    for name in one.channels:
        assert np.array_equal(one[name], other[name], equal_nan=True), name


@pytest.mark.parametrize("gl", ["auto", "none"])
@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("options", [{}, {"shadows": "exact", "ambient": "ao", "reflections": True, "aov": "N,first,shadow"},
                                     {"samples": 3, "translucency": "raytraced"}], ids=["defaults", "masks", "samples"])
def test_each_picture_is_the_one_it_is_alone(gl, threads, options):
    scene = sideray.load("panes")
    cameras = around(scene, 7)
    with sideray.Renderer(gl=gl, threads=threads) as renderer, sideray.Renderer(gl=gl, threads=threads) as alone:
        expected = [alone.render(scene, SIZE, camera, **options) for camera in cameras]
        for _ in range(2):
            pictures = renderer.render_many(scene, cameras, SIZE, **options)
            assert len(pictures) == 7
            for picture, other in zip(pictures, expected):
                same(picture, other)


@pytest.mark.parametrize("scene", ["smoke", "forest"])
def test_what_each_view_hits_otherwise(scene):
    """Sprites face each camera, and plants are posed: pictures are drawn one after the other."""
    scene = sideray.load(scene)
    cameras = around(scene, 4)
    options = {"ambient": False, "shadows": "exact", "poses": "all"}
    with sideray.Renderer(gl="none", threads=2) as renderer, sideray.Renderer(gl="none") as alone:
        for picture, camera in zip(renderer.render_many(scene, cameras, SIZE, **options), cameras):
            same(picture, alone.render(scene, SIZE, camera, **options))


def boxes():
    scene = sideray.Scene(env=None)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7],
             [1, 7, 3]]
    scene.add_mesh(corners * [4, 0.1, 4], faces, name="floor")
    return scene, [scene.add_mesh(0.3 * corners, faces, material={"base_color": (1, 0.5, k / 3, 1)}) for k in range(3)]


def poses_of(count, seed=1):
    random = np.random.default_rng(seed)
    poses = np.zeros((count, 3, 3, 4))
    poses[..., :3] = np.eye(3)
    poses[..., 3] = random.uniform(-1, 1, (count, 3, 3)) + [0, 1, 0]
    return poses


def test_poses():
    scene, objects = boxes()
    camera = sideray.Camera.look_at((0, 3, 6), (0, 0.5, 0))
    poses = poses_of(5)
    poses[3] = poses[2]
    with sideray.Renderer(gl="none") as renderer:
        pictures = renderer.render_many(scene, [camera] * 5, SIZE, objects=objects, transforms=poses)
        # A scene is built once, and moved once for each pose.
        assert [picture.times["build"][1] > 0 for picture in pictures] == [True] + 4 * [False]
        assert np.array_equal(objects[1].transform[:3], poses[4, 1])
        for picture, placed in zip(pictures, poses):
            scene.move(objects, placed)
            same(picture, renderer.render(scene, SIZE, camera))
        assert not np.array_equal(pictures[0].ids, pictures[1].ids) and np.array_equal(pictures[2].ids, pictures[3].ids)
        full = np.concatenate([poses, np.broadcast_to([0, 0, 0, 1.0], (5, 3, 1, 4))], 2)
        same(renderer.render_many(scene, [camera] * 5, SIZE, objects=objects, transforms=full)[1], pictures[1])
    for wrong in (poses[:, :2], poses[0], np.full_like(poses, np.nan)):
        with pytest.raises(sideray.InvalidArgument, match="transforms"):
            renderer.render_many(scene, [camera] * 5, SIZE, objects=objects, transforms=wrong)


def test_arrays_of_all_pictures():
    scene = sideray.load("panes")
    cameras = around(scene, 3)
    with sideray.Renderer(gl="none") as renderer:
        rgb, depth = np.empty((3, SIZE[1], SIZE[0], 3), np.float32), np.empty((3, SIZE[1], SIZE[0]), np.float32)
        pictures = renderer.render_many(scene, cameras, SIZE, aov="N", out={"rgb": rgb, "Z": depth})
        assert pictures.rgb is rgb and pictures.depth is depth
        for name, value in (("rgb", rgb), ("Z", depth), ("id.surface", pictures.ids), ("N", pictures["N"])):
            for i, picture in enumerate(pictures):
                assert np.array_equal(value[i], picture.rgb if name == "rgb" else picture[name])
        assert pictures.ids.dtype == np.uint32 and pictures.display().shape == (3, SIZE[1], SIZE[0], 3)
        assert len(pictures[1:]) == 2 and pictures[-1].size == SIZE and "3 of 48x36" in repr(pictures)
        for wrong in (np.empty((2, SIZE[1], SIZE[0], 3), np.float32), np.empty((3, SIZE[1], SIZE[0], 3)), [1]):
            with pytest.raises(sideray.InvalidArgument, match=r'out\["rgb"\]: give a numpy array of float32 with the shape'):
                renderer.render_many(scene, cameras, SIZE, out={"rgb": wrong})
        with pytest.raises(sideray.UnknownChannel, match="albedo"):
            pictures["albedo"]
        assert len(renderer.render_many(scene, [], SIZE)) == 0
        with pytest.raises(sideray.Error, match="budgets"):
            renderer.render_many(scene, cameras, SIZE, budget=5)


@pytest.mark.parametrize("gl", ["auto", "none"])
def test_without_colour(gl):
    scene = sideray.load("panes")
    with sideray.Renderer(gl=gl) as renderer:
        whole = renderer.render(scene, SIZE, aov="N,first")
        bare = renderer.render(scene, SIZE, aov="N,first", color=False)
        assert set(whole.channels) - set(bare.channels) == set("RGBA")
        for name in bare.channels:
            assert np.array_equal(whole[name], bare[name], equal_nan=True), name
        with pytest.raises(sideray.UnknownChannel, match="without colours"):
            bare.rgb
        with pytest.raises(sideray.UnknownChannel, match="without colours"):
            renderer.render_many(scene, [None, None], SIZE, color=False).rgb
        with pytest.raises(sideray.Error, match="without_color"):
            renderer.render(scene, SIZE, reference=True, color=False)
        masks = renderer.render(scene, SIZE, aov="shadow", shadows="exact", color=False)
        lit = renderer.render(scene, SIZE, aov="shadow", shadows="exact")
        shadows = [name for name in lit.channels if name.startswith("shadow.")]
        assert shadows
        for name in shadows:
            assert np.array_equal(masks[name], lit[name])


def test_thousands_do_not_grow():
    from threads_test import growth

    scene, objects = boxes()
    camera = sideray.Camera.look_at((0, 3, 6), (0, 0.5, 0))
    poses = poses_of(10)
    with sideray.Renderer(gl="none") as renderer:

        def ten():
            assert renderer.render_many(scene, [camera] * 10, (32, 24), objects=objects, transforms=poses).rgb.any()

        assert growth(1000 if "SIDERAY_SLOW" in os.environ else 40, ten) < 8 << 20


@pytest.mark.parametrize("gl", ["none", "auto"])
def test_scenes_in_turn_are_built_once(gl):
    scenes = [sideray.load("panes"), boxes()[0]]
    with sideray.Renderer(gl=gl) as renderer, sideray.Renderer(gl=gl) as alone:
        first = [renderer.render(scene, SIZE) for scene in scenes]
        again = [renderer.render(scene, SIZE) for scene in scenes]
        assert first[0].times["build"][1] > 0
        assert not any(picture.times["build"][1] > 0 for picture in again)
        for one, other, scene in zip(first, again, scenes):
            same(one, other)
            same(one, alone.render(scene, SIZE))
            # What stands still is not traced again, whatever was drawn in between.
            rays = {name: value for name, value in alone.render(scene, SIZE).stats.items() if name.startswith("rays_")}
            assert {name: other.stats[name] for name in rays} == rays


@pytest.mark.parametrize("gl", ["none", "auto"])
def test_scenes_that_are_gone_are_forgotten(gl):
    from threads_test import growth

    with sideray.Renderer(gl=gl) as renderer:

        def another():
            scene = sideray.Scene(env=None)
            scene.add_mesh(np.random.default_rng(1).random((30000, 3)))
            assert renderer.render(scene, (32, 24)).depth.shape == (24, 32)

        assert growth(60, another) < 8 << 20
