"""Builds a .glb in Blender: an own reader, since Blender's importer changes lights and materials. The scene stays in glTF's
axes (+Y up)."""
import dataclasses
import math
import tempfile

import bpy
import numpy
from gltf import Material
from mathutils import Matrix, Vector


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
    source, data, kind = glb.image(info)
    key = (source, linear)
    if key not in images:
        with tempfile.NamedTemporaryFile(suffix=".png" if kind == "image/png" else ".jpg") as file:
            file.write(data)
            file.flush()
            images[key] = bpy.data.images.load(file.name)
            images[key].colorspace_settings.name = "Non-Color" if linear else "sRGB"
            images[key].alpha_mode = "CHANNEL_PACKED"
            images[key].pack()
    uv = nodes.make("ShaderNodeUVMap", uv_map="uv%d" % info.get("texCoord", 0)).outputs[0]
    moved = info.get("extensions", {}).get("KHR_texture_transform")
    if moved:  # Blender's V runs the other way; turned coordinates are not read
        scale, offset = moved.get("scale", [1, 1]), moved.get("offset", [0, 0])
        uv = nodes.vector("ADD", nodes.vector("MULTIPLY", uv, (*scale, 1)), (offset[0], 1 - scale[1] - offset[1], 0))
    return nodes.make("ShaderNodeTexImage", {"Vector": uv}, image=images[key])


def factor(nodes, value, info, glb, images, linear):
    """A colour factor times its texture, as a vector socket or a triple; and the texture's alpha."""
    if info is None:
        return tuple(value), None
    node = texture(nodes, glb, images, info, linear)
    return nodes.vector("MULTIPLY", node.outputs["Color"], tuple(value)), node.outputs["Alpha"]


def schlick_of_air(nodes, ior):
    """The reflectance of a face by glTF's term, at the angle in the air; 1 at total internal reflection."""
    geometry = nodes.make("ShaderNodeNewGeometry")
    cosine = nodes.math("ABSOLUTE", nodes.vector("DOT_PRODUCT", geometry.outputs["Incoming"], geometry.outputs["Normal"]))
    sine2 = nodes.math("MULTIPLY", nodes.math("SUBTRACT", 1.0, nodes.math("MULTIPLY", cosine, cosine)), ior * ior)
    behind = nodes.math("SQRT", nodes.math("MAXIMUM", nodes.math("SUBTRACT", 1.0, sine2), 0.0))
    in_air = nodes.math("ADD", cosine, nodes.math("MULTIPLY", geometry.outputs["Backfacing"], nodes.math("SUBTRACT", behind, cosine)))
    f0 = ((ior - 1) / (ior + 1)) ** 2
    fifth = nodes.math("POWER", nodes.math("SUBTRACT", 1.0, in_air), 5.0)
    return nodes.math("ADD", nodes.math("MULTIPLY", fifth, 1 - f0), f0)


