"""Scenes of glassware on a table as binary glTF: lathed glasses with walls of real thickness, some with a liquid in them,
and a few opaque things that stand among them. Lengths are metres, +Y is up, the table's top is y = 0.
"""
import io
import json
import math
import struct

import numpy as np
from PIL import Image

GLASS = {
    "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0},
    "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_ior": {"ior": 1.5},
        "KHR_materials_volume": {"thicknessFactor": 0.003},
    },
}
# Tints: the colour that white light has after so many metres.
TINTS = {"clear": None, "green": (0.02, [0.55, 0.85, 0.6]), "brown": (0.01, [0.75, 0.45, 0.2]), "blue": (0.02, [0.5, 0.7, 0.95])}
LIQUIDS = {"water": (1.33, None), "tea": (1.33, (0.05, [0.8, 0.4, 0.1])), "oil": (1.47, (0.08, [0.95, 0.85, 0.3]))}

# Outline of a closed wall as (radius, height) in centimetres: up the outside, over the rim, down the inside; the first
# and the last point lie on the axis.
SHAPES = {
    "tumbler": [(0, 0), (2.9, 0), (3.1, 0.3), (3.9, 9.4), (3.9, 9.6), (3.7, 9.6), (3.65, 9.4), (2.9, 1.1), (2.5, 0.9), (0, 0.9)],
    "wineglass": [(0, 0), (3.4, 0), (3.5, 0.15), (3.3, 0.35), (0.9, 0.7), (0.4, 1.6), (0.38, 7.5), (0.8, 8.3), (2.8, 9.8), (3.9, 12.3),
                  (3.4, 17.8), (3.3, 18.0), (3.2, 17.8), (3.7, 12.3), (2.6, 10.0), (0.7, 8.7), (0, 8.6)],
    "bottle": [(0, 0.5), (2.2, 0.3), (2.9, 0), (3.4, 0.3), (3.5, 1), (3.5, 13), (3.2, 14.6), (1.4, 17), (1.3, 21.5), (1.5, 21.7),
               (1.5, 22.6), (1.3, 22.7), (1.0, 22.6), (1.0, 17), (2.9, 14.3), (3.2, 13), (3.2, 1.3), (2.8, 0.7), (0, 0.9)],
    "flask": [(0, 0), (4.0, 0), (4.3, 0.3), (4.2, 1.2), (1.4, 9), (1.4, 11.8), (1.7, 12.1), (1.6, 12.3), (1.2, 12.1), (1.2, 9),
              (4.0, 1.2), (3.8, 0.4), (0, 0.25)],
    "bowl": [(0, 0), (2.4, 0), (2.6, 0.3), (2.6, 0.5), (5.6, 3.2), (6.6, 6.2), (6.5, 6.4), (6.3, 6.2), (5.3, 3.4), (2.6, 1.0), (0, 0.7)],
    "vial": [(0, 0), (1.1, 0), (1.25, 0.2), (1.25, 5.4), (1.0, 6.0), (1.0, 6.6), (1.15, 6.7), (1.1, 6.9), (0.85, 6.8), (0.85, 5.9),
             (1.12, 5.3), (1.12, 0.35), (0.9, 0.18), (0, 0.18)],
}
# For shapes that can hold a liquid: the index of the first point on the inside, which continues to the last point.
FILLED_FROM = {"tumbler": 6, "wineglass": 12, "flask": 9, "bowl": 7, "vial": 9}


def rounded(points, rounds=3):
    """Corners cut by Chaikin's scheme; the two ends stay on the axis."""
    p = np.asarray(points, float)
    for _ in range(rounds):
        cut = np.empty((2 * len(p) - 2, 2))
        cut[0::2], cut[1::2] = 0.75 * p[:-1] + 0.25 * p[1:], 0.25 * p[:-1] + 0.75 * p[1:]
        cut[0], cut[-1] = p[0], p[-1]
        p = cut
    return p


def lathe(points, segments=72):
    """Positions, normals and triangles of an outline that is turned about +Y; the outside lies to the right of its way."""
    p = rounded(points) * 0.01
    along = np.gradient(p, axis=0)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    on_axis = p[:, 0] < 1e-9
    normal[on_axis, 0] = 0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    angle = np.arange(segments) * 2 * math.pi / segments
    c, s = np.cos(angle), np.sin(angle)

    def turned(q):
        return np.stack([np.outer(q[:, 0], c), np.repeat(q[:, 1:2], segments, axis=1), np.outer(q[:, 0], s)], axis=-1)

    i = np.arange(len(p) - 1)[:, None] * segments
    k = np.arange(segments)[None, :]
    next_k = (k + 1) % segments
    a, b, d, e = i + k, i + next_k, i + segments + k, i + segments + next_k
    # At the axis a quad becomes one triangle.
    lower, upper = np.stack([a, d, e], -1)[~on_axis[1:]], np.stack([a, e, b], -1)[~on_axis[:-1]]
    triangles = np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])
    return turned(p).reshape(-1, 3), turned(normal).reshape(-1, 3), triangles


