#!/usr/bin/env python3
"""Writes the seed scenes of tests/fuzz/corpus/scene: small files that together use all that the loader reads."""
import base64
import json
import math
import pathlib
import struct

HERE = pathlib.Path(__file__).resolve().parent / "corpus"
FLOAT, U8, U16, I16, U32 = 5126, 5121, 5123, 5122, 5125
CODES = {FLOAT: "f", U8: "B", U16: "H", I16: "h", U32: "I"}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Scene:
    """A glTF file made of parts; starts as one square in the xy plane."""

    def __init__(self):
        self.binary = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "accessors": [], "bufferViews": []}
        self.attributes = {
            "POSITION": self.add([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], FLOAT, "VEC3", min=[0, 0, 0], max=[1, 1, 0]),
            "NORMAL": self.add([0, 0, 1] * 4, FLOAT, "VEC3"),
            "TEXCOORD_0": self.add([0, 0, 1, 0, 1, 1, 0, 1], FLOAT, "VEC2"),
        }
        self.indices = self.add([0, 1, 2, 0, 2, 3], U16, "SCALAR")
        self.primitive = {"attributes": self.attributes, "indices": self.indices}
        self.json["meshes"] = [{"name": "square", "primitives": [self.primitive]}]
        self.json["nodes"] = [{"name": "a", "mesh": 0}]

    def view(self, data, **extra):
        self.binary += bytes(-len(self.binary) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **extra})
        self.binary += data
        return len(self.json["bufferViews"]) - 1

    def add(self, values, component, kind, **extra):
        view = self.view(struct.pack("<%d%s" % (len(values), CODES[component]), *values))
        self.json["accessors"].append({"bufferView": view, "componentType": component, "type": kind,
                                       "count": len(values) // COMPONENTS[kind], **extra})
        return len(self.json["accessors"]) - 1

    def textures(self, *names):
        self.json["samplers"] = [{"wrapS": 33071, "wrapT": 33648, "minFilter": 9729, "magFilter": 9728}]
        self.json["images"], self.json["textures"] = [], []
        for name in names:
            kind = {"jpg": "jpeg"}.get(name.split(".")[1], name.split(".")[1])
            data = (HERE / "picture" / name).read_bytes()
            texture = {"sampler": 0, "source": len(self.json["images"])}
            if kind == "webp":
                texture = {"sampler": 0, "extensions": {"EXT_texture_webp": {"source": len(self.json["images"])}}}
            image = {"bufferView": self.view(data), "mimeType": "image/" + kind}
            if kind == "webp":
                image = {"uri": "data:image/webp;base64," + base64.b64encode(data).decode()}
            self.json["images"].append(image)
            self.json["textures"].append(texture)

    def extensions(self, *names):
        self.json["extensionsUsed"] = list(names)

    def write(self, name):
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        if name.endswith(".gltf"):
            self.json["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
            (HERE / "scene" / name).write_text(json.dumps(self.json))
            return
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + bytes(-len(self.binary) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
        (HERE / "scene" / name).write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def info(index, **extra):
    return {"index": index, **extra}


def materials(name, emissive):
    scene = Scene()
    scene.textures("p8.png", "a.jpg", "grey.png", emissive)
    moved = {"extensions": {"KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3], "texCoord": 0}}}
    scene.json["materials"] = [{
        "name": "all", "alphaMode": "BLEND", "doubleSided": True, "emissiveFactor": [1, 0.5, 0],
        "pbrMetallicRoughness": {"baseColorTexture": info(0, **moved), "metallicRoughnessTexture": info(1), "metallicFactor": 0.5},
        "normalTexture": info(2, scale=0.5), "occlusionTexture": info(1, strength=0.5), "emissiveTexture": info(3),
        "extras": {"sideray": {"rayTraced": True, "blend": "additive"}},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": info(1, **moved)},
            "KHR_materials_volume": {"thicknessFactor": 0.1, "thicknessTexture": info(1), "attenuationDistance": 2,
                                     "attenuationColor": [0.5, 0.6, 0.7]},
            "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 0.9, 0.8], "specularTexture": info(0),
                                       "specularColorTexture": info(1)},
            "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.2, "clearcoatTexture": info(1),
                                        "clearcoatRoughnessTexture": info(1), "clearcoatNormalTexture": info(2, scale=0.4)},
            "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.4, "sheenColorTexture": info(1),
                                    "sheenRoughnessTexture": info(0)},
            "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.3, "diffuseTransmissionColorFactor": [1, 1, 0],
                                                   "diffuseTransmissionTexture": info(0), "diffuseTransmissionColorTexture": info(1)},
            "KHR_materials_iridescence": {"iridescenceFactor": 0.8, "iridescenceIor": 1.6, "iridescenceThicknessMinimum": 50,
                                          "iridescenceTexture": info(1), "iridescenceThicknessTexture": info(2)},
            "KHR_materials_emissive_strength": {"emissiveStrength": 5},
        }}, {"name": "unlit", "alphaMode": "MASK", "alphaCutoff": 0.3, "extensions": {"KHR_materials_unlit": {}}},
        {"name": "old", "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [1, 0, 0, 1], "specularFactor": [0.2, 0.2, 0.2], "glossinessFactor": 0.7, "diffuseTexture": info(0),
            "specularGlossinessTexture": info(0)}}}]
    scene.extensions(*scene.json["materials"][0]["extensions"], "KHR_texture_transform", "KHR_materials_unlit",
                     "KHR_materials_pbrSpecularGlossiness", *(["EXT_texture_webp"] if "webp" in emissive else []))
    scene.json["meshes"] = [{"primitives": [{**scene.primitive, "material": i} for i in range(3)]}]
    scene.write(name)


