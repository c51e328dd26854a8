"""sideray.mujoco beside mujoco's own Renderer: shapes, types, ids, depth and what is where. Skipped where there is no mujoco."""

import os

os.environ.setdefault("MUJOCO_GL", "egl")

import numpy as np
import pytest

import sideray

mujoco = pytest.importorskip("mujoco", "3.0", reason="the package mujoco is not installed: pip install mujoco")
sideray_mujoco = pytest.importorskip("sideray.mujoco")

HEIGHT, WIDTH = 120, 160

ASSETS = """
<asset>
  <texture name="sky" type="skybox" builtin="gradient" rgb1=".3 .5 .8" rgb2="1 1 1" width="32" height="192"/>
  <texture name="checker" type="2d" builtin="checker" rgb1="1 .2 .2" rgb2=".2 .2 1" width="64" height="64"/>
  <texture name="dice" type="cube" builtin="checker" mark="edge" rgb1=".8 .2 .2" rgb2=".2 .8 .2" markrgb="1 1 1" width="32"
           height="192"/>
  <material name="checker" texture="checker" texrepeat="3 2" specular="0"/>
  <material name="even" texture="checker" texrepeat="3 2" texuniform="true" specular="0"/>
  <material name="dice" texture="dice" specular="0"/>
  <material name="dice even" texture="dice" texuniform="true" specular="0"/>
  <material name="glass" rgba="1 1 1 .3"/>
  <mesh name="wedge" vertex="0 0 0  .4 0 0  0 .4 0  0 0 .4  .3 .3 .3"/>
  <hfield name="hills" nrow="9" ncol="12" size=".5 .4 .2 .1"/>
</asset>"""

SHAPES = """
<geom type="box" size=".2 .1 .3" pos="-1 0 .3" material="{0}"/>
<geom type="sphere" size=".2" pos="-.5 0 .2" material="{0}"/>
<geom type="capsule" size=".1 .2" pos="0 0 .3" euler="20 30 0" material="{0}"/>
<geom type="cylinder" size=".15 .2" pos=".4 0 .2" material="{0}"/>
<geom type="ellipsoid" size=".1 .2 .3" pos=".8 0 .3" material="{0}"/>
<geom type="mesh" mesh="wedge" pos="1.1 0 .2" material="{0}"/>
<geom type="plane" size=".6 .4 .1" pos="-.6 -1 0" material="{0}"/>
<geom type="hfield" hfield="hills" pos=".6 -1 .1" material="{0}"/>"""

MOVING = """
<geom type="plane" size="0 0 .1"/>
<body name="arm" pos="0 0 .5"><joint axis="0 1 0"/><geom type="capsule" size=".05" fromto="0 0 0 .4 0 0"/>
  <site name="end" pos=".4 0 0" size=".09"/></body>
<flexcomp type="grid" count="5 5 1" spacing=".1 .1 .1" pos="-.5 0 .4" radius=".01" name="cloth" dim="2" mass="1">
  <contact selfcollide="none"/></flexcomp>
<body name="ball" pos=".3 .4 .1"><freejoint/><geom type="sphere" size=".1" rgba="1 0 0 .5"/></body>"""


def model_of(world, head=""):
    light = '<headlight ambient=".5 .5 .5" diffuse=".4 .4 .4" specular="0 0 0"/>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><statistic center='0 0 .2' extent='2'/><visual>{light}<map znear='.01'/>{head}</visual>{ASSETS}"
        f"<worldbody>{world}</worldbody></mujoco>")
    model.hfield_data[:] = np.random.default_rng(1).random(model.hfield_data.shape)
    return model


def data_of(model, steps=0):
    data = mujoco.MjData(model)
    for _ in range(steps):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return data


def view(model, azimuth=70.0, elevation=-30.0, distance=3.0):
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    camera.azimuth, camera.elevation, camera.distance = azimuth, elevation, distance
    return camera


def pictures(renderer, data, camera=-1, option=None):
    """Colour, depth and segmentation."""
    renderer.update_scene(data, camera, option)
    color = renderer.render()
    renderer.enable_depth_rendering()
    depth = renderer.render()
    renderer.enable_segmentation_rendering()
    segmentation = renderer.render()
    renderer.disable_segmentation_rendering()
    return color, depth, segmentation


