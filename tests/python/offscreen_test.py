"""OffscreenRenderer, with scenes shaped like pyrender's; and with pyrender's own where it is installed."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import plain_scene, quad

import sideray


def material(**fields):
    defaults = dict(baseColorFactor=(1, 1, 1, 1), metallicFactor=0.0, roughnessFactor=1.0, alphaMode="OPAQUE",
                    alphaCutoff=0.5, doubleSided=False, emissiveFactor=(0, 0, 0), baseColorTexture=None,
                    metallicRoughnessTexture=None, normalTexture=None, occlusionTexture=None, emissiveTexture=None)
    return SimpleNamespace(**{**defaults, **fields})


def mesh(positions, triangles, poses=None, **fields):
    primitive = SimpleNamespace(positions=positions, indices=triangles, normals=None, texcoord_0=None, color_0=None,
                                tangents=None, mode=4, poses=poses, material=material(**fields))
    return SimpleNamespace(primitives=[primitive], is_visible=True)


class FakeScene:
    """What of pyrender.Scene is read."""

    def __init__(self):
        self.mesh_nodes, self.light_nodes, self.main_camera_node = [], [], None
        self.ambient_light, self.bg_color, self._poses = np.zeros(3), np.ones(4), {}

    def node(self, pose, **fields):
        node = SimpleNamespace(name=fields.pop("name", None), **fields)
        self._poses[id(node)] = np.asarray(pose, float)
        return node

    def get_pose(self, node):
        return self._poses[id(node)]


class DirectionalLight:
    color, intensity, range = (1.0, 1.0, 1.0), np.pi, None


def at(x=0.0, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


@pytest.mark.parametrize("other", [{}, dict(cx=20.0), dict(cy=31.0), dict(fx=75.0), dict(fx=45.0, fy=75.0, cx=40.0, cy=20.0)])
def test_intrinsics(fake, other):
    given = {**dict(fx=60.0, fy=60.0, cx=32.0, cy=24.0), **other}
    fake.main_camera_node = fake.node(at(z=3), camera=SimpleNamespace(**given, znear=0.1, zfar=None))
    _, depth = sideray.OffscreenRenderer(64, 48).render(fake)
    # The square is 2 wide at a distance of 3, and no edge of it meets the middle of a pixel.
    x, y = np.arange(64) + 0.5, np.arange(48) + 0.5
    expected = np.outer(np.abs(y - given["cy"]) < given["fy"] / 3, np.abs(x - given["cx"]) < given["fx"] / 3)
    assert np.array_equal(depth > 0, expected)
    assert np.allclose(depth[expected], 3, rtol=1e-5)


@pytest.fixture
def fake():
    scene = FakeScene()
    scene.mesh_nodes.append(scene.node(at(), mesh=mesh(*quad(), baseColorFactor=(0.5, 0.5, 0.5, 1)), name="square"))
    scene.light_nodes.append(scene.node(at(), light=DirectionalLight()))
    camera = SimpleNamespace(yfov=np.radians(45), znear=0.1, zfar=None)
    scene.main_camera_node = scene.node(at(z=3), camera=camera)
    return scene


@pytest.fixture(scope="module")
def offscreen():
    made = sideray.OffscreenRenderer(32, 24)
    yield made
    made.delete()


def test_colour_and_depth(offscreen, fake):
    color, depth = offscreen.render(fake)
    assert color.shape == (24, 32, 3) and color.dtype == np.uint8
    assert depth.shape == (24, 32) and depth.dtype == np.float32
    assert depth[12, 16] == pytest.approx(3.0, rel=1e-4) and depth[0, 0] == 0
    assert tuple(color[0, 0]) == (255, 255, 255), "the background is white"
    # Light of pi that falls straight on a rough surface of albedo 0.5: radiance 0.5 and a little reflection, as sRGB.
    assert 186 <= color[12, 16, 0] <= 200


def test_nodes_that_move_come_and_go(offscreen, fake):
    offscreen.render(fake)
    fake._poses[id(fake.mesh_nodes[0])] = at(z=1)
    assert offscreen.render(fake, sideray.RenderFlags.DEPTH_ONLY)[12, 16] == pytest.approx(2.0, rel=1e-4)
    fake.mesh_nodes.append(fake.node(at(), mesh=mesh(*quad(half=0.1), poses=np.stack([at(z=1.5), at(x=0.5, z=1.5)]))))
    assert offscreen.render(fake)[1][12, 16] == pytest.approx(1.5, rel=1e-4)
    fake.mesh_nodes[:] = []
    assert not offscreen.render(fake)[1].any()


def test_materials_are_read_anew(offscreen, fake):
    before = offscreen.render(fake)[0][12, 16].astype(int)
    fake.mesh_nodes[0].mesh.primitives[0].material.baseColorFactor = (0.5, 0, 0, 1)
    after = offscreen.render(fake)[0][12, 16].astype(int)
    # What reflects keeps its colour: only the diffuse part is red.
    assert before[0] == after[0] and after[1] < 0.5 * before[1]


def test_segmentation_by_nodes(offscreen, fake):
    other = fake.node(at(x=0.8, z=0.5), mesh=mesh(*quad(half=0.2)))
    fake.mesh_nodes.append(other)
    seg, depth = offscreen.render(fake, sideray.RenderFlags.SEG, _ById(fake.mesh_nodes[0], (10, 20, 30)))
    assert tuple(seg[12, 16]) == (10, 20, 30) and not seg[0, 0].any() and depth[12, 16] > 0


class _ById:
    """A mapping whose keys need no hash."""

    def __init__(self, node, color):
        self._entries = [(node, color)]

    def items(self):
        return self._entries


def test_alpha_and_glass(offscreen, fake):
    glass = mesh(*quad(z=1.0, half=0.5), transmission=1.0, roughnessFactor=0.0)
    glass.primitives[0].material.transmission = 1.0
    fake.mesh_nodes.append(fake.node(at(), mesh=glass))
    color, depth = offscreen.render(fake, sideray.RenderFlags.RGBA)
    assert color.shape == (24, 32, 4) and color[0, 0, 3] == 0 and color[12, 16, 3] == 255
    assert depth[12, 16] == pytest.approx(3.0, rel=1e-4), "depth is of what is opaque"
    assert offscreen.picture["A"][12, 16] == 1


def test_scenes_of_this_package(offscreen):
    color, depth = offscreen.render(plain_scene(unlit=True, base_color=(0, 0, 1)))
    assert color[12, 16, 2] > 200 and depth[12, 16] == pytest.approx(3.0, rel=1e-4)


def test_what_is_not_drawn_is_refused(offscreen, fake):
    with pytest.raises(sideray.Unsupported, match="ALL_WIREFRAME"):
        offscreen.render(fake, sideray.RenderFlags.ALL_WIREFRAME)
    fake.main_camera_node = None
    with pytest.raises(sideray.Error, match="no main camera"):
        offscreen.render(fake)


def test_pyrender_s_own_scene(offscreen):
    pyrender = pytest.importorskip("pyrender", reason="pyrender is not installed")
    trimesh = pytest.importorskip("trimesh")
    scene = pyrender.Scene(ambient_light=[0.1, 0.1, 0.1], bg_color=[0, 0, 0])
    node = scene.add(pyrender.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=3, radius=1.0)))
    scene.add(pyrender.DirectionalLight(color=np.ones(3), intensity=3.0), pose=at(z=3))
    scene.add(pyrender.PerspectiveCamera(yfov=np.pi / 4), pose=at(z=4))
    color, depth = offscreen.render(scene)
    assert depth[12, 16] == pytest.approx(3.0, abs=0.01) and color[12, 16].min() > 100 and not color[0, 0].any()
    seg, _ = offscreen.render(scene, sideray.RenderFlags.SEG, {node: (0, 255, 0)})
    assert tuple(seg[12, 16]) == (0, 255, 0)
