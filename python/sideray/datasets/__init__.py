"""Writers of data sets: pictures and their ground truth in the layouts that other tools read.

    from sideray import datasets
    with datasets.CocoWriter("annotations.json", amodal=True) as coco:
        coco.add("rgb/000001.png", size, scene.object_truth(size), scene.names)

CocoWriter: instances of COCO. BopWriter: poses, depth and masks of BOP. LayeredDepthWriter: layers of LayeredDepth. Each is a
context manager: what is collected is written when it ends without an error. The same calls write the same bytes.
docs/ground-truth.md (Data sets) defines every figure.
"""

from ._bop import BopObject, BopWriter
from ._coco import CocoWriter
from ._layered_depth import LayeredDepthWriter

__all__ = ["BopObject", "BopWriter", "CocoWriter", "LayeredDepthWriter"]
