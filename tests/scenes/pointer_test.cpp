// Tests KHR_animation_pointer and KHR_node_visibility: an animated value gives the content of a file with this value.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A white pixel.
constexpr const char* pixel =
    "data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC";

// One object of a material with every extension and texture, a light of each kind, and cameras. The object is twice as
// large as its mesh, which doubles its thickness.
struct Stage : SmallGltf {
  Stage() {
    json["images"] = {{{"uri", pixel}}};
    json["textures"] = {{{"source", 0}}};
    const nlohmann::json map = {{"index", 0}};
    nlohmann::json& m = json["materials"][0];
    m = {{"normalTexture", map}, {"occlusionTexture", map}, {"emissiveTexture", map}};
    m["emissiveFactor"] = {1, 0.5, 0.25};
    m["pbrMetallicRoughness"] = {{"baseColorTexture", map}, {"metallicRoughnessTexture", map}};
    nlohmann::json& e = m["extensions"];
    e["KHR_materials_anisotropy"] = {{"anisotropyTexture", map}};
    e["KHR_materials_clearcoat"] = {{"clearcoatTexture", map}, {"clearcoatNormalTexture", map}};
    e["KHR_materials_diffuse_transmission"] = {{"diffuseTransmissionTexture", map}};
    e["KHR_materials_emissive_strength"] = {{"emissiveStrength", 3}};
    e["KHR_materials_iridescence"] = {{"iridescenceTexture", map}};
    e["KHR_materials_sheen"] = {{"sheenColorTexture", map}};
    e["KHR_materials_specular"] = {{"specularTexture", map}};
    e["KHR_materials_transmission"] = {{"transmissionTexture", map}};
    e["KHR_materials_volume"] = {{"thicknessFactor", 0.5}};
    primitive()["material"] = 0;
    primitive()["attributes"]["TEXCOORD_0"] = add(std::vector<float>{0, 0, 1, 0, 0, 1}, 5126, "VEC2", 3);
    json["nodes"][0]["scale"] = {2, 2, 2};
    json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}},
        {{"type", "point"}, {"color", {1, 0.5, 0}}, {"intensity", 10}},
        {{"type", "spot"}, {"spot", nlohmann::json::object()}}};
    json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}},
                       {{"type", "orthographic"},
                        {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.5}, {"zfar", 9}}}}};
    for (int i = 0; i < 3; ++i) {
      json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
      if (i < 2) json["nodes"].back()["camera"] = i;
    }
    json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  }

  // Lets the pointer's value go from `from` at 0 s to `to` at 2 s.
  void animate(const std::string& pointer, const std::vector<float>& from, const std::vector<float>& to) {
    std::vector<float> values = from;
    values.insert(values.end(), to.begin(), to.end());
    const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const size_t times = add(std::vector<float>{0, 2}, 5126, "SCALAR", 2);
    const size_t output = add(values, 5126, types[from.size()], 2);
    nlohmann::json& animation = json["animations"][0];
    const size_t sampler = animation["samplers"].size();
    animation["samplers"].push_back({{"input", times}, {"output", output}});
    animation["channels"].push_back(
        {{"sampler", sampler},
         {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}});
  }
  void set(const std::string& pointer, const std::vector<float>& value) {
    nlohmann::json& at = json[nlohmann::json::json_pointer(pointer)];
    if (value.size() == 1)
      at = value[0];
    else
      at = value;
  }
  Content load_at(double time_s) {
    const ScratchFolder folder;
    return load_file(write(folder), {.animation = "", .time_s = time_s});
  }
};

template <typename T>
bool same_bytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

// Materials, lights and cameras have the same bits, and objects the same places.
void expect_equal(const Content& a, const Content& b) {
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (size_t i = 0; i < a.materials.size(); ++i) EXPECT_TRUE(same_bytes(a.materials[i].desc, b.materials[i].desc));
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (size_t i = 0; i < a.lights.size(); ++i) EXPECT_TRUE(same_bytes(a.lights[i].light, b.lights[i].light)) << i;
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) EXPECT_TRUE(same_bytes(a.cameras[i].camera, b.cameras[i].camera)) << i;
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i)
    EXPECT_TRUE(same_bytes(a.objects[i].world_from_object, b.objects[i].world_from_object)) << i;
}

struct Pointed {
  const char* pointer;
  std::vector<float> from, to;  // whose mean is a float
};

std::ostream& operator<<(std::ostream& out, const Pointed& p) {
  return out << p.pointer;
}

class Pointer : public testing::TestWithParam<Pointed> {};

