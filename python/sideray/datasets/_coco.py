"""Instances of COCO: one JSON file of boxes and masks of every object."""

from __future__ import annotations

import os
from types import TracebackType
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Type, Union

from .._errors import InvalidArgument
from .._truth import Mask, ObjectTruth
from . import _files, _masks


class CocoWriter:
    """Collects annotations of pictures, and writes them as one file of COCO's instances.

    path: of the JSON file. masks: how they are written: "rle" (compressed, a text), "counts" (the same as a list) or "polygon"
    (outlines along the edges of pixels). amodal: annotations hold amodal_area, amodal_bbox and amodal_segmentation too, what would be
    seen of the object if there were nothing else. hidden: objects of which nothing is seen have annotations too, where their amodal
    mask holds pixels. categories: names in the order of their ids, from 1 on; where they are not given, ids are in the order in which
    names first come.
    """

    def __init__(self, path: Union[str, "os.PathLike[str]"], *, masks: str = "rle", amodal: bool = False, hidden: bool = False,
                 categories: Optional[Sequence[str]] = None) -> None:
        if masks not in ("rle", "counts", "polygon"):
            raise InvalidArgument(f"masks: {masks!r}; give \"rle\", \"counts\" or \"polygon\"")
        self._path, self._masks, self._amodal, self._hidden = os.fspath(path), masks, amodal, hidden
        self._are_fixed = categories is not None
        self._categories: Dict[str, int] = {name: i for i, name in enumerate(categories or (), 1)}
        self._images: List[Dict[str, Any]] = []
        self._annotations: List[Dict[str, Any]] = []

    def add(self, file_name: str, size: Tuple[int, int], objects: Sequence[ObjectTruth], categories: Mapping[int, str], *,
            image_id: Optional[int] = None, image: Optional[Mapping[str, Any]] = None,
            details: Optional[Mapping[int, Mapping[str, Any]]] = None) -> int:
        """Adds a picture with its objects, and returns its id.

        file_name: of the picture, as readers are to find it. size: its (width, height). objects: of Scene.object_truth. categories:
        the name of each object's category by its number; objects that are not in it have no annotation. image_id: where it is not
        given, pictures count from 1. image: further entries of the picture. details: further entries of annotations, by object.
        """
        number = image_id if image_id is not None else len(self._images) + 1
        if any(known["id"] == number for known in self._images):
            raise InvalidArgument(f"image_id: {number} is another picture's; give each its own")
        for one in objects:
            if tuple(one.visible.size) != tuple(size):
                raise InvalidArgument(f"objects: their masks are of a picture of {one.visible.size}, and this one is of {tuple(size)}; "
                                      "ask for Scene.object_truth of the same size")
        annotations = [self._annotation(one, number, categories[one.object], (details or {}).get(one.object, {}))
                       for one in objects if one.object in categories and self._is_wanted(one)]
        for i, annotation in enumerate(annotations, len(self._annotations) + 1):
            annotation["id"] = i
        self._images.append({"id": number, "file_name": file_name, "width": int(size[0]), "height": int(size[1]), **(image or {})})
        self._annotations += annotations
        return number

    def save(self) -> None:
        """Writes what was added so far. The end of a `with` calls it."""
        _files.write_json(self._path, {
            "info": {"description": "made with Sideray"}, "licenses": [], "images": self._images,
            "categories": [{"id": i, "name": name, "supercategory": ""} for name, i in self._categories.items()],
            "annotations": self._annotations})

    def __enter__(self) -> CocoWriter:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]) -> None:
        if kind is None:
            self.save()

    def _is_wanted(self, one: ObjectTruth) -> bool:
        return one.visible.area > 0 or (self._hidden and one.amodal.area > 0)

    def _annotation(self, one: ObjectTruth, image: int, category: str, details: Mapping[str, Any]) -> Dict[str, Any]:
        annotation = {"id": 0, "image_id": image, "category_id": self._category(category), "iscrowd": 0, "area": int(one.visible.area),
                      "bbox": [int(part) for part in one.visible.box], "segmentation": self._segmentation(one.visible)}
        if self._amodal:
            annotation.update(amodal_area=int(one.amodal.area), amodal_bbox=[int(part) for part in one.amodal.box],
                              amodal_segmentation=self._segmentation(one.amodal))
        annotation.update(coverage=one.coverage, visible_fraction=one.visible_fraction, **details)
        return annotation

    def _segmentation(self, mask: Mask) -> Any:
        if self._masks == "polygon":
            return _masks.polygons(mask.pixels)
        coco = mask.coco
        return coco if self._masks == "counts" else {"size": coco["size"], "counts": _masks.compressed(mask.runs)}

    def _category(self, name: str) -> int:
        if name not in self._categories:
            if self._are_fixed:
                raise InvalidArgument(f"categories: {name!r} is none of {', '.join(self._categories)}; name it at the writer, or not here")
            self._categories[name] = len(self._categories) + 1
        return self._categories[name]
