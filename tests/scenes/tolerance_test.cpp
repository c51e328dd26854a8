#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "scenes/images/images.h"
#include "scenes/support.h"

// Tests that slight violations of glTF by exporters are accepted with a warning, and that large ones are refused.
namespace sideray::scenes::tolerance_test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

SmallGltf with_material(const json& material) {
  SmallGltf g;
  g.json["materials"] = json::array({material});
  g.json["materials"][0]["name"] = "m";
  g.primitive()["material"] = 0;
  return g;
}

SmallGltf with_extension(const char* name, const json& values) {
  return with_material({{"extensions", {{name, values}}}});
}

sideray_material_desc desc_of(SmallGltf g) {
  return g.load().materials.at(0).desc;
}

// Expects that a scene accepts the content.
void expect_shown(const Content& content, size_t objects = 1) {
  EXPECT_EQ(content.objects.size(), objects);
  Scene scene = Scene::create().value();
  EXPECT_EQ(message_of([&] { fill(scene, content, std::vector<bool>(content.objects.size(), true)); }), "");
}

struct Odd {
  const char* name;
  SmallGltf (*file)();
  const char* warning;  // "" = it is valid, and nothing is said
};

class OddGltf : public testing::TestWithParam<Odd> {};

TEST_P(OddGltf, IsShownWithOneClearLine) {
  const Content content = GetParam().file().load();
  expect_shown(content);
  if (*GetParam().warning == '\0') {
    EXPECT_THAT(content.warnings, IsEmpty());
    return;
  }
  EXPECT_THAT(content.warnings, ElementsAre(AllOf(HasSubstr(GetParam().warning), HasSubstr("; "))));
  EXPECT_THAT(content.warnings, Each(Not(HasSubstr("\n"))));
}

SmallGltf with_camera(const json& camera) {
  SmallGltf g;
  g.json["cameras"] = json::array({camera});
  g.json["nodes"][0]["camera"] = 0;
  return g;
}

SmallGltf with_light(const json& light) {
  SmallGltf g;
  g.json["extensionsUsed"] = {"KHR_lights_punctual"};
  g.json["extensions"]["KHR_lights_punctual"]["lights"] = json::array({light});
  g.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  return g;
}

// A second primitive beside the triangle.
SmallGltf with_primitive(const json& primitive) {
  SmallGltf g;
  g.json["meshes"][0]["primitives"].push_back(primitive);
  return g;
}

SmallGltf with_empty_accessor(const char* type, int component_type) {
  SmallGltf g;
  g.json["accessors"].push_back({{"componentType", component_type}, {"type", type}, {"count", 0}});
  return g;
}

SmallGltf with_animation(const std::vector<float>& times, const char* interpolation) {
  SmallGltf g;
  const size_t input = g.add(times, 5126, "SCALAR", 2);
  const size_t output = g.add(std::vector<float>{0, 0, 0, 4, 0, 0}, 5126, "VEC3", 2);
  g.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                           {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}}};
  return g;
}

