"""Reads a .glb for the peers that have no importer of their own. Needs numpy alone."""
import json
import math
import pathlib
import struct

import numpy

COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


class Glb:
    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + length])
        self.binary = data[20 + length + 8:]

    @classmethod
    def of(cls, gltf, binary):
        """A scene that is read already."""
        glb = cls.__new__(cls)
        glb.json, glb.binary = gltf, binary
        return glb

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.binary[start:start + view["byteLength"]], view.get("byteStride", 0)

    def accessor(self, index):
        """One row an element; normalized integers as numbers from -1 or 0 to 1."""
        accessor = self.json["accessors"][index]
        data, stride = self.view(accessor["bufferView"])
        kind, width = numpy.dtype(KINDS[accessor["componentType"]]), COMPONENTS[accessor["type"]]
        rows = numpy.ndarray((accessor["count"], width), kind, data, accessor.get("byteOffset", 0),
                             (stride or kind.itemsize * width, kind.itemsize)).copy()
        return rows.astype("f4") / numpy.iinfo(kind).max if accessor.get("normalized") else rows

    def image(self, texture):
        """(index, bytes, MIME type) of the image of a texture."""
        index = self.json["textures"][texture["index"]]["source"]
        entry = self.json["images"][index]
        return index, self.view(entry["bufferView"])[0], entry["mimeType"]

    def corners(self, primitive):
        """Indices of vertices, one row a triangle."""
        attributes = primitive["attributes"]
        if "indices" in primitive:
            return self.accessor(primitive["indices"])[:, 0].astype("i4").reshape(-1, 3)
        return numpy.arange(self.json["accessors"][attributes["POSITION"]]["count"], dtype="i4").reshape(-1, 3)

    def nodes(self):
        """(node, matrix to the world) of every node of the scene; an instanced node once for each instance."""
        found = []

        def visit(index, parent):
            node = self.json["nodes"][index]
            world = parent @ node_matrix(node)
            found.extend((node, world @ own) for own in self.instances(node))
            for child in node.get("children", []):
                visit(child, world)

        for root in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            visit(root, numpy.identity(4))
        return found

    def instances(self, node):
        instancing = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if instancing is None:
            return [numpy.identity(4)]
        columns = {name: self.accessor(index) for name, index in instancing["attributes"].items() if name[0] != "_"}
        count = len(next(iter(columns.values())))
        return [node_matrix({name.lower(): columns[name][i] for name in columns}) for i in range(count)]

    def meshes(self):
        """(mesh and primitive index, primitive, its material or {}, matrix to the world) of all that is drawn."""
        materials = self.json.get("materials", [])
        for node, world in self.nodes():
            for number, primitive in enumerate(self.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []):
                material = materials[primitive["material"]] if "material" in primitive else {}
                yield (node["mesh"], number), primitive, material, world

    def lights(self):
        """(light, matrix to the world)."""
        lights = self.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
        for node, world in self.nodes():
            if "KHR_lights_punctual" in node.get("extensions", {}):
                yield lights[node["extensions"]["KHR_lights_punctual"]["light"]], world

    def camera(self, index):
        """(perspective, matrix to the world)."""
        for node, world in self.nodes():
            if node.get("camera") == index:
                return self.json["cameras"][index]["perspective"], world
        raise ValueError(f"no node has camera {index}")