@pytest.fixture(scope="module")
def has_own_renderer():
    try:
        mujoco.Renderer(model_of(""), 8, 8).close()
    except Exception as error:
        pytest.skip(f"mujoco draws nothing here to compare with (MUJOCO_GL={os.environ['MUJOCO_GL']}): {error}")


def both(model, data, camera=-1, option=None, **options):
    theirs = mujoco.Renderer(model, HEIGHT, WIDTH)
    expected = pictures(theirs, data, camera, option)
    theirs.close()
    with sideray_mujoco.Renderer(model, HEIGHT, WIDTH, **options) as ours:
        return expected, pictures(ours, data, camera, option)


def away_from_edges(segmentation):
    """Pixels whose neighbours show the same object."""
    same = np.ones(segmentation.shape[:2], bool)
    for axis in (0, 1):
        edge = (np.diff(segmentation, axis=axis) != 0).any(-1)
        for shift in (0, 1):
            part = [slice(None), slice(None)]
            part[axis] = slice(shift, shift + edge.shape[axis])
            same[tuple(part)] &= ~edge
    return same


def require_same_geometry(expected, drawn):
    inside = away_from_edges(expected[2])
    assert inside.mean() > 0.5
    assert np.array_equal(expected[2][inside], drawn[2][inside])
    assert (expected[2] != drawn[2]).any(-1).mean() < 0.002
    # Theirs went through a 24-bit or 32-bit buffer whose near plane is 0.02.
    assert np.allclose(expected[1][inside], drawn[1][inside], rtol=2e-4)
    for a, b in zip(expected, drawn):
        assert a.shape == b.shape and a.dtype == b.dtype


