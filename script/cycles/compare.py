"""Renders a .glb in Blender's Cycles, with direct light only or by paths: run by script/cycles/compare.

Own reader: Blender's importer changes lights and materials. The scene stays in glTF's axes (+Y up).
"""
import argparse
import json
import math
import pathlib
import struct
import sys
import tempfile

import bpy
from mathutils import Matrix, Quaternion, Vector

COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
CODES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
LARGEST = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}


class Glb:
    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + length])
        self.binary = data[20 + length + 8:]

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.binary[start:start + view["byteLength"]], view.get("byteStride", 0)

    def accessor(self, index):
        """The elements as tuples."""
        accessor = self.json["accessors"][index]
        data, stride = self.view(accessor["bufferView"])
        form = struct.Struct("<%d%s" % (COMPONENTS[accessor["type"]], CODES[accessor["componentType"]]))
        start, step = accessor.get("byteOffset", 0), stride or form.size
        elements = [form.unpack_from(data, start + i * step) for i in range(accessor["count"])]
        if accessor.get("normalized"):
            elements = [tuple(c / LARGEST[accessor["componentType"]] for c in e) for e in elements]
        return elements


class Nodes:
    """Builds one shader from formulas."""

    def __init__(self, material):
        material.use_nodes = True
        self.tree = material.node_tree
        self.tree.nodes.clear()

    def make(self, kind, inputs=(), **properties):
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for key, value in dict(inputs).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, node.inputs[key])
            elif value is not None:
                is_color = node.inputs[key].type == "RGBA" and len(value) == 3
                node.inputs[key].default_value = (*value, 1) if is_color else value
        return node

    def math(self, operation, *values):
        return self.make("ShaderNodeMath", dict(enumerate(values)), operation=operation).outputs[0]

    def vector(self, operation, *values):
        node = self.make("ShaderNodeVectorMath", dict(enumerate(values)), operation=operation)
        return node.outputs["Value" if operation == "DOT_PRODUCT" else 0]

    def shader(self, kind, **inputs):
        return self.make(kind, inputs).outputs[0]

    def add(self, a, b):
        return self.make("ShaderNodeAddShader", {0: a, 1: b}).outputs[0]


def triple(value):
    return (value, value, value)


def mix(nodes, a, b, t):
    """a + (b - a) t of vectors; t is a socket or a number."""
    t3 = nodes.make("ShaderNodeCombineXYZ", {0: t, 1: t, 2: t}).outputs[0]
    return nodes.vector("ADD", a, nodes.vector("MULTIPLY", nodes.vector("SUBTRACT", b, a), t3))


def texture(nodes, glb, images, info, linear):
    source = glb.json["textures"][info["index"]]["source"]
    key = (source, linear)
    if key not in images:
        entry = glb.json["images"][source]
        suffix = ".png" if entry["mimeType"] == "image/png" else ".jpg"
        with tempfile.NamedTemporaryFile(suffix=suffix) as file:
            file.write(glb.view(entry["bufferView"])[0])
            file.flush()
            images[key] = bpy.data.images.load(file.name)
            images[key].colorspace_settings.name = "Non-Color" if linear else "sRGB"
            images[key].alpha_mode = "CHANNEL_PACKED"
            images[key].pack()
    uv = nodes.make("ShaderNodeUVMap", uv_map="uv%d" % info.get("texCoord", 0)).outputs[0]
    return nodes.make("ShaderNodeTexImage", {"Vector": uv}, image=images[key])


def factor(nodes, value, info, glb, images, linear):
    """A colour factor times its texture, as a vector socket or a triple; and the texture's alpha."""
    if info is None:
        return tuple(value), None
    node = texture(nodes, glb, images, info, linear)
    return nodes.vector("MULTIPLY", node.outputs["Color"], tuple(value)), node.outputs["Alpha"]


