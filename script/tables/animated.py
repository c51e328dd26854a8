"""Built-in scenes with something that moves, for tables about sequences. Nodes get an animated parent, which leaves their
own matrices as they are."""
import json
import math
import struct
import subprocess

GLB, JSON, BIN = 0x46546C67, 0x4E4F534A, 0x004E4942


def read_glb(path):
    with open(path, "rb") as stream:
        data = stream.read()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[28 + length:]


def write_glb(path, document, binary):
    binary += b"\0" * (-len(binary) % 4)
    document["buffers"][0]["byteLength"] = len(binary)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as stream:
        stream.write(struct.pack("<III", GLB, 2, 28 + len(text) + len(binary)))
        stream.write(struct.pack("<II", len(text), JSON) + text)
        stream.write(struct.pack("<II", len(binary), BIN) + binary)


def add_accessor(document, binary, kind, rows):
    """Appends rows of floats; returns the accessor's index and what the buffer has become."""
    binary += b"\0" * (-len(binary) % 4)
    values = struct.pack("<%df" % (len(rows) * len(rows[0])), *(v for row in rows for v in row))
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(values)})
    document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "count": len(rows),
                                  "type": kind, "min": [min(c) for c in zip(*rows)], "max": [max(c) for c in zip(*rows)]})
    return len(document["accessors"]) - 1, binary + values


def animate(document, binary, name, path, interpolation, keys):
    """The node's place becomes a parent's, whose `path` goes through keys: (seconds, values), translations from there on."""
    index, node = next((i, n) for i, n in enumerate(document["nodes"]) if n.get("name") == name)
    place = node["matrix"][12:15]
    node["matrix"][12:15] = [0, 0, 0]
    parent = len(document["nodes"])
    document["nodes"].append({"name": name + " mount", "translation": place, "children": [index]})
    for scene in document["scenes"]:
        scene["nodes"] = [parent if n == index else n for n in scene["nodes"]]
    rows = [values if path == "rotation" else [p + v for p, v in zip(place, values)] for _, values in keys]
    times, binary = add_accessor(document, binary, "SCALAR", [[seconds] for seconds, _ in keys])
    values, binary = add_accessor(document, binary, "VEC%d" % len(rows[0]), rows)
    document["animations"] = [{"samplers": [{"input": times, "output": values, "interpolation": interpolation}],
                               "channels": [{"sampler": 0, "target": {"node": parent, "path": path}}]}]
    return binary


def made(program, scene, path):
    name, _, parameters = scene.partition("?")
    command = [program, "make", name, "-o", path]
    for parameter in filter(None, parameters.split("&")):
        command += ["--set", parameter]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return read_glb(path)


def turning(program, path):
    """The cube of solids turns about the vertical, half a turn in four seconds."""
    document, binary = made(program, "solids", path)
    quarters = [(k / 1.0, [0, math.sin(k * math.pi / 8), 0, math.cos(k * math.pi / 8)]) for k in range(5)]
    write_glb(path, document, animate(document, binary, "cube", "rotation", "LINEAR", quarters))


def windy(program, path):
    """The forest, whose wall is a pane of glass that mirrors plants in wind."""
    document, binary = made(program, "forest", path)
    wall = next(m for m in document["materials"] if m["name"] == "wall")
    wall["pbrMetallicRoughness"] = {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0}
    wall["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1}}
    document["extensionsUsed"] = sorted({*document["extensionsUsed"], "KHR_materials_transmission"})
    write_glb(path, document, binary)


def sliding(program, scene, path):
    """A .glb without cameras, seen as `sideray render` frames it, by a camera that goes a hundredth of the scene's radius to
    the right in each of 30 frames a second."""
    info = json.loads(subprocess.run([program, "info", scene, "--json"], check=True, capture_output=True, text=True).stdout)
    low, high = info["bounds"]["minimum"], info["bounds"]["maximum"]
    radius = math.dist(low, high) / 2
    back = [v / math.hypot(1, 0.6, 1.4) for v in (1, 0.6, 1.4)]
    away = 1.05 * radius / math.sin(math.radians(22.5))
    right = [back[2] / math.hypot(back[0], back[2]), 0, -back[0] / math.hypot(back[0], back[2])]
    up = [back[1] * right[2], back[2] * right[0] - back[0] * right[2], -back[1] * right[0]]
    eye = [(a + b) / 2 + away * c for a, b, c in zip(low, high, back)]
    document, binary = read_glb(scene)
    document["cameras"] = [{"type": "perspective", "perspective": {"yfov": math.radians(45), "znear": away / 1000}}]
    document["nodes"].append({"name": "slide", "camera": 0, "matrix": [*right, 0, *up, 0, *back, 0, *eye, 1]})
    document["scenes"][document.get("scene", 0)]["nodes"].append(len(document["nodes"]) - 1)
    keys = [(seconds, [0.3 * seconds * radius * v for v in right]) for seconds in (0, 2)]
    write_glb(path, document, animate(document, binary, "slide", "translation", "LINEAR", keys))


def cut(program, path, seconds):
    """The bistro, whose camera `main` is two metres elsewhere from then on."""
    document, binary = made(program, "bistro", path)
    keys = [(0, [0, 0, 0]), (seconds, [-1.5, 0.5, 1.2])]
    write_glb(path, document, animate(document, binary, "main", "translation", "STEP", keys))


# What scripts call in place of a scene: how it is made, and its camera.
SCENES = {"turning": (turning, "view"), "wind": (windy, "wall")}
