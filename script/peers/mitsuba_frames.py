"""Draws a .glb with Mitsuba 3 and prints what it took as JSON: run by script/scoreboard."""
import io
import json
import math
import pathlib
import sys

import mitsuba as mi
import numpy
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import parser_of, timed  # noqa: E402
from gltf import Glb, Material  # noqa: E402

MOST_SAMPLES_AT_ONCE = 1 << 25  # of all pixels: what fits into memory


def variant():
    """LLVM's, or the scalar one where no library of LLVM 16 or later is found (DRJIT_LIBLLVM_PATH)."""
    try:
        mi.set_variant("llvm_ad_rgb")
        import drjit
        drjit.eval(mi.Float([1, 2]) + 1)
    except Exception:  # Dr.Jit's own exceptions
        sys.exit("mitsuba_frames: no LLVM; install libllvm16 or later, or set DRJIT_LIBLLVM_PATH")


def from_srgb(values):
    return numpy.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


class Builder:
    def __init__(self, glb):
        self.glb, self.images = glb, {}

    def pixels(self, texture):
        """RGBA of 0 to 1, as stored."""
        index, data, _ = self.glb.image(texture)
        if index not in self.images:
            self.images[index] = numpy.asarray(Image.open(io.BytesIO(data)).convert("RGBA"), dtype="f4") / 255
        return self.images[index]

    @staticmethod
    def bitmap(values, texture):
        moved = texture.get("extensions", {}).get("KHR_texture_transform", {})
        to_uv = mi.ScalarTransform3f().translate(moved.get("offset", [0, 0])).scale(moved.get("scale", [1, 1]))
        return {"type": "bitmap", "bitmap": mi.Bitmap(numpy.ascontiguousarray(values, dtype="f4")), "raw": True, "to_uv": to_uv}

    def color(self, factor, texture):
        if texture is None:
            return {"type": "rgb", "value": list(factor)}
        return self.bitmap(from_srgb(self.pixels(texture)[..., :3]) * numpy.array(factor, "f4"), texture)

    def number(self, factor, texture, channel):
        if texture is None:
            return factor
        return self.bitmap(self.pixels(texture)[..., channel:channel + 1] * factor, texture)

    def opaque(self, m):
        # Mitsuba asks for either an index or Disney's measure of it.
        specular = ((m.ior - 1) / (m.ior + 1)) ** 2 * m.specular / 0.08
        roughness = max(m.roughness, 0.03)
        bsdf = {"type": "principled", "base_color": self.color(m.color, m.color_texture), "specular": min(specular, 1.0),
                "roughness": self.number(roughness, m.roughness_texture, 1),
                "metallic": self.number(m.metallic, m.roughness_texture, 2)}
        if m.normal_texture:
            stored = self.pixels(m.normal_texture)[..., :3] * 2 - 1
            stored[..., :2] *= m.normal_texture.get("scale", 1)
            stored /= numpy.linalg.norm(stored, axis=-1, keepdims=True)
            bsdf = {"type": "normalmap", "normalmap": self.bitmap(stored * 0.5 + 0.5, m.normal_texture), "bsdf": bsdf}
        return {"type": "twosided", "bsdf": bsdf}

    def bsdf(self, material):
        m = Material(material)
        if m.unlit or any(m.emission) and m.transmission == 0 and max(m.color) == 0:
            bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": 0.0}}
        elif m.is_body() and m.transmission > 0.9:
            bsdf = {"type": "glass_body", "int_ior": m.ior, "ext_ior": 1.0, "schlick": False,
                    "tint": mi.ScalarColor3f(m.color), "absorption": mi.ScalarColor3f(m.absorption())}
        elif m.transmission > 0:
            bsdf = {"type": "glass_thin", "int_ior": m.ior, "tint": mi.ScalarColor3f(m.color)}
            if m.transmission < 1:
                bsdf = {"type": "blendbsdf", "weight": m.transmission, "opaque": self.opaque(m), "thin": bsdf}
        else:
            bsdf = self.opaque(m)
        if m.mode != "OPAQUE":
            opacity = self.number(m.alpha, m.color_texture, 3)
            if m.mode == "MASK" and m.color_texture:
                opacity = self.bitmap(self.pixels(m.color_texture)[..., 3:] * m.alpha >= m.cutoff, m.color_texture)
            bsdf = {"type": "mask", "opacity": opacity, "bsdf": bsdf}
        return bsdf

    def mesh(self, name, material, parts):
        """One mesh of all primitives with a material: few meshes make short kernels."""
        m, at = Material(material), 0
        points, normals, uvs, faces = [], [], [], []
        for primitive, world in parts:
            attributes, corners = primitive["attributes"], self.glb.corners(primitive)
            local = self.glb.accessor(attributes["POSITION"])
            points.append(local @ world[:3, :3].T + world[:3, 3])
            faces.append(at + (corners[:, ::-1] if numpy.linalg.det(world[:3, :3]) < 0 else corners))
            at += len(local)
            normals.append(self.glb.accessor(attributes["NORMAL"]) @ numpy.linalg.inv(world[:3, :3]) if "NORMAL" in attributes
                           else flat_normals(points[-1], corners))
            uv = (self.glb.accessor(attributes["TEXCOORD_0"]).astype("f4") if "TEXCOORD_0" in attributes
                  else numpy.zeros((len(local), 2), "f4"))
            uvs.append(uv)
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(self.bsdf(material))
        if m.unlit or any(m.emission):
            glow = self.color(m.color, m.color_texture) if m.unlit else self.color(m.emission, m.emission_texture)
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": glow})
        faces, normals = numpy.concatenate(faces), numpy.concatenate(normals)
        mesh = mi.Mesh(name, at, len(faces), properties, True, True)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = numpy.concatenate(points).astype("f4").ravel()
        parameters["faces"] = faces.astype("u4").ravel()
        length = numpy.maximum(numpy.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
        parameters["vertex_normals"] = (normals / length).astype("f4").ravel()
        parameters["vertex_texcoords"] = numpy.concatenate(uvs).astype("f4").ravel()
        parameters.update()
        return mesh

    def meshes(self):
        parts = {}
        for _, primitive, material, world in self.glb.meshes():
            parts.setdefault(json.dumps(material), []).append((primitive, world))
        for number, (material, found) in enumerate(parts.items()):
            yield f"mesh{number}", self.mesh(f"mesh{number}", json.loads(material), found)

    def light(self, light, world):
        color = [c * light.get("intensity", 1) for c in light.get("color", [1, 1, 1])]
        at, along = world[:3, 3], -world[:3, 2]
        radius = light.get("extras", {}).get("sideray", {}).get("radius_m", 0)
        if light["type"] == "directional":
            return {"type": "directional", "direction": along.tolist(), "irradiance": {"type": "rgb", "value": color}}
        if light["type"] == "spot":
            cone = light.get("spot", {})
            outer = math.degrees(cone.get("outerConeAngle", math.pi / 4))
            look = mi.ScalarTransform4f().look_at(at.tolist(), (at + along).tolist(), world[:3, 1].tolist())
            return {"type": "spot", "to_world": look, "intensity": {"type": "rgb", "value": color}, "cutoff_angle": outer,
                    "beam_width": min(math.degrees(cone.get("innerConeAngle", 0)), 0.99 * outer)}
        if radius == 0:
            return {"type": "point", "position": at.tolist(), "intensity": {"type": "rgb", "value": color}}
        radiance = [c / (math.pi * radius**2) for c in color]
        return {"type": "sphere", "center": at.tolist(), "radius": radius,
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}}

    def scene(self, width, height, sky):
        perspective, world = self.glb.camera(0)
        look = mi.ScalarTransform4f().look_at(world[:3, 3].tolist(), (world[:3, 3] - world[:3, 2]).tolist(), world[:3, 1].tolist())
        scene = {"type": "scene", "integrator": {"type": "volpath", "max_depth": 65, "rr_depth": 16},
                 "sensor": {"type": "perspective", "fov": math.degrees(perspective["yfov"]), "fov_axis": "y",
                            "near_clip": perspective.get("znear", 0.01), "far_clip": 1e5, "to_world": look,
                            "sampler": {"type": "independent"},
                            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"},
                                     "component_format": "float32"}}}
        scene.update(self.meshes())
        for i, (light, world) in enumerate(self.glb.lights()):
            scene[f"light{i}"] = self.light(light, world)
        if sky:  # its middle is +Z in Mitsuba
            scene["sky"] = {"type": "envmap", "filename": sky, "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], 180)}
        return mi.load_dict(scene)


def flat_normals(points, corners):
    normals = numpy.zeros_like(points)
    a, b, c = (points[corners[:, i]] for i in range(3))
    for i in range(3):
        normals[corners[:, i]] = numpy.cross(b - a, c - a)
    return normals


def draw(scene, samples, seed, pixels, robust=False):
    """The picture of many samples, in parts that fit into memory. Robust: what one part has beyond four times the median of all
    parts is cut, since it is a path of little probability and much light."""
    most = max(1, min(MOST_SAMPLES_AT_ONCE // pixels, samples // 16 if robust else samples))
    counts = [min(most, samples - i) for i in range(0, samples, most)]
    parts = numpy.stack([numpy.array(mi.render(scene, spp=n, seed=1000 * seed + i))[..., :3] for i, n in enumerate(counts)])
    if robust:
        parts = numpy.minimum(parts, 4 * numpy.median(parts, axis=0) + 1e-3)
    return numpy.average(parts, axis=0, weights=counts)


def main():
    parser = parser_of("mitsuba_frames.py", __doc__, picture=".npy of radiance")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robust", action="store_true", help="without single bright samples")
    options = parser.parse_args()
    variant()
    import mitsuba_glass  # after the variant
    mitsuba_glass.register()
    width, height = options.size
    scene = Builder(Glb(options.scene)).scene(width, height, options.sky)
    picture = draw(scene, options.samples, options.seed, width * height, options.robust)
    numpy.save(options.o, picture.astype("f4"))
    result = timed(lambda number: draw(scene, options.samples, options.seed + number, width * height), options.frames)
    print(json.dumps({"version": mi.__version__, **result}))


main()