@pytest.mark.parametrize("material", ["checker", "even", "dice", "dice even", "glass"])
@pytest.mark.parametrize("angle", [(70.0, -30.0), (200.0, -60.0)])
def test_shapes_and_their_textures(has_own_renderer, material, angle):
    model = model_of(SHAPES.format(material))
    expected, drawn = both(model, data_of(model), view(model, *angle), glass=())
    require_same_geometry(expected, drawn)
    inside = away_from_edges(expected[2])
    error = np.abs(expected[0].astype(int) - drawn[0])[inside]
    # Their pictures are antialiased and ours are not; wrong coordinates differ by 10 and more.
    assert error.mean() < (6 if material == "glass" else 4)


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (0.1, 0.1, 0.4)])
def test_triangles_follow_a_cube_texture(scale):
    """Interpolated coordinates are less than half a texel from those of a cube, and the whole shape is there without gaps."""
    from sideray.mujoco import _shapes, _textures

    side, scale = 100, np.array(scale)
    ball = _shapes.sphere(48, 32)
    positions, triangles, _, uv = _textures.onto_cube(ball, scale, side)
    assert triangles is None and len(positions) < 2.5 * 3 * len(ball[1])
    corners, place = positions.reshape(-1, 3, 3), uv.reshape(-1, 3, 2)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1).sum()
    whole = ball[0][ball[1]]
    assert np.isclose(area, np.linalg.norm(np.cross(whole[:, 1] - whole[:, 0], whole[:, 2] - whole[:, 0]), axis=-1).sum())
    vertices = np.unique(np.round(positions, 7) + 0.0, axis=0, return_inverse=True)[1].reshape(-1, 3)
    edges = np.sort(vertices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()  # each is that of two triangles
    weights = np.random.default_rng(2).dirichlet(np.ones(3), len(corners))[:, :, None]
    face, exact = _textures.faces_of((corners * weights).sum(1) * scale)
    width = _textures.strip(np.zeros((6, side, side, 3), np.uint8)).shape[1]
    exact = np.stack([exact[:, 0] * side + (width - side) // 2, exact[:, 1] * side + (width - side) // 2 + face * width], -1)
    assert np.abs((place * weights).sum(1) * [width, 6 * width] - exact).max() < 0.5


def test_faces_of_a_cube_do_not_mix():
    """Nor do their mip levels, as far as the margins reach: red faces between green ones."""
    from sideray.mujoco import _textures

    faces = np.zeros((6, 50, 50, 3), np.uint8)
    faces[::2, :, :, 0] = faces[1::2, :, :, 1] = 255
    strip = _textures.strip(faces)
    assert strip.shape[1] % 32 == 0 and strip.shape[0] == 6 * strip.shape[1]
    for number in range(6):
        block = strip[number * strip.shape[1]:(number + 1) * strip.shape[1]]
        assert (block == faces[number, 0, 0]).all()


@pytest.mark.parametrize("reflectance", [0.2, 0.9])
def test_mirrors_add_to_what_a_surface_shows(has_own_renderer, reflectance):
    """And neither the sky nor ambient light is mirrored."""
    world = f"""<light directional="true" diffuse=".3 .3 .3" dir="0 .5 -1" pos="0 0 3" castshadow="false" specular="0 0 0"/>
    <geom type="plane" size="3 3 .1" rgba=".6 .4 .2 1" material="mirror"/>
    <geom type="box" size=".5 .5 .02" pos="0 .3 .8" rgba="0 1 0 1"/>"""
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><statistic center='0 0 .2' extent='2'/><visual><headlight ambient='.2 .2 .2' diffuse='.1 .1 .1' specular='0 0 0'/>"
        f"</visual><asset><texture name='sky' type='skybox' builtin='flat' rgb1='.3 .5 .8' width='8' height='48'/>"
        f"<material name='mirror' reflectance='{reflectance}' specular='0'/></asset><worldbody>{world}</worldbody></mujoco>")
    expected, drawn = both(model, data_of(model), view(model, 90.0, -30.0))
    inside = away_from_edges(expected[2])
    error = np.abs(expected[0].astype(int) - drawn[0]).max(-1)[inside]
    assert (error > 2).mean() < 0.02  # the edge of what is mirrored
    floor = drawn[0][(expected[2][..., 0] == 0) & inside].astype(int)
    assert floor[:, 1].max() - floor[:, 1].min() > 10  # and something is


def test_moving_things_sites_flexes_and_what_is_added(has_own_renderer):
    model = model_of(MOVING)
    option = mujoco.MjvOption()
    option.flags[mujoco.mjtVisFlag.mjVIS_CONTACTPOINT] = True
    option.flags[mujoco.mjtVisFlag.mjVIS_JOINT] = True
    with sideray_mujoco.Renderer(model, HEIGHT, WIDTH) as ours:
        for steps in (0, 100, 200):
            data = data_of(model, steps)
            theirs = mujoco.Renderer(model, HEIGHT, WIDTH)
            expected, drawn = (pictures(r, data, view(model, distance=2), option) for r in (theirs, ours))
            theirs.close()
            inside = away_from_edges(expected[2])
            assert np.array_equal(expected[2][inside], drawn[2][inside])
            assert (expected[2] != drawn[2]).any(-1).mean() < 0.005
            assert np.isin([mujoco.mjtObj.mjOBJ_GEOM, mujoco.mjtObj.mjOBJ_FLEX, mujoco.mjtObj.mjOBJ_SITE],
                           drawn[2][..., 1]).all()


def test_skins(has_own_renderer):
    spec = """<mujoco><statistic center="0 0 0" extent="1"/><visual><map znear=".01"/></visual>
      <worldbody><body name="left" pos="-.3 0 0"><joint axis="1 0 0"/><geom type="sphere" size=".02" rgba="0 0 0 0"/></body>
        <body name="right" pos=".3 0 0"><joint axis="1 0 0"/><geom type="sphere" size=".02" rgba="0 0 0 0"/></body></worldbody>
      <deformable><skin name="sheet" rgba=".2 .6 .9 1" vertex="-.3 -.2 0  -.3 .2 0  .3 -.2 0  .3 .2 0" face="0 2 1 2 3 1">
        <bone body="left" bindpos="-.3 0 0" bindquat="1 0 0 0" vertid="0 1" vertweight="1 1"/>
        <bone body="right" bindpos=".3 0 0" bindquat="1 0 0 0" vertid="2 3" vertweight="1 1"/></skin></deformable></mujoco>"""
    model = mujoco.MjModel.from_xml_string(spec)
    with sideray_mujoco.Renderer(model, HEIGHT, WIDTH) as ours:
        shown = []
        for turn in (0.0, 0.6):
            data = mujoco.MjData(model)
            data.qpos[:] = turn
            mujoco.mj_forward(model, data)
            theirs = mujoco.Renderer(model, HEIGHT, WIDTH)
            expected, drawn = (pictures(r, data, view(model, -40, -50, 1.2)) for r in (theirs, ours))
            theirs.close()
            require_same_geometry(expected, drawn)
            shown.append((drawn[2] == (0, mujoco.mjtObj.mjOBJ_SKIN)).all(-1))
        assert shown[0].mean() > 0.05 and (shown[0] != shown[1]).any()


@pytest.mark.parametrize("angle", [(0.0, 0.0), (200.0, 40.0), (300.0, -50.0)])
def test_sky_and_planes_from_below(has_own_renderer, angle):
    model = model_of('<geom type="plane" size=".4 .4 .1" rgba="1 0 0 1"/>')
    expected, drawn = both(model, data_of(model), view(model, *angle))
    require_same_geometry(expected, drawn)
    assert np.abs(expected[0].astype(int) - drawn[0]).mean() < 3


def test_segmentation_differs_where_surfaces_coincide(has_own_renderer):
    """And nowhere else but in pixels of outlines: the depth is the same there, so that a depth buffer decides."""
    plates = "".join(f'<geom type="box" size="3 3 .2" pos="{i - 2} {i - 2} 0"/>' for i in range(4))
    model = model_of(plates)
    expected, drawn = both(model, data_of(model), view(model, 60.0, -50.0, 30.0))
    other = (expected[2] != drawn[2]).any(-1)
    top = np.abs(expected[1] - drawn[1]) < 1e-4 * drawn[1]
    assert other.any() and (other & ~top).mean() < 0.002
    model = model_of(plates.replace("3 3 .2", "3 3 {}").format(0.2, 0.21, 0.22, 0.23))
    require_same_geometry(*both(model, data_of(model), view(model, 60.0, -50.0, 30.0)))


def test_cameras_of_the_model(has_own_renderer):
    world = SHAPES.format("checker") + """
      <camera name="front" pos="0 -4 1" xyaxes="1 0 0 0 .2 1" fovy="40"/>
      <camera name="flat" pos="0 -4 1" xyaxes="1 0 0 0 .2 1" {0} fovy="2"/>
      <camera name="lens" pos="0 -4 1" xyaxes="1 0 0 0 .2 1" resolution="160 120" sensorsize=".0032 .0024" focal=".003 .003"
              principal=".0004 .0002"/>
      <camera name="fraction" pos="0 -4 1" xyaxes="1 0 0 0 .2 1" resolution="160 120" sensorsize=".0032 .0024"
              focal=".003 .003" principal=".00041 -.000213"/>
      <camera name="stretched" pos="0 -4 1" xyaxes="1 0 0 0 .2 1" resolution="160 120" sensorsize=".0032 .0024"
              focal=".002 .003" principal=".0001 .0002"/>"""
    try:
        model = model_of(world.format('projection="orthographic"'))
    except ValueError:  # before 3.3
        model = model_of(world.format('orthographic="true"'))
    data = data_of(model)
    for camera in ("front", "flat", "lens", "fraction", "stretched", 0):
        expected, drawn = both(model, data, camera)
        require_same_geometry(expected, drawn)


def test_what_is_wrong_is_said_as_there(has_own_renderer):
    model = model_of("")
    theirs, ours = mujoco.Renderer(model, 8, 8), sideray_mujoco.Renderer(model, 8, 8)
    for wrong in ("nowhere", 3, -2):
        messages = []
        for renderer in (theirs, ours):
            with pytest.raises(ValueError) as caught:
                renderer.update_scene(data_of(model), wrong)
            messages.append(str(caught.value))
        assert messages[0] == messages[1]
    for renderer in (theirs, ours):
        renderer.update_scene(data_of(model))
        with pytest.raises(ValueError, match="Expected `out.shape == "):
            renderer.render(out=np.empty((8, 9, 3), np.uint8))
        renderer.close()
        with pytest.raises(RuntimeError, match="render cannot be called after close."):
            renderer.render()


def test_members_are_there(has_own_renderer):
    theirs = {name for name in dir(mujoco.Renderer) if not name.startswith("_")}
    assert theirs <= set(dir(sideray_mujoco.Renderer))


# What needs no picture of MuJoCo's.

GLASS = '<geom type="plane" size="0 0 .1" material="checker"/><geom name="ball" type="sphere" size=".4" pos="0 0 .4" material="glass"/>'


def test_glass_bends_light_and_counts_as_an_object():
    model = model_of(GLASS)
    data = data_of(model)
    with sideray_mujoco.Renderer(model, HEIGHT, WIDTH) as bent, \
            sideray_mujoco.Renderer(model, HEIGHT, WIDTH, glass=()) as straight:
        color, depth, segmentation = pictures(bent, data, view(model))
        flat_color, flat_depth, flat_segmentation = pictures(straight, data, view(model))
        assert np.array_equal(segmentation, flat_segmentation) and np.array_equal(depth, flat_depth)
        ball = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "ball")
        on_ball = (segmentation == (ball, mujoco.mjtObj.mjOBJ_GEOM)).all(-1)
        assert 0.02 < on_ball.mean() < 0.5
        assert np.abs(color.astype(int) - flat_color)[on_ball].mean() > 20
        assert bent.picture.stats is not None and bent.picture.size == (WIDTH, HEIGHT)
        shown = bent.objects[bent.picture.ids]
        assert shown.shape == (HEIGHT, WIDTH, 2)


def test_thin_walls_keep_their_colour():
    """A hollow ball of green glass whose walls are a sixtieth of it tints what is behind, as a solid one does."""
    from sideray.mujoco import _shapes

    points, triangles, _, _ = _shapes.sphere(48, 32)
    solid = 0.3 * points, triangles
    hollow = np.concatenate([0.3 * points, 0.29 * points]), np.concatenate([triangles, len(points) + triangles[:, ::-1]])
    for (vertices, faces), reach in ((solid, 0.6), (hollow, 0.03)):
        assert abs(_shapes.reach_inside(vertices[faces.ravel()]) - reach) < 0.02 * reach
        model = mujoco.MjModel.from_xml_string(f"""<mujoco><visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
          <asset><mesh name="ball" vertex="{' '.join(map(str, vertices.ravel()))}" face="{' '.join(map(str, faces.ravel()))}"/>
            <material name="glass" rgba=".3 .9 .3 .4" specular="0"/></asset>
          <worldbody><geom type="plane" size="5 5 .1" rgba=".8 .8 .8 1"/>
            <geom type="mesh" mesh="ball" material="glass" pos="0 0 .5"/></worldbody></mujoco>""")
        with sideray_mujoco.Renderer(model, 40, 40, shadows="off") as renderer:
            renderer.update_scene(data_of(model), view(model, 90, -89.9, 3.0))
            color = renderer.render()[18:22, 18:22].reshape(-1, 3).astype(float).mean(0)
        assert color[0] < 0.7 * color[1] and color[1] > 100, (reach, color)


def test_options_out_and_flags():
    model = model_of('<light pos="0 0 3" dir="0 0 -1"/><geom type="plane" size="2 2 .1"/>'
                     '<geom type="sphere" size=".3" pos="0 0 .8"/>')
    data = data_of(model)
    with sideray_mujoco.Renderer(model, 60, 80, shadows="exact", aov="N") as renderer:
        renderer.update_scene(data, view(model, elevation=-60))
        out = np.zeros((60, 80, 3), np.uint8)
        assert renderer.render(out=out) is out and out.any()
        assert renderer.picture["N"].shape == (60, 80, 3)
        renderer.enable_depth_rendering()
        depth = np.zeros((60, 80), np.float64)
        assert renderer.render(out=depth) is depth and 1 < depth.min() < depth.max() <= 100.01
    with sideray_mujoco.Renderer(model, 60, 80) as renderer:
        renderer.update_scene(data, view(model, elevation=-60))
        with_shadow = renderer.render().astype(int)
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        without = renderer.render().astype(int)
        assert (without - with_shadow).max() > 20 and (without - with_shadow).min() > -3
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = 0
        renderer.update_scene(data, view(model, elevation=10))
        assert not renderer.render()[0].any()


def test_linear_colours():
    model = model_of(GLASS)
    with sideray_mujoco.Renderer(model, 60, 80, linear=True) as linear, sideray_mujoco.Renderer(model, 60, 80) as plain:
        for renderer in (linear, plain):
            renderer.update_scene(data_of(model), view(model))
        assert not np.array_equal(linear.render(), plain.render())


def test_frames_do_not_grow():
    from threads_test import growth

    model = model_of(MOVING + GLASS)
    data = mujoco.MjData(model)
    option = mujoco.MjvOption()
    option.flags[mujoco.mjtVisFlag.mjVIS_CONTACTPOINT] = True
    option.flags[mujoco.mjtVisFlag.mjVIS_CONTACTFORCE] = True
    with sideray_mujoco.Renderer(model, 48, 64, shadows="off") as renderer:

        def frame():
            if data.time > 2:
                mujoco.mj_resetData(model, data)
            mujoco.mj_step(model, data, 5)
            renderer.update_scene(data, scene_option=option)
            assert renderer.render().any()

        frames = 10000 if "SIDERAY_SLOW" in os.environ else 120
        assert growth(frames, frame) < 8 << 20


@pytest.mark.parametrize("camera", [-1, "fixed"])
@pytest.mark.parametrize("forward", [False, True])
def test_nothing_is_drawn_before_there_is_a_place(camera, forward):
    """Before update_scene(), and of data that mj_forward() has not seen."""
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><light pos="0 0 3"/><camera name="fixed" pos="0 -2 1" xyaxes="1 0 0 0 .4 .9"/>'
        '<geom type="box" size=".2 .2 .2" pos="0 0 .5"/></worldbody></mujoco>')
    drawn = []
    for renderer in (sideray_mujoco.Renderer(model, 48, 64), mujoco.Renderer(model, 48, 64)):
        with renderer:
            if forward:
                renderer.update_scene(mujoco.MjData(model), camera)
            pictures = [renderer.render()]
            renderer.enable_depth_rendering()
            pictures.append(renderer.render())
            renderer.disable_depth_rendering()
            renderer.enable_segmentation_rendering()
            pictures.append(renderer.render())
            drawn.append(pictures)
    ours, theirs = drawn
    assert np.array_equal(ours[0], theirs[0]) and not ours[0].any()
    assert np.allclose(ours[1], theirs[1], rtol=1e-3)
    assert np.array_equal(ours[2], theirs[2]) and (ours[2] == -1).all()


