#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "scenes/content/animation.h"
#include "scenes/builtin/builtin.h"
#include "scenes/support.h"

// Tests writing and reading EXT_mesh_gpu_instancing: shared values are written once, and nothing is lost.
namespace sideray::scenes {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

json json_of(const std::string& path) {
  const std::vector<uint8_t> bytes = bytes_of(path);
  uint32_t length = 0;
  std::memcpy(&length, &bytes.at(12), 4);
  return json::parse(bytes.begin() + 20, bytes.begin() + 20 + length);
}

json instances_of(const json& node) {
  return node.value("/extensions/EXT_mesh_gpu_instancing/attributes"_json_pointer, json());
}

void expect_same_objects(const Content& a, const Content& b) {
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    const Object &x = a.objects[i], &y = b.objects[i];
    ASSERT_EQ(x.name, y.name) << i;
    ASSERT_EQ(a.meshes[x.mesh].name, b.meshes[y.mesh].name) << i;
    ASSERT_EQ(a.materials[x.material].name, b.materials[y.material].name) << i;
    ASSERT_TRUE(std::equal(x.world_from_object, x.world_from_object + 12, y.world_from_object)) << i << ' ' << x.name;
    ASSERT_EQ(x.wind != 0, y.wind != 0) << i;
    ASSERT_EQ(x.wind_phase, y.wind_phase) << i;
    if (x.wind != 0) {
      // Without the padding behind the last field.
      constexpr size_t bytes = offsetof(sideray_wind_desc, wavelength) + sizeof(float);
      ASSERT_EQ(std::memcmp(&a.winds[x.wind - 1], &b.winds[y.wind - 1], bytes), 0) << i;
    }
  }
}

// One triangle, two materials; tests add objects.
Content small_content() {
  Content content;
  content.name = "small";
  Mesh mesh;
  mesh.name = "triangle";
  mesh.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  mesh.indices = {0, 1, 2};
  content.meshes.push_back(mesh);
  for (const char* name : {"a", "b"}) {
    Material material;
    material.name = name;
    material.desc = sideray_material_defaults();
    content.materials.push_back(material);
  }
  return content;
}

Object object_at(const std::string& name, const glm::dmat4& world_from_object) {
  Object object;
  object.name = name;
  set_transform(object, world_from_object);
  return object;
}

// Every factor has more digits than a float.
glm::dmat4 placement(int i, double scale = 1.0) {
  glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(i / 3.0, std::sqrt(i + 0.5), -1e5 / 7.0 * i));
  m = glm::rotate(m, 0.7 * i, glm::normalize(glm::dvec3(1, 0.3 * i - 4, 0.5)));
  return glm::scale(m, scale * glm::dvec3(1.0 / 3.0 + i, 0.1, 1.7));
}

Content round_trip(const Content& content, json* written = nullptr) {
  const ScratchFolder folder;
  write_glb(folder / "a.glb", content);
  if (written) *written = json_of(folder / "a.glb");
  return load(folder / "a.glb");
}

TEST(Instances, AForestIsFewNodesAndComesBackToTheLastBit) {
  const Content forest = generate("forest", {{"count", "3000"}});
  json written;
  const Content read = round_trip(forest, &written);
  EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
  EXPECT_GE(read.objects.size(), 3000u);
  EXPECT_LT(written["nodes"].size(), 200u);
  expect_same_objects(forest, read);
  EXPECT_EQ(forest.meshes.size(), read.meshes.size());
}

TEST(Instances, KeepTheOrderOfObjectsAroundThem) {
  Content content = small_content();
  for (int i = 0; i < 40; ++i) {
    content.objects.push_back(object_at(i % 4 == 3 ? "single " + std::to_string(i) : "many", placement(i)));
    content.objects.back().material = i % 4 == 1 ? 1 : 0;
  }
  json written;
  const Content read = round_trip(content, &written);
  expect_same_objects(content, read);
  size_t instanced = 0;
  for (const json& node : written["nodes"])
    if (!instances_of(node).is_null()) ++instanced;
  EXPECT_EQ(instanced, 2u) << "one for each material";
  EXPECT_THAT(written["extensionsUsed"], ElementsAre("EXT_mesh_gpu_instancing"));
  EXPECT_FALSE(written.contains("extensionsRequired")) << "as the extension is used elsewhere";
}