def build_glass(nodes, source, material, look):
    """A body of glass by paths: Fresnel's term of the two indices or glTF's; its inside absorbs (Beer)."""
    pbr, extensions = source.get("pbrMetallicRoughness", {}), source["extensions"]
    color = [*pbr.get("baseColorFactor", [1, 1, 1, 1])[:3], 1]
    if look.rasterized:  # EEVEE takes a body's tint from its surface
        color[:3] = [c * t for c, t in zip(color, Material(source).tint())]
        material.use_raytrace_refraction = True
    ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    rough = {"Roughness": pbr.get("roughnessFactor", 1)}
    if look.schlick:
        refracts = nodes.make("ShaderNodeBsdfRefraction", {"Color": color, "IOR": ior, **rough}, distribution="GGX")
        mirrors = nodes.make("ShaderNodeBsdfGlossy", {"Color": [1, 1, 1, 1], **rough}, distribution="GGX")
        glass = nodes.make("ShaderNodeMixShader", {0: schlick_of_air(nodes, ior), 1: refracts.outputs[0], 2: mirrors.outputs[0]})
    else:
        glass = nodes.make("ShaderNodeBsdfGlass", {"Color": color, "IOR": ior, **rough}, distribution="GGX")
    volume = extensions["KHR_materials_volume"]
    inside = None
    if "attenuationDistance" in volume and not look.rasterized:
        # Cycles absorbs density (1 - color) a unit.
        lost = [-math.log(max(c, 1e-6)) / volume["attenuationDistance"] for c in volume.get("attenuationColor", [1, 1, 1])]
        density = max(lost)
        if density > 0:
            inside = nodes.shader("ShaderNodeVolumeAbsorption", Color=[*(1 - c / density for c in lost), 1], Density=density)
    share = extensions["KHR_materials_transmission"]["transmissionFactor"]
    if share < 1:  # frosted: the rest is opaque
        opaque = nodes.make("ShaderNodeBsdfPrincipled", {"Base Color": color, "IOR": ior, **rough})
        glass = nodes.make("ShaderNodeMixShader", {0: share, 1: opaque.outputs[0], 2: glass.outputs[0]})
    nodes.make("ShaderNodeOutputMaterial", {"Surface": glass.outputs[0], "Volume": inside})
    return material, False


def build_material(source, glb, images, look):
    """glTF's metallic-roughness by nodes: Lambert and GGX, weighted by Schlick's Fresnel of the viewing angle."""
    material = bpy.data.materials.new(source.get("name", "material"))
    nodes = Nodes(material)
    pbr, extensions = source.get("pbrMetallicRoughness", {}), source.get("extensions", {})
    if look.by_paths and Material(source).is_body():
        return build_glass(nodes, source, material, look)
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
    principled = look.principled and transmission == 0
    passed = nodes.vector("SUBTRACT", triple(1.0), fresnel)
    opaque_share = nodes.math("MULTIPLY", nodes.math("SUBTRACT", 1.0, metallic), 1.0 - transmission)
    diffuse = mix(nodes, triple(0.0), nodes.vector("MULTIPLY", base, passed), opaque_share)
    shader = nodes.shader("ShaderNodeBsdfDiffuse", Color=diffuse, Roughness=0.0, Normal=normal)
    glossy = nodes.make("ShaderNodeBsdfGlossy", {"Color": fresnel, "Roughness": roughness, "Normal": normal}, distribution="MULTI_GGX")
    shader = nodes.add(shader, glossy.outputs[0])
    if principled:  # Fresnel's term of the half vector, as glTF has it
        shader = nodes.shader("ShaderNodeBsdfPrincipled", **{
            "Base Color": base, "Metallic": metallic, "Roughness": roughness, "IOR": ior, "Normal": normal,
            "Specular IOR Level": 0.5 * weight})
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
    if look.culled and not source.get("doubleSided", False):
        clear = nodes.shader("ShaderNodeBsdfTransparent", Color=(1, 1, 1, 1))
        shader = nodes.make("ShaderNodeMixShader", {0: geometry.outputs["Backfacing"], 1: shader, 2: clear}).outputs[0]
    nodes.make("ShaderNodeOutputMaterial", {"Surface": shader})
    if look.rasterized and (mode == "BLEND" or transmission > 0):
        material.surface_render_method = "BLENDED"
    # With direct light alone, BLEND and transmissive surfaces cast no shadow.
    return material, not look.by_paths and (mode == "BLEND" or transmission > 0)


