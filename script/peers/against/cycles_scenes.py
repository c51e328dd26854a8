#!/usr/bin/python3
"""Writes calibration-*.glb, spheres.glb and glass.glb for script/peers/against/cycles: materials where both renderers compute the
same formula, and materials where they do not."""
import array
import json
import math
import pathlib
import struct
import sys


class Scene:
    def __init__(self):
        self.binary = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                     "materials": [], "accessors": [], "bufferViews": [], "cameras": [],
                     "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular"],
                     "extensions": {"KHR_lights_punctual": {"lights": []}}}

    def accessor(self, values, code, component, kind, width, **extra):
        data = array.array(code, values).tobytes()
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data + bytes(-len(data) % 4)
        self.json["accessors"].append({"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component,
                                       "type": kind, "count": len(values) // width, **extra})
        return len(self.json["accessors"]) - 1

    def mesh(self, positions, normals, indices, material):
        flat = [c for p in positions for c in p]
        bounds = {"min": [min(flat[i::3]) for i in range(3)], "max": [max(flat[i::3]) for i in range(3)]}
        attributes = {"POSITION": self.accessor(flat, "f", 5126, "VEC3", 3, **bounds),
                      "NORMAL": self.accessor([c for n in normals for c in n], "f", 5126, "VEC3", 3)}
        self.json["meshes"].append({"primitives": [{"attributes": attributes, "material": material,
                                                    "indices": self.accessor(indices, "I", 5125, "SCALAR", 1)}]})
        return len(self.json["meshes"]) - 1

    def same_mesh(self, mesh, material):
        primitive = self.json["meshes"][mesh]["primitives"][0]
        self.json["meshes"].append({"primitives": [{**primitive, "material": material}]})
        return len(self.json["meshes"]) - 1

    def material(self, name, color, metallic, roughness, specular=1.0):
        self.json["materials"].append({
            "name": name, "doubleSided": True, "extensions": {"KHR_materials_specular": {"specularFactor": specular}},
            "pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": metallic, "roughnessFactor": roughness}})
        return len(self.json["materials"]) - 1

    def node(self, **node):
        self.json["nodes"].append(node)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def light(self, kind, intensity, size, **node):
        lights = self.json["extensions"]["KHR_lights_punctual"]["lights"]
        key = "angular_diameter_deg" if kind == "directional" else "radius_m"
        lights.append({"type": kind, "intensity": intensity, "extras": {"sideray": {key: size}}})
        self.node(extensions={"KHR_lights_punctual": {"light": len(lights) - 1}}, **node)

    def camera(self, yfov, **node):
        self.json["cameras"].append({"type": "perspective", "perspective": {"yfov": yfov, "znear": 0.1}})
        self.node(camera=len(self.json["cameras"]) - 1, **node)

    def floor(self, size, material):
        corners = [(-size, 0, size), (size, 0, size), (size, 0, -size), (-size, 0, -size)]
        return self.mesh(corners, [(0, 1, 0)] * 4, [0, 1, 2, 0, 2, 3], material)

    def sphere(self, material, rings=96):
        points, indices = [], []
        for i in range(rings + 1):
            for j in range(2 * rings + 1):
                polar, around = math.pi * i / rings, math.pi * j / rings
                points.append((math.sin(polar) * math.cos(around), math.cos(polar), -math.sin(polar) * math.sin(around)))
        for i in range(rings):
            for j in range(2 * rings):
                a = i * (2 * rings + 1) + j
                b = a + 2 * rings + 1
                indices += ([a, b, b + 1] if i < rings - 1 else []) + ([a, b + 1, a + 1] if i > 0 else [])
        return self.mesh(points, points, indices, material)

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(self.binary), 0x004E4942) + self.binary
        pathlib.Path(path).write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def turned_about_x(degrees):
    return [math.sin(math.radians(degrees) / 2), 0, 0, math.cos(math.radians(degrees) / 2)]


def calibration(path, kind):
    """A white Lambertian floor seen from above under one light."""
    scene = Scene()
    scene.node(mesh=scene.floor(10, scene.material("white", (1, 1, 1), 0, 1, specular=0)))
    if kind == "sun":
        scene.light("directional", 3.0, 0.53, rotation=turned_about_x(-90))
    else:
        scene.light("point", 10.0, 0.1, translation=[0, 2, 0])
    scene.camera(0.5, translation=[0, 5, 0], rotation=turned_about_x(-90))
    scene.write(path)


