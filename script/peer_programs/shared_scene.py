"""Makes the scene that all programs of script/peers draw: one .glb, one camera, one sky."""
import json
import math
import struct

from processes import Failure

MOST_OF_DIMMED_LAMPS = 2  # candela


def read_glb(path):
    """(JSON, what follows its chunk) of a .glb."""
    data = path.read_bytes()
    if data[:4] != b"glTF" or len(data) < 20:
        raise Failure(f"{path} is not a .glb")
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[20 + length:]


def write_glb(path, gltf, rest):
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest)


def looking(eye, target):
    """The columns of a glTF matrix that looks from eye to target along its -Z, with +Y up as far as that goes."""
    back = [a - b for a, b in zip(eye, target)]
    length = math.hypot(*back)
    if length == 0:
        raise Failure("--eye and --target are the same point")
    back = [c / length for c in back]
    hint = [0, 1, 0] if abs(back[1]) < 0.999 else [0, 0, -1]
    right = cross(hint, back)
    right = [c / math.hypot(*right) for c in right]
    return [*right, 0, *cross(back, right), 0, *back, 0, *eye, 1]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def add_node(gltf, **node):
    gltf["nodes"].append(node)
    gltf["scenes"][gltf.get("scene", 0)]["nodes"].append(len(gltf["nodes"]) - 1)


def place_camera(gltf, options):
    """The index of the camera that all use."""
    cameras = gltf.setdefault("cameras", [])
    if options.eye:
        cameras.append({"type": "perspective", "perspective": {"yfov": math.radians(options.fov), "znear": 0.01}})
        add_node(gltf, camera=len(cameras) - 1, matrix=looking(options.eye, options.target))
        return len(cameras) - 1
    if options.camera >= len(cameras):
        raise Failure(f"the scene has {len(cameras)} cameras and not one of index {options.camera}; place one with --eye "
                      "and --target")
    return options.camera


def add_light_where_none(gltf):
    extension = gltf.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {})
    if extension.get("lights"):
        return
    extension["lights"] = [{"type": "directional", "intensity": 3.0}]
    used = gltf.setdefault("extensionsUsed", [])
    gltf["extensionsUsed"] = sorted({*used, "KHR_lights_punctual"})
    add_node(gltf, matrix=looking([0, 0, 0], [-0.4, -0.8, -0.45]), extensions={"KHR_lights_punctual": {"light": 0}})


def dim_lamps(gltf):
    """F3D takes candela without a falloff: bright lamps would make its picture white."""
    for light in gltf["extensions"]["KHR_lights_punctual"]["lights"]:
        if light["type"] != "directional":
            light["intensity"] = min(light.get("intensity", 1), MOST_OF_DIMMED_LAMPS)


def copy_scene(source, path, dimmed_path, options):
    """Writes the scene that all draw, and its copy for F3D; the index of its camera."""
    gltf, rest = read_glb(source)
    for node in gltf["nodes"]:
        node.get("extras", {}).get("sideray", {}).pop("particles", None)
    camera = place_camera(gltf, options)
    add_light_where_none(gltf)
    write_glb(path, gltf, rest)
    dim_lamps(gltf)
    write_glb(dimmed_path, gltf, rest)
    return camera


def write_sky(path, width=256, height=128):
    """Writes Sideray's sky (scenes/scene.cpp) as a lat-long picture in Radiance's format."""
    zenith, horizon, ground = (0.25, 0.45, 0.9), (0.81, 0.855, 0.9), (0.25, 0.22, 0.2)
    data = bytearray(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
    for row in range(height):
        up = math.sin((0.5 - (row + 0.5) / height) * math.pi)
        above = min(max((up + 0.05) / 0.05, 0), 1)
        above *= above * (3 - 2 * above)
        air = [h + (z - h) * math.sqrt(max(up, 0)) for h, z in zip(horizon, zenith)]
        color = [g + (a - g) * above for g, a in zip(ground, air)]
        exponent = math.frexp(max(color))[1]
        data += bytes([*(int(c * 256 / 2**exponent) for c in color), exponent + 128]) * width
    path.write_bytes(data)