const Odd odd[] = {
    {"Ior1000", [] { return with_extension("KHR_materials_ior", {{"ior", 1000}}); }, ""},
    {"Ior0", [] { return with_extension("KHR_materials_ior", {{"ior", 0}}); }, ""},
    {"IorRounded", [] { return with_extension("KHR_materials_ior", {{"ior", 0.99999988}}); },
     "material m: ior is 0.99999988; 1 is taken"},
    {"BaseColorRounded",
     [] { return with_material({{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1.00000012, 1, 1}}}}}); },
     "material m: baseColorFactor is 1.00000012; 1 is taken"},
    {"RoughnessRounded", [] { return with_material({{"pbrMetallicRoughness", {{"roughnessFactor", -1e-8}}}}); },
     "material m: roughnessFactor is -1e-08; 0 is taken"},
    {"MetallicOfBytes", [] { return with_material({{"pbrMetallicRoughness", {{"metallicFactor", 256 / 255.0}}}}); },
     "metallicFactor"},
    {"SpecularColorRounded",
     [] { return with_extension("KHR_materials_specular", {{"specularColorFactor", {-1e-9, 1, 1}}}); },
     "specularColorFactor is -1e-09; 0 is taken"},
    {"CutoffRounded", [] { return with_material({{"alphaMode", "MASK"}, {"alphaCutoff", -1e-8}}); }, "alphaCutoff"},
    {"EmissionAboveOne", [] { return with_material({{"emissiveFactor", {5, 2, 0}}}); },
     "material m: emissiveFactor is 5; more than 1"},
    {"AttenuationAtZero",
     [] { return with_extension("KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 0}}); },
     "attenuationDistance is 0; it is taken for infinite"},
    {"AlphaModeUnknown", [] { return with_material({{"alphaMode", "DITHER"}}); }, "\"DITHER\" is unknown; OPAQUE"},
    {"ThirdTexcoords",
     [] {
       SmallGltf g = with_material({{"occlusionTexture", {{"index", 0}, {"texCoord", 2}}}});
       const size_t view = g.add_view(encode_png(1, 1, 4, std::vector<uint8_t>{1, 2, 3, 4}, "test"));
       g.json["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}};
       g.json["textures"] = {{{"source", 0}}};
       return g;
     },
     "material m: a texture uses TEXCOORD_2"},
    {"ExtensionUnlisted", [] { return with_extension("KHR_materials_clearcoat", {{"clearcoatFactor", 1}}); }, ""},
    {"NoAttributes", [] { return with_primitive({{"attributes", json::object()}}); },
     "mesh tri.1: it has no vertices; left out"},
    {"NoVertices",
     [] {
       SmallGltf g = with_empty_accessor("VEC3", 5126);
       g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 1}}}});
       return g;
     },
     "mesh tri.1: it has no vertices; left out"},
    {"NoIndices",
     [] {
       SmallGltf g = with_empty_accessor("SCALAR", 5123);
       g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
       return g;
     },
     "mesh tri.1: it has no vertices; left out"},
    {"UnusedImageMissing",
     [] {
       SmallGltf g;
       g.json["images"] = {{{"uri", "gone.png"}}};
       g.json["textures"] = {{{"source", 0}}};
       return g;
     },
     "image 0: it cannot be read, and nothing shown uses it; left out"},
    {"UnusedImageElsewhere",
     [] {
       SmallGltf g;
       g.json["images"] = {{{"uri", "../../etc/passwd"}}};
       return g;
     },
     "image 0"},
    {"UnusedMaterialBroken",
     [] {
       SmallGltf g;
       g.json["materials"] = {{{"emissiveTexture", {{"index", 3}}}}};
       return g;
     },
     "material material0 uses texture 3, and there are 0; nothing shown has material material0, which is left out"},
    {"UnusedNodeBroken",
     [] {
       SmallGltf g;
       g.json["nodes"].push_back({{"mesh", 77}, {"camera", 5}, {"rotation", {0, 0, 0, 0}}});
       return g;
     },
     ""},
    {"RotationOfLengthZero",
     [] {
       SmallGltf g;
       g.json["nodes"][0]["rotation"] = {0, 0, 0, 0};
       return g;
     },
     "node 0: its rotation has length 0; it is not turned"},
    {"RotationRounded",
     [] {
       SmallGltf g;
       g.json["nodes"][0]["rotation"] = {0, 0, 0.001, 1.0};
       return g;
     },
     ""},
    {"RootListedTwice",
     [] {
       SmallGltf g;
       g.json["scenes"][0]["nodes"] = {0, 0};
       return g;
     },
     "node a: the scene lists it, and shows it already; shown once"},
    {"FieldOfViewBeyondPi",
     [] { return with_camera({{"type", "perspective"}, {"perspective", {{"yfov", 4}, {"znear", 0.1}}}}); },
     "yfov of camera a is 4; the camera is left out"},
    {"CameraUnknown", [] { return with_camera({{"type", "panoramic"}}); }, "camera a has an unknown type"},
    {"CameraOnNothing",
     [] {
       SmallGltf g = with_camera({{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
       g.json["nodes"] = {{{"mesh", 0}}, {{"camera", 0}, {"scale", {0, 0, 0}}}};
       g.json["scenes"][0]["nodes"] = {0, 1};
       return g;
     },
     "the camera is left out"},
    {"OrthographicNegative",
     [] {
       return with_camera({{"type", "orthographic"},
                           {"orthographic", {{"xmag", -4}, {"ymag", -2}, {"znear", 0}, {"zfar", 9}}}});
     },
     ""},
    {"LightUnknown", [] { return with_light({{"type", "area"}}); }, "light a: its type \"area\" is unknown; left out"},
    {"LightOnNothing",
     [] {
       SmallGltf g = with_light({{"type", "point"}});
       g.json["nodes"] = {{{"mesh", 0}}, {{"scale", {0, 0, 0}}}};
       g.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
       g.json["scenes"][0]["nodes"] = {0, 1};
       return g;
     },
     "a scale of its node is 0; left out"},
    {"LightColorRounded", [] { return with_light({{"type", "point"}, {"color", {-1e-9, 1, 1}}}); },
     "light a: color is -1e-09; 0 is taken"},
    {"SpotWithAHardEdge",
     [] { return with_light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}}); },
     "the cone has a hard edge"},
    {"SpotWithoutAngles", [] { return with_light({{"type", "spot"}}); }, ""},
    {"TimesBelowZero", [] { return with_animation({-0.5f, 1}, "LINEAR"); }, "its times begin at -0.5; it plays from 0"},
    {"InterpolationUnknown", [] { return with_animation({0, 1}, "BEZIER"); }, "\"BEZIER\" is unknown; LINEAR is taken"},
    {"VersionWithoutMinor",
     [] {
       SmallGltf g;
       g.json["asset"]["version"] = "2";
       return g;
     },
     ""},
    {"NullLists",
     [] {
       SmallGltf g;
       for (const char* key : {"animations", "skins", "cameras", "images", "extensions"}) g.json[key] = nullptr;
       return g;
     },
     ""},
    {"EmptyLists",
     [] {
       SmallGltf g;
       for (const char* key : {"animations", "skins", "cameras", "images", "textures", "samplers", "materials"})
         g.json[key] = json::array();
       g.json["nodes"][0]["children"] = json::array();
       return g;
     },
     ""},
};