def calibration_metal(path):
    """A white metal floor of roughness 1, lit and seen at 60 degrees from opposite sides: the half vector is the normal."""
    scene = Scene()
    scene.node(mesh=scene.floor(10, scene.material("metal", (1, 1, 1), 1, 1)))
    scene.light("directional", 3.0, 0.53, rotation=turned_about_x(-150))
    scene.camera(0.05, translation=[0, 5, 5 * math.sqrt(3)], rotation=turned_about_x(-30))
    scene.write(path)


def spheres(path):
    """Rows from the front: Lambertian, white metal, copper, dielectric; roughness 0.1 to 1 from left to right."""
    scene = Scene()
    scene.node(name="floor", mesh=scene.floor(20, scene.material("floor", (0.4, 0.4, 0.4), 0, 1, specular=0)))
    ball = None
    for row in range(4):
        for column in range(5):
            roughness = (0.1, 0.3, 0.5, 0.7, 1.0)[column]
            material = [
                scene.material("lambert", (0.2 + 0.15 * column, 0.5, 0.8 - 0.15 * column), 0, roughness, specular=0),
                scene.material("white metal", (1, 1, 1), 1, roughness),
                scene.material("copper", (0.95, 0.64, 0.54), 1, roughness),
                scene.material("dielectric", (0.1, 0.3, 0.6), 0, roughness)][row]
            ball = scene.same_mesh(ball, material) if ball else scene.sphere(material)
            scene.node(mesh=ball, scale=[0.45] * 3, translation=[column - 2, 0.45, 1.5 - row])
    scene.light("directional", 2.0, 0.53, rotation=turned_about_x(-50))
    scene.light("point", 20.0, 0.2, translation=[-2, 3, 2.5])
    scene.camera(0.6, translation=[0, 4.5, 6.5], rotation=turned_about_x(-36))
    scene.write(path)


def glass(path):
    """A clear and a green ball of glass in a room without a front, under a square that shines."""
    scene = Scene()
    scene.json["extensionsUsed"] += ["KHR_materials_transmission", "KHR_materials_ior", "KHR_materials_volume",
                                     "KHR_materials_emissive_strength"]
    white, red, blue = (scene.material(name, color, 0, 1, specular=0) for name, color in (
        ("white", (0.7, 0.7, 0.7)), ("red", (0.6, 0.1, 0.1)), ("blue", (0.1, 0.2, 0.6))))

    def wall(center, u, v, material):
        corners = [tuple(center[i] + a * u[i] + b * v[i] for i in range(3)) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        scene.node(mesh=scene.mesh(corners, [normal] * 4, [0, 1, 2, 0, 2, 3], material))

    wall((0, 0, 0), (1.5, 0, 0), (0, 0, -1), white)
    wall((0, 1, -1), (1.5, 0, 0), (0, 1, 0), white)
    wall((-1.5, 1, 0), (0, 0, -1), (0, 1, 0), red)
    wall((1.5, 1, 0), (0, 0, 1), (0, 1, 0), blue)
    shining = scene.material("shining", (0, 0, 0), 0, 1, specular=0)
    scene.json["materials"][shining].update(emissiveFactor=[1, 1, 1])
    scene.json["materials"][shining]["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": 8}
    wall((0, 2, 0), (0.6, 0, 0), (0, 0, 0.6), shining)
    ball = None
    for x, color in ((-0.55, None), (0.6, (0.2, 0.8, 0.3))):
        material = scene.material("glass", (1, 1, 1), 0, 0)
        volume = {"thicknessFactor": 1, **({"attenuationDistance": 0.5, "attenuationColor": color} if color else {})}
        scene.json["materials"][material]["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1},
                                                           "KHR_materials_ior": {"ior": 1.5}, "KHR_materials_volume": volume}
        ball = scene.same_mesh(ball, material) if ball else scene.sphere(material)
        scene.node(mesh=ball, scale=[0.45] * 3, translation=[x, 0.5, 0.1])
    scene.light("point", 0, 0.1, translation=[0, 1.9, 0])  # in place of the light that a file without any gets
    scene.camera(0.7, translation=[0, 1.1, 4], rotation=turned_about_x(-4))
    scene.write(path)


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    calibration(folder / "calibration-sun.glb", "sun")
    calibration(folder / "calibration-point.glb", "point")
    calibration_metal(folder / "calibration-metal.glb")
    spheres(folder / "spheres.glb")
    glass(folder / "glass.glb")