BATCH_WORLD = """
<light pos="0 0 3" dir="0 0 -1"/><geom type="plane" size="0 0 .1" material="checker"/>
<camera name="front" pos="0 -3 1" xyaxes="1 0 0 0 .3 1"/>
<body name="arm" pos="0 0 .5"><joint axis="0 1 0"/><geom type="capsule" size=".05" fromto="0 0 0 .4 0 0"/>
  <site name="end" pos=".4 0 0" size=".09"/>
  <camera name="hand" pos="0 -1 .5" xyaxes="1 0 0 0 .3 1"/></body>
<body name="ball" pos=".3 .4 .6"><freejoint/><geom type="sphere" size=".1" rgba="1 0 0 .5"/></body>
<body name="bowl" pos="-.3 .2 .7"><freejoint/><geom type="ellipsoid" size=".1 .2 .1" material="glass"/></body>"""


def states_of(model, count):
    states = []
    for i in range(count):
        data = mujoco.MjData(model)
        data.qvel[0] = 1.0 + i
        for _ in range(20 * i):
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        states.append(data)
    return states


@pytest.mark.parametrize("world", [BATCH_WORLD, MOVING + '<camera name="front" pos="0 -3 1" xyaxes="1 0 0 0 .3 1"/>'],
                         ids=["rigid", "cloth"])