TEST_P(Pointer, ChangesWhatAFileWouldSay) {
  const Pointed& p = GetParam();
  std::vector<float> middle;
  for (size_t i = 0; i < p.from.size(); ++i) middle.push_back(0.5f * (p.from[i] + p.to[i]));
  Stage moving, still, start;
  moving.animate(p.pointer, p.from, p.to);
  still.set(p.pointer, middle);
  start.set(p.pointer, p.from);
  Content content = moving.load_at(1);
  EXPECT_THAT(content.warnings, IsEmpty());
  EXPECT_TRUE(moves(content));
  expect_equal(content, still.load());
  pose(content, 0);
  expect_equal(content, start.load());
  // The animation must have changed something.
  Scene scene = Scene::create().value();
  fill(scene, content, std::vector<bool>(content.objects.size(), true));
  const Content other = moving.load_at(1.5);
  bool differs = false;
  for (size_t i = 0; i < other.materials.size(); ++i)
    differs |= !same_bytes(other.materials[i].desc, content.materials[i].desc);
  for (size_t i = 0; i < other.lights.size(); ++i)
    differs |= !same_bytes(other.lights[i].light, content.lights[i].light);
  for (size_t i = 0; i < other.cameras.size(); ++i)
    differs |= !same_bytes(other.cameras[i].camera, content.cameras[i].camera);
  for (size_t i = 0; i < other.objects.size(); ++i)
    differs |= !same_bytes(other.objects[i].world_from_object, content.objects[i].world_from_object);
  EXPECT_TRUE(differs);
  pose(content, 1.5);
  EXPECT_EQ(message_of([&] { move(scene, content); }), "");
}

