"""Draws a scene through the C interface with nothing but ctypes: offscreen.py SCENE [WIDTH HEIGHT]

The libraries are found as the system finds libraries, or in the folder that SIDERAY_LIBRARIES names. Prints the mean
radiance; with numpy installed, `picture()` gives an array of height x width x 3.
"""

import ctypes
import os
import sys


class Error(ctypes.Structure):
    _fields_ = [("status", ctypes.c_int), ("message", ctypes.c_char * 1020)]


class Camera(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("world_from_camera", ctypes.c_double * 12),
                ("orthographic", ctypes.c_int32), ("yfov", ctypes.c_float), ("half_height", ctypes.c_float),
                ("z_near", ctypes.c_float), ("z_far", ctypes.c_float)]


# What is not named stays as the defaults function wrote it. `rest` is larger than any version's.
class Options(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("width", ctypes.c_uint32), ("height", ctypes.c_uint32),
                ("rest", ctypes.c_ubyte * 4096)]


class Desc(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("rest", ctypes.c_ubyte * 4096)]


class Channel(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("type", ctypes.c_int), ("values", ctypes.POINTER(ctypes.c_float))]


def load(name):
    folder = os.environ.get("SIDERAY_LIBRARIES")
    return ctypes.CDLL(os.path.join(folder, name) if folder else name)


sideray, scenes = load("libsideray.so"), load("libsideray_scenes.so")
sideray.sideray_render_defaults.restype = Options
sideray.sideray_renderer_defaults.restype = Desc
sideray.sideray_picture_channel_count.restype = ctypes.c_size_t
sideray.sideray_picture_channel.restype = Channel
sideray.sideray_picture_channel.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
scenes.sideray_content_camera.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_float, ctypes.c_void_p,
                                          ctypes.c_void_p]


def call(function, *arguments):
    error = Error()
    if function(*arguments, ctypes.byref(error)) != 0:
        raise RuntimeError(error.message.decode())


def picture(scene_name, width=320, height=180):
    """Channels by name: sequences of width * height floats, top row first."""
    options = sideray.sideray_render_defaults()
    options.width, options.height = width, height
    content, scene, renderer, drawn = (ctypes.c_void_p() for _ in range(4))
    camera = Camera()
    call(scenes.sideray_content_load, scene_name.encode(), None, ctypes.byref(content))
    call(scenes.sideray_content_camera, content, 0, width / height, ctypes.byref(camera))
    call(sideray.sideray_scene_create, ctypes.byref(scene))
    call(scenes.sideray_content_fill, content, None, scene)
    desc = sideray.sideray_renderer_defaults()
    call(sideray.sideray_renderer_create, ctypes.byref(desc), ctypes.byref(renderer))
    call(sideray.sideray_renderer_render, renderer, scene, ctypes.byref(camera), ctypes.byref(options),
         ctypes.byref(drawn))
    channels = {}
    for index in range(sideray.sideray_picture_channel_count(drawn)):
        channel = sideray.sideray_picture_channel(drawn, index)
        channels[channel.name.decode()] = channel.values[:width * height]
    sideray.sideray_picture_release(drawn)
    sideray.sideray_renderer_destroy(renderer)
    sideray.sideray_scene_release(scene)
    scenes.sideray_content_release(content)
    return channels


if __name__ == "__main__":
    if len(sys.argv) not in (2, 4):
        sys.exit(__doc__.splitlines()[0])
    drawn = picture(sys.argv[1], *map(int, sys.argv[2:]))
    print("mean radiance", *(f"{sum(drawn[c]) / len(drawn[c]):.4f}" for c in "RGB"))