@pytest.mark.parametrize("camera", ["front", "hand", "each"])
def test_a_batch_is_as_its_states_alone(world, camera):
    model = model_of(world)
    if camera == "hand" and "hand" not in world:
        pytest.skip("no such camera in this model")
    states = states_of(model, 4)
    cameras = [view(model, 20.0 * i) for i in range(4)] if camera == "each" else camera
    with sideray_mujoco.Renderer(model, 48, 64, batch=4) as batch, sideray_mujoco.Renderer(model, 48, 64) as alone:
        for _ in range(2):
            drawn = pictures(batch, states, cameras)
            channels = batch.render_channels()
            for i, state in enumerate(states):
                own = cameras[i] if camera == "each" else camera
                for one, other in zip(drawn, pictures(alone, state, own)):
                    assert one.dtype == other.dtype and np.array_equal(one[i], other)
                for name, value in alone.render_channels().items():
                    assert np.array_equal(channels[name][i], value), name
            states = states[1:] + states[:1]
        assert len(batch.pictures) == 4 and drawn[0].shape == (4, 48, 64, 3)
        assert not np.array_equal(drawn[2][0], drawn[2][1])


def test_what_a_batch_refuses():
    model = model_of(BATCH_WORLD)
    states = states_of(model, 2)
    with pytest.raises(ValueError, match="batch: -1"):
        sideray_mujoco.Renderer(model, 8, 8, batch=-1)
    with sideray_mujoco.Renderer(model, 8, 8, batch=2) as batch:
        with pytest.raises(ValueError, match="1 states for a batch of 2"):
            batch.update_scene(states[:1])
        with pytest.raises(ValueError, match="3 cameras for a batch of 2"):
            batch.update_scene(states, ["front"] * 3)
        batch.update_scene(states)
        with pytest.raises(ValueError, match=r"Expected `out.shape == \(2, 8, 8, 3\)`"):
            batch.render(out=np.empty((8, 8, 3), np.uint8))
        with pytest.raises(ValueError, match="'normals' is none"):
            batch.render_channels(["normals"])