#define MATERIAL "/materials/0/"
#define LIGHT "/extensions/KHR_lights_punctual/lights/"
INSTANTIATE_TEST_SUITE_P(
    Materials, Pointer,
    testing::Values(
        Pointed{MATERIAL "pbrMetallicRoughness/baseColorFactor", {0, 0.5, 1, 1}, {1, 0.25, 0, 0.5}},
        Pointed{MATERIAL "pbrMetallicRoughness/metallicFactor", {0}, {1}},
        Pointed{MATERIAL "pbrMetallicRoughness/roughnessFactor", {0.25}, {1}},
        Pointed{MATERIAL "alphaCutoff", {0}, {1}}, Pointed{MATERIAL "emissiveFactor", {0, 0, 0}, {1, 0.5, 0.25}},
        Pointed{MATERIAL "normalTexture/scale", {0}, {-2}}, Pointed{MATERIAL "occlusionTexture/strength", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_emissive_strength/emissiveStrength", {1}, {9}},
        Pointed{MATERIAL "extensions/KHR_materials_anisotropy/anisotropyStrength", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_anisotropy/anisotropyRotation", {0}, {3}},
        Pointed{MATERIAL "extensions/KHR_materials_clearcoat/clearcoatFactor", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", {1}, {0}},
        Pointed{MATERIAL "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
                {0, 0, 0},
                {1, 0, 1}},
        Pointed{MATERIAL "extensions/KHR_materials_dispersion/dispersion", {0}, {5}},
        Pointed{MATERIAL "extensions/KHR_materials_ior/ior", {1}, {2}},
        Pointed{MATERIAL "extensions/KHR_materials_iridescence/iridescenceFactor", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_iridescence/iridescenceIor", {1}, {2}},
        Pointed{MATERIAL "extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", {0}, {100}},
        Pointed{MATERIAL "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", {0}, {800}},
        Pointed{MATERIAL "extensions/KHR_materials_sheen/sheenColorFactor", {0, 0, 0}, {1, 0, 1}},
        Pointed{MATERIAL "extensions/KHR_materials_sheen/sheenRoughnessFactor", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_specular/specularFactor", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_specular/specularColorFactor", {0, 1, 2}, {1, 1, 1}},
        Pointed{MATERIAL "extensions/KHR_materials_transmission/transmissionFactor", {0}, {1}},
        Pointed{MATERIAL "extensions/KHR_materials_volume/thicknessFactor", {0}, {0.5}},
        Pointed{MATERIAL "extensions/KHR_materials_volume/attenuationDistance", {1}, {3}},
        Pointed{MATERIAL "extensions/KHR_materials_volume/attenuationColor", {1, 1, 1}, {0, 0.5, 1}}));

INSTANTIATE_TEST_SUITE_P(
    Textures, Pointer,
    testing::Values(
        Pointed{MATERIAL "pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset",
                {0, 0},
                {1, 3}},
        Pointed{MATERIAL "emissiveTexture/extensions/KHR_texture_transform/scale", {1, 1}, {4, 2}},
        Pointed{MATERIAL "normalTexture/extensions/KHR_texture_transform/rotation", {0}, {1.5}},
        Pointed{MATERIAL "extensions/KHR_materials_sheen/sheenColorTexture/extensions/KHR_texture_transform/offset",
                {0, 0},
                {1, 1}}));

INSTANTIATE_TEST_SUITE_P(LightsAndCameras, Pointer,
                         testing::Values(Pointed{LIGHT "0/intensity", {0}, {3}},
                                         Pointed{LIGHT "1/color", {1, 0, 0}, {0, 0, 1}},
                                         Pointed{LIGHT "1/range", {1}, {5}},
                                         Pointed{LIGHT "2/spot/innerConeAngle", {0}, {0.5}},
                                         Pointed{LIGHT "2/spot/outerConeAngle", {0.5}, {1.5}},
                                         Pointed{"/cameras/0/perspective/yfov", {0.5}, {1.5}},
                                         Pointed{"/cameras/0/perspective/znear", {0.5}, {1}},
                                         Pointed{"/cameras/1/orthographic/ymag", {1}, {3}},
                                         Pointed{"/cameras/1/orthographic/zfar", {10}, {30}}));

INSTANTIATE_TEST_SUITE_P(Nodes, Pointer,
                         testing::Values(Pointed{"/nodes/0/translation", {0, 0, 0}, {1, 2, 4}},
                                         Pointed{"/nodes/2/translation", {0, 0, 0}, {1, 2, 4}}));

TEST(Pointers, SeveralChangeOneThing) {
  Stage moving, still;
  moving.animate(MATERIAL "pbrMetallicRoughness/metallicFactor", {0}, {1});
  moving.animate(MATERIAL "emissiveFactor", {0, 0, 0}, {1, 1, 1});
  moving.animate(MATERIAL "extensions/KHR_materials_emissive_strength/emissiveStrength", {0}, {8});
  const std::string transform = MATERIAL "emissiveTexture/extensions/KHR_texture_transform/";
  moving.animate(transform + "offset", {0, 0}, {1, 1});
  moving.animate(transform + "rotation", {0}, {1});
  still.set(MATERIAL "pbrMetallicRoughness/metallicFactor", {0.5});
  still.set(MATERIAL "emissiveFactor", {0.5, 0.5, 0.5});
  still.set(MATERIAL "extensions/KHR_materials_emissive_strength/emissiveStrength", {4});
  still.set(transform + "offset", {0.5, 0.5});
  still.set(transform + "rotation", {0.5});
  expect_equal(moving.load_at(1), still.load());
}

// Two objects of one material, one twice as large: there are two materials, and both change.
TEST(Pointers, EveryScaleOfAMaterialChanges) {
  const auto two = [](Stage& g) {
    g.json["nodes"].push_back({{"mesh", 0}, {"name", "plain"}});
    g.json["scenes"][0]["nodes"].push_back(4);
  };
  Stage moving, still;
  two(moving), two(still);
  moving.animate(MATERIAL "extensions/KHR_materials_volume/thicknessFactor", {0}, {2});
  still.set(MATERIAL "extensions/KHR_materials_volume/thicknessFactor", {1});
  const Content content = moving.load_at(1);
  ASSERT_EQ(content.materials.size(), 2u);
  EXPECT_EQ(content.materials[content.objects[0].material].desc.thickness, 2.0f);
  EXPECT_EQ(content.materials[content.objects[1].material].desc.thickness, 1.0f);
  expect_equal(content, still.load());
}

TEST(Pointers, ValuesOutOfRangeAreTheNearestInRange) {
  Stage g;
  g.animate(MATERIAL "pbrMetallicRoughness/roughnessFactor", {-3}, {-1});
  g.animate(LIGHT "1/intensity", {-3}, {-1});
  g.animate("/cameras/0/perspective/yfov", {40}, {50});
  const Content content = g.load_at(1);
  EXPECT_EQ(content.materials[0].desc.roughness, 0.0f);
  EXPECT_EQ(content.lights[1].light.intensity[0], 0.0f);
  EXPECT_LT(content.cameras[0].camera.yfov, 3.14f);
  Scene scene = Scene::create().value();
  EXPECT_EQ(message_of([&] { fill(scene, content, {true}); }), "");
}

TEST(Pointers, WhatCannotChangeIsNamedOnce) {
  Stage g;
  g.animate("/cameras/0/perspective/aspectRatio", {1}, {2});
  g.animate("/materials/0/extensions/ACME_glitter/glitterFactor", {1}, {2});
  g.animate("/materials/0/extensions/ACME_glitter/glitterFactor", {1}, {2});
  g.animate("/extras/mood", {1}, {2});
  EXPECT_THAT(g.load().warnings, ElementsAre(HasSubstr("/cameras/0/perspective/aspectRatio"),
                                             HasSubstr("ACME_glitter/glitterFactor leads to nothing"),
                                             HasSubstr("/extras/mood")));
}

TEST(Pointers, BrokenOnesAreRefusedByName) {
  const auto error_of = [](const std::string& pointer, const std::vector<float>& value = {0}) {
    Stage g;
    g.animate(pointer, value, value);
    return g.load_error();
  };
  EXPECT_THAT(error_of("/materials/9/alphaCutoff"),
              AllOf(HasSubstr("animation animation0, channel 0, pointer /materials/9/alphaCutoff"),
                    HasSubstr("uses material 9, and there are 1; ")));
  EXPECT_THAT(error_of("/materials/99999999999/alphaCutoff"), HasSubstr("names no material by its number"));
  EXPECT_THAT(error_of("/materials/-1/alphaCutoff"), HasSubstr("uses material -1"));
  EXPECT_THAT(error_of("/nodes/x/translation"), HasSubstr("names no node by its number"));
  EXPECT_THAT(error_of("materials/0/alphaCutoff"), HasSubstr("does not begin with /"));
  EXPECT_THAT(error_of(""), HasSubstr("does not begin with /"));
  EXPECT_THAT(error_of(MATERIAL "alphaCutoff", {0, 0, 0}), HasSubstr("channel 0, values"));
  EXPECT_THAT(error_of(MATERIAL "alphaCutoff", {NAN}), HasSubstr("not finite"));
  Stage g;
  g.animate(MATERIAL "alphaCutoff", {0}, {1});
  g.json["animations"][0]["channels"][0]["target"].erase("extensions");
  EXPECT_THAT(g.load().warnings, ElementsAre(HasSubstr("it has no pointer of KHR_animation_pointer; left out")));
  g.json["animations"][0]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"]["pointer"] = 3;
  EXPECT_THAT(g.load_error(), HasSubstr("the pointer of animation animation0, channel 0 is not text"));
}

TEST(Pointers, WeightsOfAMeshAreThoseOfItsNodes) {
  const auto morphing = [](Stage& g) {
    const size_t target = g.add(std::vector<float>{0, 0, 0, 4, 0, 0, 0, 4, 0}, 5126, "VEC3", 3);
    g.primitive()["targets"] = {{{"POSITION", target}}};
  };
  for (const char* pointer : {"/meshes/0/weights", "/nodes/0/weights"}) {
    Stage moving, still;
    morphing(moving), morphing(still);
    moving.animate(pointer, {0}, {1});
    still.json[nlohmann::json::json_pointer(pointer)] = {0.5};
    EXPECT_EQ(moving.load_at(1).meshes[0].positions, still.load().meshes[0].positions) << pointer;
  }
}

// A parent of the object and the lights, seen from 0 to 1 s.
struct Blinking : Stage {
  explicit Blinking(bool is_animated) {
    json["nodes"].push_back({{"children", {0, 2}}});
    json["scenes"][0]["nodes"] = {4, 1, 3};
    if (!is_animated) return;
    const size_t times = add(std::vector<float>{0, 1, 2}, 5126, "SCALAR", 3);
    const size_t output = add(std::vector<uint8_t>{1, 0, 0}, 5121, "SCALAR", 3);
    json["animations"] = {{{"samplers", {{{"input", times}, {"output", output}, {"interpolation", "STEP"}}}},
                           {"channels",
                            {{{"sampler", 0},
                              {"target",
                               {{"path", "pointer"},
                                {"extensions",
                                 {{"KHR_animation_pointer",
                                   {{"pointer", "/nodes/4/extensions/KHR_node_visibility/visible"}}}}}}}}}}}};
  }
};

TEST(Visibility, HiddenNodesAreNotRead) {
  Blinking g(false);
  g.json["extensionsUsed"] = {"KHR_node_visibility"};
  g.json["nodes"][4]["extensions"]["KHR_node_visibility"]["visible"] = false;
  g.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = true;
  const Content content = g.load();
  EXPECT_THAT(content.objects, IsEmpty()) << "children of what is hidden are hidden, whatever they say";
  EXPECT_EQ(content.lights.size(), 2u);
  EXPECT_EQ(content.cameras.size(), 2u) << "cameras stay";
  EXPECT_THAT(content.warnings, IsEmpty());
  g.json["nodes"][4]["extensions"]["KHR_node_visibility"]["visible"] = 1;
  EXPECT_THAT(g.load_error(), HasSubstr("visible of node 4 is not true or false"));
}

TEST(Visibility, ChannelsHideAndShow) {
  Content content = Blinking(true).load_at(0.5);
  const Content shown = Blinking(false).load();
  expect_equal(content, shown);
  pose(content, 1.5);
  EXPECT_LT(std::abs(content.objects[0].world_from_object[0]), 1e-6);
  EXPECT_EQ(content.lights[0].light.intensity[0], 0.0f) << "that of the hidden node";
  EXPECT_EQ(content.lights[1].light.intensity[0], 1.0f);
  pose(content, 0);
  expect_equal(content, shown);
}

}  // namespace
}  // namespace sideray::scenes
