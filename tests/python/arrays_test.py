"""Arrays in and out: what is copied, what is not, and what is refused."""

import ctypes
import dataclasses
import gc

import numpy as np
import pytest
from conftest import plain_scene, quad

import sideray


def test_channels_are_the_picture_s_memory_and_keep_it(renderer, square):
    picture = renderer.render(square, (16, 16))
    plane = picture["Z"]
    again = renderer.render(square, (16, 16))["Z"]
    address = plane.__array_interface__["data"][0]
    assert picture.depth.__array_interface__["data"][0] == address
    expected = plane.copy()
    del picture
    gc.collect()
    assert np.array_equal(plane, expected) and np.array_equal(again, expected)


def test_buffer_protocol_and_dlpack(renderer, square):
    plane = renderer.render(square, (16, 8)).depth
    view = memoryview(plane)
    assert view.shape == (8, 16) and view.format == "f" and view.c_contiguous
    assert np.from_dlpack(plane).__array_interface__["data"][0] == plane.__array_interface__["data"][0]
    assert ctypes.c_float.from_buffer(plane).value == plane[0, 0]


def test_rgb_is_the_planes_side_by_side_and_made_once(renderer, square):
    picture = renderer.render(square, (16, 8), aov="N,id")
    for i, name in enumerate("RGB"):
        assert np.array_equal(picture.rgb[..., i], picture[name])
    assert picture.rgb is picture.rgb
    assert np.array_equal(picture["N"][..., 2], picture["N.Z"])
    assert picture["id"].dtype == np.uint32
    assert np.array_equal(np.asarray(picture), picture.rgb)


def test_layers_have_fields_of_their_own_types(renderer):
    picture = renderer.render(sideray.load("panes"), (32, 18), aov="layers")
    layer = picture["layer0"]
    assert layer["surface"].dtype == np.uint32 and layer["distance"].dtype == np.float32
    assert np.array_equal(layer["surface"], picture["layer0.surface"])
    assert np.array_equal(picture["layers"][0], layer)


@pytest.mark.parametrize("dtype", [np.float64, np.float16, np.int32])
def test_positions_of_any_number_type(renderer, dtype):
    positions, triangles = quad()
    scene = sideray.Scene()
    scene.add_mesh(positions.astype(dtype), triangles.astype(np.uint8).tolist())
    assert np.allclose(scene.bounds, ([-1, -1, 0], [1, 1, 0]))


def test_strided_arrays_are_read_as_they_are_indexed():
    wide = np.zeros((8, 6))
    positions, triangles = quad()
    wide[::2, ::2] = positions
    scene = sideray.Scene()
    scene.add_mesh(wide[::2, ::2], triangles)
    assert np.allclose(scene.bounds, ([-1, -1, 0], [1, 1, 0]))


def test_colours_of_vertices_and_texels_reach_the_picture(renderer):
    positions, triangles = quad()
    camera = sideray.Camera.look_at((0, 0, 3), (0, 0, 0))
    scene = sideray.Scene(env=None)
    scene.add_mesh(positions, triangles, colors=np.tile([0.0, 1.0, 0.0], (4, 1)))
    r, g, b = renderer.render(scene, (16, 16), camera).rgb[8, 8]
    assert g > 0.1 and r < 0.2 * g and b < 0.2 * g
    image = np.zeros((2, 2, 3), np.uint8)
    image[0, :, 0] = 255  # the top row is red
    scene = sideray.Scene(env=None)
    texture = scene.add_texture(image)
    uv = [[0, 1], [1, 1], [1, 0], [0, 0]]
    scene.add_mesh(positions, triangles, uv=uv,
                   material={"base_color_texture": {"texture": texture, "filter": "nearest", "wrap_v": "clamp"}})
    picture = renderer.render(scene, (16, 16), camera)
    assert picture.rgb[6, 8, 0] > 5 * picture.rgb[6, 8, 1]
    assert picture.rgb[9, 8, 0] < 0.2 * picture.rgb[6, 8, 0]


