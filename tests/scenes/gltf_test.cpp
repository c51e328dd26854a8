#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "scenes/images/images.h"
#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using testing::Pointwise;

TEST(Gltf, OneTriangleWithDefaults) {
  const Content content = SmallGltf().load();
  ASSERT_EQ(content.objects.size(), 1u);
  EXPECT_EQ(content.objects[0].name, "a");
  EXPECT_THAT(content.meshes[0].positions, ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0));
  EXPECT_THAT(content.meshes[0].indices, ElementsAre(0, 1, 2));
  EXPECT_TRUE(content.meshes[0].normals.empty()) << "flat";
  ASSERT_EQ(content.lights.size(), 1u);
  EXPECT_EQ(content.lights[0].name, "sun");
  EXPECT_EQ(content.lights[0].light.intensity[1], 3.0f);
  EXPECT_THAT(content.defaulted, Contains(HasSubstr("(-0.4, -0.8, -0.45)")));
  EXPECT_TRUE(content.warnings.empty());
}

// The corner orders of glTF 2.0, 3.7.2.1.
TEST(Gltf, StripsAndFansKeepTheirWinding) {
  SmallGltf strip;
  strip.primitive()["attributes"]["POSITION"] =
      strip.add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, 5126, "VEC3", 5);
  strip.primitive()["mode"] = 5;
  EXPECT_THAT(strip.load().meshes[0].indices, ElementsAre(0, 1, 2, 1, 3, 2, 2, 3, 4));
  strip.primitive()["mode"] = 6;
  EXPECT_THAT(strip.load().meshes[0].indices, ElementsAre(1, 2, 0, 2, 3, 0, 3, 4, 0));
}

