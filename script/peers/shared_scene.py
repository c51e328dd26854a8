"""Makes the scene that all programs of script/scoreboard draw: one .glb, one camera, one sky."""
import copy
import json
import math
import struct

import numpy
from gltf import Glb, Material, read_hdr, write_hdr
from processes import Failure

MOST_OF_DIMMED_LAMPS = 2  # candela
# Extensions that not all programs support; without them all draw the same picture.
LEFT_OUT = ("clearcoat", "sheen", "diffuse_transmission", "dispersion", "iridescence", "anisotropy")

COMPRESSED = {"EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_draco_mesh_compression"}


def write_glb(path, gltf, binary):
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A) + text +
                     struct.pack("<II", len(binary), 0x004E4942) + binary)


def refuse_compressed(path, gltf):
    """Refuses meshes that need a decoder, which not all programs have."""
    for name in COMPRESSED & set(gltf.get("extensionsRequired", [])):
        raise Failure(f"{path} is compressed by {name}, which not all programs read; export it again without compression")


def pack(path):
    """(JSON, binary) of a .glb or of a .gltf with its files."""
    if path.suffix == ".glb":
        glb = Glb(path)
        refuse_compressed(path, glb.json)
        return glb.json, glb.binary
    gltf, binary = json.loads(path.read_text()), bytearray()
    refuse_compressed(path, gltf)

    def append(data):
        binary.extend(b"\0" * (-len(binary) % 4))
        binary.extend(data)
        return len(binary) - len(data)

    starts = [append((path.parent / buffer["uri"]).read_bytes()) for buffer in gltf["buffers"]]
    for view in gltf["bufferViews"]:
        view.update(buffer=0, byteOffset=view.get("byteOffset", 0) + starts[view["buffer"]])
    for image in gltf.get("images", []):
        if "uri" in image:
            data = (path.parent / image.pop("uri")).read_bytes()
            image.update(bufferView=len(gltf["bufferViews"]),
                         mimeType="image/png" if data[:4] == b"\x89PNG" else "image/jpeg")
            gltf["bufferViews"].append({"buffer": 0, "byteOffset": append(data), "byteLength": len(data)})
    gltf["buffers"] = [{"byteLength": len(binary)}]
    return gltf, bytes(binary)


def looking(eye, target):
    """The columns of a glTF matrix that looks from eye to target along its -Z, with +Y up as far as that goes."""
    back = numpy.subtract(eye, target).astype(float)
    if not back.any():
        raise Failure("the camera's eye and target are the same point")
    back /= numpy.linalg.norm(back)
    right = numpy.cross([0, 1, 0] if abs(back[1]) < 0.999 else [0, 0, -1], back)
    right /= numpy.linalg.norm(right)
    return [*right, 0, *numpy.cross(back, right), 0, *back, 0, *eye, 1]


def add_node(gltf, **node):
    gltf["nodes"].append(node)
    gltf["scenes"][gltf.get("scene", 0)]["nodes"].append(len(gltf["nodes"]) - 1)


def place_camera(gltf, setting):
    """The index of the camera that all use: the file then has no other one."""
    cameras = gltf.setdefault("cameras", [])
    if setting.eye:
        cameras.append({"type": "perspective", "perspective": {"yfov": math.radians(setting.fov), "znear": 0.01}})
        add_node(gltf, camera=len(cameras) - 1, matrix=looking(setting.eye, setting.target))
        chosen = len(cameras) - 1
    else:
        names = [next((n.get("name") for n in gltf["nodes"] if n.get("camera") == i), None) for i in range(len(cameras))]
        chosen = names.index(setting.camera) if setting.camera in names else int(setting.camera or 0)
    if chosen >= len(cameras):
        raise Failure(f"the scene has {len(cameras)} cameras; place one with --eye and --target")
    for node in gltf["nodes"]:
        if node.get("camera", chosen) != chosen:
            del node["camera"]
        elif "camera" in node:
            node["camera"] = 0
    gltf["cameras"] = [cameras[chosen]]
    perspective = gltf["cameras"][0]["perspective"]
    perspective["aspectRatio"] = setting.width / setting.height
    perspective.setdefault("zfar", 1000.0)