def skinned(name):
    scene = Scene()
    half = math.sqrt(0.5)
    scene.attributes["JOINTS_0"] = scene.add([0, 1, 0, 0] * 4, U8, "VEC4")
    scene.attributes["WEIGHTS_0"] = scene.add([0.75, 0.25, 0, 0] * 4, FLOAT, "VEC4")
    matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    scene.json["skins"] = [{"joints": [1, 2], "inverseBindMatrices": scene.add(matrix * 2, FLOAT, "MAT4"), "skeleton": 1}]
    scene.json["nodes"] = [{"mesh": 0, "skin": 0}, {"children": [2], "translation": [0, 1, 0]}, {"rotation": [0, 0, half, half]}]
    scene.json["scenes"] = [{"nodes": [0, 1]}]
    times = scene.add([0, 0.5, 2], FLOAT, "SCALAR", min=[0], max=[2])
    moves = scene.add([0, 0, 0, 1, 0, 0, 0, 2, 0], FLOAT, "VEC3")
    turns = scene.add([0, 0, 0, 1, 0, 0, half, half, 0, 0, 1, 0], FLOAT, "VEC4")
    cubic = scene.add([1.0] * 27, FLOAT, "VEC3")
    scene.json["animations"] = [{
        "name": "wave",
        "samplers": [{"input": times, "output": moves, "interpolation": "STEP"}, {"input": times, "output": turns},
                     {"input": times, "output": cubic, "interpolation": "CUBICSPLINE"}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}},
                     {"sampler": 1, "target": {"node": 2, "path": "rotation"}},
                     {"sampler": 2, "target": {"node": 2, "path": "scale"}}]}]
    scene.write(name)


def placed(name):
    scene = Scene()
    scene.extensions("EXT_mesh_gpu_instancing", "KHR_lights_punctual")
    instances = {"TRANSLATION": scene.add([0, 0, 0, 2, 0, 0], FLOAT, "VEC3"),
                 "ROTATION": scene.add([0, 0, 0, 1, 0, 1, 0, 0], FLOAT, "VEC4"), "SCALE": scene.add([1, 1, 1, 2, 2, 2], FLOAT, "VEC3")}
    scene.json["nodes"] = [
        {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": instances}}},
        {"camera": 0, "translation": [0, 0, 5]}, {"camera": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
        *({"extensions": {"KHR_lights_punctual": {"light": i}}, "translation": [0, 2, 0]} for i in range(3))]
    scene.json["scenes"] = [{"nodes": list(range(6))}]
    scene.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1, "aspectRatio": 1.5}},
                             {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 10}}]
    scene.json["extensions"] = {"KHR_lights_punctual": {"lights": [
        {"type": "directional", "intensity": 3, "extras": {"sideray": {"angular_diameter_deg": 1}}},
        {"type": "point", "color": [1, 0.5, 0], "range": 10, "extras": {"sideray": {"radius_m": 0.1}}},
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]}}
    scene.write(name)