TEST(Instances, FewAreNodes) {
  Content content = small_content();
  for (int i = 0; i < 7; ++i) content.objects.push_back(object_at("few", placement(i)));
  json written;
  expect_same_objects(content, round_trip(content, &written));
  EXPECT_FALSE(written.contains("extensionsUsed"));
  EXPECT_EQ(written["nodes"].size(), 7u);
}

TEST(Instances, MirroredOnesAreInstancesAndShearedOnesNodes) {
  Content content = small_content();
  for (int i = 0; i < 20; ++i) content.objects.push_back(object_at("mirrored", placement(i, -1.0)));
  for (int i = 0; i < 20; ++i) {
    glm::dmat4 shear(1.0);
    shear[1][0] = 0.01;
    content.objects.push_back(object_at("sheared", placement(i) * shear));
  }
  json written;
  expect_same_objects(content, round_trip(content, &written));
  size_t sheared = 0;
  for (const json& node : written["nodes"]) {
    if (node["name"] == "sheared") {
      ++sheared;
      EXPECT_TRUE(instances_of(node).is_null());
    }
    if (node["name"] == "mirrored") {
      EXPECT_FALSE(instances_of(node).is_null());
    }
  }
  EXPECT_EQ(sheared, 20u);
}

// Other programs read translation, rotation and scale alone, which give the same placement up to floats.
TEST(Instances, FloatsSayThePlacesToo) {
  Content content = small_content();
  for (int i = 0; i < 20; ++i) content.objects.push_back(object_at("many", placement(i, i % 2 == 0 ? 1 : -1)));
  const ScratchFolder folder;
  write_glb(folder / "a.glb", content);
  std::vector<uint8_t> bytes = bytes_of(folder / "a.glb");
  // Another name of the same length hides an attribute.
  const std::string name = "_MATRIX_ROW_";
  for (auto at = bytes.begin(); (at = std::search(at, bytes.end(), name.begin(), name.end())) != bytes.end(); ++at)
    at[1] = 'X';
  put_bytes(folder / "b.glb", bytes);
  const Content read = load(folder / "b.glb");
  ASSERT_EQ(read.objects.size(), content.objects.size());
  for (size_t i = 0; i < content.objects.size(); ++i) {
    const double *x = content.objects[i].world_from_object, *y = read.objects[i].world_from_object;
    double largest = 0;
    for (int k = 0; k < 9; ++k) largest = std::max(largest, std::abs(x[k]));
    for (int k = 0; k < 9; ++k) EXPECT_NEAR(x[k], y[k], 1e-6 * largest) << i;
    for (int k = 9; k < 12; ++k) EXPECT_EQ(static_cast<float>(x[k]), static_cast<float>(y[k])) << i;
  }
}

TEST(Instances, SimplePlacesNeedNoDoubles) {
  Content content = small_content();
  for (int i = 0; i < 20; ++i) {
    const glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(0.25 * i, 1, 2));
    content.objects.push_back(object_at("many", glm::scale(m, glm::dvec3(0.5 * (i + 1)))));
  }
  json written;
  expect_same_objects(content, round_trip(content, &written));
  EXPECT_FALSE(instances_of(written["nodes"][0]).contains("_MATRIX_ROW_0"));
}

TEST(Instances, EachHasItsWindPhase) {
  Content content = small_content();
  for (const float amplitude : {0.1f, 0.2f}) {
    sideray_wind_desc wind = sideray_wind_defaults();
    wind.amplitude = amplitude;
    content.winds.push_back(wind);
  }
  for (int i = 0; i < 30; ++i) {
    content.objects.push_back(object_at("plant", placement(i)));
    content.objects.back().wind = static_cast<uint32_t>(i % 3);  // none, the first, the second
    if (i % 3 != 0) content.objects.back().wind_phase = static_cast<float>(i) / 31.0f;
  }
  expect_same_objects(content, round_trip(content));
}

TEST(Instances, WhatMovesByItselfStaysANode) {
  Content content = small_content();
  const auto rig = std::make_shared<Rig>();
  content.animations.push_back({"walk", 1.0});
  for (uint32_t i = 0; i < 30; ++i) {
    content.objects.push_back(object_at("many", placement(static_cast<int>(i))));
    if (i % 3 == 0) rig->objects.push_back({.index = i, .node = 0});
  }
  content.rig = rig;
  const ScratchFolder folder;
  write_glb(folder / "a.glb", content);
  const json written = json_of(folder / "a.glb");
  EXPECT_EQ(written["nodes"].size(), 10u + 1u);
  EXPECT_TRUE(instances_of(written["nodes"][0]).is_null());
  EXPECT_FALSE(instances_of(written["nodes"][1]).is_null());
}

