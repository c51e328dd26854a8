"""Flicker over a dolly: frames of a camera that moves, and by how much they change otherwise than those of the truth.

`flicker` and `flicker_of_error` are those of `sideray chart --frames` (docs/cli.md): half the mean square of the change between
frames, less that of the truth; and the same of the difference to the truth, for which motion that is right does not count. The
first frames are drawn and not counted, since a sequence of Sideray's has a history by then. The other programs draw each frame by
itself, as they do here without a history of their own.
"""
import dataclasses
import json
import os

import numpy
from board import Board, radiance, write_shown
from gltf import Glb, node_matrix
from PIL import Image
from processes import Failure
from programs import Job, Sideray, tracer_of
from shared_scene import write_glb

FRAMES, LOOKED_AT = 12, 5  # as `sideray chart` looks at 12 frames
FPS = 30
SIZE = (240, 135)
TRUTH, SAMPLES = "Cycles", 64
ONCE_MORE = "the truth with other random numbers"
KINDS = ("raster look", "balanced", "balanced --gl none", "three.js", "VTK", "F3D", "pyrender", "Cycles, 4, denoised")


def camera_of(gltf):
    return next(node for node in gltf["nodes"] if "camera" in node)


def places(gltf, step):
    """The camera's matrices: each frame `step` on, in the camera's own space."""
    start = node_matrix(camera_of(gltf))
    shift = numpy.identity(4)
    for frame in range(FRAMES):
        shift[:3, 3] = numpy.multiply(step, frame)
        yield start @ shift


def quaternion(rotation):
    """(x, y, z, w) of a rotation matrix, by its largest element (Shepperd 1978)."""
    trace = numpy.trace(rotation)
    squares = [*(1 - trace + 2 * numpy.diag(rotation)), 1 + trace]
    largest = int(numpy.argmax(squares))
    if largest == 3:
        around = [rotation[(i + 2) % 3][(i + 1) % 3] - rotation[(i + 1) % 3][(i + 2) % 3] for i in range(3)]
        values = [*around, squares[3]]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        values = [0.0] * 4
        values[i], values[3] = squares[i], rotation[k][j] - rotation[j][k]
        values[j], values[k] = rotation[i][j] + rotation[j][i], rotation[i][k] + rotation[k][i]
    return (numpy.array(values) / numpy.linalg.norm(values)).tolist()


def write_moving(path, glb, matrices):
    """The scene with an animation that moves the camera: frame n is the moment n / FPS."""
    gltf, binary = json.loads(json.dumps(glb.json)), bytearray(glb.binary)

    def append(values, kind):
        data = numpy.asarray(values, "<f4")
        binary.extend(b"\0" * (-len(binary) % 4))
        gltf["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": data.nbytes})
        binary.extend(data.tobytes())
        bounds = {"min": [float(data.min())], "max": [float(data.max())]} if kind == "SCALAR" else {}
        gltf["accessors"].append({"bufferView": len(gltf["bufferViews"]) - 1, "componentType": 5126, "count": len(data), "type": kind, **bounds})
        return len(gltf["accessors"]) - 1

    node = camera_of(gltf)
    node.pop("matrix", None)
    node["rotation"] = quaternion(matrices[0][:3, :3])
    times = append([frame / FPS for frame in range(FRAMES)], "SCALAR")
    moves = append([matrix[:3, 3] for matrix in matrices], "VEC3")
    gltf["animations"] = [{"samplers": [{"input": times, "output": moves}],
                           "channels": [{"sampler": 0, "target": {"node": gltf["nodes"].index(node), "path": "translation"}}]}]
    gltf["buffers"] = [{"byteLength": len(binary)}]
    write_glb(path, gltf, bytes(binary))