@pytest.mark.parametrize("intrinsics", [None, (30.0, 24.0, 13.0, 10.0)])
def test_rays_hit_what_the_camera_sees(renderer, square, intrinsics):
    camera = square.camera
    if intrinsics is not None:
        camera = sideray.Camera.from_intrinsics(camera.world_from_camera, *intrinsics, (32, 24))
    picture = renderer.render(square, (32, 24), camera)
    origins, directions = camera.rays((32, 24))
    hits = square.trace_rays(origins, directions)
    assert hits.shape == (24, 32)
    inside = picture.ids != 0
    assert np.array_equal(hits["surface_id"], picture.ids)
    assert np.allclose(hits["distance"][inside], picture.depth[inside], rtol=1e-5)
    assert np.isinf(hits["distance"][~inside]).all()
    assert np.allclose(hits["normal"][inside], [0, 0, 1])


def test_rays_of_an_orthographic_camera():
    scene = plain_scene()
    camera = sideray.Camera.look_at((0, 0, 3), half_height=1.2)
    origins, directions = camera.rays((24, 24))
    hits = scene.trace_rays(origins, directions)
    assert np.allclose(hits["distance"][12, 12], 3.0) and (hits["surface_id"] == 1).sum() == 400


def test_layers_of_rays_come_in_order():
    scene = sideray.Scene()
    for z in (0.0, 1.0, -1.0):
        scene.add_mesh(*quad(z), material={"base_color": (1, 1, 1, 0.5), "alpha_mode": "blend", "double_sided": True})
    hits = scene.trace_rays((0.1, 0.2, 5.0), (0, 0, -2), layers=4, translucent=True)
    assert hits.shape == (4,)
    assert np.allclose(hits["distance"][:3], [2.0, 2.5, 3.0])
    assert list(hits["surface_id"]) == [2, 1, 3, 0]
    assert not scene.trace_rays((0.1, 0.2, 5.0), (0, 0, -1))["surface_id"]


def test_moving_removing_replacing(renderer):
    scene = sideray.Scene(env=None)
    first = scene.add_mesh(*quad(), name="first")
    camera = sideray.Camera.look_at((0, 0, 6), (0, 0, 0))
    assert renderer.render(scene, (16, 16), camera).depth[8, 8] == pytest.approx(6.0, rel=1e-4)
    moved = np.eye(4)
    moved[2, 3] = 2.0
    first.transform = moved
    assert renderer.render(scene, (16, 16), camera).depth[8, 8] == pytest.approx(4.0, rel=1e-4)
    assert np.array_equal(first.transform, moved)
    second = scene.add_instance(first.mesh)
    assert second.surface_id == 2 and scene.names == {1: "first"}
    scene.move([first, second], np.stack([np.eye(4), moved]))
    assert renderer.render(scene, (16, 16), camera).ids[8, 8] == 2
    second.remove()
    assert renderer.render(scene, (16, 16), camera).ids[8, 8] == 1
    first.material = {"unlit": True, "base_color": (0, 0, 1)}
    assert np.allclose(renderer.render(scene, (16, 16), camera).rgb[8, 8], [0, 0, 1])
    scene.replace_geometry(first.mesh, *quad(z=1.0))
    assert renderer.render(scene, (16, 16), camera).depth[8, 8] == pytest.approx(5.0, rel=1e-4)
    scene.set_vertices(first.mesh, quad(z=3.0)[0])
    assert renderer.render(scene, (16, 16), camera).depth[8, 8] == pytest.approx(3.0, rel=1e-4)