// A triangle twice, at (1, 0, 0) and (0, 5, 0).
struct InstancedGltf : SmallGltf {
  InstancedGltf() {
    json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    set("TRANSLATION", add(std::vector<float>{1, 0, 0, 0, 5, 0}, 5126, "VEC3", 2));
  }
  nlohmann::json& attributes() {
    return json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  }
  void set(const char* key, const nlohmann::json& accessor) {
    attributes()[key] = accessor;
    json.erase("buffers");  // written anew, as long as it is by then
  }
  void set_floats(const char* key, const std::vector<float>& values) {
    set(key, add(values, 5126, "SCALAR", values.size()));
  }
  // The matrices' row as doubles.
  void set_row(const char* key, const std::vector<double>& values) {
    std::vector<uint16_t> parts;
    for (const double value : values)
      for (int shift = 0; shift < 64; shift += 16)
        parts.push_back(static_cast<uint16_t>(std::bit_cast<uint64_t>(value) >> shift));
    set(key, add(parts, 5123, "MAT4", values.size() / 4));
  }
};

TEST(Instances, AttributesOfOtherProgramsAreNoConcern) {
  InstancedGltf g;
  g.set_floats("_ID", {7, 8});
  EXPECT_EQ(g.load().objects.size(), 2u);
  g.attributes().erase("TRANSLATION");
  const Content read = g.load();
  ASSERT_EQ(read.objects.size(), 2u) << "as many as there are numbers, all where the node is";
  EXPECT_EQ(read.objects[1].world_from_object[9], 0.0);
  g.set_floats("_WIND_PHASE", {-3, 8});
  EXPECT_EQ(g.load().objects.size(), 2u) << "the node has no wind";
  g.attributes() = json::object();
  EXPECT_EQ(g.load().objects.size(), 1u) << "no attributes, no instances: the mesh itself";
}

TEST(Instances, RowsAreTakenWhereTheyOnlyRefine) {
  const double third = 1.0 / 3.0;
  InstancedGltf g;
  g.set("TRANSLATION", g.add(std::vector<float>{static_cast<float>(third), 0, 0, 9, 0, 0}, 5126, "VEC3", 2));
  g.set_row("_MATRIX_ROW_0", {1, 0, 0, third, 1, 0, 0, third});
  const Content read = g.load();
  EXPECT_EQ(read.objects[0].world_from_object[9], third);
  EXPECT_EQ(read.objects[1].world_from_object[9], 9.0) << "moved since by another program";
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0], AllOf(HasSubstr("node a: 1 instances"), HasSubstr("TRANSLATION")));
}

TEST(Instances, IndicesOrderObjectsAndOthersFillTheGaps) {
  InstancedGltf g;
  g.json["nodes"].push_back({{"name", "b"}, {"mesh", 0}});
  g.json["nodes"].push_back({{"name", "c"}, {"mesh", 0}});
  g.json["scenes"][0]["nodes"] = {0, 1, 2};
  const auto names = [&] {
    std::vector<std::string> list;
    for (const Object& object : g.load().objects) list.push_back(object.name);
    return list;
  };
  EXPECT_THAT(names(), ElementsAre("a", "a", "b", "c")) << "without indices: the file's order";
  g.set_floats("_OBJECT_INDEX", {2, 1});
  EXPECT_THAT(names(), ElementsAre("b", "a", "a", "c"));
  EXPECT_EQ(g.load().objects[1].world_from_object[10], 5.0) << "the second one";
  g.set_floats("_OBJECT_INDEX", {1000, 1});
  EXPECT_THAT(names(), ElementsAre("b", "a", "c", "a")) << "beyond the end: last";
  g.set_floats("_OBJECT_INDEX", {0, 0});
  EXPECT_THAT(names(), ElementsAre("a", "a", "b", "c")) << "the same place twice: one after the other";
}

