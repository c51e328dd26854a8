"""Draws a .glb with pyrender and prints what it took as JSON: run by script/scoreboard."""
import io
import json
import os
import pathlib
import sys

os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
import numpy  # noqa: E402

if not hasattr(numpy, "infty"):
    numpy.infty = numpy.inf  # pyrender 0.1.45 is older than NumPy 2
import pyrender  # noqa: E402
from PIL import Image  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import parser_of, timed  # noqa: E402
from gltf import Glb, Material, constant_sky  # noqa: E402


class Builder:
    def __init__(self, glb):
        self.glb, self.meshes = glb, {}

    def texture(self, info, channels="RGBA"):
        if info is None:
            return None
        image = Image.open(io.BytesIO(self.glb.image(info)[1])).convert(channels)
        return pyrender.Texture(source=numpy.asarray(image), source_channels=channels)

    def material(self, source):
        m = Material(source)
        color = [c * t for c, t in zip(m.color, m.tint() if m.transmission else (1, 1, 1))]
        alpha = m.opacity()
        mode = "BLEND" if alpha < 1 or m.mode == "BLEND" else m.mode
        return pyrender.MetallicRoughnessMaterial(
            baseColorFactor=[*color, alpha], baseColorTexture=self.texture(m.color_texture), metallicFactor=m.metallic,
            roughnessFactor=m.roughness, metallicRoughnessTexture=self.texture(m.roughness_texture, "RGB"),
            emissiveFactor=numpy.minimum(m.color if m.unlit else m.emission, 1),
            emissiveTexture=self.texture(m.color_texture if m.unlit else m.emission_texture, "RGB"),
            alphaMode=mode, alphaCutoff=m.cutoff, doubleSided=m.double_sided)

    def mesh(self, key, primitive, material):
        if key not in self.meshes:
            attributes = primitive["attributes"]
            of = lambda name: self.glb.accessor(attributes[name]).astype("f4") if name in attributes else None  # noqa: E731
            uv = of("TEXCOORD_0")
            if uv is not None:
                uv[:, 1] = 1 - uv[:, 1]  # pyrender turns pictures upside down
            self.meshes[key] = pyrender.Mesh([pyrender.Primitive(
                positions=of("POSITION"), normals=of("NORMAL"), texcoord_0=uv, indices=self.glb.corners(primitive),
                material=self.material(material), mode=4)])
        return self.meshes[key]

    def scene(self, sky, aspect):
        ambient, behind = constant_sky(sky) if sky else (numpy.zeros(3), numpy.zeros(3))
        scene = pyrender.Scene(bg_color=[*numpy.minimum(behind, 1) ** (1 / 2.2), 1], ambient_light=ambient)
        for key, primitive, material, world in self.glb.meshes():
            scene.add(self.mesh(key, primitive, material), pose=world)
        for light, world in self.glb.lights():
            color, strength = light.get("color", [1, 1, 1]), light.get("intensity", 1)
            if light["type"] == "directional":
                made = pyrender.DirectionalLight(color, strength)
            elif light["type"] == "point":
                made = pyrender.PointLight(color, strength)
            else:
                cone = light.get("spot", {})
                made = pyrender.SpotLight(color, strength, innerConeAngle=cone.get("innerConeAngle", 0),
                                          outerConeAngle=cone.get("outerConeAngle", numpy.pi / 4))
            scene.add(made, pose=world)
        perspective, world = self.glb.camera(0)
        camera = pyrender.PerspectiveCamera(perspective["yfov"], znear=perspective.get("znear", 0.01),
                                            zfar=perspective.get("zfar", 1000.0), aspectRatio=aspect)
        return scene, scene.add(camera, pose=world), world


def main():
    options = parser_of("pyrender_frames.py", __doc__).parse_args()
    width, height = options.size
    scene, camera, world = Builder(Glb(options.scene)).scene(options.sky, width / height)
    suns = any(isinstance(node.light, pyrender.DirectionalLight) for node in scene.light_nodes)
    flags = pyrender.RenderFlags.SHADOWS_DIRECTIONAL if suns else pyrender.RenderFlags.NONE
    renderer = pyrender.OffscreenRenderer(width, height)
    Image.fromarray(renderer.render(scene, flags)[0]).save(options.o)

    def frame(number):
        moved = world.copy()
        moved[:3, 3] += 1e-5 * number * world[:3, 0]
        scene.set_pose(camera, moved)
        renderer.render(scene, flags)

    print(json.dumps({"version": pyrender.__version__, "gl": "", **timed(frame, options.frames)}))


main()