class Material:
    """A material's values, with glTF's defaults; textures as glTF names them, or None."""

    def __init__(self, source):
        pbr, extensions = source.get("pbrMetallicRoughness", {}), source.get("extensions", {})
        of = lambda name: extensions.get("KHR_materials_" + name, {})  # noqa: E731
        *self.color, self.alpha = pbr.get("baseColorFactor", [1, 1, 1, 1])
        self.color_texture = pbr.get("baseColorTexture")
        self.metallic, self.roughness = pbr.get("metallicFactor", 1), pbr.get("roughnessFactor", 1)
        self.roughness_texture = pbr.get("metallicRoughnessTexture")
        self.normal_texture = source.get("normalTexture")
        strength = of("emissive_strength").get("emissiveStrength", 1)
        self.emission = [c * strength for c in source.get("emissiveFactor", [0, 0, 0])]
        self.emission_texture = source.get("emissiveTexture") if any(self.emission) else None
        self.mode, self.cutoff = source.get("alphaMode", "OPAQUE"), source.get("alphaCutoff", 0.5)
        self.double_sided = source.get("doubleSided", False)
        self.transmission = of("transmission").get("transmissionFactor", 0)
        volume = of("volume")
        self.thickness = volume.get("thicknessFactor", 0)
        self.attenuation = volume.get("attenuationColor", [1, 1, 1])
        self.attenuation_distance = volume.get("attenuationDistance", math.inf)
        self.ior = of("ior").get("ior", 1.5)
        self.specular = of("specular").get("specularFactor", 1)
        self.unlit = "KHR_materials_unlit" in extensions

    def is_body(self):
        """A solid of glass or a liquid, whose surface bends rays."""
        return self.transmission > 0 and self.thickness > 0

    def absorption(self):
        """What the inside absorbs per unit of length."""
        if math.isinf(self.attenuation_distance):
            return [0, 0, 0]
        return [-math.log(max(c, 1e-6)) / self.attenuation_distance for c in self.attenuation]

    def opacity(self, transmissive=0.25):
        """For rasterizers with alpha alone: the share of the background that the surface covers."""
        alpha = self.alpha if self.mode == "BLEND" else 1
        return alpha * (1 - self.transmission * (1 - transmissive))

    def tint(self):
        """The share of light that a volume of the material's thickness lets through, for each colour."""
        return [math.exp(-a * self.thickness) for a in self.absorption()]


def node_matrix(node):
    if "matrix" in node:
        return numpy.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = (float(c) for c in node.get("rotation", [0, 0, 0, 1]))
    turn = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    matrix = numpy.identity(4)
    matrix[:3, :3] = turn * numpy.asarray(node.get("scale", [1, 1, 1]), float)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def read_hdr(path):
    """A Radiance picture as float32 of (height, width, 3), the top row first."""
    data = pathlib.Path(path).read_bytes()
    at = data.index(b"\n\n") + 2
    end = data.index(b"\n", at)
    words = data[at:end].split()
    height, width, at = int(words[1]), int(words[3]), end + 1
    rows = numpy.empty((height, width, 4), "u1")
    for row in rows:
        if width < 8 or data[at:at + 2] != b"\2\2":
            row[:] = numpy.frombuffer(data, "u1", 4 * width, at).reshape(width, 4)
            at += 4 * width
            continue
        at += 4
        for channel in range(4):
            x = 0
            while x < width:
                count = data[at]
                if count > 128:
                    row[x:x + count - 128, channel] = data[at + 1]
                    x, at = x + count - 128, at + 2
                else:
                    row[x:x + count, channel] = numpy.frombuffer(data, "u1", count, at + 1)
                    x, at = x + count, at + 1 + count
    scale = numpy.where(rows[..., 3:] > 0, numpy.ldexp(1.0, rows[..., 3:].astype("i4") - 136), 0)
    return (rows[..., :3] * scale).astype("f4")


def constant_sky(path):
    """For programs without skies: (the sky's mean over all directions, for light; its median, to be seen)."""
    pixels = read_hdr(path)
    weights = numpy.cos((0.5 - (numpy.arange(len(pixels)) + 0.5) / len(pixels)) * math.pi)
    return (pixels.mean(axis=1) * weights[:, None]).sum(axis=0) / weights.sum(), numpy.median(pixels, axis=(0, 1))


def write_hdr(path, pixels):
    """Writes radiance as a Radiance picture without runs."""
    largest = numpy.maximum(pixels.max(axis=-1), 1e-30)
    exponent = numpy.frexp(largest)[1]
    bytes_ = numpy.empty((*pixels.shape[:2], 4), "u1")
    bytes_[..., :3] = numpy.clip(numpy.ldexp(pixels, (8 - exponent)[..., None]), 0, 255)
    bytes_[..., 3] = numpy.clip(exponent + 128, 0, 255)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {pixels.shape[0]} +X {pixels.shape[1]}\n"
    pathlib.Path(path).write_bytes(head.encode() + bytes_.tobytes())
