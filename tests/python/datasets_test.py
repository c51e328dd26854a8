"""Writers of data sets: read back by readers of our own, and by those of others where they are installed."""

import json
import os
import pathlib
import re
import struct
import zlib

import numpy as np
import pytest
from conftest import quad

import sideray
from sideray import datasets
from sideray.datasets import _masks, _models

SIZE = (80, 60)


def read(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def read_png(path):
    """Pixels of a PNG of 8 or 16 bits, grey or RGB, with any filters of the kind none, sub and up; by the standard."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, header, packed = 8, None, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        content = data[at + 8:at + 8 + size]
        assert struct.unpack_from(">I", data, at + 8 + size)[0] == zlib.crc32(kind + content)
        header = struct.unpack(">2I5B", content) if kind == b"IHDR" else header
        packed += content if kind == b"IDAT" else b""
        at += 12 + size
    width, height, bits, color, *rest = header
    assert rest == [0, 0, 0]
    channels = {0: 1, 2: 3}[color]
    step = channels * bits // 8
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * step)
    rows = np.zeros((height, width * step), np.uint8)
    for y, line in enumerate(lines):
        if line[0] == 1:
            rows[y] = np.cumsum(line[1:].reshape(width, step), axis=0, dtype=np.uint64).astype(np.uint8).ravel()
        else:
            assert line[0] == 0
            rows[y] = line[1:]
    values = rows.view(">u2").astype(np.uint16) if bits == 16 else rows
    return values.reshape((height, width) if channels == 1 else (height, width, 3))


def decoded(text, count):
    """COCO's compressed run lengths, by its definition."""
    numbers, at = [], 0
    while at < len(text):
        value = shift = 0
        while True:
            group = ord(text[at]) - 48
            at += 1
            value |= (group & 31) << shift
            shift += 5
            if not group & 32:
                value -= (group & 16) << (shift - 4) if group & 16 else 0
                break
        numbers.append(value + (numbers[-2] if len(numbers) > 2 else 0))
    assert sum(numbers) == count
    return numbers


def unrolled(segmentation):
    """(height, width) bool of run lengths, a text or a list."""
    height, width = segmentation["size"]
    counts = segmentation["counts"]
    counts = decoded(counts, height * width) if isinstance(counts, str) else counts
    return np.repeat(np.arange(len(counts)) % 2 == 1, counts).reshape(width, height).T


def filled(polygons, size):
    """The pixels whose middles are within an outline, by crossings (even-odd); a union of outlines."""
    width, height = size
    inside = np.zeros((height, width), bool)
    for polygon in polygons:
        crossed = np.zeros((height, width), bool)
        corners = np.array(polygon, float).reshape(-1, 2)
        for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0)):
            rows = np.arange(height) + 0.5
            between = (rows > min(y0, y1)) & (rows < max(y0, y1))
            if not between.any():
                continue
            x = x0 + (rows[between] - y0) / (y1 - y0) * (x1 - x0)
            crossed[between] ^= np.arange(width)[None] + 0.5 < x[:, None]
        inside |= crossed
    return inside


def random_masks():
    rng = np.random.default_rng(5)
    masks = [np.zeros((7, 9), bool), np.ones((7, 9), bool), rng.random((1, 1)) < 2, np.eye(6, dtype=bool), ~np.eye(6, dtype=bool)]
    masks += [rng.random((17, 23)) < share for share in (0.05, 0.3, 0.5, 0.7, 0.95)]
    ring = np.ones((12, 12), bool)
    ring[2:10, 2:10], ring[4:8, 4:8], ring[5:7, 5:7] = False, True, False
    return [*masks, ring]


def runs_of(mask):
    flat = mask.T.ravel()
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flat])))
    return np.diff(np.concatenate([[0], edges, [flat.size]])).astype(np.uint32)