def write_frames(board):
    """A folder a frame with the copies of the scene that programs read, and moving.glb."""
    scene = Glb(board.folder / "scene.glb")
    matrices = list(places(scene.json, board.setting.dolly))
    write_moving(board.folder / "moving.glb", scene, matrices)
    folders = []
    for frame, matrix in enumerate(matrices):
        folder = board.folder / f"{frame:02}"
        folder.mkdir(exist_ok=True)
        for name in ("scene", "flat", "dimmed"):
            glb = Glb(board.folder / f"{name}.glb")
            node = camera_of(glb.json)
            for key in ("translation", "rotation", "scale"):
                node.pop(key, None)
            node["matrix"] = matrix.T.ravel().tolist()
            write_glb(folder / f"{name}.glb", glb.json, glb.binary)
        for sky in ("sky.hdr", "turned.hdr"):
            if (board.folder / sky).is_file() and not (folder / sky).exists():
                os.symlink(board.folder / sky, folder / sky)
        folders.append(folder)
    return folders


def shown(path):
    if path.suffix != ".png":
        write_shown(path.with_suffix(".png"), radiance(path))
    return numpy.asarray(Image.open(path.with_suffix(".png")).convert("RGB"), dtype="f8") / 255


class Alone:
    """A program that draws each frame by itself."""

    def __init__(self, program):
        self.program, self.name, self.file, self.family = program, program.name, program.file, program.family

    def pictures(self, board, folders):
        for folder in folders:
            job = Job(folder, board.job.width, board.job.height, board.job.limit_s)
            path = folder / (self.file + self.program.suffix)
            if not path.is_file():
                part = path.with_name("part" + path.suffix)
                self.program.draw(job, part, 0)
                os.replace(part, path)
            yield shown(path)


class InSequence:
    """Frames of one process of Sideray's, with the history that sequences have by default."""

    family = "Sideray"

    def __init__(self, program, name, words):
        self.program, self.name, self.words = Sideray(program, name, words), name, words
        self.file = self.program.file

    def pictures(self, board, folders):
        command = self.program.command(board.job, "render")
        command[2] = board.folder / "moving.glb"
        board.job.run([*command, "--tonemap", "none", "--frames", f"0-{len(folders) - 1}", "--fps", FPS, "-o",
                       board.folder / f"{self.file}.####.png"])
        for frame in range(len(folders)):
            yield shown(board.folder / f"{self.file}.{frame:04}.png")


def flicker(pictures, truths):
    test, truth = (numpy.diff(numpy.stack(frames[LOOKED_AT:]), axis=0) for frames in (pictures, truths))
    energy = [0.5 * float((change ** 2).mean()) for change in (test, truth, test - truth)]
    return {"flicker": energy[0] - energy[1], "flicker_of_error": energy[2], "truth": energy[1]}


def has_drawn(program, folder):
    """Returns whether the program has a result in a scene's folder, so that it can draw the scene in time."""
    path = folder / f"{program.file}.json"
    return path.is_file() and "flip" in json.loads(path.read_text())


def measure_dolly(setting, options, sideray, there):
    """Writes a result to FOLDER/dolly-NAME for each program that has one in FOLDER/NAME."""
    there = [p for p in there if p.name in KINDS and has_drawn(p, options.folder / setting.name)]
    setting = dataclasses.replace(setting, name=f"dolly-{setting.name}", width=SIZE[0], height=SIZE[1])
    board = Board(setting, options, sideray)
    board.prepare()
    folders = write_frames(board)
    peers = options.peers.resolve()
    truth, again = (tracer_of(peers, sideray, TRUTH, SAMPLES, seed) for seed in ("7", "8"))
    truth.file, again.file, again.name = f"truth-{SAMPLES}", f"truth-{SAMPLES}-once-more", ONCE_MORE
    truths = list(Alone(truth).pictures(board, folders))
    ways = [InSequence(sideray, "balanced, a sequence", []), InSequence(sideray, "balanced --gl none, a sequence", ["--gl", "none"]),
            *map(Alone, there), Alone(again)]
    for way in ways:
        path = board.folder / f"{way.file}.json"
        if path.is_file() and not options.again:
            continue
        record = {"program": way.name, "family": way.family}
        try:
            record.update(flicker(list(way.pictures(board, folders)), truths))
        except (Failure, OSError, ValueError) as failure:
            record["error"] = str(failure)
        path.write_text(json.dumps(record, indent=1) + "\n")
        board.say(f"{way.name}: {record}")
