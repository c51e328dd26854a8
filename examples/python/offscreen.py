"""Draws a scene through the C interface with nothing but ctypes: offscreen.py SCENE.glb [WIDTH HEIGHT] [OPTION=VALUE ...]

Options are those of the program (`sideray render --help`), by name: offscreen.py scene.glb 320 180 cache-rate=quarter.
The libraries are found as the system finds libraries, or in the folder that SIDERAY_LIBRARIES names. Prints the mean
radiance; with numpy installed, `picture()` gives arrays that can be reshaped to height x width.
"""

import ctypes
import os
import sys


class Error(ctypes.Structure):
    _fields_ = [("status", ctypes.c_int), ("message", ctypes.c_char * 1020)]


# Structs of sideray 0.3.0. Later versions add fields at their end; their libraries read the size that is set here,
# and write no more than that.
class Camera(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("world_from_camera", ctypes.c_double * 12),
                ("orthographic", ctypes.c_int32), ("yfov", ctypes.c_float), ("half_height", ctypes.c_float),
                ("z_near", ctypes.c_float), ("z_far", ctypes.c_float)]


class RendererDesc(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("gl", ctypes.c_char_p), ("device", ctypes.c_char_p),
                ("threads", ctypes.c_uint32), ("isa", ctypes.c_char_p), ("host", ctypes.c_void_p)]


class Channel(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("type", ctypes.c_int), ("values", ctypes.POINTER(ctypes.c_float))]


def load(name):
    folder = os.environ.get("SIDERAY_LIBRARIES")
    return ctypes.CDLL(os.path.join(folder, name) if folder else name)


sideray, scenes = load("libsideray.so.0.3"), load("libsideray_scenes.so.0.3")
sideray.sideray_options_render.restype = ctypes.c_void_p
sideray.sideray_options_render.argtypes = [ctypes.c_void_p]
sideray.sideray_picture_channel_count.restype = ctypes.c_size_t
sideray.sideray_picture_channel_count.argtypes = [ctypes.c_void_p]
sideray.sideray_picture_channel.restype = ctypes.POINTER(Channel)
sideray.sideray_picture_channel.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
scenes.sideray_content_camera.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_float, ctypes.c_void_p,
                                          ctypes.c_void_p]


def call(function, *arguments):
    error = Error()
    if function(*arguments, ctypes.byref(error)) != 0:
        raise RuntimeError(error.message.decode())


def defaults(struct, init):
    """A struct with the defaults of every field that it has."""
    init.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
    filled = struct()
    init(ctypes.byref(filled), ctypes.sizeof(filled))
    return filled


def picture(scene_name, width=320, height=180, **options):
    """Channels by name: sequences of width * height floats, top row first. Options: cache_rate="quarter", ..."""
    content, scene, renderer, chosen, drawn = (ctypes.c_void_p() for _ in range(5))
    camera = defaults(Camera, sideray.sideray_camera_init)
    desc = defaults(RendererDesc, sideray.sideray_renderer_init)
    try:
        call(sideray.sideray_options_create, ctypes.byref(chosen))
        for name, value in {"size": f"{width}x{height}", **options}.items():
            call(sideray.sideray_options_set, chosen, name.replace("_", "-").encode(), str(value).encode())
        call(sideray.sideray_options_check, chosen)
        call(scenes.sideray_content_load, scene_name.encode(), None, ctypes.byref(content))
        call(scenes.sideray_content_camera, content, 0, width / height, ctypes.byref(camera))
        call(sideray.sideray_scene_create, ctypes.byref(scene))
        call(scenes.sideray_content_fill, content, None, scene)
        call(sideray.sideray_renderer_create, ctypes.byref(desc), ctypes.byref(renderer))
        call(sideray.sideray_renderer_render, renderer, scene, ctypes.byref(camera),
             ctypes.c_void_p(sideray.sideray_options_render(chosen)), ctypes.byref(drawn))
        channels = {}
        for index in range(sideray.sideray_picture_channel_count(drawn)):
            channel = sideray.sideray_picture_channel(drawn, index).contents
            channels[channel.name.decode()] = channel.values[:width * height]
        return channels
    finally:
        # All of these accept NULL.
        sideray.sideray_picture_release(drawn)
        sideray.sideray_renderer_destroy(renderer)
        sideray.sideray_scene_release(scene)
        scenes.sideray_content_release(content)
        sideray.sideray_options_release(chosen)


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if "=" not in word]
    if len(words) not in (1, 3):
        sys.exit(__doc__.splitlines()[0])
    named = dict(word.split("=", 1) for word in sys.argv[1:] if "=" in word)
    drawn = picture(words[0], *map(int, words[1:]), **named)
    print("mean radiance", *(f"{sum(drawn[c]) / len(drawn[c]):.4f}" for c in "RGB"))
