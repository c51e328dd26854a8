"""BOP: pictures, depth, masks and poses for benchmarks of 6D object pose."""

from __future__ import annotations

import dataclasses
import os
from types import TracebackType
from typing import Any, Dict, List, Optional, Sequence, Tuple, Type, Union

import numpy as np

from .._arrays import Array
from .._camera import Camera, matrix
from .._errors import InvalidArgument
from .._picture import Picture
from .._scene import Scene
from . import _files, _models

# OpenCV's camera looks along +Z with +Y down, Sideray's along -Z with +Y up.
_CV_FROM_CAMERA = np.diag([1.0, -1.0, -1.0])
_LONGEST_SIDE = 16384  # of a picture


@dataclasses.dataclass(frozen=True, eq=False)
class BopObject:
    """An object of a picture, whose pose is told.

    obj_id: of its model, from 1 on. surfaces: surface ids of what it is made of in the scene. world_from_model: (4, 4), a rotation and
    a place in world units: where the model's own coordinates are in the scene.
    """

    obj_id: int
    surfaces: Sequence[int]
    world_from_model: Array

    def __post_init__(self) -> None:
        placed = matrix(self.world_from_model, "world_from_model")
        turn = placed[:3, :3]
        if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-5) or np.linalg.det(turn) < 0:
            raise InvalidArgument(f"world_from_model of object {self.obj_id}: it scales, shears or mirrors; poses are a rotation and a "
                                  "place: put the scale into the model")
        if int(self.obj_id) < 1:
            raise InvalidArgument(f"obj_id: {self.obj_id}; give 1 or more")
        object.__setattr__(self, "world_from_model", placed)