def test_channels_of_one_picture(has_own_renderer):
    """Depth and segmentation as MuJoCo has them, but for outlines, which are those of rounder shapes."""
    model = model_of(SHAPES.format("checker") + '<geom name="ball" type="sphere" size=".4" pos="0 .9 .4" material="glass"/>')
    data = data_of(model)
    theirs = mujoco.Renderer(model, HEIGHT, WIDTH)
    expected = pictures(theirs, data, view(model))
    theirs.close()
    for options in ({}, {"samples": 4}, {"glass": ()}):
        with sideray_mujoco.Renderer(model, HEIGHT, WIDTH, **options) as ours:
            ours.update_scene(data, view(model))
            drawn = ours.render_channels()
            assert np.array_equal(drawn["rgb"], ours.render())
            assert list(ours.render_channels(["depth"])) == ["depth"]
        inside = away_from_edges(expected[2]) & (expected[2] == drawn["segmentation"]).all(-1)
        assert (expected[2] != drawn["segmentation"]).any(-1).mean() < 0.01
        assert np.isclose(expected[1][inside], drawn["depth"][inside], rtol=5e-3).mean() > 0.999


@pytest.mark.parametrize("material, pictures", [("even", 1), ("glass", 2)])
def test_channels_share_pictures(monkeypatch, material, pictures):
    """Where all is opaque one picture has all channels, and one more has what is seen first where not."""
    drawn = []
    render = sideray.Renderer.render
    monkeypatch.setattr(sideray.Renderer, "render", lambda *args, **options: drawn.append(1) or render(*args, **options))
    model = model_of(SHAPES.format(material))
    with sideray_mujoco.Renderer(model, HEIGHT, WIDTH, glass=()) as renderer:
        for step in range(3):
            renderer.update_scene(data_of(model), view(model))
            renderer.render_channels()
            assert len(drawn) == pictures * (step + 1)