// An animation follows its object to its new place.
TEST(Instances, OrderedObjectsKeepTheirAnimation) {
  InstancedGltf g;
  g.set_floats("_OBJECT_INDEX", {2, 1});
  g.json["nodes"].push_back({{"name", "b"}, {"mesh", 0}});
  g.json["nodes"].push_back({{"name", "c"}, {"mesh", 0}});
  g.json["scenes"][0]["nodes"] = {0, 1, 2};
  const size_t times = g.add(std::vector<float>{0, 1}, 5126, "SCALAR", 2);
  const size_t values = g.add(std::vector<float>{0, 0, 0, 0, 0, 7}, 5126, "VEC3", 2);
  g.json["animations"] = {{{"samplers", {{{"input", times}, {"output", values}}}},
                           {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}}}}};
  const ScratchFolder folder;
  const Content read = load(g.write(folder), {.animation = "", .time_s = 0.5});
  ASSERT_EQ(read.objects.size(), 4u);
  EXPECT_EQ(read.objects[0].name, "b");
  EXPECT_EQ(read.objects[0].world_from_object[11], 3.5);
  for (size_t i = 1; i < 4; ++i) EXPECT_EQ(read.objects[i].world_from_object[11], 0.0) << i;
}

struct Malformed {
  const char* name;
  void (*break_it)(InstancedGltf&);
  const char* says;
};

class MalformedInstances : public testing::TestWithParam<Malformed> {};

TEST_P(MalformedInstances, AreRefused) {
  InstancedGltf g;
  g.json["nodes"][0]["extras"]["sideray"]["wind"] = {{"amplitude", 0.2}};
  ASSERT_EQ(g.load_error(), "");
  GetParam().break_it(g);
  EXPECT_THAT(g.load_error(), AllOf(HasSubstr("node a"), HasSubstr(GetParam().says), HasSubstr("; ")));
}

constexpr float nan_float = std::numeric_limits<float>::quiet_NaN();
INSTANTIATE_TEST_SUITE_P(
    All, MalformedInstances,
    testing::Values(
        Malformed{"counts", [](InstancedGltf& g) { g.set("SCALE", g.add(std::vector<float>(9, 1), 5126, "VEC3", 3)); },
                  "2 elements where 3 belong"},
        Malformed{"count_of_phases", [](InstancedGltf& g) { g.set_floats("_WIND_PHASE", {0, 0, 0}); },
                  "_WIND_PHASE has 3 elements where 2 belong"},
        Malformed{"no_accessor", [](InstancedGltf& g) { g.set("ROTATION", 99); }, "accessor 99"},
        Malformed{"no_index", [](InstancedGltf& g) { g.set("_ID", -1); }, "_ID is -1"},
        Malformed{"half_an_index", [](InstancedGltf& g) { g.set("ROTATION", 0.5); }, "ROTATION is 0.5"},
        Malformed{"components", [](InstancedGltf& g) { g.set("ROTATION", g.attributes()["TRANSLATION"]); },
                  "ROTATION has 3 components instead of 4"},
        Malformed{"scalar_row",
                  [](InstancedGltf& g) {
                    g.set_floats("_MATRIX_ROW_1", {0, 1});
                  },
                  "_MATRIX_ROW_1 has 1 components instead of 16"},
        Malformed{"float_row",
                  [](InstancedGltf& g) {
                    g.set("_MATRIX_ROW_1", g.add(std::vector<float>(32, 1), 5126, "MAT4", 2));
                  },
                  "_MATRIX_ROW_1 is not of unsigned shorts"},
        Malformed{"nan", [](InstancedGltf& g) {
                    g.set("SCALE", g.add(std::vector<float>{1, 1, 1, 1, nan_float, 1}, 5126, "VEC3", 2));
                  },
                  "SCALE is not finite"},
        Malformed{"nan_phase", [](InstancedGltf& g) { g.set_floats("_WIND_PHASE", {0, nan_float}); },
                  "_WIND_PHASE is not finite"},
        Malformed{"nan_row",
                  [](InstancedGltf& g) {
                    g.set_row("_MATRIX_ROW_0", {1, 0, 0, 1, double{nan_float}, 0, 0, 0});
                  },
                  "_MATRIX_ROW_0 is not finite"},
        Malformed{"phase", [](InstancedGltf& g) { g.set_floats("_WIND_PHASE", {0, 1.5f}); }, "give 0 to 1"},
        Malformed{"place", [](InstancedGltf& g) { g.set_floats("_OBJECT_INDEX", {0, 0.5f}); }, "whole numbers"},
        Malformed{"negative_place", [](InstancedGltf& g) { g.set_floats("_OBJECT_INDEX", {0, -1}); }, "whole numbers"},
        Malformed{"list", [](InstancedGltf& g) { g.attributes() = json::array({0}); }, "not an object"},
        Malformed{"far", [](InstancedGltf& g) {
                    g.set("TRANSLATION", g.add(std::vector<float>{1, 0, 0, 2e15f, 0, 0}, 5126, "VEC3", 2));
                  },
                  "beyond 1e15"}),
    [](const auto& test) { return std::string(test.param.name); });

