"""Builds a .glb as a MuJoCo model, for MuJoCo's renderers: each primitive is a mesh of its own, without collisions."""
import io
import math

import mujoco
import numpy
from gltf import Material, constant_sky
from PIL import Image

TO_MUJOCO = numpy.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)  # MuJoCo is used to +Z up


class Builder:
    def __init__(self, glb, sky, width, height):
        self.glb, self.sky = glb, sky
        self.spec = mujoco.MjSpec()
        self.spec.visual.global_.offwidth, self.spec.visual.global_.offheight = width, height
        self.spec.visual.headlight.active = 0
        self.spec.visual.quality.shadowsize = 2048
        self.materials, self.textures = {}, {}

    def texture(self, info):
        index, data, _ = self.glb.image(info)
        if index not in self.textures:
            image = numpy.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
            name = f"texture{index}"
            self.spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=image.shape[1], height=image.shape[0],
                                  nchannel=3).data = image.tobytes()
            self.textures[index] = name
        return self.textures[index]

    def material(self, source):
        key = str(source)
        if key in self.materials:
            return self.materials[key]
        m = Material(source)
        color = [c * t for c, t in zip(m.color, m.tint() if m.transmission else (1, 1, 1))]
        shown = [min(1, c) ** (1 / 2.2) for c in color]  # MuJoCo adds light as display values
        glow = m.color if m.unlit else m.emission
        made = self.spec.add_material(name=f"material{len(self.materials)}", rgba=[*shown, m.opacity()],
                                      specular=0.5 * (1 - m.roughness), shininess=1 - m.roughness,
                                      metallic=m.metallic, roughness=m.roughness)
        if any(glow):
            made.emission = min(1, max(glow)) ** (1 / 2.2)
            made.rgba = [*(min(1, c) ** (1 / 2.2) for c in glow), m.opacity()]
        if m.color_texture:
            made.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = self.texture(m.color_texture)
        self.materials[key] = made.name
        return made.name

    def add_meshes(self):
        for number, (_, primitive, material, world) in enumerate(self.glb.meshes()):
            attributes = primitive["attributes"]
            points = self.glb.accessor(attributes["POSITION"]) @ world[:3, :3].T + world[:3, 3]
            corners = self.glb.corners(primitive)
            values = {"uservert": (points @ TO_MUJOCO.T).ravel(), "userface": corners.ravel()}
            if "NORMAL" in attributes:
                normals = self.glb.accessor(attributes["NORMAL"]) @ numpy.linalg.inv(world[:3, :3])
                values.update(usernormal=(normals @ TO_MUJOCO.T).ravel(), userfacenormal=corners.ravel())
            if "TEXCOORD_0" in attributes:
                uv = self.glb.accessor(attributes["TEXCOORD_0"]).astype(float)
                values.update(usertexcoord=uv.ravel(), userfacetexcoord=corners.ravel())
            self.spec.add_mesh(name=f"mesh{number}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL, **values)
            self.spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"mesh{number}",
                                         material=self.material(material), contype=0, conaffinity=0)

    def add_lights(self):
        for light, world in self.glb.lights():
            color = [c * light.get("intensity", 1) for c in light.get("color", [1, 1, 1])]
            sun = light["type"] == "directional"
            kinds = {"directional": mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, "point": mujoco.mjtLightType.mjLIGHT_POINT,
                     "spot": mujoco.mjtLightType.mjLIGHT_SPOT}
            self.spec.worldbody.add_light(
                pos=TO_MUJOCO @ world[:3, 3], dir=TO_MUJOCO @ -world[:3, 2], type=kinds[light["type"]], castshadow=True,
                diffuse=[c / math.pi for c in color], specular=[0.3 * min(1, max(color))] * 3, ambient=[0, 0, 0],
                attenuation=[1, 0, 0] if sun else [0.01, 0, 1],
                cutoff=math.degrees(light.get("spot", {}).get("outerConeAngle", math.pi / 4)), exponent=1)
        if self.sky:
            mean, behind = constant_sky(self.sky)
            self.spec.visual.headlight.active = 1
            self.spec.visual.headlight.ambient = numpy.minimum(1, mean) ** (1 / 2.2)
            self.spec.visual.headlight.diffuse = self.spec.visual.headlight.specular = [0, 0, 0]
            rgb = numpy.minimum(1, behind) ** (1 / 2.2)
            self.spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
                                  width=16, height=96, rgb1=rgb, rgb2=rgb)

    def add_camera(self):
        perspective, world = self.glb.camera(0)
        turned = TO_MUJOCO @ world[:3, :3]
        quaternion = numpy.zeros(4)
        mujoco.mju_mat2Quat(quaternion, turned.ravel())
        self.spec.worldbody.add_camera(name="camera", pos=TO_MUJOCO @ world[:3, 3], quat=quaternion,
                                       fovy=math.degrees(perspective["yfov"]))
        return perspective

    def model(self):
        self.add_meshes()
        self.add_lights()
        perspective = self.add_camera()
        model = self.spec.compile()
        model.vis.map.znear = perspective.get("znear", 0.01) / model.stat.extent
        model.vis.map.zfar = perspective.get("zfar", 1000.0) / model.stat.extent
        return model