def test_particles_light_and_surroundings(renderer):
    scene = sideray.Scene(env=None, default_light=False)
    camera = sideray.Camera.look_at((0, 0, 3), (0, 0, 0))
    positions, triangles = quad(-1.0, 5.0)
    scene.add_mesh(positions, triangles)
    assert not renderer.render(scene, (16, 16), camera).rgb.any()
    scene.add_light("point", position=(0, 0, 1), intensity=4.0, name="lamp")
    assert renderer.render(scene, (16, 16), camera).rgb[8, 8].min() > 0.1
    assert "shadow.lamp" in renderer.render(scene, (16, 16), camera, aov="shadow", shadows="exact")
    scene.lights = []
    scene.set_environment(np.ones((4, 8, 3)))
    assert renderer.render(scene, (16, 16), camera).rgb[8, 8].min() > 0.1
    scene.set_environment(None)
    smoke = scene.add_particles(blend_mode="additive")
    smoke.set([[0, 0, 0]], sizes=1.0, colors=(0, 2, 0, 1))
    assert np.allclose(renderer.render(scene, (16, 16), camera).rgb[8, 8], [0, 2, 0], atol=0.01)


@pytest.mark.parametrize("broken, message", [
    (lambda s: s.add_mesh([[0, 0]]), r"positions: the array has the shape \(1, 2\); give \(n, 3\)"),
    (lambda s: s.add_mesh(quad()[0], [[0, 1, 9]]), "index 9 is not below vertex_count 4"),
    (lambda s: s.add_mesh(quad()[0], [[0, 1, -1]]), "triangles: numbers from -1"),
    (lambda s: s.add_mesh(quad()[0], [[0, 1, 1.5]]), "whole numbers"),
    (lambda s: s.add_mesh(*quad(), normals=np.zeros((3, 3))), r"normals: .*\(3, 3\); give \(4, 3\)"),
    (lambda s: s.add_mesh(*quad(), transform=np.eye(3)), r"transform: .*\(3, 3\); give \(4, 4\)"),
    (lambda s: s.add_mesh(*quad(), transform=np.full((4, 4), np.nan)), "finite"),
    (lambda s: s.add_mesh(*quad(), surface_id=-1), "surface_id: numbers from -1"),
    (lambda s: s.add_mesh(*quad(), material=99), "material"),
    (lambda s: s.add_material(base_colour=(1, 1, 1)), "there is no base_colour; there are base_color,"),
    (lambda s: s.add_material(roughness="rough"), "roughness: 'rough' is not a number"),
    (lambda s: s.add_material(alpha_mode="glass"), "alpha_mode: unknown value \"glass\"; one of opaque, mask, blend"),
    (lambda s: s.add_texture(np.zeros((2, 2, 5))), "image: the array has the shape"),
    (lambda s: s.add_light("laser"), "unknown value \"laser\"; one of directional, point, spot"),
    (lambda s: s.trace_rays([0, 0], [0, 0]), "origins and directions"),
    (lambda s: s.trace_rays([0, 0, np.nan], [0, 0, 1]), "ray 0"),
    (lambda s: s.get_camera("front"), "camera 'front': no such camera; the scene has 0"),
])
def test_what_is_wrong_is_named(square, broken, message):
    with pytest.raises(sideray.InvalidArgument, match=message):
        broken(square)
    with pytest.raises(ValueError):
        broken(square)


def test_a_failed_call_changes_nothing(renderer, square):
    before = renderer.render(square, (16, 16)).rgb
    with pytest.raises(sideray.Error):
        square.add_mesh(*quad(), material=99)
    assert np.array_equal(renderer.render(square, (16, 16)).rgb, before)