def schlick_of_air(nodes, ior):
    """What a face reflects by glTF's term, at the angle in the air: 1 where light inside is reflected totally."""
    geometry = nodes.make("ShaderNodeNewGeometry")
    cosine = nodes.math("ABSOLUTE", nodes.vector("DOT_PRODUCT", geometry.outputs["Incoming"], geometry.outputs["Normal"]))
    sine2 = nodes.math("MULTIPLY", nodes.math("SUBTRACT", 1.0, nodes.math("MULTIPLY", cosine, cosine)), ior * ior)
    behind = nodes.math("SQRT", nodes.math("MAXIMUM", nodes.math("SUBTRACT", 1.0, sine2), 0.0))
    in_air = nodes.math("ADD", cosine, nodes.math("MULTIPLY", geometry.outputs["Backfacing"], nodes.math("SUBTRACT", behind, cosine)))
    f0 = ((ior - 1) / (ior + 1)) ** 2
    fifth = nodes.math("POWER", nodes.math("SUBTRACT", 1.0, in_air), 5.0)
    return nodes.math("ADD", nodes.math("MULTIPLY", fifth, 1 - f0), f0)


def build_glass(nodes, source, material, schlick):
    """A body of glass by paths: Fresnel's term is that of the two indices or glTF's, and what is inside absorbs (Beer)."""
    pbr, extensions = source.get("pbrMetallicRoughness", {}), source["extensions"]
    color, ior = [*pbr.get("baseColorFactor", [1, 1, 1, 1])[:3], 1], extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    rough = {"Roughness": pbr.get("roughnessFactor", 1)}
    if schlick:
        refracts = nodes.make("ShaderNodeBsdfRefraction", {"Color": color, "IOR": ior, **rough}, distribution="GGX")
        mirrors = nodes.make("ShaderNodeBsdfGlossy", {"Color": [1, 1, 1, 1], **rough}, distribution="GGX")
        glass = nodes.make("ShaderNodeMixShader", {0: schlick_of_air(nodes, ior), 1: refracts.outputs[0], 2: mirrors.outputs[0]})
    else:
        glass = nodes.make("ShaderNodeBsdfGlass", {"Color": color, "IOR": ior, **rough}, distribution="GGX")
    volume = extensions["KHR_materials_volume"]
    inside = None
    if "attenuationDistance" in volume:
        # Cycles absorbs density (1 - color) a unit.
        lost = [-math.log(max(c, 1e-6)) / volume["attenuationDistance"] for c in volume.get("attenuationColor", [1, 1, 1])]
        density = max(lost)
        if density > 0:
            inside = nodes.shader("ShaderNodeVolumeAbsorption", Color=[*(1 - c / density for c in lost), 1], Density=density)
    nodes.make("ShaderNodeOutputMaterial", {"Surface": glass.outputs[0], "Volume": inside})
    return material, False


