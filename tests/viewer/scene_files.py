"""Small files to load and to drop, written without the program."""
import base64
import json
import struct


def gltf(path, size=1.0):
    """A square in the colour of one of two variants of materials, which moves to the right and back in four seconds."""
    corners = [(-size, -size, 0), (size, -size, 0), (size, size, 0), (-size, size, 0)]
    data = b"".join(struct.pack("<3f", *c) for c in corners) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    data += struct.pack("<3f", 0, 2, 4) + struct.pack("<9f", 0, 0, 0, 2, 0, 0, 0, 0, 0)
    colours = {"plain": [0.8, 0.8, 0.8, 1], "red": [0.9, 0.05, 0.05, 1], "blue": [0.05, 0.05, 0.9, 1]}
    variants = {"variants": [{"name": "red"}, {"name": "blue"}]}
    mappings = {"mappings": [{"material": 1, "variants": [0]}, {"material": 2, "variants": [1]}]}
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "square"}],
        "extensionsUsed": ["KHR_materials_variants"], "extensions": {"KHR_materials_variants": variants},
        "materials": [{"name": name, "pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0}}
                      for name, colour in colours.items()],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0,
                                    "extensions": {"KHR_materials_variants": mappings}}]}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteOffset": offset, "byteLength": size}
                        for offset, size in ((0, 48), (48, 12), (60, 12), (72, 36))],
        "animations": [{"samplers": [{"input": 2, "output": 3}],
                        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-size, -size, 0],
                       "max": [size, size, 0]}, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
                      {"bufferView": 2, "componentType": 5126, "count": 3, "type": "SCALAR", "min": [0], "max": [4]},
                      {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC3"}]}))


def hdr(path, red, green, blue):
    """Surroundings of one colour, in Radiance's format; each part is a mantissa of 8 bits for the exponent 1."""
    width, height = 16, 8
    path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) +
                     bytes([red, green, blue, 129]) * (width * height))