def packed(name):
    """Quantized, strided, sparse and strip geometry."""
    scene = Scene()
    scene.extensions("KHR_mesh_quantization")
    scene.attributes["POSITION"] = scene.add([0, 0, 0, 32767, 0, 0, 32767, 32767, 0, 0, 32767, 0], I16, "VEC3", normalized=True)
    scene.attributes["COLOR_0"] = scene.add([255, 128, 0, 255] * 4, U8, "VEC4", normalized=True)
    scene.attributes["TEXCOORD_1"] = scene.add([0, 65535] * 4, U16, "VEC2", normalized=True)
    scene.json["accessors"][scene.attributes["NORMAL"]]["sparse"] = {
        "count": 1, "indices": {"bufferView": scene.view(struct.pack("<H", 2)), "componentType": U16},
        "values": {"bufferView": scene.view(struct.pack("<3f", 0, 1, 0))}}
    del scene.primitive["indices"]
    scene.primitive["mode"] = 5
    scene.json["meshes"][0]["primitives"].append({**scene.primitive, "mode": 6})
    scene.write(name)


def pointed(name):
    """Values that channels point at, variants of materials, scattering, lines and points."""
    scene = Scene()
    scene.extensions("KHR_animation_pointer", "KHR_node_visibility", "KHR_materials_variants", "KHR_materials_volume_scatter",
                     "KHR_lights_punctual")
    scene.json["materials"] = [
        {"name": "milk", "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 0.5},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.5, 0.4, 0.3]},
            "KHR_materials_volume_scatter": {"multiscatterColorFactor": [0.9, 0.8, 0.7], "scatterAnisotropy": 0.2}}},
        {"name": "ink"}]
    scene.json["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "inked"}]},
                                "KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.5}}]}}
    scene.primitive["material"] = 0
    scene.primitive["extensions"] = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}
    scene.json["meshes"][0]["primitives"] += [{"attributes": scene.attributes, "mode": mode} for mode in range(4)]
    scene.json["nodes"] = [{"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": True}}}, {"camera": 0},
                           {"extensions": {"KHR_lights_punctual": {"light": 0}, "KHR_node_visibility": {"visible": False}}}]
    scene.json["scenes"] = [{"nodes": [0, 1, 2]}]
    scene.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    times = scene.add([0, 1], FLOAT, "SCALAR", min=[0], max=[1])
    outputs = {1: scene.add([0.25, 1], FLOAT, "SCALAR"), 3: scene.add([0, 0.5, 1, 1, 0, 0], FLOAT, "VEC3"),
               4: scene.add([0, 0, 0, 1, 1, 1, 1, 1], FLOAT, "VEC4"), 0: scene.add([1, 0], U8, "SCALAR")}
    pointers = [("/materials/1/pbrMetallicRoughness/baseColorFactor", 4), ("/materials/0/emissiveFactor", 3),
                ("/materials/0/extensions/KHR_materials_volume/thicknessFactor", 1), ("/nodes/0/translation", 3),
                ("/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle", 1), ("/cameras/0/perspective/yfov", 1),
                ("/nodes/2/extensions/KHR_node_visibility/visible", 0)]
    scene.json["animations"] = [{
        "samplers": [{"input": times, "output": outputs[count]} for _, count in pointers],
        "channels": [{"sampler": i, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}}
                     for i, (pointer, _) in enumerate(pointers)]}]
    scene.write(name)


if __name__ == "__main__":
    Scene().write("square.gltf")
    Scene().write("square.glb")
    materials("materials.glb", "p16.png")
    materials("webp.glb", "a.webp")
    skinned("skinned.gltf")
    skinned("skinned.glb")
    placed("placed.gltf")
    packed("packed.glb")
    pointed("pointed.gltf")