class BopWriter:
    """Writes one scene of a data set in the layout of BOP.

    folder: of the data set. split: the name of the part, such as "train_pbr" or "test". scene_id: pictures of one folder share it.
    mm_per_unit: how long the scene's unit is. depth_scale: millimetres of a step of the 16-bit depth images; what lies beyond 65535
    steps, and where there is no depth, is written as 0. through_glass: opaque surfaces alone hide what is straight behind them.
    """

    def __init__(self, folder: Union[str, "os.PathLike[str]"], *, split: str = "train_pbr", scene_id: int = 0,
                 mm_per_unit: float = 1000.0, depth_scale: float = 0.1, through_glass: bool = False) -> None:
        self._root = os.fspath(folder)
        self._folder = os.path.join(self._root, split, f"{scene_id:06d}")
        self._mm = _files.positive(mm_per_unit, "mm_per_unit")
        self._step = _files.positive(depth_scale, "depth_scale")
        self._through_glass = through_glass
        self._cameras: Dict[str, Any] = {}
        self._poses: Dict[str, List[Dict[str, Any]]] = {}
        self._infos: Dict[str, List[Dict[str, Any]]] = {}
        self._models: Dict[str, Dict[str, float]] = {}
        self._sensor: Optional[Dict[str, float]] = None

    def add(self, scene: Scene, camera: Camera, rgb: Union[Picture, Array], depth: Array, objects: Sequence[BopObject], *,
            image_id: Optional[int] = None) -> int:
        """Adds a picture with its depth, masks and poses, and returns its id; image files are written at once.

        camera: a perspective one, of the picture. rgb: a Picture, or (height, width, 3) uint8. depth: (height, width), distance along
        the view axis in world units: Picture.depth sees through glass, picture["first.Z"] stops at it. image_id: where it is not
        given, pictures count from 0.
        """
        shown = _files.colors(rgb)
        height, width = shown.shape[:2]
        if np.shape(depth) != (height, width):
            raise InvalidArgument(f"depth: the array has the shape {np.shape(depth)}; give ({height}, {width}), that of rgb")
        number = image_id if image_id is not None else len(self._cameras)
        if str(number) in self._cameras:
            raise InvalidArgument(f"image_id: {number} is another picture's; give each its own")
        k = camera.intrinsics((width, height))
        steps = _files.millimetres(depth, self._step, self._mm)
        _files.write_png(self._path("rgb", f"{number:06d}"), shown)
        _files.write_png(self._path("depth", f"{number:06d}"), steps)
        self._infos[str(number)] = self._masks(scene, camera, k, (width, height), steps > 0, objects, number)
        self._cameras[str(number)] = self._camera_of(camera, k)
        self._poses[str(number)] = [self._pose(camera, one) for one in objects]
        if self._sensor is None:
            self._sensor = {"cx": k[0, 2] - 0.5, "cy": k[1, 2] - 0.5, "depth_scale": self._step, "fx": k[0, 0], "fy": k[1, 1],
                            "height": height, "width": width}
        return number

    def add_model(self, obj_id: int, positions: Array, triangles: Array, normals: Optional[Array] = None) -> None:
        """Writes models/obj_NNNNNN.ply, and remembers its size and diameter for models_info.json.

        positions: (n, 3) in the model's coordinates, world units; triangles: (m, 3); normals: (n, 3), those of the triangles around
        each vertex where they are not given.
        """
        points = np.asarray(positions, np.float64) * self._mm
        faces = np.asarray(triangles, np.int64).reshape(-1, 3)
        _files.write_whole(os.path.join(self._root, "models", f"obj_{obj_id:06d}.ply"), _models.ply(points, faces, normals))
        self._models[str(obj_id)] = _models.info(points)

    def save(self) -> None:
        """Writes the JSON files of what was added so far. The end of a `with` calls it."""
        for name, content in (("scene_camera", self._cameras), ("scene_gt", self._poses), ("scene_gt_info", self._infos)):
            _files.write_json(os.path.join(self._folder, name + ".json"), content)
        if self._sensor:
            _files.write_json(os.path.join(self._root, "camera.json"), self._sensor)
        if self._models:
            _files.write_json(os.path.join(self._root, "models", "models_info.json"), self._models)

    def __enter__(self) -> BopWriter:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]) -> None:
        if kind is None:
            self.save()

    def _path(self, kind: str, name: str) -> str:
        return os.path.join(self._folder, kind, name + ".png")

    def _camera_of(self, camera: Camera, k: Array) -> Dict[str, Any]:
        # BOP counts from the middle of the first pixel, as OpenCV does.
        from_middle = k - np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
        turn, place = self._in_camera(camera, np.eye(4))
        return {"cam_K": from_middle.ravel().tolist(), "depth_scale": self._step, "cam_R_w2c": turn.ravel().tolist(),
                "cam_t_w2c": place.tolist()}

    def _pose(self, camera: Camera, one: BopObject) -> Dict[str, Any]:
        turn, place = self._in_camera(camera, one.world_from_model)
        return {"cam_R_m2c": turn.ravel().tolist(), "cam_t_m2c": place.tolist(), "obj_id": int(one.obj_id)}

    def _in_camera(self, camera: Camera, world_from_model: Array) -> Tuple[Array, Array]:
        """Rotation and millimetres in OpenCV's camera."""
        in_camera = np.linalg.inv(camera.world_from_camera) @ world_from_model
        return _CV_FROM_CAMERA @ in_camera[:3, :3], _CV_FROM_CAMERA @ in_camera[:3, 3] * self._mm

    def _masks(self, scene: Scene, camera: Camera, k: Array, size: Tuple[int, int], has_depth: Array,
               objects: Sequence[BopObject], number: int) -> List[Dict[str, Any]]:
        """Writes the masks of all objects, and returns what scene_gt_info.json says of them. Silhouettes reach beyond the picture: as
        the toolkit does, they are counted on a canvas of three times its width and height."""
        if not objects:
            return []
        width, height = size
        right, down = min(width, (_LONGEST_SIDE - width) // 2), min(height, (_LONGEST_SIDE - height) // 2)
        canvas = (width + 2 * right, height + 2 * down)
        around = Camera.from_intrinsics(camera.world_from_camera, k[0, 0], k[1, 1], k[0, 2] + right, k[1, 2] + down, canvas,
                                        z_near=camera.z_near, z_far=camera.z_far)
        found = scene.object_truth(canvas, around, samples_per_side=1, through_glass=self._through_glass,
                                   objects={i: one.surfaces for i, one in enumerate(objects, 1)})
        picture = np.s_[down:down + height, right:right + width]
        infos = []
        for i, truth in enumerate(found):
            whole, visible = truth.amodal.pixels, truth.visible.pixels[picture]
            mask = whole[picture]
            _files.write_png(self._path("mask", f"{number:06d}_{i:06d}"), np.where(mask, np.uint8(255), np.uint8(0)))
            _files.write_png(self._path("mask_visib", f"{number:06d}_{i:06d}"), np.where(visible, np.uint8(255), np.uint8(0)))
            seen, pixels = int(visible.sum()), int(whole.sum())
            infos.append({
                "bbox_obj": _box(whole, right, down) if seen else [-1] * 4, "bbox_visib": _box(visible, 0, 0) if seen else [-1] * 4,
                "px_count_all": pixels, "px_count_valid": int((mask & has_depth).sum()), "px_count_visib": seen,
                "visib_fract": seen / pixels if pixels else 0.0})
        return infos


def _box(mask: Array, left: int, above: int) -> List[int]:
    """As the toolkit has it: width and height are from the first to the last pixel's number, one less than there are."""
    rows, columns = np.nonzero(mask.any(axis=1))[0], np.nonzero(mask.any(axis=0))[0]
    return [int(columns[0]) - left, int(rows[0]) - above, int(columns[-1] - columns[0]), int(rows[-1] - rows[0])]