@pytest.mark.parametrize("gl", ["auto", "none"])
@pytest.mark.parametrize("name", ["panes", "smoke"])
def test_intrinsics_choose_the_pixels_of_a_larger_picture(gl, name):
    scene = sideray.load(name)
    pose = scene.get_camera(None, aspect=16 / 9).world_from_camera
    # What is drawn with random numbers has others at other places of a picture.
    options = dict(translucency="raytraced", shadows="off", ambient=False, reflections=False, aov="id,Z")
    if name == "smoke":
        options["translucency"] = "raster"
    with sideray.Renderer(gl=gl) as renderer:

        def draw(size, fx, cx, cy):
            return renderer.render(scene, size, sideray.Camera.from_intrinsics(pose, fx, 100.0, cx, cy, size), **options)

        if gl == "none" and name == "smoke":
            options["translucency"] = "hybrid"
        whole = draw((128, 72), 100.0, 64.0, 36.0)
        part = draw((48, 40), 100.0, 64.0 - 30, 36.0 - 17)
        stretched = draw((384, 72), 300.0, 192.0, 36.0)
    for drawn, pixels in ((part, np.s_[17:57, 30:78]), (stretched.rgb[:, 1::3], np.s_[:, :])):
        rgb = drawn if isinstance(drawn, np.ndarray) else drawn.rgb
        difference = np.abs(rgb - whole.rgb[pixels]).max(-1)
        assert (difference > 0.02).mean() < 0.01  # texels of other levels, and edges that rounding moves
    assert (part.ids != whole.ids[17:57, 30:78]).mean() < 0.002
    assert (stretched.ids[:, 1::3] != whole.ids).mean() < 0.002
    same = part.ids == whole.ids[17:57, 30:78]
    assert np.allclose(part.depth[same], whole.depth[17:57, 30:78][same], rtol=1e-4)


@pytest.mark.parametrize("wrong, name", [
    (dict(fx=0.0), "fx: 0.0"), (dict(fy=np.nan), "fy: nan"), (dict(cx=np.inf), "cx: inf"), (dict(cy=np.nan), "cy: nan"),
    (dict(size=(64, 0)), "size: 0"), (dict(fx=1e6), "fx_per_fy"), (dict(cx=1e6), "shift"),
])
def test_wrong_intrinsics_are_refused_by_name(wrong, name):
    with pytest.raises(sideray.InvalidArgument, match=name):
        sideray.Camera.from_intrinsics(np.eye(4), **{**dict(fx=60.0, fy=60.0, cx=32.0, cy=24.0, size=(64, 48)), **wrong})
    for shift in (3, (1,), ("a", "b"), None):
        with pytest.raises(sideray.InvalidArgument, match="shift"):
            sideray.Camera(shift=shift)


@pytest.mark.parametrize("change", [dict(fx_per_fy=1.3), dict(shift=(0.2, 0.0)), dict(shift=(0.0, -0.2))])
def test_a_view_whose_intrinsics_change_does_not_stand_still(change):
    scene = plain_scene()
    before = scene.camera
    after = dataclasses.replace(before, **change)
    with sideray.Renderer(gl="none") as renderer:
        for frame in range(6):
            renderer.render(scene, (48, 36), before, taa=True, continues=frame > 0)
        followed = renderer.render(scene, (48, 36), after, taa=True, continues=True)
        fresh, old = (renderer.render(scene, (48, 36), camera) for camera in (after, before))
    # Jitter moves its edges by less than a pixel; a mean over both views would be about as far from one as from the other.
    assert np.abs(followed.rgb - fresh.rgb).mean() < np.abs(old.rgb - fresh.rgb).mean() / 3
    assert (followed.ids != fresh.ids).mean() < (old.ids != fresh.ids).mean() / 3