def build_material(source, glb, images, by_paths, schlick):
    """glTF's metallic-roughness by nodes: Lambert and GGX, weighted by Schlick's Fresnel of the viewing angle."""
    material = bpy.data.materials.new(source.get("name", "material"))
    nodes = Nodes(material)
    pbr, extensions = source.get("pbrMetallicRoughness", {}), source.get("extensions", {})
    if by_paths and extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0) > 0:
        return build_glass(nodes, source, material, schlick)
    rgba = pbr.get("baseColorFactor", [1, 1, 1, 1])
    base, alpha = factor(nodes, rgba[:3], pbr.get("baseColorTexture"), glb, images, False)
    metallic, roughness = pbr.get("metallicFactor", 1), pbr.get("roughnessFactor", 1)
    if "metallicRoughnessTexture" in pbr:
        color = texture(nodes, glb, images, pbr["metallicRoughnessTexture"], True).outputs["Color"]
        parts = nodes.make("ShaderNodeSeparateColor", {0: color}).outputs
        metallic, roughness = nodes.math("MULTIPLY", parts[2], metallic), nodes.math("MULTIPLY", parts[1], roughness)
    roughness = nodes.math("MAXIMUM", roughness, 0.04)
    normal = None
    if "normalTexture" in source:
        color = texture(nodes, glb, images, source["normalTexture"], True).outputs["Color"]
        strength = source["normalTexture"].get("scale", 1)
        normal = nodes.make("ShaderNodeNormalMap", {"Color": color, "Strength": strength}, uv_map="uv0").outputs[0]
    geometry = nodes.make("ShaderNodeNewGeometry")
    cosine = nodes.math("ABSOLUTE", nodes.vector("DOT_PRODUCT", geometry.outputs["Incoming"],
                                                 normal if normal else geometry.outputs["Normal"]))
    fifth = nodes.math("POWER", nodes.math("SUBTRACT", 1.0, cosine), 5.0)
    ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    specular = extensions.get("KHR_materials_specular", {})
    weight = specular.get("specularFactor", 1)
    f0 = [weight * min(1, c * ((ior - 1) / (ior + 1)) ** 2) for c in specular.get("specularColorFactor", [1, 1, 1])]
    fresnel = mix(nodes, mix(nodes, tuple(f0), base, metallic), mix(nodes, triple(weight), triple(1.0), metallic), fifth)
    transmission = extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0)
    passed = nodes.vector("SUBTRACT", triple(1.0), fresnel)
    opaque_share = nodes.math("MULTIPLY", nodes.math("SUBTRACT", 1.0, metallic), 1.0 - transmission)
    diffuse = mix(nodes, triple(0.0), nodes.vector("MULTIPLY", base, passed), opaque_share)
    shader = nodes.shader("ShaderNodeBsdfDiffuse", Color=diffuse, Roughness=0.0, Normal=normal)
    glossy = nodes.make("ShaderNodeBsdfGlossy", {"Color": fresnel, "Roughness": roughness, "Normal": normal}, distribution="MULTI_GGX")
    shader = nodes.add(shader, glossy.outputs[0])
    if transmission > 0:
        through = mix(nodes, triple(0.0), nodes.vector("MULTIPLY", base, passed),
                      nodes.math("MULTIPLY", nodes.math("SUBTRACT", 1.0, metallic), transmission))
        shader = nodes.add(shader, nodes.shader("ShaderNodeBsdfTransparent", Color=through))
    emissive, _ = factor(nodes, source.get("emissiveFactor", [0, 0, 0]), source.get("emissiveTexture"), glb, images, False)
    if any(source.get("emissiveFactor", [0, 0, 0])):
        strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
        shader = nodes.add(shader, nodes.shader("ShaderNodeEmission", Color=emissive, Strength=strength))
    if "KHR_materials_unlit" in extensions:
        shader = nodes.shader("ShaderNodeEmission", Color=base)
    mode = source.get("alphaMode", "OPAQUE")
    if mode != "OPAQUE":
        alpha = nodes.math("MULTIPLY", alpha, rgba[3]) if alpha else rgba[3]
        if mode == "MASK":
            alpha = nodes.math("GREATER_THAN", alpha, source.get("alphaCutoff", 0.5))
        clear = nodes.shader("ShaderNodeBsdfTransparent", Color=(1, 1, 1, 1))
        shader = nodes.make("ShaderNodeMixShader", {0: alpha, 1: clear, 2: shader}).outputs[0]
    if not source.get("doubleSided", False):
        clear = nodes.shader("ShaderNodeBsdfTransparent", Color=(1, 1, 1, 1))
        shader = nodes.make("ShaderNodeMixShader", {0: geometry.outputs["Backfacing"], 1: shader, 2: clear}).outputs[0]
    nodes.make("ShaderNodeOutputMaterial", {"Surface": shader})
    # BLEND and transmissive surfaces cast no shadow where only direct light counts.
    return material, not by_paths and (mode == "BLEND" or transmission > 0)


def build_mesh(primitive, glb):
    attributes = primitive["attributes"]
    positions = glb.accessor(attributes["POSITION"])
    corners = [i for (i,) in glb.accessor(primitive["indices"])] if "indices" in primitive else list(range(len(positions)))
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(positions, [], list(zip(corners[::3], corners[1::3], corners[2::3])))
    for which in range(2):
        if "TEXCOORD_%d" % which in attributes:
            uv = glb.accessor(attributes["TEXCOORD_%d" % which])
            layer = mesh.uv_layers.new(name="uv%d" % which)
            layer.data.foreach_set("uv", [c for i in corners for c in (uv[i][0], 1 - uv[i][1])])
    if "NORMAL" in attributes:
        if hasattr(mesh, "use_auto_smooth"):  # before Blender 4.1
            mesh.use_auto_smooth = True
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        mesh.normals_split_custom_set_from_vertices(glb.accessor(attributes["NORMAL"]))
    return mesh


def node_matrix(node):
    if "matrix" in node:
        m = node["matrix"]
        return Matrix([[m[4 * c + r] for c in range(4)] for r in range(4)])
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    return Matrix.LocRotScale(Vector(node.get("translation", [0, 0, 0])), Quaternion((w, x, y, z)), Vector(node.get("scale", [1, 1, 1])))