def add_lamps(gltf, setting):
    """Lamps of the setting; a sun where neither it, its sky nor the file has light."""
    extension = gltf.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {})
    lights = extension.setdefault("lights", [])
    for position, candela in setting.lamps:
        lights.append({"type": "point", "intensity": candela, "color": [1, 0.85, 0.7], "extras": {"sideray": {"radius_m": 0.05}}})
        add_node(gltf, translation=position, extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})
    if not lights and setting.sky == "sky":
        lights.append({"type": "directional", "intensity": 3.0, "extras": {"sideray": {"angular_diameter_deg": 0.53}}})
        add_node(gltf, matrix=looking([0, 0, 0], [-0.4, -0.8, -0.45]), extensions={"KHR_lights_punctual": {"light": 0}})
    if lights:
        gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), "KHR_lights_punctual"})
    else:
        del gltf["extensions"]["KHR_lights_punctual"]


def simplify(gltf):
    """Leaves out particles, wind, animation and the lobes that not all programs have."""
    for node in gltf["nodes"]:
        for name in ("particles", "wind"):
            node.get("extras", {}).get("sideray", {}).pop(name, None)
    gltf.pop("animations", None)
    names = {"KHR_materials_" + name for name in LEFT_OUT}
    for material in gltf.get("materials", []):
        for name in names & set(material.get("extensions", {})):
            del material["extensions"][name]
    gltf["extensionsUsed"] = [name for name in gltf.get("extensionsUsed", []) if name not in names]


def is_transmissive(material):
    return "KHR_materials_transmission" in material.get("extensions", {})


def make_thin_wall(material):
    """A wall that does not bend light and is seen from both sides. A body's wall has two surfaces: each gets half of its tint."""
    extensions, pbr = material["extensions"], material.setdefault("pbrMetallicRoughness", {})
    if "KHR_materials_volume" in extensions:
        color = pbr.get("baseColorFactor", [1, 1, 1, 1])
        pbr["baseColorFactor"] = [*(c * math.sqrt(t) for c, t in zip(color, Material(material).tint())), color[3]]
        del extensions["KHR_materials_volume"]
    material["doubleSided"] = True


def free_lamps(gltf, binary):
    """Makes glass around lamps, and glass that shines, thin walls: through refracting ones lamps light by caustics alone, which path
    tracers hardly find and denoisers remove. Lamps shrink to half their distance to these walls: of a sphere that touches
    its bulb each program sees another part outside."""
    glb = Glb.of(gltf, binary)
    walls = [material for material in gltf.get("materials", []) if is_transmissive(material) and any(material.get("emissiveFactor", []))]
    lamps = [(light, world[:3, 3]) for light, world in glb.lights() if light["type"] != "directional"]
    for _, primitive, material, world in glb.meshes():
        if not is_transmissive(material):
            continue
        points = glb.accessor(primitive["attributes"]["POSITION"]) @ world[:3, :3].T + world[:3, 3]
        for light, position in lamps:
            if (points.min(axis=0) < position).all() and (position < points.max(axis=0)).all():
                walls.append(material)
                lamp = light.get("extras", {}).get("sideray", {})
                nearest = float(numpy.linalg.norm(points - position, axis=1).min())
                lamp["radius_m"] = min(lamp.get("radius_m", 0), nearest / 2)
    for wall in walls:
        make_thin_wall(wall)


def set_thickness(gltf, thickness):
    """Corrects thicknesses that are far too large in the file: rasterizers would draw these bodies black."""
    for material in gltf.get("materials", []):
        if material.get("name") in thickness:
            material["extensions"]["KHR_materials_volume"]["thicknessFactor"] = thickness[material["name"]]


