"""Sideray: pictures with ray-traced glass, and their ground truth, without a window, a display or a GPU.

    import sideray
    scene = sideray.load("scene.glb")
    picture = sideray.Renderer().render(scene, size=(1280, 720))
    picture.save("picture.png")
    print(picture.depth.min(), picture.ids.max())

Arrays are numpy's, (height, width) or (height, width, channels), top row first; colours are linear Rec.709, lengths world
units, transforms (4, 4) matrices that columns are multiplied by. Failures are sideray.Error. docs/python.md is the manual.
"""

from . import _interpreter  # first: says why the extension cannot be loaded
from ._camera import Camera
from ._errors import (DeviceFailed, Error, InvalidArgument, NoDevice, OutOfMemory, SceneNotFound, UnknownChannel,
                      Unsupported)
from ._images import Comparison, compare, read_image, save_png
from ._layered import LayeredDepth, SurfaceFace, SurfaceKind
from ._load import load
from ._native import version as _version
from ._objects import (VISIBLE_ALL, VISIBLE_AO, VISIBLE_LAYERS, VISIBLE_REFLECTION, VISIBLE_SHADOW, Object,
                       Particles)
from ._offscreen import OffscreenRenderer, RenderFlags
from ._picture import Picture
from ._pictures import Pictures
from ._renderer import Renderer, devices, option, option_names
from ._scene import Scene
from ._truth import Mask, ObjectTruth
from . import datasets  # after what it is made of

__version__ = _version()

__all__ = [
    "Camera", "Comparison", "DeviceFailed", "Error", "InvalidArgument", "LayeredDepth", "Mask", "NoDevice", "Object",
    "ObjectTruth", "OffscreenRenderer", "OutOfMemory", "Particles", "Picture", "Pictures", "RenderFlags", "Renderer",
    "Scene", "SceneNotFound", "SurfaceFace", "SurfaceKind", "UnknownChannel", "Unsupported", "VISIBLE_ALL",
    "VISIBLE_AO", "VISIBLE_LAYERS", "VISIBLE_REFLECTION", "VISIBLE_SHADOW", "compare", "datasets", "devices", "load",
    "option", "option_names", "read_image", "save_png",
]