def liquid_outline(shape, level, overlap=0.02):
    """What fills a shape up to a share of its inside. It reaches a little into the wall: no gap of air is between them."""
    inside = np.asarray(SHAPES[shape][FILLED_FROM[shape]:], float)[::-1]
    bottom, top = inside[0, 1], inside[-1, 1]
    height = bottom + level * (top - bottom)
    outline = [(0, bottom - overlap)]
    for (r0, y0), (r1, y1) in zip(inside[:-1], inside[1:]):
        if r0 > 0:
            outline.append((r0 + overlap, y0))
        if y1 >= height:
            r = r0 + (r1 - r0) * (height - y0) / (y1 - y0) + overlap
            outline += [(r, height - 0.03), (r - 0.05, height), (0, height)]
            return outline
    raise ValueError(shape)


def box(size):
    """A box with flat sides that stands on y = 0."""
    positions, normals, triangles = [], [], []
    for axis in range(3):
        for sign in (-1, 1):
            n = np.zeros(3)
            n[axis] = sign
            u, v = np.roll(np.eye(3)[axis], 1), np.roll(np.eye(3)[axis], 2)
            first = len(positions)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                positions.append(((n + a * u + b * v) * 0.5 + [0, 0.5, 0]) * size)
                normals.append(n)
            order = (0, 1, 2, 0, 2, 3) if sign > 0 else (0, 2, 1, 0, 3, 2)
            triangles += [[first + order[k] for k in t] for t in ((0, 1, 2), (3, 4, 5))]
    return np.array(positions), np.array(normals), np.array(triangles)


def cloth(rng, size=512):
    """A checked table cloth with a little noise: something to see bent."""
    y, x = np.mgrid[0:size, 0:size]
    checks = 0.35 * ((x // 32) % 2) + 0.35 * ((y // 32) % 2)
    a, b = rng.uniform(0.15, 0.6, 3), rng.uniform(0.6, 0.95, 3)
    noise = rng.normal(0, 0.02, (size, size, 1))
    image = a + (b - a) * (1 - checks[..., None] / 0.7) + noise
    return (np.clip(image, 0, 1) * 255).astype(np.uint8)


class Glb:
    """Collects meshes, materials and nodes, and writes them as one file."""

    def __init__(self):
        self.data = bytearray()
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
                     "accessors": [], "bufferViews": [], "images": [], "textures": [], "cameras": [],
                     "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_ior", "KHR_materials_volume"]}

    def add(self, kind, entry):
        self.json[kind].append(entry)
        return len(self.json[kind]) - 1

    def view(self, payload):
        self.data += b"\0" * (-len(self.data) % 4)
        self.data += payload
        return self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.data) - len(payload), "byteLength": len(payload)})

    def accessor(self, values, kind):
        if kind == "SCALAR":
            flat = np.ascontiguousarray(values, np.uint32).ravel()
            return self.add("accessors", {"bufferView": self.view(flat.tobytes()), "componentType": 5125, "count": len(flat), "type": kind})
        array = np.ascontiguousarray(values, np.float32)
        return self.add("accessors", {"bufferView": self.view(array.tobytes()), "componentType": 5126, "count": len(array), "type": kind,
                                      "min": array.min(0).tolist(), "max": array.max(0).tolist()})

    def mesh(self, positions, normals, triangles, material, uv=None):
        attributes = {"POSITION": self.accessor(positions, "VEC3"), "NORMAL": self.accessor(normals, "VEC3")}
        if uv is not None:
            attributes["TEXCOORD_0"] = self.accessor(uv, "VEC2")
        primitive = {"attributes": attributes, "indices": self.accessor(triangles, "SCALAR"), "material": material}
        return self.add("meshes", {"primitives": [primitive]})

    def texture(self, rgb):
        png = io.BytesIO()
        Image.fromarray(rgb).save(png, "PNG")
        image = self.add("images", {"bufferView": self.view(png.getvalue()), "mimeType": "image/png"})
        return self.add("textures", {"source": image})

    def node(self, name, **what):
        self.json["scenes"][0]["nodes"].append(self.add("nodes", {"name": name, **what}))

    def write(self, path):
        self.data += b"\0" * (-len(self.data) % 4)
        description = {k: v for k, v in self.json.items() if v != []}
        description["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(description, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.data)))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", len(self.data), b"BIN\0") + self.data)