TEST(Gltf, NormalizedIntegersSparseAndColors) {
  SmallGltf g;
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const size_t positions =
      g.add(std::vector<int16_t>{0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 16384, 0}, 5122, "VEC3", 3);
  g.json["bufferViews"].back()["byteStride"] = 8;
  g.json["accessors"][positions]["normalized"] = true;
  g.primitive()["attributes"]["POSITION"] = positions;
  const size_t colors = g.add(std::vector<uint8_t>{255, 0, 51, 0, 0, 255, 0, 0, 255, 255, 255, 0}, 5121, "VEC3", 3);
  g.json["bufferViews"].back()["byteStride"] = 4;
  g.json["accessors"][colors]["normalized"] = true;
  g.primitive()["attributes"]["COLOR_0"] = colors;
  const size_t indices = g.add_view(std::vector<uint8_t>{2}), values = g.add_view(std::vector<float>{0.5f, 0.25f});
  g.json["accessors"].push_back({{"componentType", 5126},
                                 {"type", "VEC2"},
                                 {"count", 3},
                                 {"sparse",
                                  {{"count", 1},
                                   {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                   {"values", {{"bufferView", values}}}}}});
  g.primitive()["attributes"]["TEXCOORD_0"] = g.json["accessors"].size() - 1;
  const Content content = g.load();
  const Mesh& mesh = content.meshes[0];
  EXPECT_THAT(mesh.positions,
              Pointwise(FloatNear(1e-7f), {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, -1.f, 16384.f / 32767.f}));
  EXPECT_THAT(mesh.colors, Pointwise(FloatNear(1e-7f), {1.f, 0.f, 0.2f, 1.f, 0.f, 1.f, 0.f, 1.f, 1.f, 1.f, 1.f, 1.f}));
  EXPECT_THAT(mesh.uv0, ElementsAre(0, 0, 0, 0, 0.5f, 0.25f));
}

TEST(Gltf, TransformsMultiplyDownTheTree) {
  SmallGltf g;
  const double half = std::sqrt(0.5);
  // Parent: 90 degrees about +Y, then moved. Child: scaled and moved before that.
  g.json["nodes"] = {{{"children", {1}}, {"rotation", {0, half, 0, half}}, {"translation", {10, 0, 0}}},
                     {{"mesh", 0}, {"translation", {1, 2, 3}}, {"scale", {2, 2, 2}}}};
  const Content content = g.load();
  ASSERT_EQ(content.objects.size(), 1u);
  EXPECT_EQ(content.objects[0].name, "node1");
  const double* m = content.objects[0].world_from_object;
  // x -> -z, z -> x.
  const double expected[12] = {0, 0, -2, 0, 2, 0, 2, 0, 0, 13, 2, -1};
  for (int i = 0; i < 12; ++i) EXPECT_NEAR(m[i], expected[i], 1e-12) << i;
}

TEST(Gltf, GpuInstancesBecomeObjects) {
  SmallGltf g;
  g.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  const size_t t = g.add(std::vector<float>{1, 0, 0, 0, 5, 0}, 5126, "VEC3", 2);
  const size_t r = g.add(std::vector<int8_t>{0, 0, 0, 127, 0, 127, 0, 0}, 5120, "VEC4", 2);
  g.json["accessors"][r]["normalized"] = true;
  g.json["nodes"][0]["scale"] = {3, 3, 3};
  g.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", t}, {"ROTATION", r}};
  const Content content = g.load();
  ASSERT_EQ(content.objects.size(), 2u);
  EXPECT_EQ(content.meshes.size(), 1u);
  EXPECT_NEAR(content.objects[0].world_from_object[9], 3.0, 1e-12);
  EXPECT_NEAR(content.objects[1].world_from_object[10], 15.0, 1e-12);
  EXPECT_NEAR(content.objects[1].world_from_object[0], -3.0, 1e-12) << "half a turn about +Y";
}

json rich_material() {
  return {{"name", "m"},
          {"alphaMode", "BLEND"},
          {"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.5}, {"roughnessFactor", 0.6}}},
          {"emissiveFactor", {1, 0.5, 0}},
          {"extras", {{"sideray", {{"rayTraced", false}, {"blend", "additive"}}}}},
          {"extensions",
           {{"KHR_materials_transmission", {{"transmissionFactor", 0.7}}},
            {"KHR_materials_ior", {{"ior", 1.33}}},
            {"KHR_materials_volume",
             {{"thicknessFactor", 0.25}, {"attenuationDistance", 2}, {"attenuationColor", {1, 0.5, 0.25}}}},
            {"KHR_materials_specular", {{"specularFactor", 0.9}, {"specularColorFactor", {2, 1, 0.5}}}},
            {"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}},
            {"KHR_materials_unlit", json::object()}}}};
}

TEST(Gltf, MaterialsWithEveryExtension) {
  SmallGltf g;
  g.json["materials"] = json::array({rich_material()});
  g.primitive()["material"] = 0;
  const Content content = g.load();
  const Material& material = content.materials.at(0);
  const sideray_material_desc& d = material.desc;
  EXPECT_EQ(material.ray_traced, RayTraced::no);
  EXPECT_EQ(d.alpha_mode, SIDERAY_BLEND);
  EXPECT_EQ(d.blend_mode, SIDERAY_BLEND_ADDITIVE);
  EXPECT_TRUE(d.double_sided && d.unlit);
  EXPECT_THAT(d.base_color, ElementsAre(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(d.metallic, 0.5f);
  EXPECT_EQ(d.roughness, 0.6f);
  EXPECT_THAT(d.emissive, ElementsAre(4, 2, 0));
  EXPECT_EQ(d.transmission, 0.7f);
  EXPECT_EQ(d.ior, 1.33f);
  EXPECT_EQ(d.thickness, 0.25f);
  EXPECT_EQ(d.attenuation_distance, 2.0f);
  EXPECT_THAT(d.attenuation_color, ElementsAre(1, 0.5f, 0.25f));
  EXPECT_EQ(d.specular, 0.9f);
  EXPECT_THAT(d.specular_color, ElementsAre(2, 1, 0.5f));
}

TEST(Gltf, ThicknessFollowsTheScaleOfEachNode) {
  SmallGltf g;
  g.json["materials"] = json::array({rich_material()});
  g.primitive()["material"] = 0;
  g.json["nodes"] = {{{"mesh", 0}, {"scale", {2, 2, 2}}}, {{"mesh", 0}}, {{"mesh", 0}, {"scale", {2, 2, 2}}}};
  g.json["scenes"][0]["nodes"] = {0, 1, 2};
  const Content content = g.load();
  const auto thickness = [&](size_t i) { return content.materials[content.objects[i].material].desc.thickness; };
  EXPECT_EQ(thickness(0), 0.5f);
  EXPECT_EQ(thickness(1), 0.25f);
  EXPECT_EQ(thickness(2), 0.5f);
  EXPECT_EQ(content.materials.size(), 2u);
}

TEST(Gltf, TexturesAreSharedAndTransformed) {
  SmallGltf g;
  const std::vector<uint8_t> pixels = {255, 0, 0, 255, 0, 255, 0, 128};
  const size_t view = g.add_view(encode_png(2, 1, 4, pixels, "test"));
  g.json["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}};
  g.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"minFilter", 9728}, {"magFilter", 9728}}};
  g.json["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 0}}};
  const json transform = {{"KHR_texture_transform",
                           {{"offset", {0, 1}}, {"rotation", 1.57079632679}, {"scale", {0.5, 0.5}}, {"texCoord", 1}}}};
  g.json["materials"] = {{{"pbrMetallicRoughness",
                           {{"baseColorTexture", {{"index", 0}, {"extensions", transform}}},
                            {"metallicRoughnessTexture", {{"index", 1}}}}},
                          {"emissiveTexture", {{"index", 1}}}}};
  g.primitive()["material"] = 0;
  const Content content = g.load();
  const sideray_material_desc& d = content.materials[0].desc;
  ASSERT_EQ(content.textures.size(), 2u) << "one image, once as colours and once as numbers";
  EXPECT_EQ(d.base_color_texture.texture, d.emissive_texture.texture);
  EXPECT_TRUE(content.textures[d.base_color_texture.texture - 1].srgb);
  EXPECT_FALSE(content.textures[d.metallic_roughness_texture.texture - 1].srgb);
  EXPECT_EQ(content.textures[0].rgba, pixels);
  EXPECT_EQ(d.base_color_texture.wrap_u, SIDERAY_CLAMP);
  EXPECT_EQ(d.base_color_texture.wrap_v, SIDERAY_MIRROR);
  EXPECT_EQ(d.base_color_texture.filter, SIDERAY_NEAREST);
  EXPECT_EQ(d.emissive_texture.filter, SIDERAY_TRILINEAR);
  EXPECT_EQ(d.base_color_texture.uv_set, 1u);
  // The extension's own example: these values use only the lower left quadrant of the image (v points down).
  const float* m = d.base_color_texture.texture_from_uv;
  for (const auto& [u, v] : {std::pair{0.1f, 0.2f}, {0.9f, 0.7f}, {0.5f, 0.99f}}) {
    const float s = m[0] * u + m[2] * v + m[4], t = m[1] * u + m[3] * v + m[5];
    EXPECT_TRUE(s >= 0 && s <= 0.5f && t >= 0.5f && t <= 1.0f) << s << " " << t;
  }
}

TEST(Gltf, CamerasAndLights) {
  SmallGltf g;
  g.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}, {"aspectRatio", 1.5}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 4}, {"ymag", 2}, {"znear", 0}, {"zfar", 50}}}}};
  g.json["extensionsUsed"] = {"KHR_lights_punctual"};
  g.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"},
       {"color", {1, 0.5, 0.25}},
       {"intensity", 8},
       {"range", 3},
       {"spot", {{"innerConeAngle", 0.2}, {"outerConeAngle", 0.4}}},
       {"extras", {{"sideray", {{"radius_m", 0.05}, {"radius", 1}}}}}},
      {{"type", "directional"}, {"extras", {{"sideray", {{"angular_diameter_deg", 2}}}}}}};
  const auto light = [](int i) { return json{{"KHR_lights_punctual", {{"light", i}}}}; };
  g.json["nodes"] = {{{"camera", 0}, {"translation", {1, 2, 3}}, {"scale", {5, 5, 5}}, {"name", "cam"}},
                     {{"camera", 1}},
                     {{"extensions", light(0)}, {"translation", {0, 4, 0}}, {"name", "same"}},
                     {{"extensions", light(1)}, {"name", "same"}}};
  g.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Content content = g.load();
  ASSERT_EQ(content.cameras.size(), 2u);
  const Camera& camera = content.cameras[0];
  EXPECT_EQ(camera.name, "cam");
  EXPECT_EQ(camera.aspect, 1.5f);
  EXPECT_EQ(camera.camera.yfov, 0.8f);
  EXPECT_EQ(camera.camera.z_far, 0.0f);
  EXPECT_THAT(camera.camera.world_from_camera, ElementsAre(1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 2, 3)) << "no scale";
  EXPECT_TRUE(content.cameras[1].camera.orthographic);
  EXPECT_EQ(content.cameras[1].camera.half_height, 2.0f);
  EXPECT_EQ(content.cameras[1].aspect, 2.0f);
  EXPECT_GT(content.cameras[1].camera.z_near, 0.0f);
  ASSERT_EQ(content.lights.size(), 2u);
  EXPECT_EQ(content.lights[0].name, "light0") << "names that are not unique give way to the index";
  const sideray_light& spot = content.lights[0].light;
  EXPECT_EQ(spot.type, SIDERAY_LIGHT_SPOT);
  EXPECT_THAT(spot.intensity, ElementsAre(8, 4, 2));
  EXPECT_THAT(spot.position, ElementsAre(0, 4, 0));
  EXPECT_THAT(spot.direction, ElementsAre(0, 0, -1));
  EXPECT_EQ(spot.outer_cone, 0.4f);
  EXPECT_EQ(spot.radius, 0.05f);
  EXPECT_THAT(content.warnings, Contains("light same: extras.sideray.radius is unknown and left out"));
  EXPECT_EQ(content.lights[1].light.angular_diameter_deg, 2.0f);
}