def test_a_backdrop_is_the_same_for_any_number_of_threads():
    """MuJoCo's sky behind a picture, whose rows the threads share."""
    from sideray import _native

    random = np.random.default_rng(5)
    planes = [random.random((300, 410), np.float32) for _ in range(4)]
    faces = random.integers(0, 256, (6, 8, 8, 3), np.uint8)
    corner, across, down = np.array([-1.0, 0.8, -1.0]), np.array([2 / 410, 0.1 / 410, 0.0]), np.array([0.0, -1.6 / 300, 0.0])

    def drawn(threads, faces=faces, as_bytes=False):
        return _native.with_backdrop(planes, (np.array([0.1, 0.2, 0.3]), faces, 0.5, False), (corner, across, down), threads,
                                     None, as_bytes)

    one = drawn(1)
    for threads in (2, 3, 7):
        assert np.array_equal(one, drawn(threads))
    without_sky = drawn(3, faces=None)
    rgb = np.stack(planes[:3], -1) + (1 - planes[3])[..., None] * np.array([0.1, 0.2, 0.3], np.float32)
    assert np.allclose(without_sky, rgb, atol=1e-6)
    assert np.array_equal(drawn(2, as_bytes=True), (np.clip(one, 0, 1) * np.float32(255) + np.float32(0.5)).astype(np.uint8))


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_haze_is_two_strips_seen_in_perspective(share):
    """Against rays that meet the strips, (distance, height) of their edges: nothing, all, nothing of the colour."""
    from sideray import _native

    height, end, width, rows = 2.0, 40.0, 5, 400
    edges = np.array([[(1 - share) * (1 + share) * end, -(1 + share) * height], [end, -height], [(1 + share) * end, 0.0]])
    falls = 0.02 - 0.25 * np.arange(rows) / rows  # of each row, for a step of 1 along the plane
    expected = np.zeros(rows)
    for first, last in ((edges[0], edges[1]), (edges[2], edges[1])):
        for row, fall in enumerate(falls):
            # Where first + s (last - first) lies on the ray (t, t fall).
            s = (first[1] - fall * first[0]) / ((first[1] - last[1]) - fall * (first[0] - last[0]))
            if 0 <= s <= 1:
                expected[row] = s
    planes = [np.full((rows, width), value, np.float32) for value in (0.0, 1.0, 0.0, 1.0)]  # green, and nothing behind it
    surfaces = np.zeros((rows, width), np.uint32)
    surfaces[:] = [0, 1, 2, 2, 7]
    haze = {"surfaces": surfaces, "is_endless": np.array([1, 0, 1], np.uint8), "color": np.array([1.0, 0, 0]),
            "up": np.array([0.0, 0, 1]), "height": height, "end": end, "share": share}
    faces = np.full((6, 4, 4, 3), [0, 0, 255], np.uint8)
    directions = np.array([0.0, 1.0, falls[0]]), np.zeros(3), np.array([0.0, 0.0, falls[1] - falls[0]])
    drawn = _native.with_backdrop(planes, (np.zeros(3), faces, 1.0, False), directions, 1, haze, False)
    assert np.array_equal(drawn[:, 1], np.tile(np.float32([0, 1, 0]), (rows, 1))) and np.array_equal(drawn[:, 4], drawn[:, 1])
    assert np.allclose(drawn[:, 2, 0], expected, atol=2e-3) and np.array_equal(drawn[:, 2], drawn[:, 3])
    beyond = falls > -height / end  # of which the plane shows nothing, but the sky
    assert np.allclose(drawn[beyond, 2, 1], 0) and np.allclose(drawn[beyond, 2, 2], 1 - expected[beyond], atol=2e-3)
    assert np.allclose(drawn[~beyond, 2, 1], 1 - expected[~beyond], atol=2e-3)
    assert np.allclose(drawn[:, 0, 0], expected, atol=2e-3)


def test_times_are_there_without_repeats(renderer):
    times = renderer.render(sideray.load("panes"), (32, 18)).times
    assert times["trace"][1] > 0 and times["total_frame"][1] >= times["trace"][1]


def test_first_surfaces_do_not_depend_on_the_number_of_samples(renderer):
    """They are those at the pixels' centres, though a picture of several samples is drawn from places beside them."""
    scene = sideray.load("solids")
    one, four = (renderer.render(scene, (32, 18), samples=samples, aov="first") for samples in (1, 4))
    assert np.array_equal(one["first"]["Z"], four["first"]["Z"])
    assert np.array_equal(one["first"]["surface"], four["first"]["surface"])
