"""Threads: several renderers at once, one renderer from many, Python that runs on meanwhile; and no growth."""

import gc
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import plain_scene

import sideray


def in_threads(*functions):
    failures = []

    def guarded(function):
        try:
            function()
        except BaseException as error:  # noqa: B902: it is raised again below
            failures.append(error)

    threads = [threading.Thread(target=guarded, args=(function,)) for function in functions]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]


def test_two_renderers_in_two_threads(renderer):
    scene = sideray.load("panes")
    expected = renderer.render(scene, (48, 27), shadows="exact").rgb
    drawn = [[], []]

    def draw(pictures):
        with sideray.Renderer() as own:
            for _ in range(4):
                pictures.append(own.render(scene, (48, 27), shadows="exact").rgb)

    in_threads(lambda: draw(drawn[0]), lambda: draw(drawn[1]))
    assert all(np.array_equal(rgb, expected) for pictures in drawn for rgb in pictures)


def test_one_renderer_from_many_threads(renderer):
    scenes = [plain_scene(base_color=(k / 4, 1, 1), unlit=True) for k in range(4)]

    def draw(k):
        for _ in range(5):
            assert renderer.render(scenes[k], (24, 24)).rgb[12, 12, 0] == pytest.approx(k / 4, abs=1e-3)

    in_threads(*(lambda k=k: draw(k) for k in range(4)))


def test_queries_while_another_thread_renders(renderer):
    scene = sideray.load("panes")
    expected = scene.trace_rays((0, 0, 5), (0, 0, -1))

    def ask():
        for _ in range(50):
            assert scene.trace_rays((0, 0, 5), (0, 0, -1)) == expected

    in_threads(ask, lambda: [renderer.render(scene, (32, 18)) for _ in range(5)])


def test_python_goes_on_while_a_picture_is_drawn(renderer):
    scene = sideray.load("panes")
    turns, is_drawn = [], threading.Event()

    def count():
        while not is_drawn.is_set():
            turns.append(time.perf_counter())
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    begin = time.perf_counter()
    renderer.render(scene, (128, 72), reference=True, light_samples=32)
    end = time.perf_counter()
    is_drawn.set()
    counter.join()
    # Held, the lock would let the other thread in before and after the call alone.
    middle = [t for t in turns if begin + 0.2 * (end - begin) < t < end - 0.2 * (end - begin)]
    assert len(middle) >= 3


@pytest.mark.parametrize("ending", ["", "terminate()", "terminate(); renderer.close()", "os._exit(0)",
                                    "os.kill(os.getpid(), signal.SIGKILL)"])
def test_processes_end_whatever_happened(ending):
    script = """
import ctypes, os, signal
import sideray
renderer = sideray.Renderer()
picture = renderer.render(sideray.Scene(), (8, 8))
def terminate():  # as other libraries do with the display that all share
    egl = ctypes.CDLL("libEGL.so.1")
    find = egl.eglGetProcAddress
    find.restype, find.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    devices, count = (ctypes.c_void_p * 16)(), ctypes.c_int()
    ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(find(b"eglQueryDevicesEXT"))(
        16, devices, ctypes.byref(count))
    display_of = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_uint, ctypes.c_void_p, ctypes.c_void_p)(
        find(b"eglGetPlatformDisplayEXT"))
    egl.eglTerminate.argtypes = [ctypes.c_void_p]
    for device in devices[:count.value]:
        egl.eglTerminate(display_of(0x313F, device, None))
"""
    run = subprocess.run([sys.executable, "-B", "-c", script + ending], capture_output=True, text=True, timeout=120)
    assert run.returncode == (-9 if "SIGKILL" in ending else 0), run.stderr


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def growth(frames, draw):
    """Bytes that the process grew by over the second half of so many frames."""
    for _ in range(frames // 2):
        draw()
    gc.collect()
    before = resident_bytes()
    for _ in range(frames - frames // 2):
        draw()
    gc.collect()
    return resident_bytes() - before


def frame(renderer):
    """A scene that is made, changed, drawn, asked and thrown away; pictures of 64 x 64 hold 115 kB."""
    scene = plain_scene()
    scene.add_texture(np.zeros((16, 16, 3), np.uint8))
    picture = renderer.render(scene, (64, 64))
    scene.trace_rays((0, 0, 3), (0, 0, -1))
    assert picture.rgb[32, 32].min() > 0 and picture.ids[32, 32] == 1


def test_short_runs_do_not_grow(renderer):
    # 80 frames that leaked their pictures alone would be 9 MB.
    assert growth(160, lambda: frame(renderer)) < 4 << 20


def test_queries_of_new_scenes_do_not_grow():
    def ask():
        assert plain_scene().trace_rays((0, 0, 3), (0, 0, -1))["surface_id"] == 1

    # Threads' arenas that are made anew for each would be 7 kB each, 1.8 MB.
    assert growth(500, ask) < 1 << 20


@pytest.mark.skipif("SIDERAY_SLOW" not in os.environ, reason="10,000 frames: SIDERAY_SLOW=1 draws them")
def test_long_runs_do_not_grow(renderer):
    assert growth(10000, lambda: frame(renderer)) < 4 << 20


def test_renderers_do_not_leave_anything():
    scene = plain_scene()

    def draw():
        with sideray.Renderer() as own:
            own.render(scene, (32, 32))

    draw()
    assert growth(12, draw) < 24 << 20


def test_a_picture_can_be_cancelled_by_another_thread(renderer):
    scene = sideray.load("solids")
    expected = renderer.render(scene, (48, 27)).rgb
    ended = threading.Event()

    def cancel():
        while not ended.wait(0.001):
            renderer.cancel()

    thread = threading.Thread(target=cancel)
    thread.start()
    try:
        with pytest.raises(sideray.Error, match="cancelled"):
            renderer.render(scene, (48, 27), samples=4096)
    finally:
        ended.set()
        thread.join()
    assert np.array_equal(renderer.render(scene, (48, 27)).rgb, expected)