// An accessor without data takes no bytes in the file, and each instance takes some in memory.
TEST(Instances, MoreThanObjectsAreRefusedBeforeTheyAreMade) {
  InstancedGltf g;
  g.json["accessors"].push_back(
      {{"componentType", 5126}, {"type", "VEC3"}, {"count", (size_t{1} << 22) + 1}});
  g.set("TRANSLATION", g.json["accessors"].size() - 1);
  EXPECT_THAT(g.load_error(), HasSubstr("4194305 instances, more than 4194304"));
}

std::string write_error(const Content& content) {
  const ScratchFolder folder;
  const std::string message = message_of([&] { write_glb(folder / "a.glb", content); });
  EXPECT_EQ(folder.entries(), 0u) << "nothing is left, whole or half";
  const std::string path = folder / "a.glb";
  EXPECT_THAT(message, HasSubstr("cannot write " + path));
  return message;
}

// Lights are the product of a colour and a strength, which does not round them.
TEST(Write, LightsComeBackToTheLastBit) {
  Content content = small_content();
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_POINT;
  for (int i = 1; i < 50; ++i) {
    const float channels[] = {0.1f * static_cast<float>(i), 3.3f, 7.7f / static_cast<float>(i)};
    std::copy(channels, channels + 3, light.intensity);
    content.lights.push_back({"light" + std::to_string(i), light});
  }
  const ScratchFolder folder;
  write_glb(folder / "a.glb", content);
  const Content again = load(folder / "a.glb");
  ASSERT_EQ(again.lights.size(), content.lights.size());
  for (size_t i = 0; i < content.lights.size(); ++i)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(again.lights[i].light.intensity[c], content.lights[i].light.intensity[c]) << i;
}

TEST(WriteLimits, MoreJsonThanIsReadIsRefused) {
  Content content = small_content();
  for (int i = 0; i < 400000; ++i) content.objects.push_back(object_at("o" + std::to_string(i), placement(i % 9)));
  EXPECT_THAT(write_error(content), AllOf(HasSubstr("more than the 8388608 values that are read"),
                                          HasSubstr("make fewer objects, or more of the same mesh")));
}

TEST(WriteLimits, DeeperJsonThanIsReadIsRefused) {
  Content content = small_content();
  Emitter emitter{};
  emitter.node = "steam";
  const auto nested = [](int depth) {
    return "{\"count\": 1, \"x\": " + std::string(static_cast<size_t>(depth), '[') +
           std::string(static_cast<size_t>(depth), ']') + "}";
  };
  emitter.json = nested(70);
  content.emitters.push_back(emitter);
  EXPECT_THAT(write_error(content), HasSubstr("nested deeper than the 64"));
  // The greatest depth that is written is the greatest that is read.
  for (int depth = 50; depth < 70; ++depth) {
    content.emitters[0].json = nested(depth);
    const ScratchFolder folder;
    const bool is_written = message_of([&] { write_glb(folder / "a.glb", content); }).empty();
    const bool is_read = is_written && message_of([&] { load(folder / "a.glb"); }).empty();
    EXPECT_EQ(is_written, is_read) << depth;
  }
}

TEST(WriteLimits, WhatIsTooLargeOrTooFarIsRefused) {
  const Content small = small_content();
  Content lights = small, texture = small, far = small, nowhere = small;
  lights.lights.resize(4097);
  EXPECT_THAT(write_error(lights), HasSubstr("4097 lights, and 4096 are the most"));
  texture.textures.push_back({"wide", 16385, 1, std::vector<uint8_t>(4 * 16385), false});
  EXPECT_THAT(write_error(texture), HasSubstr("16385 pixels along a side"));
  far.objects.push_back(object_at("moon", glm::translate(glm::dmat4(1), glm::dvec3(2e15, 0, 0))));
  EXPECT_THAT(write_error(far), AllOf(HasSubstr("object moon"), HasSubstr("2e+15"), HasSubstr("move it closer")));
  nowhere.objects.push_back(object_at("ghost", glm::scale(glm::dmat4(1), glm::dvec3(NAN))));
  EXPECT_THAT(write_error(nowhere), HasSubstr("object ghost"));
}

}  // namespace
}  // namespace sideray::scenes