INSTANTIATE_TEST_SUITE_P(Files, OddGltf, testing::ValuesIn(odd),
                         [](const testing::TestParamInfo<Odd>& test) { return test.param.name; });

TEST(Tolerance, ValuesAreTheNearestInRange) {
  EXPECT_EQ(desc_of(with_extension("KHR_materials_ior", {{"ior", 1000}})).ior, 1000.0f);
  const float ior = desc_of(with_extension("KHR_materials_ior", {{"ior", 0}})).ior;
  EXPECT_GT(std::pow((ior - 1) / (ior + 1), 2.0f), 0.99999f) << "KHR_materials_ior: 0 is Fresnel 1";
  EXPECT_EQ(desc_of(with_material({{"pbrMetallicRoughness", {{"metallicFactor", 1.0001}}}})).metallic, 1.0f);
  EXPECT_THAT(desc_of(with_material({{"emissiveFactor", {5, 2, 0}}})).emissive, ElementsAre(5, 2, 0));
  EXPECT_TRUE(std::isinf(desc_of(with_extension("KHR_materials_volume", {{"attenuationDistance", 0}}))
                             .attenuation_distance));
}

TEST(Tolerance, FarOutsideStaysRefused) {
  EXPECT_THAT(with_material({{"pbrMetallicRoughness", {{"metallicFactor", 1.02}}}}).load_error(),
              HasSubstr("metallicFactor of material m is 1.02, outside 0 to 1"));
  EXPECT_THAT(with_material({{"emissiveFactor", {5, -1, 0}}}).load_error(), HasSubstr("emissiveFactor"));
  EXPECT_THAT(with_material({{"emissiveFactor", {1e7, 0, 0}}}).load_error(), HasSubstr("emissiveFactor"));
  EXPECT_THAT(with_extension("KHR_materials_ior", {{"ior", 0.5}}).load_error(), HasSubstr("ior of material m is 0.5"));
  EXPECT_THAT(with_extension("KHR_materials_ior", {{"ior", 1e7}}).load_error(), HasSubstr("1 to 1e6"));
  EXPECT_THAT(with_extension("KHR_materials_volume", {{"attenuationDistance", -1}}).load_error(),
              HasSubstr("attenuationDistance"));
  EXPECT_THAT(with_light({{"type", "point"}, {"intensity", -3}}).load_error(), HasSubstr("intensity of light a is -3"));
  EXPECT_THAT(with_animation({1, 0}, "LINEAR").load_error(), HasSubstr("growing"));
}