def add_object(name, data, world):
    thing = bpy.data.objects.new(name, data)
    thing.matrix_world = world
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_light(light, world):
    """Lux and candela as radiometric numbers. Cycles: a sun's strength is irradiance; a point lamp of P watts has the
    intensity P / (4 pi): both measured on calibration-*.glb."""
    extras = light.get("extras", {}).get("sideray", {})
    color = light.get("color", [1, 1, 1])
    if light["type"] == "directional":
        lamp = bpy.data.lights.new("sun", "SUN")
        lamp.energy, lamp.angle = light.get("intensity", 1), math.radians(extras.get("angular_diameter_deg", 0.53))
    elif light["type"] == "point":
        lamp = bpy.data.lights.new("point", "POINT")
        lamp.energy = light.get("intensity", 1) * 4 * math.pi
        lamp.shadow_soft_size = extras.get("radius_m", 0)
    else:
        sys.exit("cycles/compare: a %s light has no counterpart here; leave it out" % light["type"])
    lamp.color = color
    lamp.cycles.max_bounces = 1024
    add_object("light", lamp, world)


def add_camera(camera, world, aspect):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = camera["yfov"]
    data.clip_start, data.clip_end = camera.get("znear", 0.01), camera.get("zfar", 1e5)
    bpy.context.scene.camera = add_object("camera", data, world)


def build(glb, by_paths, schlick):
    images, meshes = {}, {}
    materials = [build_material(m, glb, images, by_paths, schlick) for m in glb.json.get("materials", [])]
    default = build_material({}, glb, images, by_paths, schlick)
    lights = glb.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    has_light = False

    def place(index, parent):
        nonlocal has_light
        node = glb.json["nodes"][index]
        world = parent @ node_matrix(node)
        for number, primitive in enumerate(glb.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []):
            key = (node["mesh"], number)
            if key not in meshes:
                meshes[key] = build_mesh(primitive, glb)
                material, clear = materials[primitive["material"]] if "material" in primitive else default
                meshes[key].materials.append(material)
            thing = add_object(node.get("name", "node"), meshes[key], world)
            thing.visible_shadow = not (materials[primitive["material"]] if "material" in primitive else default)[1]
        if "camera" in node and bpy.context.scene.camera is None:
            add_camera(glb.json["cameras"][node["camera"]]["perspective"], world, None)
        if "KHR_lights_punctual" in node.get("extensions", {}):
            add_light(lights[node["extensions"]["KHR_lights_punctual"]["light"]], world)
            has_light = True
        for child in node.get("children", []):
            place(child, world)

    for root in glb.json["scenes"][glb.json.get("scene", 0)]["nodes"]:
        place(root, Matrix.Identity(4))
    if not has_light:
        direction = Vector((-0.4, -0.8, -0.45))
        add_light({"type": "directional", "intensity": 3.0}, direction.to_track_quat("-Z", "Y").to_matrix().to_4x4())


def set_up(options):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.seed = options.samples, options.seed
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    # Direct light, or all that bounces; as many transparent surfaces as there are.
    bounces = 0 if options.bounces == "1" else 1024
    scene.cycles.max_bounces = scene.cycles.glossy_bounces = bounces
    scene.cycles.diffuse_bounces = scene.cycles.transmission_bounces = scene.cycles.volume_bounces = bounces
    scene.cycles.transparent_max_bounces = 256
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = True
    scene.cycles.light_sampling_threshold = 0
    scene.cycles.pixel_filter_type = "BOX"
    width, height = (int(n) for n in options.size.split("x"))
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.film_transparent = False
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGB"
    scene.world = bpy.data.worlds.new("black")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    if options.threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", options.threads


def main():
    parser = argparse.ArgumentParser(prog="compare.py", description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("-o", required=True, help="the .exr to write")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bounces", choices=["1", "unlimited"], default="1")
    parser.add_argument("--schlick", action="store_true", help="bodies of glass reflect by glTF's term in place of Fresnel's")
    parser.add_argument("--threads", type=int, default=0)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    set_up(options)
    build(Glb(options.scene), options.bounces != "1", options.schlick)
    bpy.context.scene.render.filepath = str(pathlib.Path(options.o).resolve())
    bpy.ops.render.render(write_still=True)


main()