def build_mesh(primitive, glb):
    attributes = primitive["attributes"]
    positions, corners = glb.accessor(attributes["POSITION"]), glb.corners(primitive)
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(positions.tolist(), [], corners.tolist())
    for which in range(2):
        if "TEXCOORD_%d" % which in attributes:
            uv = glb.accessor(attributes["TEXCOORD_%d" % which])[corners.ravel()].astype("f4")
            uv[:, 1] = 1 - uv[:, 1]
            mesh.uv_layers.new(name="uv%d" % which).data.foreach_set("uv", uv.ravel())
    if "NORMAL" in attributes:
        if hasattr(mesh, "use_auto_smooth"):  # before Blender 4.1
            mesh.use_auto_smooth = True
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        mesh.normals_split_custom_set_from_vertices(glb.accessor(attributes["NORMAL"]).tolist())
    return mesh


def add_object(name, data, world):
    thing = bpy.data.objects.new(name, data)
    thing.matrix_world = Matrix(numpy.asarray(world).tolist())
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
    else:
        spot = light["type"] == "spot"
        lamp = bpy.data.lights.new(light["type"], "SPOT" if spot else "POINT")
        lamp.energy = light.get("intensity", 1) * 4 * math.pi
        lamp.shadow_soft_size = extras.get("radius_m", 0)
        if hasattr(lamp, "use_soft_falloff"):  # otherwise a disc, which the globe around a lamp hides
            lamp.use_soft_falloff = False
        if spot:
            outer, inner = (light.get("spot", {}).get(n, d) for n, d in (("outerConeAngle", math.pi / 4), ("innerConeAngle", 0)))
            lamp.spot_size, lamp.spot_blend = 2 * outer, 1 - inner / outer
    lamp.color = color
    lamp.cycles.max_bounces = 1024
    add_object("light", lamp, world)


def add_camera(camera, world):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = camera["yfov"]
    data.clip_start, data.clip_end = camera.get("znear", 0.01), camera.get("zfar", 1e5)
    bpy.context.scene.camera = add_object("camera", data, world)


def add_world(sky):
    """A black world, or one that shines as a lat-long picture whose middle is -Z and whose right half holds +X."""
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    nodes = Nodes(world)
    background = nodes.make("ShaderNodeBackground", {"Strength": 1.0 if sky else 0.0})
    if sky:
        parts = nodes.make("ShaderNodeSeparateXYZ", {0: nodes.make("ShaderNodeTexCoord").outputs["Generated"]}).outputs
        minus = lambda part: nodes.math("MULTIPLY", part, -1.0)  # noqa: E731
        turned = nodes.make("ShaderNodeCombineXYZ", {0: minus(parts[2]), 1: minus(parts[0]), 2: parts[1]}).outputs[0]
        image = bpy.data.images.load(str(sky))
        nodes.tree.links.new(nodes.make("ShaderNodeTexEnvironment", {0: turned}, image=image).outputs[0], background.inputs["Color"])
    nodes.make("ShaderNodeOutputWorld", {"Surface": background.outputs[0]})


@dataclasses.dataclass
class Look:
    """How a scene is built: with bodies of glass for paths or direct light alone; with backs left out as glTF says or not."""

    by_paths: bool
    schlick: bool = False
    culled: bool = True
    principled: bool = False  # opaque surfaces by Blender's own Principled BSDF
    rasterized: bool = False  # for EEVEE


def build(glb, look, sun_where_dark=True):
    images, meshes = {}, {}
    materials = [build_material(m, glb, images, look) for m in glb.json.get("materials", [])]
    default = build_material({}, glb, images, look)
    for key, primitive, _, world in glb.meshes():
        material, clear = materials[primitive["material"]] if "material" in primitive else default
        if key not in meshes:
            meshes[key] = build_mesh(primitive, glb)
            meshes[key].materials.append(material)
        add_object("mesh", meshes[key], world).visible_shadow = not clear
    if glb.json.get("cameras"):
        add_camera(*glb.camera(0))
    lights = list(glb.lights())
    for light, world in lights:
        add_light(light, world)
    if not lights and sun_where_dark:
        direction = Vector((-0.4, -0.8, -0.45))
        add_light({"type": "directional", "intensity": 3.0}, direction.to_track_quat("-Z", "Y").to_matrix().to_4x4())
