"""Scenes of trimesh."""

import numpy as np
import pytest

import sideray

trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed: pip install trimesh")


def looking(scene):
    scene.camera = sideray.Camera.look_at((0, 0, 5), (0, 0, 0))
    return scene


def test_a_mesh_is_where_it_is(renderer):
    box = trimesh.creation.box((2, 2, 2))
    for smooth in (True, False):
        scene = looking(sideray.Scene.from_trimesh(box, smooth=smooth, env=None))
        assert np.allclose(scene.bounds, ([-1, -1, -1], [1, 1, 1]))
        picture = renderer.render(scene, (32, 32), aov="N")
        assert np.isclose(picture.depth[16, 16], 4.0)
        corner = picture["N"][12, 12]
        assert np.allclose(corner, [0, 0, 1], atol=1e-3) != smooth


def test_a_scene_has_its_transforms_names_and_camera(renderer):
    source = trimesh.Scene()
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.5)
    for x, name in ((-1, "left"), (1, "right")):
        source.add_geometry(ball, node_name=name, geom_name="ball", transform=trimesh.transformations.translation_matrix((x, 0, 0)))
    source.camera = trimesh.scene.Camera(fov=(60, 60))
    source.camera_transform = trimesh.transformations.translation_matrix((0, 0, 4))
    scene = sideray.Scene.from_trimesh(source)
    picture = renderer.render(scene, (64, 64))
    assert sorted(np.unique(picture.ids)) == [0, 1, 2]
    columns = [np.nonzero(picture.ids == i)[1].mean() + 0.5 for i in (1, 2)]
    # 1 of the half width, which is 4 tan(30 degrees), on either side of the middle; nearer halves look farther out.
    assert np.allclose(np.array(sorted(columns)) - 32, np.array([-1, 1]) * 32 / (4 * np.tan(np.pi / 6)), atol=0.5)


def test_colours_and_textures(renderer):
    options = dict(shadows="off", ambient=False, reflections=False, aov="albedo")
    box = trimesh.creation.box((2, 2, 2))
    box.visual.face_colors = [255, 0, 0, 255]
    albedo = renderer.render(looking(sideray.Scene.from_trimesh(box)), (16, 16), **options)["albedo"]
    assert np.allclose(albedo[8, 8], [1, 0, 0], atol=1e-3)
    box = trimesh.creation.box((2, 2, 2))
    box.visual.vertex_colors = np.tile([188, 188, 188, 255], (8, 1))
    albedo = renderer.render(looking(sideray.Scene.from_trimesh(box)), (16, 16), **options)["albedo"]
    assert np.allclose(albedo[8, 8], 0.503, atol=2e-3)  # sRGB 188
    image = pytest.importorskip("PIL.Image").fromarray(np.array([[[255, 0, 0]] * 8] * 4 + [[[0, 0, 255]] * 8] * 4, np.uint8))
    square = trimesh.Trimesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    square.visual = trimesh.visual.TextureVisuals(
        uv=[[0, 0], [1, 0], [1, 1], [0, 1]],
        material=trimesh.visual.material.PBRMaterial(baseColorTexture=image, roughnessFactor=0.5, doubleSided=True))
    albedo = renderer.render(looking(sideray.Scene.from_trimesh(square)), (32, 32), **options)["albedo"]
    assert np.allclose(albedo[12, 16], [1, 0, 0], atol=0.02) and np.allclose(albedo[19, 16], [0, 0, 1], atol=0.02)


def test_what_is_no_trimesh_is_refused():
    with pytest.raises(sideray.InvalidArgument, match="source: int; give a trimesh"):
        sideray.Scene.from_trimesh(3)