def test_channels_are_the_first_surfaces_of_the_picture():
    """Glass included; and what is opaque is drawn once for all of them."""
    opaque = SHAPES.format("checker")
    glass = '<geom type="sphere" size=".4" pos="0 .9 .4" material="glass"/>'
    for world, is_drawn_once in ((opaque, True), (opaque + glass, False)):
        model = model_of(world)
        with sideray_mujoco.Renderer(model, HEIGHT, WIDTH, aov="first") as renderer:
            renderer.update_scene(data_of(model), view(model))
            drawn = renderer.render_channels()
            far = np.float32(renderer.scene.camera[0].frustum_far)
            first = renderer.picture
            assert np.isclose(drawn["depth"], np.minimum(first["first.Z"], far), rtol=1e-5).mean() > 0.9999
            assert (drawn["segmentation"] == renderer.objects[first["first.surface"]]).mean() > 0.9999
            assert (renderer._round is None) == is_drawn_once


@pytest.mark.parametrize("share", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("glass", ["", '<geom type="sphere" size=".3" pos="-.6 3 .9" material="glass"/>'], ids=["opaque", "glass"])
def test_haze_around_planes_without_an_end(has_own_renderer, share, glass):
    """As MuJoCo blends it, over the plane, to the horizon and no further; not over what stands before it."""
    post = '<geom type="box" size="1 1 2" pos="4 30 0" material="white"/>'
    world = f'<geom type="plane" size="0 0 .1" material="green"/>{post}{glass}'
    head = f'<headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/><map haze="{share}" znear=".01" zfar="25"/>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><statistic center='0 0 0' extent='2'/><visual>{head}<rgba haze='1 0 0 1'/></visual><asset>"
        "<texture name='s' type='skybox' builtin='flat' rgb1='0 0 1' rgb2='0 0 1' width='16' height='96'/>"
        "<material name='glass' rgba='1 1 1 .3'/><material name='green' rgba='0 1 0 1' specular='0'/>"
        f"<material name='white' specular='0'/></asset><worldbody>{world}"
        "<camera name='c' pos='0 0 1' fovy='30' xyaxes='1 0 0 0 .05 1'/></worldbody></mujoco>")
    (expected, depth, _), (drawn, _, _) = both(model, data_of(model), "c")
    hazed = (expected[..., 0] > 20) & (expected[..., 0] < 250)
    if glass:
        hazed[30:105, 5:65] = False  # where the ball is
    assert hazed.sum() > 500
    # MuJoCo's strips have corners. Where something is glass, the sky lights the plane, in its own colour.
    apart = np.abs(expected.astype(int) - drawn)
    assert (apart[hazed][:, 0] <= 10).mean() > 0.9
    if not glass:
        assert (apart.max(-1) <= 10).mean() > 0.98