def test_masks_come_back_from_each_form():
    for mask in random_masks():
        runs = runs_of(mask)
        assert np.array_equal(unrolled({"size": mask.shape, "counts": runs.tolist()}), mask)
        assert decoded(_masks.compressed(runs), mask.size) == runs.tolist()
        assert np.array_equal(filled(_masks.polygons(mask), mask.shape[::-1]), mask)
    # One outline a part: the ring's holes are cuts in it, and the island in the hole is a part of its own.
    assert len(_masks.polygons(random_masks()[-1])) == 2 and len(_masks.polygons(np.eye(6, dtype=bool))) == 6


def test_masks_are_what_pycocotools_reads():
    coco = pytest.importorskip("pycocotools.mask", reason="pycocotools is not installed (PyPI: pycocotools)")
    for mask in random_masks():
        height, width = mask.shape
        text = {"size": [height, width], "counts": _masks.compressed(runs_of(mask))}
        assert np.array_equal(coco.decode(text).astype(bool), mask)
        assert text["counts"].encode() == coco.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"]
        outlines = _masks.polygons(mask)
        if outlines:
            assert np.array_equal(coco.decode(coco.merge(coco.frPyObjects(outlines, height, width))).astype(bool), mask)


def shelf():
    """A wall, a card half hidden by a pane, and a card that reaches out of the picture; a camera that is not in the middle of it."""
    scene = sideray.Scene(env=None)
    positions, triangles = quad(-1.0, 4.0)
    wall = scene.add_mesh(positions, triangles, name="wall")
    positions, triangles = quad(0.0, 0.3)
    turn = np.array([[0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    card = scene.add_mesh(positions, triangles, transform=turn, name="card", material={"base_color": (0.8, 0.1, 0.1)})
    beside = np.eye(4)
    beside[:3, 3] = (1.3, 0, 0.2)
    cut = scene.add_mesh(positions, triangles, transform=beside, name="cut", material={"base_color": (0.1, 0.8, 0.1)})
    positions, triangles = quad(0.5, 0.2)
    pane = scene.add_mesh(positions, triangles, material={"alpha_mode": "blend", "base_color": (1, 1, 1, 0.3)}, name="pane")
    scene.camera = sideray.Camera.from_intrinsics(sideray.Camera.look_at((0.3, 0.1, 3), (0.1, 0, 0)).world_from_camera, 90, 75, 33.2, 34.3, SIZE)
    return scene, wall, card, cut, pane


def test_coco_is_read_back(renderer, tmp_path):
    scene, wall, card, cut, pane = shelf()
    first = renderer.render(scene, SIZE, aov="first")["first.surface"]
    names = {card.surface_id: "card", cut.surface_id: "card", pane.surface_id: "pane"}
    for form in ("rle", "counts", "polygon"):
        path = tmp_path / f"{form}.json"
        with datasets.CocoWriter(path, masks=form, amodal=True) as coco:
            assert coco.add("rgb/1.png", SIZE, scene.object_truth(SIZE), names, details={card.surface_id: {"name": "red"}}) == 1
            assert coco.add("rgb/9.png", SIZE, scene.object_truth(SIZE), names, image_id=9, image={"time": 0.5}) == 9
        found = read(path)
        assert [i["id"] for i in found["images"]] == [1, 9] and found["images"][1]["time"] == 0.5
        assert found["images"][0] == {"id": 1, "file_name": "rgb/1.png", "width": 80, "height": 60}
        assert [(c["id"], c["name"]) for c in found["categories"]] == [(1, "card"), (2, "pane")]
        assert [a["id"] for a in found["annotations"]] == list(range(1, 7)) and found["annotations"][0]["name"] == "red"
        for annotation, surface in zip(found["annotations"], 2 * [card.surface_id, cut.surface_id, pane.surface_id]):
            masks = [annotation[key] for key in ("segmentation", "amodal_segmentation")]
            visible, amodal = (filled(mask, SIZE) if form == "polygon" else unrolled(mask) for mask in masks)
            assert np.array_equal(visible, first == surface) and annotation["area"] == visible.sum() > 0
            assert annotation["amodal_area"] == amodal.sum() >= visible.sum() and not (visible & ~amodal).any()
            rows, columns = np.nonzero(visible)
            assert annotation["bbox"] == [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
            assert annotation["category_id"] == (2 if surface == pane.surface_id else 1) and annotation["iscrowd"] == 0
    assert found["annotations"][0]["amodal_area"] > found["annotations"][0]["area"]


def test_coco_is_what_pycocotools_reads(tmp_path):
    reader = pytest.importorskip("pycocotools.coco", reason="pycocotools is not installed (PyPI: pycocotools)")
    evaluation = pytest.importorskip("pycocotools.cocoeval")
    scene, _, card, cut, pane = shelf()
    truths = scene.object_truth(SIZE)
    names = {card.surface_id: "card", cut.surface_id: "card", pane.surface_id: "pane"}
    for form in ("rle", "counts", "polygon"):
        with datasets.CocoWriter(tmp_path / "coco.json", masks=form) as coco:
            coco.add("1.png", SIZE, truths, names)
        found = reader.COCO(str(tmp_path / "coco.json"))
        for annotation, surface in zip(found.loadAnns(found.getAnnIds(imgIds=1)), names):
            visible = next(t.visible for t in truths if t.object == surface)
            assert np.array_equal(found.annToMask(annotation).astype(bool), visible.pixels)
        # What is found exactly is found wholly.
        results = [{"image_id": 1, "category_id": a["category_id"], "segmentation": found.annToRLE(a), "bbox": a["bbox"], "score": 1.0}
                   for a in found.dataset["annotations"]]
        for kind in ("segm", "bbox"):
            judged = evaluation.COCOeval(found, found.loadRes(results), kind)
            judged.evaluate(), judged.accumulate(), judged.summarize()
            assert judged.stats[0] == 1.0


def test_coco_leaves_out_what_is_hidden_and_refuses_what_is_wrong(tmp_path):
    scene = sideray.Scene(env=None)
    for z in (0.0, -1.0):
        scene.add_mesh(*quad(z, 3.0))
    scene.camera = sideray.Camera.look_at((0, 0, 2), (0, 0, 0))
    truths = scene.object_truth((8, 6))
    for hidden, count in ((False, 1), (True, 2)):
        with datasets.CocoWriter(tmp_path / "a.json", hidden=hidden) as coco:
            coco.add("a.png", (8, 6), truths, {1: "a", 2: "b"})
        assert len(read(tmp_path / "a.json")["annotations"]) == count
    coco = datasets.CocoWriter(tmp_path / "b.json", categories=["b", "a"])
    coco.add("a.png", (8, 6), truths, {1: "a"})
    with pytest.raises(sideray.InvalidArgument, match="'c' is none of b, a"):
        coco.add("b.png", (8, 6), truths, {1: "c"})
    with pytest.raises(sideray.InvalidArgument, match="image_id: 1"):
        coco.add("b.png", (8, 6), truths, {1: "a"}, image_id=1)
    with pytest.raises(sideray.InvalidArgument, match="same size"):
        coco.add("b.png", (9, 6), truths, {1: "a"})
    with pytest.raises(sideray.InvalidArgument, match="masks"):
        datasets.CocoWriter(tmp_path / "b.json", masks="png")
    assert not os.path.exists(tmp_path / "b.json")
    with pytest.raises(ZeroDivisionError):
        with datasets.CocoWriter(tmp_path / "b.json"):
            1 / 0
    assert not os.path.exists(tmp_path / "b.json")
    coco.save()
    assert [c["name"] for c in read(tmp_path / "b.json")["categories"]] == ["b", "a"]
    assert read(tmp_path / "b.json")["annotations"][0]["category_id"] == 2


def measured(picture):
    """Depth of what is opaque, of which a sensor has missed some columns."""
    depth = picture.depth.copy()
    depth[:, 30:36] = np.inf
    return depth


def write_bop(renderer, folder, mm_per_unit=100.0):
    scene, wall, card, cut, pane = shelf()
    picture = renderer.render(scene, SIZE, aov="first")
    objects = [datasets.BopObject(1, [card.surface_id], card.transform), datasets.BopObject(1, [cut.surface_id], cut.transform),
               datasets.BopObject(2, [pane.surface_id], np.eye(4))]
    with datasets.BopWriter(folder, split="train", scene_id=3, mm_per_unit=mm_per_unit, depth_scale=0.05) as bop:
        bop.add(scene, scene.camera, picture, picture["first.Z"], objects)
        bop.add(scene, scene.camera, picture.display(), measured(picture), objects, image_id=7)
        bop.add_model(1, *quad(0.0, 0.3))
        bop.add_model(2, *quad(0.5, 0.2), normals=np.tile((0.0, 0.0, 1.0), (4, 1)))
    return scene, picture, (card, cut, pane)


def mask_of(folder, number, index):
    return read_png(folder / "mask" / f"{int(number):06d}_{index:06d}.png")


def test_bop_is_read_back(renderer, tmp_path):
    """By the documented layout: poses project the models' corners onto the corners of their masks, in the middle of pixels."""
    scene, picture, shown = write_bop(renderer, tmp_path)
    folder = tmp_path / "train" / "000003"
    cameras, poses, infos = (read(folder / f"scene_{name}.json") for name in ("camera", "gt", "gt_info"))
    assert list(cameras) == list(poses) == list(infos) == ["0", "7"]
    models = read(tmp_path / "models" / "models_info.json")
    assert models["1"] == pytest.approx({"diameter": 60 * np.sqrt(2), "min_x": -30, "min_y": -30, "min_z": 0, "size_x": 60, "size_y": 60,
                                         "size_z": 0}, rel=1e-12)
    for number in ("0", "7"):
        camera = cameras[number]
        assert camera["depth_scale"] == 0.05
        k = np.reshape(camera["cam_K"], (3, 3))
        assert np.allclose(k, [[90, 0, 32.7], [0, 75, 33.8], [0, 0, 1]])
        rgb, depth = (read_png(folder / kind / f"{int(number):06d}.png") for kind in ("rgb", "depth"))
        assert np.array_equal(rgb, picture.display())
        z = picture["first.Z"] if number == "0" else measured(picture)
        known = np.isfinite(z)
        assert depth.dtype == np.uint16 and np.allclose(depth[known] * 0.05, z[known] * 100, atol=0.0251) and not depth[~known].any()
        # The world's camera: a point of the scene is where it is in the picture, and its depth is that of the image.
        turn, place = np.reshape(camera["cam_R_w2c"], (3, 3)), np.array(camera["cam_t_w2c"])
        assert np.allclose(turn @ turn.T, np.eye(3)) and np.linalg.det(turn) == pytest.approx(1)
        origins, directions = scene.camera.rays(SIZE)
        points = (origins + directions * picture.depth[..., None]) * 100
        seen = points @ turn.T + place
        assert number == "0" or np.allclose(seen[..., 2][known] / 0.05, depth[known], atol=0.51)
        pixels = seen @ k.T
        x, y = np.meshgrid(np.arange(80), np.arange(60))
        assert np.allclose(pixels[..., 0] / pixels[..., 2], x, atol=1e-3) and np.allclose(pixels[..., 1] / pixels[..., 2], y, atol=1e-3)
        first = picture["first.surface"]
        for i, (pose, info, one, corners) in enumerate(zip(poses[number], infos[number], shown, (quad(0, 0.3), quad(0, 0.3), quad(0.5, 0.2)))):
            assert pose["obj_id"] == (1, 1, 2)[i]
            mask, visible = (read_png(folder / kind / f"{int(number):06d}_{i:06d}.png") for kind in ("mask", "mask_visib"))
            assert set(np.unique(mask)) <= {0, 255} and not (visible & ~mask).any()
            assert (np.array_equal(visible > 0, first == one.surface_id))
            at = corners[0] * 100 @ np.reshape(pose["cam_R_m2c"], (3, 3)).T + pose["cam_t_m2c"]
            at = at @ k.T
            at = at[:, :2] / at[:, 2:]
            x0, y0, w, h = info["bbox_obj"]
            # Pixels whose middles, whole numbers, are within the projected square's box.
            assert (x0, y0) == tuple(np.ceil(at.min(0)).astype(int)) and (x0 + w, y0 + h) == tuple(np.floor(at.max(0)).astype(int))
            assert info["px_count_visib"] == (visible > 0).sum() and info["px_count_valid"] == ((mask > 0) & (depth > 0)).sum()
            assert info["visib_fract"] == pytest.approx(info["px_count_visib"] / info["px_count_all"])
            middles = np.stack(np.meshgrid(np.arange(-80, 160), np.arange(-60, 120)), -1)  # beyond the picture too
            sides = np.array([(b - a)[0] * (middles - a)[..., 1] - (b - a)[1] * (middles - a)[..., 0]
                              for a, b in zip(at, np.roll(at, -1, axis=0))])
            silhouette = (sides > 0).all(0) | (sides < 0).all(0)
            assert info["px_count_all"] == silhouette.sum() and np.array_equal(mask > 0, silhouette[60:120, 80:160])
            rows, columns = np.nonzero(visible)
            assert info["bbox_visib"] == [columns.min(), rows.min(), np.ptp(columns), np.ptp(rows)]
        cut = infos[number][1]
        assert (infos[number][0]["px_count_valid"] < np.count_nonzero(mask_of(folder, number, 0))) == (number == "7")
        assert cut["bbox_obj"][0] + cut["bbox_obj"][2] > 80 and cut["px_count_all"] > cut["px_count_valid"] > 0
        assert infos[number][0]["visib_fract"] < 1
    sensor = read(tmp_path / "camera.json")
    assert sensor == pytest.approx({"cx": 32.7, "cy": 33.8, "depth_scale": 0.05, "fx": 90, "fy": 75, "height": 60, "width": 80})
    lines = (tmp_path / "models" / "obj_000001.ply").read_text().splitlines()
    vertices = np.array([line.split() for line in lines[lines.index("end_header") + 1:][:4]], float)
    assert np.allclose(vertices[:, :3], quad(0.0, 0.3)[0] * 100) and np.allclose(vertices[:, 3:], (0, 0, 1))
    assert lines[-1] == "3 0 2 3"


def test_bop_is_what_its_toolkit_reads(renderer, tmp_path):
    toolkit = pytest.importorskip("bop_toolkit_lib.inout", reason="the BOP toolkit is not installed (github.com/thodan/bop_toolkit)")
    from bop_toolkit_lib import misc
    write_bop(renderer, tmp_path)
    folder = tmp_path / "train" / "000003"
    cameras, poses = toolkit.load_scene_camera(folder / "scene_camera.json"), toolkit.load_scene_gt(folder / "scene_gt.json")
    infos = toolkit.load_json(folder / "scene_gt_info.json", keys_to_int=True)
    assert list(cameras) == [0, 7]
    for number in cameras:
        k = cameras[number]["cam_K"]
        depth = toolkit.load_depth(folder / "depth" / f"{number:06d}.png") * cameras[number]["depth_scale"]
        away = misc.depth_im_to_dist_im(depth, k)
        assert toolkit.load_im(folder / "rgb" / f"{number:06d}.png").shape == (60, 80, 3)
        for i, (pose, info) in enumerate(zip(poses[number], infos[number])):
            model = toolkit.load_ply(tmp_path / "models" / f"obj_{pose['obj_id']:06d}.ply")
            diameter = toolkit.load_json(tmp_path / "models" / "models_info.json", keys_to_int=True)[pose["obj_id"]]["diameter"]
            assert misc.calc_pts_diameter(model["pts"]) == pytest.approx(diameter, rel=1e-6)
            at = misc.project_pts(model["pts"], k, pose["cam_R_m2c"], pose["cam_t_m2c"])
            x, y, w, h = info["bbox_obj"]
            assert (np.abs(at.min(0) - (x, y)) <= 1).all() and (np.abs(at.max(0) - (x + w, y + h)) <= 1).all()
            visible = toolkit.load_im(folder / "mask_visib" / f"{number:06d}_{i:06d}.png") > 0
            rows, columns = np.nonzero(visible)
            assert misc.calc_2d_bbox(columns, rows) == info["bbox_visib"]
            # The visible part is where the depth image has the model: its plane, in the toolkit's distances.
            turn, place = pose["cam_R_m2c"], pose["cam_t_m2c"][:, 0]
            normal, on = turn[:, 2], turn @ model["pts"][0] + place
            x, y = np.meshgrid(np.arange(80), np.arange(60))
            rays = np.stack([(x - k[0, 2]) / k[0, 0], (y - k[1, 2]) / k[1, 1], np.ones_like(x, float)], -1)
            expected = (on @ normal) / (rays @ normal) * np.linalg.norm(rays, axis=-1)
            if number == 0:
                assert np.allclose(away[visible], expected[visible], atol=0.05)


def test_bop_refuses_what_it_cannot_say(tmp_path):
    scene, _, card, *_ = shelf()
    rgb, depth = np.zeros((60, 80, 3), np.uint8), np.full((60, 80), np.inf)
    bop = datasets.BopWriter(tmp_path)
    with pytest.raises(sideray.InvalidArgument, match="scales"):
        datasets.BopObject(1, [2], np.diag([2.0, 2, 2, 1]))
    with pytest.raises(sideray.InvalidArgument, match="mirrors"):
        datasets.BopObject(1, [2], np.diag([-1.0, 1, 1, 1]))
    with pytest.raises(sideray.InvalidArgument, match="obj_id"):
        datasets.BopObject(0, [2], np.eye(4))
    with pytest.raises(sideray.InvalidArgument, match="orthographic"):
        bop.add(scene, sideray.Camera(half_height=1.0), rgb, depth, [])
    with pytest.raises(sideray.InvalidArgument, match=re.escape("(60, 80)")):
        bop.add(scene, scene.camera, rgb, depth[1:], [])
    with pytest.raises(sideray.InvalidArgument, match="uint8"):
        bop.add(scene, scene.camera, rgb.astype(float), depth, [])
    with pytest.raises(sideray.InvalidArgument, match="depth_scale"):
        datasets.BopWriter(tmp_path, depth_scale=0)
    # Nothing, what is too far for 16 bits, and what is behind the picture's edge.
    away = np.eye(4)
    away[:3, 3] = (0, 0, 50)
    moved = scene.add_mesh(*quad(), transform=away)
    depth[0, :5] = 6.5535, 6.5536, 6.5539, 0.00004, np.nan
    bop.add(scene, scene.camera, rgb, depth, [datasets.BopObject(1, [moved.surface_id], away)])
    bop.save()
    steps = read_png(tmp_path / "train_pbr" / "000000" / "depth" / "000000.png")
    assert steps[0, :5].tolist() == [65535, 0, 0, 0, 0] and not steps[1:].any()
    (info,) = read(tmp_path / "train_pbr" / "000000" / "scene_gt_info.json")["0"]
    assert info == {"bbox_obj": [-1] * 4, "bbox_visib": [-1] * 4, "px_count_all": 0, "px_count_valid": 0, "px_count_visib": 0,
                    "visib_fract": 0.0}


def test_diameters_are_those_of_all_pairs():
    rng = np.random.default_rng(2)
    for points in (rng.normal(size=(700, 3)), rng.uniform(-1, 1, (1300, 3)) * (3, 1, 0.1), np.zeros((1, 3)), np.eye(3)):
        apart = np.linalg.norm(points[:, None] - points[None], axis=2).max()
        assert _models.diameter(points) == pytest.approx(apart, rel=1e-12)


def test_layered_depth_is_read_back(renderer, tmp_path):
    scene = sideray.load("solids")
    picture, layers = renderer.render(scene, SIZE), scene.layered_depth(SIZE, bent=True, layers=12)
    datasets.LayeredDepthWriter(tmp_path / "out").add("000001", picture, layers, tuples=30, seed=4)
    assert np.array_equal(read_png(tmp_path / "out" / "000001.image.png"), picture.display())
    depth = np.stack([read_png(tmp_path / "out" / f"000001.depth_{k}.png") for k in range(1, 9)])
    z = layers.z.transpose(2, 0, 1)[:8].astype(float)
    assert depth.dtype == np.uint16 and np.array_equal(depth, np.rint(np.where(np.isfinite(z), z, 0) * 1000))
    assert ((depth > 0).sum(0) == np.minimum(layers.count, 8)).all() and (depth[2] > 0).any()
    tuples = read(tmp_path / "out" / "000001.tuples.json")
    assert set(tuples) == {"layer_all", "layer_first"}
    for subset, kinds in tuples.items():
        for name, points in (("pairs", 2), ("trips", 3), ("quads", 4)):
            assert len(kinds[name]) == 30
            for one in kinds[name]:
                assert set(one) == {*(f"p{n}" for n in range(1, points + 1)), "is_real"}
                places = [one[f"p{n}"] for n in range(1, points + 1)]
                values = [int(depth[layer - 1, y, x]) for x, y, layer in places]
                assert all(layer % 2 == 1 and (subset == "layer_all" or layer == 1) for _, _, layer in places)
                assert values[0] > 0 and all(b >= 1.01 * a for a, b in zip(values, values[1:]))
    assert any(layer > 1 for one in tuples["layer_all"]["quads"] for key, (_, _, layer) in list(one.items())[:4])
    # The same call, the same bytes; another seed, other tuples.
    writer = datasets.LayeredDepthWriter(tmp_path / "again")
    writer.add("000001", picture, layers, tuples=30, seed=4)
    for name in os.listdir(tmp_path / "out"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "again" / name).read_bytes(), name
    writer.add("000002", picture, layers, tuples=30, seed=5)
    assert read(tmp_path / "again" / "000002.tuples.json") != tuples
    with pytest.raises(sideray.InvalidArgument, match="one size"):
        writer.add("3", picture, scene.layered_depth((8, 8)))


def test_layers_in_feet_and_fewer_of_them(renderer, tmp_path):
    scene, *_ = shelf()
    picture, layers = renderer.render(scene, SIZE), scene.layered_depth(SIZE, layers=2)
    datasets.LayeredDepthWriter(tmp_path, mm_per_unit=304.8).add("a", picture, layers)
    assert np.array_equal(read_png(tmp_path / "a.depth_1.png"), np.rint(layers.z[..., 0].astype(float) * 304.8).astype(np.uint16))
    assert not read_png(tmp_path / "a.depth_3.png").any() and not os.path.exists(tmp_path / "a.tuples.json")


def test_code_of_the_page(tmp_path, monkeypatch):
    page = pathlib.Path(os.environ.get("SIDERAY_SOURCE", pathlib.Path(__file__).parents[2])) / "docs/ground-truth.md"
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 2
    names = {"np": np}
    for block in blocks:
        exec(compile(block, "docs/ground-truth.md", "exec"), names)
    assert 0 < names["thickness"].mean() < 1
    assert len(read(tmp_path / "annotations.json")["annotations"]) > 3
    assert list(read(tmp_path / "bop/train_pbr/000000/scene_gt.json")) == ["0"]
    assert (tmp_path / "layered/000001.depth_8.png").exists()