TEST(Gltf, LightNamesAreUniqueWhereANodeIsNamedLikeAnIndex) {
  SmallGltf g;
  g.json["extensionsUsed"] = {"KHR_lights_punctual"};
  g.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  g.json["nodes"] = json::array();
  for (const char* name : {"light1", "", "lamp", ""}) {
    g.json["nodes"].push_back({{"name", name}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  }
  g.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  std::vector<std::string> names;
  for (const Light& light : g.load().lights) names.push_back(light.name);
  EXPECT_THAT(names, ElementsAre("light0", "light1", "lamp", "light3"));
}

TEST(Gltf, WithoutASceneAllRootsAreShown) {
  SmallGltf g;
  g.json.erase("scene");
  g.json.erase("scenes");
  g.json["nodes"] = {{{"mesh", 0}}, {{"children", {0}}}, {{"mesh", 0}}};
  const Content content = g.load();
  EXPECT_EQ(content.objects.size(), 2u);
  EXPECT_THAT(content.defaulted, Contains(HasSubstr("scene")));
}

TEST(Gltf, NonFinitePositionsAreLeftOutWithAWarning) {
  SmallGltf g;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  g.primitive()["attributes"]["POSITION"] =
      g.add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, nan, 0, 0, 0, 1, 0}, 5126, "VEC3", 6);
  const Content content = g.load();
  EXPECT_THAT(content.meshes[0].indices, ElementsAre(0, 1, 2));
  EXPECT_THAT(content.warnings, Contains(HasSubstr("1 of 2 triangles")));
}