def test_glass_throws_a_coloured_shadow():
    """Under a red pane: glass lets nearly all of the light pass, more of its red; a blended pane a share of all colours."""
    world = """<mujoco><visual><headlight ambient="0 0 0" diffuse="0 0 0" specular="0 0 0"/></visual>
      <asset><material name="glass" rgba="1 .2 .2 .4" specular="0"/></asset>
      <worldbody><light directional="true" dir="0 0 -1" diffuse=".8 .8 .8" specular="0 0 0" castshadow="true"/>
        <geom type="plane" size="5 5 .1" rgba=".8 .8 .8 1"/>
        <geom type="box" size=".8 .8 .02" pos="0 0 1.2" material="glass"/>
        <camera name="below" pos="0 -3 .6" xyaxes="1 0 0 0 .2 1"/></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(world)
    data = data_of(model)
    for options in ({}, {"glass": ()}):
        with sideray_mujoco.Renderer(model, 48, 64, **options) as renderer:
            renderer.update_scene(data, "below")
            picture = renderer.render().astype(float)
        lit, shadowed = picture[40, 32], picture[26, 32]
        if options:
            assert np.abs(shadowed - 0.6 * 0.6 * lit).max() < 2
        else:
            red, green, blue = shadowed / lit
            assert 0.85 < green < red - 0.015 and red < 0.96 and green == blue
