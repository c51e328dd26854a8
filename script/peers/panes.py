"""Stacks of four transparent panes, and which of a picture's stacks are right, lack a layer or have another order.

The panes are unlit, each of another pure colour and half transparent, so that the colour of a stack says which panes were drawn and
in which order. Half of the stacks are made of panes that are objects of their own, each with its place in its matrix; of the others each is
one primitive, whose panes stand in the file in a random order and take their colours from a texture. Colours blended as light and as display values are both taken as right.
"""
import io
import itertools
import random

import numpy
from PIL import Image
from shared_scene import write_glb

COLUMNS, ROWS, LAYERS, ALPHA = 8, 6, 4, 0.5
COLORS = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0))
BEHIND = (0.0, 0.0, 0.0)
NEAR_ENOUGH = 0.035  # of each channel


def write_panes(path, width, height):
    """Writes the scene; of each stack the order of its colours, farthest first."""
    rng, binary = random.Random(5), bytearray()
    unlit = {"alphaMode": "BLEND", "doubleSided": True, "extensions": {"KHR_materials_unlit": {}}}
    of = lambda color, **more: {"baseColorFactor": [*color, ALPHA], "metallicFactor": 0, "roughnessFactor": 1, **more}  # noqa: E731
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "nodes": [], "meshes": [], "accessors": [], "bufferViews": [],
            "materials": [{**unlit, "name": f"pane{i}", "pbrMetallicRoughness": of(color)} for i, color in enumerate(COLORS)],
            "extensionsUsed": ["KHR_materials_unlit"], "textures": [{"source": 0, "sampler": 0}],
            "images": [{"bufferView": 0, "mimeType": "image/png"}], "samplers": [{"magFilter": 9728, "minFilter": 9728}]}
    gltf["materials"].append({**unlit, "name": "stack", "pbrMetallicRoughness": of((1, 1, 1), baseColorTexture={"index": 0})})
    picture = io.BytesIO()
    Image.fromarray((numpy.array([COLORS]).repeat(8, axis=0).repeat(8, axis=1) * 255).astype("u1")).save(picture, "PNG")
    binary += picture.getvalue()
    gltf["bufferViews"].append({"buffer": 0, "byteLength": len(binary)})

    def append(values, kind, type_):
        binary.extend(b"\0" * (-len(binary) % 4))
        data = numpy.asarray(values, kind)
        gltf["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": data.nbytes})
        binary.extend(data.tobytes())
        accessor = {"bufferView": len(gltf["bufferViews"]) - 1, "componentType": 5126 if kind == "<f4" else 5125,
                    "count": len(data), "type": type_}
        if type_ == "VEC3":
            accessor.update(min=data.min(axis=0).tolist(), max=data.max(axis=0).tolist())
        gltf["accessors"].append(accessor)
        return len(gltf["accessors"]) - 1

    def add(panes, material, at):
        """One primitive of panes (middle, half of the side, colour), in a node that stands at a point."""
        around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        corners = [[m + o * half for m, o in zip(middle, (sx, sy, 0))] for middle, half, _ in panes for sx, sy in around]
        attributes = {"POSITION": append(numpy.subtract(corners, at), "<f4", "VEC3"),
                      "NORMAL": append([(0, 0, 1)] * len(corners), "<f4", "VEC3"),
                      "TEXCOORD_0": append([((color + 0.5) / LAYERS, 0.5) for _, _, color in panes for _ in around], "<f4", "VEC2")}
        indices = append([4 * i + c for i in range(len(panes)) for c in (0, 1, 2, 0, 2, 3)], "<u4", "SCALAR")
        gltf["meshes"].append({"primitives": [{"attributes": attributes, "indices": indices, "material": material}]})
        gltf["nodes"].append({"mesh": len(gltf["meshes"]) - 1, "translation": list(at)})

    stacks = []
    for row, column in itertools.product(range(ROWS), range(COLUMNS)):
        order = rng.sample(range(LAYERS), LAYERS)
        stacks.append(order)
        panes = []
        for depth, color in enumerate(order):
            z = -1.0 + 0.25 * depth
            scale = (10 - z) / 10
            middle = ((column - (COLUMNS - 1) / 2) * scale + rng.uniform(-0.05, 0.05), ((ROWS - 1) / 2 - row) * scale, z)
            panes.append((middle, rng.uniform(0.3, 0.36), color))
        rng.shuffle(panes)
        if (row + column) % 2:
            for pane in panes:
                add([pane], pane[2], pane[0])
        else:
            add(panes, len(COLORS), panes[0][0])
    gltf["cameras"] = [{"type": "perspective", "perspective": {"yfov": 2 * numpy.arctan(ROWS / 20), "znear": 0.1, "zfar": 100.0,
                                                               "aspectRatio": width / height}}]
    gltf["nodes"].append({"camera": 0, "translation": [0, 0, 10]})
    gltf["scenes"] = [{"nodes": list(range(len(gltf["nodes"])))}]
    gltf["buffers"] = [{"byteLength": len(binary)}]
    write_glb(path, gltf, bytes(binary))
    return stacks


def encoded(v):
    return numpy.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def shown(order):
    """Display values of a stack, blended as light and as display values."""
    result = []
    for values in (lambda c: numpy.array(c, float), lambda c: encoded(numpy.array(c, float))):
        color = values(BEHIND)
        for layer in order:
            color = ALPHA * values(COLORS[layer]) + (1 - ALPHA) * color
        result.append(color)
    return [encoded(result[0]), result[1]]


def count_layers(pixels, stacks):
    """{right, wrong order, lost layers, other} of stacks, by their middles."""
    counts = {"stacks": len(stacks), "right": 0, "order": 0, "lost": 0, "other": 0}
    subsets = [order for n in range(LAYERS + 1) for order in itertools.permutations(range(LAYERS), n)]
    known = [(order, color) for order in subsets for color in shown(order)]
    height, width = pixels.shape[:2]
    for number, order in enumerate(stacks):
        row, column = divmod(number, COLUMNS)
        seen = pixels[int((row + 0.5) * height / ROWS), int((column + 0.5) * width / COLUMNS)]
        if any(numpy.abs(color - seen).max() <= NEAR_ENOUGH for color in shown(order)):
            counts["right"] += 1
            continue
        nearest, color = min(known, key=lambda k: numpy.abs(k[1] - seen).max())
        near = numpy.abs(color - seen).max() <= NEAR_ENOUGH
        counts["other" if not near else "lost" if len(nearest) < LAYERS else "order"] += 1
    return counts