void use_image_0(SmallGltf& g) {
  g.json["textures"] = {{{"source", 0}}};
  g.json["materials"] = {{{"emissiveTexture", {{"index", 0}}}}};
  g.primitive()["material"] = 0;
}

struct Broken {
  const char* name;
  void (*breaks)(SmallGltf&);
  const char* message;
};

class BrokenGltf : public testing::TestWithParam<Broken> {};

TEST_P(BrokenGltf, IsOneClearLine) {
  SmallGltf g;
  GetParam().breaks(g);
  const std::string message = g.load_error();
  EXPECT_THAT(message, AllOf(HasSubstr(GetParam().message), HasSubstr("scene.gltf"), HasSubstr("; ")));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

const Broken broken[] = {
    {"UnknownRequired", [](SmallGltf& g) { g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"XYZ_magic"}; },
     "XYZ_magic"},
    {"Avif", [](SmallGltf& g) { g.json["extensionsRequired"] = {"EXT_texture_avif"}; }, "use a decoded copy"},
    {"MissingBin",
     [](SmallGltf& g) {
       g.json["buffers"] = {{{"byteLength", 36}, {"uri", "gone.bin"}}};
     },
     "gone.bin"},
    {"BinOutside",
     [](SmallGltf& g) {
       g.json["buffers"] = {{{"byteLength", 36}, {"uri", "../x.bin"}}};
     },
     "../x.bin"},
    {"BinOutsideEncoded",
     [](SmallGltf& g) {
       g.json["buffers"] = {{{"byteLength", 36}, {"uri", "%2e%2e/x.bin"}}};
     },
     "not in the scene's folder"},
    {"BinAbsolute",
     [](SmallGltf& g) {
       g.json["buffers"] = {{{"byteLength", 36}, {"uri", "/etc/passwd"}}};
     },
     "not in the scene's folder"},
    {"BinIsFolder",
     [](SmallGltf& g) {
       g.json["buffers"] = {{{"byteLength", 36}, {"uri", "."}}};
     },
     "not a regular file"},
    {"BinTooShort",
     [](SmallGltf& g) {
       g.json["buffers"] = {{{"byteLength", 9999}, {"uri", "data.bin"}}};
     },
     "scene.gltf"},
    {"MissingImage",
     [](SmallGltf& g) {
       g.json["images"] = {{{"uri", "gone.png"}}};
       use_image_0(g);
     },
     "gone.png"},
    {"ImageViewOutside",
     [](SmallGltf& g) {
       g.json["images"] = {{{"bufferView", 7}, {"mimeType", "image/png"}}};
       use_image_0(g);
     },
     "image 0"},
    {"ViewOutsideBuffer", [](SmallGltf& g) { g.json["bufferViews"][0]["byteLength"] = 37; }, "bufferView 0"},
    {"ViewNegative", [](SmallGltf& g) { g.json["bufferViews"][0]["byteOffset"] = -4; }, "byteOffset"},
    {"ViewHuge", [](SmallGltf& g) { g.json["bufferViews"][0]["byteLength"] = 1e18; }, "byteLength"},
    {"AccessorOutsideView", [](SmallGltf& g) { g.json["accessors"][0]["count"] = 4; }, "POSITION"},
    {"AccessorHuge", [](SmallGltf& g) { g.json["accessors"][0]["count"] = 2000000000; }, "POSITION"},
    {"AccessorWithoutDataHuge",
     [](SmallGltf& g) {
       g.json["accessors"][0]["count"] = 2000000000;
       g.json["accessors"][0].erase("bufferView");
     },
     "POSITION"},
    {"AccessorOffset", [](SmallGltf& g) { g.json["accessors"][0]["byteOffset"] = 4; }, "POSITION"},
    {"AccessorWrongType", [](SmallGltf& g) { g.json["accessors"][0]["type"] = "VEC2"; }, "components"},
    {"AccessorMissing", [](SmallGltf& g) { g.primitive()["attributes"]["POSITION"] = 99; }, "accessor 99"},
    {"IndexOutOfRange",
     [](SmallGltf& g) {
       g.primitive()["indices"] = g.add(std::vector<uint16_t>{0, 1, 3}, 5123, "SCALAR", 3);
     },
     "vertex 3"},
    {"NormalsTooFew",
     [](SmallGltf& g) {
       g.primitive()["attributes"]["NORMAL"] = g.add(std::vector<float>{0, 0, 1}, 5126, "VEC3", 1);
     },
     "NORMAL"},
    {"MaterialMissing", [](SmallGltf& g) { g.primitive()["material"] = 3; }, "material 3"},
    {"MeshMissing", [](SmallGltf& g) { g.json["nodes"][0]["mesh"] = 3; }, "mesh 3"},
    {"NodeMissing", [](SmallGltf& g) { g.json["scenes"][0]["nodes"] = {5}; }, "node 5"},
    {"NodeCycle", [](SmallGltf& g) { g.json["nodes"][0]["children"] = {0}; }, "twice"},
    {"NodeTwoParents",
     [](SmallGltf& g) {
       g.json["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
       g.json["scenes"][0]["nodes"] = {0, 1};
     },
     "twice"},
    {"SceneMissing", [](SmallGltf& g) { g.json["scene"] = 2; }, "scene 2"},
    {"TransformHuge",
     [](SmallGltf& g) {
       g.json["nodes"][0]["translation"] = {1e30, 0, 0};
     },
     "node"},
    {"Version1", [](SmallGltf& g) { g.json["asset"]["version"] = "1.0"; }, "glTF 2.0"},
    {"NoAsset", [](SmallGltf& g) { g.json.erase("asset"); }, "asset"},
    {"MeshesNotList", [](SmallGltf& g) { g.json["meshes"] = "many"; }, "meshes"},
    {"RoughnessOutside",
     [](SmallGltf& g) {
       g.json["materials"] = {{{"pbrMetallicRoughness", {{"roughnessFactor", 7}}}}};
       g.primitive()["material"] = 0;
     },
     "roughnessFactor"},
    {"BlendUnknown",
     [](SmallGltf& g) {
       g.json["materials"] = {{{"extras", {{"sideray", {{"blend", "screen"}}}}}}};
       g.primitive()["material"] = 0;
     },
     "premultiplied"},
};

INSTANTIATE_TEST_SUITE_P(Files, BrokenGltf, testing::ValuesIn(broken),
                         [](const testing::TestParamInfo<Broken>& test) { return test.param.name; });

TEST(Gltf, DeepJsonIsRefused) {
  const ScratchFolder folder;
  const size_t depth = 200000;
  const std::string text =
      R"({"asset":{"version":"2.0"},"extras":)" + std::string(depth, '[') + std::string(depth, ']') + "}";
  std::ofstream(folder / "deep.gltf") << text;
  EXPECT_THAT(message_of([&] { load(folder / "deep.gltf"); }), HasSubstr("nested deeper"));
}

TEST(Gltf, LinksOutOfTheFolderAreRefused) {
  const ScratchFolder folder, elsewhere;
  put_bytes(elsewhere / "secret.bin", std::vector<uint8_t>(36));
  std::filesystem::create_symlink(elsewhere / "secret.bin", folder / "link.bin");
  SmallGltf g;
  g.json["buffers"] = {{{"byteLength", 36}, {"uri", "link.bin"}}};
  const std::string path = g.write(folder);
  EXPECT_THAT(message_of([&] { load(path); }), HasSubstr("link out of"));
}

// The folder before ".." is a link, so that the name leads elsewhere although without "sub/.." it would not.
TEST(Gltf, LinksToFoldersLeadOutByTheirParents) {
  const ScratchFolder folder, elsewhere;
  std::filesystem::create_directory(elsewhere / "deep");
  std::filesystem::create_symlink(elsewhere / "deep", folder / "sub");
  for (const ScratchFolder* each : {&folder, &elsewhere}) put_bytes(*each / "a.bin", std::vector<uint8_t>(36));
  SmallGltf g;
  g.json["buffers"] = {{{"byteLength", 36}, {"uri", "sub/../a.bin"}}};
  const std::string path = g.write(folder);
  EXPECT_THAT(message_of([&] { load(path); }), HasSubstr("link out of"));
}

// tinygltf takes "%/1" for the character 1: it would leave the scene's folder where the checks see four folders deep.
TEST(Gltf, EscapesLeadNowhereElseThanTheChecks) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "scene/\x01\x01");
  std::filesystem::create_directories(folder / "scene/%");
  for (const char* name : {"secret.bin", "scene/%/secret.bin"}) put_bytes(folder / name, std::vector<uint8_t>(36));
  SmallGltf g;
  g.json["buffers"] = {{{"byteLength", 36}, {"uri", "%/1%/1/../../secret.bin"}}};
  std::ofstream(folder / "scene/a.gltf") << g.json;
  EXPECT_THAT(message_of([&] { load(folder / "scene/a.gltf"); }), HasSubstr("does not exist"));
}

