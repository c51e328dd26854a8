#!/usr/bin/env python3
"""Uses the whole package once, each call with its types: tour.py FOLDER

Draws a glass ball on a floor, with its channels, its ground truth, many pictures, rays, comparisons and data sets, and writes
them into FOLDER. trimesh and mujoco are used where they are installed. Type checkers find nothing in it, in strict mode:
mypy --strict tour.py; pyright, with "typeCheckingMode": "strict".
"""

import importlib
import importlib.util
import pathlib
import pickle
import sys
from typing import Any, Dict, List

import numpy as np
from numpy.typing import NDArray

import sideray
from sideray import datasets

SIZE = (96, 72)


def ball(radius: float, parts: int) -> Dict[str, NDArray[Any]]:
    """Positions and normals of a sphere, three vertices a triangle."""
    around = np.linspace(0.0, 2.0 * np.pi, 2 * parts + 1)
    down = np.linspace(0.0, np.pi, parts + 1)
    grid: NDArray[Any] = np.stack([np.sin(down)[:, None] * np.cos(around), np.repeat(np.cos(down)[:, None], len(around), 1),
                     -np.sin(down)[:, None] * np.sin(around)], -1)
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    normals = np.stack([a, b, c, a, c, d], 2).reshape(-1, 3)
    return {"positions": radius * normals, "normals": normals}


def make_scene() -> sideray.Scene:
    scene = sideray.Scene(env="sky", env_scale=0.8, env_rotate=30.0)
    checks = scene.add_texture(np.kron([[0, 1], [1, 0]], np.ones((16, 16))))
    floor: Dict[str, Any] = {"base_color_texture": checks, "roughness": 0.9}
    scene.add_mesh([[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]], [[0, 1, 2], [0, 2, 3]],
                   uv=[[0, 0], [2, 0], [2, 2], [0, 2]], material=floor, name="floor")
    glass = scene.add_material(transmission=1.0, ior=1.5, thickness=0.8, roughness=0.0)
    shape = ball(0.4, 24)
    mesh = scene.add_geometry(shape["positions"], normals=shape["normals"])
    place = np.eye(4)
    place[1, 3] = 0.4
    scene.add_instance(mesh, material=glass, transform=place, name="ball")
    scene.add_light("point", position=(1, 3, 2), intensity=(20, 19, 17), radius=0.1)
    sparks = scene.add_particles(blend_mode="additive")
    sparks.set([[0.8, 0.5, 0.0]], sizes=0.1, colors=[[1.0, 0.6, 0.2, 1.0]])
    scene.camera = sideray.Camera.look_at((1.5, 1.0, 2.0), (0.0, 0.3, 0.0), fov=40.0)
    return scene


def draw(scene: sideray.Scene, folder: pathlib.Path) -> sideray.Picture:
    with sideray.Renderer(gl="none", threads=0) as renderer:
        picture = renderer.render(scene, SIZE, aov="N,first,glass,behind,refraction", samples=2, shadows="exact",
                                  ambient="bounce", reflections=True)
        picture.save(folder / "picture.png")
        picture.save(folder / "picture.exr")
        depth: NDArray[np.float32] = picture.depth
        ids: NDArray[np.uint32] = picture.ids
        print(renderer.device["renderer"], picture.size, picture.rgb.dtype, float(depth[60, 48]), int(ids[60, 48]))
        print(len(picture.channels), "channels,", picture.stats["triangles"], "triangles,", picture.times["total_frame"][1], "ms")
        again: sideray.Picture = pickle.loads(pickle.dumps(picture))
        assert np.array_equal(again["N"], picture["N"])

        cameras: List[sideray.Camera] = [sideray.Camera.look_at((np.sin(a), 1.0, np.cos(a)), (0.0, 0.3, 0.0)) for a in (0.0, 0.5)]
        pictures = renderer.render_many(scene, cameras, (32, 24))
        shown: NDArray[np.uint8] = pictures.display()
        print(shown.shape, pictures["Z"].shape, pictures[0].size, len(pictures[:1]))
        for frame in renderer.frames(scene, range(2), (32, 24), fps=30, samples=1):
            print(frame.depth.shape)
        reference = renderer.render(scene, SIZE, reference=True, light_samples=2)
        difference = sideray.compare(picture, reference)
        print("FLIP", round(difference.metrics["flip"], 3), None if difference.flip_map is None else difference.flip_map.shape)
    return picture


def find_truth(scene: sideray.Scene, picture: sideray.Picture, folder: pathlib.Path) -> None:
    camera = scene.get_camera(aspect=SIZE[0] / SIZE[1])
    origins, directions = camera.rays(SIZE)
    hits = scene.trace_rays(origins, directions, translucent=True, layers=2)
    print("rays", hits["distance"].shape, camera.intrinsics(SIZE)[0, 0])
    layers = scene.layered_depth(SIZE, bent=True)
    print("layers", layers.z.shape, int(layers.count[36, 48]), bool(layers.translucent[36, 48, 0]))
    objects = scene.object_truth(SIZE)
    for truth in objects:
        print(scene.names[truth.object], truth.visible.box, truth.amodal.area, round(truth.visible_fraction, 3))
    with datasets.CocoWriter(folder / "annotations.json", amodal=True) as coco:
        coco.add("picture.png", SIZE, objects, scene.names)
    with datasets.BopWriter(folder / "bop", mm_per_unit=1000.0) as bop:
        bop.add(scene, camera, picture, picture["first.Z"], [datasets.BopObject(1, [2], world_from_model=np.eye(4))])
    datasets.LayeredDepthWriter(folder / "layered").add("000001", picture, layers, tuples=4)


def refuse(scene: sideray.Scene) -> None:
    try:
        sideray.Renderer(gl="none").render(scene, SIZE, "none of that name")
    except sideray.InvalidArgument as error:
        print(error.status, error)
    print(len(sideray.option_names()), sideray.option("shadows")["choices"], len(sideray.devices()) >= 0)


def others(folder: pathlib.Path) -> None:
    """Scenes of other packages."""
    if importlib.util.find_spec("trimesh"):
        trimesh: Any = importlib.import_module("trimesh")
        scene = sideray.Scene.from_trimesh(trimesh.creation.box(), smooth=False)
        sideray.Renderer(gl="none").render(scene, (32, 24)).save(folder / "trimesh.png")
    if importlib.util.find_spec("mujoco"):
        from sideray.mujoco import Renderer

        mujoco: Any = importlib.import_module("mujoco")
        model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='.2'/></worldbody></mujoco>")
        with Renderer(model, 24, 32, batch=2) as renderer:
            renderer.update_scene([mujoco.MjData(model), mujoco.MjData(model)])
            observations: Dict[str, NDArray[Any]] = renderer.render_channels(("rgb", "depth"))
            sideray.save_png(folder / "mujoco.png", observations["rgb"][0])


def main() -> None:
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "tour")
    folder.mkdir(parents=True, exist_ok=True)
    scene = make_scene()
    picture = draw(scene, folder)
    find_truth(scene, picture, folder)
    refuse(scene)
    others(folder)


if __name__ == "__main__":
    main()