def glass_material(glb, tint, ior=1.5):
    material = json.loads(json.dumps(GLASS))
    material["extensions"]["KHR_materials_ior"]["ior"] = ior
    if tint:
        material["extensions"]["KHR_materials_volume"].update(attenuationDistance=tint[0], attenuationColor=tint[1])
    return glb.add("materials", material)


def opaque_material(glb, rng):
    color = [*rng.uniform(0.1, 0.9, 3).tolist(), 1]
    return glb.add("materials", {"pbrMetallicRoughness": {"baseColorFactor": color, "metallicFactor": 0,
                                                          "roughnessFactor": float(rng.uniform(0.3, 0.9))}})


def places(rng, radii, reach=0.13):
    """Random places on the table for things of these radii, none in another."""
    found = []
    for radius in radii:
        while True:
            p = rng.uniform(-reach, reach, 2)
            if all(np.linalg.norm(p - q) > radius + r + 0.004 for q, r in found):
                found.append((p, radius))
                break
    return [p for p, _ in found]


def add_camera(glb, rng):
    azimuth, elevation, distance = rng.uniform(0, 2 * math.pi), math.radians(rng.uniform(12, 35)), rng.uniform(0.45, 0.6)
    back = np.array([math.cos(elevation) * math.sin(azimuth), math.sin(elevation), math.cos(elevation) * math.cos(azimuth)])
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = right, np.cross(back, right), back
    pose[:3, 3] = back * distance + [0, 0.055, 0]
    camera = glb.add("cameras", {"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.05}})
    glb.node("camera", camera=camera, matrix=pose.T.ravel().tolist())


def add_table(glb, rng):
    half, repeat = 1.5, 7.0
    texture = glb.texture(cloth(rng))
    material = glb.add("materials", {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}, "metallicFactor": 0, "roughnessFactor": 0.9}})
    corners = np.array([[-half, 0, half], [half, 0, half], [half, 0, -half], [-half, 0, -half]])
    uv = np.array([[0, repeat], [repeat, repeat], [repeat, 0], [0, 0]])
    glb.node("table", mesh=glb.mesh(corners, [[0, 1, 0]] * 4, [[0, 1, 2], [0, 2, 3]], material, uv))


def add_glass(glb, rng, shape, place, number):
    tint = TINTS[rng.choice(list(TINTS), p=[0.6, 0.15, 0.1, 0.15])]
    # A fifth of a millimetre above the table, like a real glass.
    translation = [float(place[0]), 2e-4, float(place[1])]
    mesh = glb.mesh(*lathe(SHAPES[shape]), glass_material(glb, tint))
    glb.node(f"{shape}_{number}", mesh=mesh, translation=translation)
    if shape not in FILLED_FROM or rng.random() > 0.5:
        return
    name = rng.choice(list(LIQUIDS))
    ior, liquid = LIQUIDS[name]
    mesh = glb.mesh(*lathe(liquid_outline(shape, rng.uniform(0.2, 0.75))), glass_material(glb, liquid, ior))
    glb.node(f"{name}_{number}", mesh=mesh, translation=translation)


def add_opaque(glb, rng, place, number):
    angle = rng.uniform(0, math.pi)
    turn = [0, math.sin(angle / 2), 0, math.cos(angle / 2)]
    shape = box(rng.uniform(0.02, 0.06, 3)) if rng.random() < 0.6 else lathe([(0, 0), (2.6, 0), (2.8, 0.3), (2.8, 5.7), (2.6, 6), (0, 6)])
    glb.node(f"opaque_{number}", mesh=glb.mesh(*shape, opaque_material(glb, rng)), rotation=turn,
             translation=[float(place[0]), 2e-4, float(place[1])])


def write_scene(path, seed, number):
    """The same bytes for the same seed and number. Returns where each node stands, by name."""
    rng = np.random.default_rng([seed, number])
    glb = Glb()
    add_camera(glb, rng)
    add_table(glb, rng)
    shapes = rng.choice(list(SHAPES), size=rng.integers(3, 6)).tolist()
    count = int(rng.integers(2, 4))
    spots = places(rng, [max(r for r, _ in SHAPES[s]) * 0.01 for s in shapes] + [0.043] * count)
    for i, shape in enumerate(shapes):
        add_glass(glb, rng, shape, spots[i], i)
    for i in range(count):
        add_opaque(glb, rng, spots[len(shapes) + i], len(shapes) + i)
    glb.write(path)
    return {node["name"]: node["translation"] for node in glb.json["nodes"] if "translation" in node}