TEST(Gltf, NamesWithPlusAndPercentAreRead) {
  for (const char* uri : {"a+b %.bin", "a+b %25.bin", "a%2bb%20%.bin"}) {
    const ScratchFolder folder;
    put_bytes(folder / "a+b %.bin", std::vector<uint8_t>(36));
    SmallGltf g;
    g.json["buffers"] = {{{"byteLength", 36}, {"uri", uri}}};
    const std::string path = g.write(folder);
    EXPECT_EQ(message_of([&] { load(path); }), "") << uri;
  }
}

// Reading the file would exceed the limits.
TEST(Gltf, DataThatIsAFilesNameIsNotOpened) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "scene/data:");
  std::ofstream(folder / "large.png");
  std::filesystem::resize_file(folder / "large.png", 3000000000u);
  SmallGltf g;
  g.json["images"] = {{{"uri", "data:/../../large.png"}}};
  g.json["buffers"] = {{{"byteLength", g.binary.size()}, {"uri", "data.bin"}}};
  put_bytes(folder / "scene/data.bin", g.binary);
  std::ofstream(folder / "scene/a.gltf") << g.json;
  EXPECT_EQ(message_of([&] { load(folder / "scene/a.gltf"); }), "");
}

TEST(Gltf, WhatIsNoJsonIsOneLineWithOneRemedy) {
  const ScratchFolder folder;
  for (const char* text :
       {R"({"asset": )", "{x: 1}", "[1, 2; 3]", "\x01", R"({"asset": 1e999})", "{\"a\": \"\xff\"}"}) {
    std::ofstream(folder / "scene.gltf") << text;
    const std::string message = message_of([&] { load(folder / "scene.gltf"); });
    EXPECT_THAT(message,
                testing::MatchesRegex("cannot read [^:]*scene.gltf: [^:]*; (get it again or )?export it again"))
        << "for " << text;
    EXPECT_THAT(message, testing::Not(HasSubstr("json.exception")));
    EXPECT_THAT(message, testing::Not(HasSubstr(".;")));
  }
  put_bytes(folder / "scene.gltf", {});
  EXPECT_THAT(message_of([&] { load(folder / "scene.gltf"); }), HasSubstr("the file is empty; "));
}