// A child that the scene lists as well is placed by its parent, in any order.
TEST(Tolerance, AChildThatTheSceneListsStaysWithItsParent) {
  for (const json& listed : {json{0, 1}, json{1, 0}}) {
    SmallGltf g;
    g.json["nodes"] = {{{"children", {1}}, {"translation", {5, 0, 0}}}, {{"mesh", 0}, {"name", "child"}}};
    g.json["scenes"][0]["nodes"] = listed;
    const Content content = g.load();
    ASSERT_EQ(content.objects.size(), 1u);
    EXPECT_EQ(content.objects[0].world_from_object[9], 5.0);
    EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("node child: the scene lists it")));
  }
}

// JSON does not tell 3.0 from 3, and the validator only warns.
TEST(Tolerance, WholeNumbersMayHaveAPoint) {
  SmallGltf g;
  g.json["bufferViews"][0]["byteLength"] = 36.0;
  g.json["bufferViews"][0]["byteOffset"] = 0.0;
  g.json["accessors"][0]["count"] = 3.0;
  g.json["accessors"][0]["componentType"] = 5126.0;
  g.json["nodes"][0]["mesh"] = 0.0;
  g.json["scene"] = 0.0;
  g.json["scenes"][0]["nodes"] = {0.0};
  g.primitive()["attributes"]["POSITION"] = 0.0;
  g.primitive()["mode"] = 4.0;
  const Content content = g.load();
  expect_shown(content);
  EXPECT_THAT(content.meshes[0].indices, ElementsAre(0, 1, 2));
  g.json["accessors"][0]["count"] = 2.5;
  EXPECT_THAT(g.load_error(), HasSubstr("scene.gltf"));
}

// A file whose buffers are elsewhere, and a binary chunk of no bytes behind its JSON.
TEST(Tolerance, ABinaryChunkMayBeEmpty) {
  const ScratchFolder folder;
  SmallGltf g;
  std::ifstream written(g.write(folder));
  std::string text{std::istreambuf_iterator<char>(written), {}};
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto length = static_cast<uint32_t>(text.size());
  const uint32_t frame[] = {0x46546c67, 2, 28 + length, length, 0x4e4f534a}, empty_chunk[] = {0, 0x004e4942};
  std::vector<uint8_t> bytes(28 + text.size());
  std::memcpy(bytes.data(), frame, 20);
  std::memcpy(&bytes[20], text.data(), text.size());
  std::memcpy(&bytes[20 + text.size()], empty_chunk, 8);
  put_bytes(folder / "scene.glb", bytes);
  expect_shown(load_file(folder / "scene.glb"));
}

TEST(Tolerance, DataOfAnyMediaTypeAreOctets) {
  for (const char* type : {"application/binary", ""}) {
    SmallGltf g;
    // Three positions at 0 but for one 1.0f, 0x3f800000.
    std::string zeros(48, 'A');
    g.json["buffers"] = {{{"byteLength", 36}, {"uri", std::string("data:") + type + ";base64," + zeros}}};
    g.load();
    EXPECT_THAT(g.load().warnings, testing::Contains(HasSubstr("buffer 0: its data URI has a media type"))) << type;
  }
}

TEST(Tolerance, BackslashesPartFolders) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "maps");
  put_bytes(folder / "maps/red.png", encode_png(1, 1, 4, std::vector<uint8_t>{200, 1, 2, 255}, "test"));
  SmallGltf g = with_material({{"emissiveTexture", {{"index", 0}}}});
  g.json["images"] = {{{"uri", "maps\\red.png"}}};
  g.json["textures"] = {{{"source", 0}}};
  const Content content = load_file(g.write(folder));
  EXPECT_EQ(content.textures.at(0).rgba[0], 200);
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("image 0: its uri has backslashes; they are read as slashes")));
  g.json["images"] = {{{"uri", "..\\red.png"}}};
  EXPECT_THAT(g.load_error(), HasSubstr("red.png"));
}

}  // namespace
}  // namespace sideray::scenes::tolerance_test