def dim(gltf, factor):
    """Scales all light of the file, so that few pixels are brighter than white: no picture is tone mapped."""
    for light in gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        light["intensity"] = light.get("intensity", 1) * factor
    for material in gltf.get("materials", []):
        extensions = material.setdefault("extensions", {})
        if "KHR_materials_unlit" in extensions:
            pbr = material.setdefault("pbrMetallicRoughness", {})
            color = pbr.get("baseColorFactor", [1, 1, 1, 1])
            pbr["baseColorFactor"] = [*(min(1, c * factor) for c in color[:3]), color[3]]
        strength = extensions.pop("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1) * factor
        emission = [c * strength for c in material.get("emissiveFactor", [0, 0, 0])]
        if max(emission) > 0:
            largest = max(1, *emission)
            material["emissiveFactor"] = [c / largest for c in emission]
            if largest > 1:
                extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": largest}
        if not extensions:
            del material["extensions"]


def without_instancing(gltf, binary):
    """A copy whose instances are nodes, for programs that do not read EXT_mesh_gpu_instancing."""
    gltf = copy.deepcopy(gltf)
    glb = Glb.of(gltf, binary)
    for node in list(gltf["nodes"]):
        if "EXT_mesh_gpu_instancing" in node.get("extensions", {}):
            mesh = node.pop("mesh")
            instances = [matrix.T.ravel().tolist() for matrix in glb.instances(node)]
            del node["extensions"]["EXT_mesh_gpu_instancing"]
            for matrix in instances:
                gltf["nodes"].append({"mesh": mesh, "matrix": matrix})
                node.setdefault("children", []).append(len(gltf["nodes"]) - 1)
    for key in ("extensionsUsed", "extensionsRequired"):
        if key in gltf:
            gltf[key] = [name for name in gltf[key] if name != "EXT_mesh_gpu_instancing"]
    return gltf


def dim_lamps(gltf):
    """F3D takes candela without a falloff: bright lamps would make its picture white. Where there is no light it adds its own, so it
    gets one that is too weak to be seen."""
    lights = gltf.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    if not lights:
        lights.append({"type": "directional", "intensity": 1e-4})
        add_node(gltf, extensions={"KHR_lights_punctual": {"light": 0}})
        gltf["extensionsUsed"] = [*gltf.get("extensionsUsed", []), "KHR_lights_punctual"]
    for light in lights:
        if light["type"] != "directional":
            light["intensity"] = min(light.get("intensity", 1), MOST_OF_DIMMED_LAMPS)


def copy_scene(source, folder, setting):
    """Writes scene.glb, which has one camera, flat.glb without instancing, dimmed.glb for F3D, and where there is a sky sky.hdr
    and turned.hdr, whose middle is +X as VTK has it."""
    gltf, binary = pack(source)
    simplify(gltf)
    free_lamps(gltf, binary)
    set_thickness(gltf, setting.thickness)
    place_camera(gltf, setting)
    add_lamps(gltf, setting)
    dim(gltf, 2.0**setting.exposure)
    write_glb(folder / "scene.glb", gltf, binary)
    flat = without_instancing(gltf, binary)
    write_glb(folder / "flat.glb", flat, binary)
    dim_lamps(flat)
    write_glb(folder / "dimmed.glb", flat, binary)
    if setting.sky != "none":
        sky = 2.0**setting.exposure * (gradient() if setting.sky == "sky" else read_hdr(setting.sky))
        write_hdr(folder / "sky.hdr", sky)
        write_hdr(folder / "turned.hdr", numpy.roll(sky, -sky.shape[1] // 4, axis=1))


def gradient(width=256, height=128):
    """Sideray's sky (scenes/scene.cpp) as a lat-long picture."""
    zenith, horizon, ground = (numpy.array(c) for c in ((0.25, 0.45, 0.9), (0.81, 0.855, 0.9), (0.25, 0.22, 0.2)))
    up = numpy.sin((0.5 - (numpy.arange(height) + 0.5) / height) * math.pi)[:, None]
    above = numpy.clip((up + 0.05) / 0.05, 0, 1)
    above = above * above * (3 - 2 * above)
    air = horizon + (zenith - horizon) * numpy.sqrt(numpy.maximum(up, 0))
    rows = ground + (air - ground) * above
    return numpy.repeat(rows[:, None, :], width, axis=1)