TEST(Gltf, FoldersAreNamedAsSuch) {
  const ScratchFolder folder;
  for (const char* name : {"dir", "dir.glb"}) {
    std::filesystem::create_directory(folder / name);
    EXPECT_THAT(message_of([&] { load(folder / name); }), HasSubstr("it is a folder; ")) << name;
  }
}

TEST(Gltf, UnknownScenesListWhatThereIs) {
  EXPECT_THAT(message_of([] { load("nonsense"); }), AllOf(HasSubstr("panes"), HasSubstr(".glb")));
  EXPECT_THAT(message_of([] { load("/no/such.glb"); }), HasSubstr("/no/such.glb"));
}

std::vector<uint8_t> small_glb(const ScratchFolder& folder) {
  SmallGltf g;
  g.json["materials"] = json::array({rich_material()});
  g.primitive()["material"] = 0;
  write_glb(folder / "small.glb", g.load());
  return bytes_of(folder / "small.glb");
}

TEST(Glb, TruncationIsAnErrorAtEveryLength) {
  const ScratchFolder folder;
  const std::vector<uint8_t> bytes = small_glb(folder);
  // Every length of the frame and its start, then a sample: each is a whole load.
  for (size_t length = 0; length < bytes.size(); length += length < 100 ? 1 : 5) {
    put_bytes(folder / "cut.glb", std::span(bytes).first(length));
    EXPECT_THAT(message_of([&] { load(folder / "cut.glb"); }), HasSubstr("cut.glb")) << length << " bytes";
  }
}

TEST(Glb, DamagedBytesNeverDoMoreThanThrow) {
  const ScratchFolder folder;
  const std::vector<uint8_t> bytes = small_glb(folder);
  std::mt19937 random(1);
  for (int round = 0; round < 600; ++round) {
    std::vector<uint8_t> damaged = bytes;
    for (int i = 0; i < 1 + round % 4; ++i) damaged[random() % damaged.size()] = static_cast<uint8_t>(random());
    put_bytes(folder / "damaged.glb", damaged);
    try {
      load(folder / "damaged.glb");
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace sideray::scenes
