#!/usr/bin/env python3
"""Times ways to draw many small pictures of one scene from Python: many_pictures.py [--size 84x84] [--count 192] [SCENE]

The median of three turns of each way, as a table: pictures a second, and those of a second of processor time of all threads, which
is the same on a busy machine as on a quiet one. PYTHONPATH=build/python where the package is not installed.
"""

import argparse
import multiprocessing
import statistics
import threading
import time

import numpy as np

import sideray

# Light that bounces, the default, takes several times as long, whichever way pictures are drawn.
OPTIONS = {"ambient": "ao"}

worker = None


class Worker:
    """A renderer with one thread, and the scene."""

    def __init__(self, scene, size, count, threads=1, gl="none"):
        self.size, self.scene = size, sideray.load(scene)
        self.renderer = sideray.Renderer(gl=gl, threads=threads)
        first = self.scene.get_camera(None, aspect=size[0] / size[1])
        self.cameras = [sideray.Camera(turned(0.3 * i / count) @ first.world_from_camera, first.yfov, first.z_near)
                        for i in range(count)]

    def draw(self, part, parts):
        for camera in self.cameras[part::parts]:
            self.renderer.render(self.scene, self.size, camera, **OPTIONS).rgb

    def draw_many(self):
        self.renderer.render_many(self.scene, self.cameras, self.size, **OPTIONS).rgb


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])


def begin(*arguments):
    global worker
    worker = Worker(*arguments)


def draw_part(part):
    """Returns the processor time that it took."""
    start = time.process_time()
    worker.draw(*part)
    return time.process_time() - start


def measure(name, draw, count):
    """draw: returns the processor time of other processes, or None."""
    draw()
    times, busy = [], []
    for _ in range(3):
        start, start_busy = time.perf_counter(), time.process_time()
        elsewhere = draw() or 0.0
        times.append(time.perf_counter() - start)
        busy.append(time.process_time() - start_busy + elsewhere)
    print(f"| {name} | {count / statistics.median(times):.0f} | {count / statistics.median(busy):.0f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default="panes")
    parser.add_argument("--size", default="84x84")
    parser.add_argument("--count", type=int, default=192)
    parser.add_argument("--threads", type=int, default=multiprocessing.cpu_count())
    given = parser.parse_args()
    size, count, threads = tuple(map(int, given.size.split("x"))), given.count, given.threads
    arguments = (given.scene, size, count)
    print("| way | pictures a second | of processor time |\n|---|---|---|")
    # What forks comes first: the parent has not used OpenGL yet.
    for start in ("fork", "spawn"):
        with multiprocessing.get_context(start).Pool(threads, begin, arguments) as pool:
            parts = [(part, threads) for part in range(threads)]
            measure(f"{threads} processes by {start}, a renderer of one thread each", lambda: sum(pool.map(draw_part, parts, 1)), count)
    workers = [Worker(*arguments) for _ in range(threads)]

    def by_threads():
        running = [threading.Thread(target=w.draw, args=(part, threads)) for part, w in enumerate(workers)]
        for thread in running:
            thread.start()
        for thread in running:
            thread.join()

    measure(f"{threads} threads of Python, a renderer of one thread each", by_threads, count)
    for gl in ("none", "auto"):
        whole = Worker(*arguments, threads=threads, gl=gl)
        measure(f'`render` in a loop, `gl="{gl}"`', lambda: whole.draw(0, 1), count)
        measure(f'`render_many`, `gl="{gl}"`', whole.draw_many, count)


if __name__ == "__main__":
    main()
