#include "scenes/content/morph.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "scenes/content/animation.h"
#include "scenes/support.h"

// Compares morph targets with closed forms, with weights at rest and over time, alone and under a skin.
namespace sideray::scenes::morph_test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pointwise;

// A square in the xy plane, of 2 x 2, with two targets: the first moves it by 3 along z, the second its upper edge by 1
// along x.
struct Square : SmallGltf {
  Square() {
    auto& attributes = primitive()["attributes"];
    attributes = {{"POSITION", add(corners, 5126, "VEC3", 4)},
                  {"NORMAL", add(same({0, 0, 1}), 5126, "VEC3", 4)},
                  {"TANGENT", add(same({1, 0, 0, -1}), 5126, "VEC4", 4)},
                  {"TEXCOORD_0", add(std::vector<float>{0, 1, 1, 1, 1, 0, 0, 0}, 5126, "VEC2", 4)}};
    primitive()["indices"] = add(std::vector<uint16_t>{0, 1, 2, 0, 2, 3}, 5123, "SCALAR", 6);
    const std::vector<float> upper_edge{0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0};
    primitive()["targets"] = {{{"POSITION", add(same({0, 0, 3}), 5126, "VEC3", 4)}},
                              {{"POSITION", add(upper_edge, 5126, "VEC3", 4)}}};
  }

  // The same numbers at each vertex.
  static std::vector<float> same(const std::vector<float>& value) {
    std::vector<float> values;
    for (int i = 0; i < 4; ++i) values.insert(values.end(), value.begin(), value.end());
    return values;
  }

  // Weights of both targets at each time, or what a spline takes.
  void animate(const std::vector<float>& times, const std::vector<float>& weights, const char* interpolation) {
    const size_t input = add(times, 5126, "SCALAR", times.size());
    const size_t output = add(weights, 5126, "SCALAR", weights.size());
    json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                           {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}}};
  }

  static std::vector<float> at(double first, double second) {
    std::vector<float> positions = corners;
    for (size_t v = 0; v < 4; ++v) positions[3 * v + 2] += static_cast<float>(3 * first);
    for (const size_t v : {size_t{2}, size_t{3}}) positions[3 * v] += static_cast<float>(second);
    return positions;
  }

  static const std::vector<float> corners;
};
const std::vector<float> Square::corners{-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};

Content load_at(SmallGltf g, double time_s) {
  const ScratchFolder folder;
  return load(g.write(folder), {.animation = "", .time_s = time_s});
}

auto near(const std::vector<float>& expected) {
  return Pointwise(FloatNear(1e-6f), expected);
}

const Mesh& only_mesh(const Content& content) {
  EXPECT_EQ(content.meshes.size(), 1u);
  return content.meshes.at(0);
}

TEST(Morph, WeightsOfTheNodeGoBeforeThoseOfTheMesh) {
  Square g;
  EXPECT_EQ(only_mesh(g.load()).positions, Square::corners) << "without any weights they are 0";
  g.json["meshes"][0]["weights"] = {0.5, -2};
  EXPECT_THAT(only_mesh(g.load()).positions, near(Square::at(0.5, -2)));
  g.json["nodes"][0]["weights"] = {0, 1.5};
  const Content content = g.load();
  EXPECT_THAT(only_mesh(content).positions, near(Square::at(0, 1.5)));
  EXPECT_THAT(content.warnings, IsEmpty());
  EXPECT_EQ(content.rig, nullptr) << "nothing moves";
}

TEST(Morph, NodesShareAShapeWhereTheirWeightsAreTheSame) {
  Square g;
  g.json["nodes"] = {{{"mesh", 0}, {"weights", {1, 0}}}, {{"mesh", 0}, {"weights", {0, 1}}},
                     {{"mesh", 0}, {"weights", {1, 0}}}, {{"mesh", 0}}};
  g.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Content content = g.load();
  ASSERT_EQ(content.meshes.size(), 3u);
  EXPECT_EQ(content.objects[0].mesh, content.objects[2].mesh);
  EXPECT_THAT(content.meshes[content.objects[0].mesh].positions, near(Square::at(1, 0)));
  EXPECT_THAT(content.meshes[content.objects[1].mesh].positions, near(Square::at(0, 1)));
  EXPECT_THAT(content.meshes[content.objects[3].mesh].positions, near(Square::corners));
}

TEST(Morph, DirectionsAreUnitAndOtherAttributesAreAdded) {
  Square g;
  auto& attributes = g.primitive()["attributes"];
  attributes["COLOR_0"] = g.add(Square::same({0.5f, 0.5f, 0.5f}), 5126, "VEC3", 4);
  g.primitive()["targets"] = {{{"NORMAL", g.add(Square::same({2, 0, 0}), 5126, "VEC3", 4)},
                               {"TANGENT", g.add(Square::same({-1, 1, 0}), 5126, "VEC3", 4)},
                               {"TEXCOORD_0", g.add(Square::same({4, 6}), 5126, "VEC2", 4)},
                               {"COLOR_0", g.add(Square::same({1, -0.5f, -2}), 5126, "VEC3", 4)}}};
  g.json["meshes"][0]["weights"] = {0.5};
  const Content content = g.load();
  const Mesh& mesh = only_mesh(content);
  const float half = std::sqrt(0.5f);
  EXPECT_EQ(mesh.positions, Square::corners);
  EXPECT_THAT(mesh.normals, near(Square::same({half, 0, half})));
  EXPECT_THAT(mesh.tangents, near(Square::same({half, half, 0, -1})));
  EXPECT_THAT(mesh.uv0, near({2, 4, 3, 4, 3, 3, 2, 3}));
  EXPECT_THAT(mesh.colors, near(Square::same({1, 0.25f, 0, 1}))) << "colours stay in 0..1";
}

TEST(Morph, TargetsMayBeSparseOrWithoutDataAndIntegers) {
  Square g;
  const size_t indices = g.add_view(std::vector<uint8_t>{2}), values = g.add_view(std::vector<float>{0, 0, 5});
  g.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 4}});
  g.primitive()["targets"][0]["POSITION"] = g.json["accessors"].size() - 1;
  g.json["nodes"][0]["weights"] = {2, 0};
  EXPECT_EQ(only_mesh(g.load()).positions, Square::corners) << "an accessor without a view is all 0";
  g.json["accessors"].back()["sparse"] = {{"count", 1},
                                          {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                          {"values", {{"bufferView", values}}}};
  EXPECT_EQ(only_mesh(g.load()).positions[8], 10.0f);
  const std::vector<int16_t> third_raised{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 32767, 0, 0, 0, 0, 0};
  const size_t shorts = g.add(third_raised, 5122, "VEC3", 4);
  g.json["bufferViews"].back()["byteStride"] = 8;
  g.json["accessors"][shorts]["normalized"] = true;
  g.primitive()["targets"][0]["POSITION"] = shorts;
  g.json.erase("buffers");  // it was written with fewer bytes
  EXPECT_EQ(only_mesh(g.load()).positions[8], 2.0f);
}

// ---- Over time ----

TEST(Morph, WeightsMoveByEveryInterpolation) {
  Square linear, step, cubic;
  linear.animate({0, 2}, {0, 1, 1, -3}, "LINEAR");
  step.animate({0, 1, 2}, {0, 1, 1, -3, 0, 0}, "STEP");
  // t^3 and 1 - t^2: a cubic is its own Hermite spline. In-tangents, values, out-tangents of both.
  cubic.animate({0, 2}, {9, 9, 0, 1, 0, 0, /**/ 12, -4, 8, -3, 9, 9}, "CUBICSPLINE");
  for (const double t : {0.0, 0.25, 0.5, 1.0, 1.75}) {
    SCOPED_TRACE(t);
    EXPECT_THAT(only_mesh(load_at(linear, t)).positions, near(Square::at(t / 2, 1 - 2 * t)));
    EXPECT_THAT(only_mesh(load_at(step, t)).positions, near(t < 1 ? Square::at(0, 1) : Square::at(1, -3)));
    EXPECT_THAT(only_mesh(load_at(cubic, t)).positions,
                Pointwise(FloatNear(1e-5f), Square::at(t * t * t, 1 - t * t)));
  }
  EXPECT_THAT(only_mesh(load_at(linear, 2.5)).positions, near(Square::at(0.25, 0))) << "it loops";
}

TEST(Morph, ManyTargetsHaveTheirOwnWeights) {
  Square g;
  std::vector<float> weights;
  g.primitive()["targets"] = json::array();
  for (int t = 0; t < 11; ++t) {
    g.primitive()["targets"].push_back(
        {{"POSITION", g.add(Square::same({static_cast<float>(1 << t), 0, 0}), 5126, "VEC3", 4)}});
    weights.push_back(t % 3 == 0 ? 1.0f : 0.0f);
  }
  weights.insert(weights.end(), 11, 0.0f);
  g.animate({0, 1}, weights, "LINEAR");
  const float all = 1 + 8 + 64 + 512;
  EXPECT_EQ(only_mesh(load_at(g, 0)).positions[0], all - 1);
  EXPECT_EQ(only_mesh(load_at(g, 0.5)).positions[0], all / 2 - 1);
}

TEST(Morph, PosingEqualsLoadingAtThatTime) {
  Square g;
  g.animate({0, 1, 2}, {0, 0, 1, -2, 0, 0}, "LINEAR");
  Content posed = load_at(g, 0.2);
  for (const double t : {0.9, 1.7, 0.0}) {
    pose(posed, t);
    EXPECT_EQ(posed.meshes[0].positions, load_at(g, t).meshes[0].positions);
    EXPECT_EQ(posed.meshes[0].normals, load_at(g, t).meshes[0].normals);
    EXPECT_EQ(posed.meshes[0].indices.size(), 6u);
  }
}

// Files are written with the shape at the current time; only cameras keep their animation.
TEST(Morph, WrittenFilesHoldTheShapeOfTheTime) {
  Square g;
  g.animate({0, 1, 2}, {0, 0, 1, -2, 0, 0}, "LINEAR");
  const ScratchFolder folder;
  write_glb(folder / "a.glb", load_at(g, 0.5));
  const Content again = load(folder / "a.glb");
  EXPECT_THAT(only_mesh(again).positions, near(Square::at(0.5, -1)));
  EXPECT_THAT(again.animations, IsEmpty());
}

TEST(Morph, EachNodeWhoseWeightsMoveHasAMeshOfItsOwn) {
  Square g;
  g.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"weights", {0, 1}}}, {{"mesh", 0}, {"weights", {0, 1}}}};
  g.json["scenes"][0]["nodes"] = {0, 1, 2};
  g.animate({0, 1}, {0, 0, 1, 0}, "LINEAR");
  const Content content = load_at(g, 0.5);
  ASSERT_EQ(content.meshes.size(), 2u);
  EXPECT_THAT(content.meshes[content.objects[0].mesh].positions, near(Square::at(0.5, 0)));
  EXPECT_THAT(content.meshes[content.objects[1].mesh].positions, near(Square::at(0, 1)));
  EXPECT_EQ(content.rig->morphed.size(), 1u) << "what stands still is not blended again";
}

// A skin bends what is blended: two bones, of which the second carries all and turns by 90 degrees about +Z in a
// second.
TEST(Morph, SkinsBendWhatIsBlended) {
  for (const bool moves : {false, true}) {
    Square g;
    auto& attributes = g.primitive()["attributes"];
    const std::vector<uint8_t> second{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    attributes["JOINTS_0"] = g.add(second, 5121, "VEC4", 4);
    attributes["WEIGHTS_0"] = g.add(Square::same({1, 0, 0, 0}), 5126, "VEC4", 4);
    g.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"weights", {0.5, 0}}}, {{"children", {2}}}, {{"name", "bone"}}};
    g.json["scenes"][0]["nodes"] = {0, 1};
    g.json["skins"] = {{{"joints", {1, 2}}}};
    g.animate({0, 1}, {0, 0, 1, 2}, "LINEAR");
    if (!moves) g.json["animations"][0] = {{"channels", json::array()}, {"samplers", json::array()}};
    const float half = std::sqrt(0.5f);
    const size_t times = g.add(std::vector<float>{0, 1}, 5126, "SCALAR", 2);
    const size_t turns = g.add(std::vector<float>{0, 0, 0, 1, 0, 0, half, half}, 5126, "VEC4", 2);
    json& animation = g.json["animations"][0];
    animation["samplers"].push_back({{"input", times}, {"output", turns}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", 2}, {"path", "rotation"}}}});
    Content content = load_at(g, 0);
    for (const double t : {0.0, 0.5, 0.9375}) {
      pose(content, t);
      std::vector<float> expected = moves ? Square::at(t, 2 * t) : Square::at(0.5, 0);
      const double angle = t * std::acos(0.0);
      for (size_t v = 0; v < 4; ++v) {
        const double x = double{expected[3 * v]}, y = double{expected[3 * v + 1]};
        expected[3 * v] = static_cast<float>(x * std::cos(angle) - y * std::sin(angle));
        expected[3 * v + 1] = static_cast<float>(x * std::sin(angle) + y * std::cos(angle));
      }
      EXPECT_THAT(only_mesh(content).positions, near(expected)) << t;
      EXPECT_EQ(content.rig->morphed.size(), moves ? 1u : 0u);
    }
  }
}

// ---- In a scene ----

double distance_to(Tracer& tracer, double x, double y) {
  const sideray_ray ray{{x, y, 10}, {0, 0, -1}, 0, 100};
  return tracer.trace(SIDERAY_RAYS_OPAQUE, std::span(&ray, 1)).at(0).distance;
}

TEST(Morph, RaysMeetTheShapeOfTheTime) {
  Square g;
  g.animate({0, 1, 2}, {0, 0, 1, 0, 0, 0}, "LINEAR");
  Content content = load_at(g, 0);
  Scene scene = Scene::create().value();
  fill(scene, content, {false});
  Tracer tracer = Tracer::create(scene).value();
  for (const double t : {0.0, 0.5, 1.0, 1.75, 0.25}) {
    pose(content, t);
    move(scene, content);
    const double weight = t <= 1 ? t : 2 - t;
    EXPECT_NEAR(distance_to(tracer, 0.3, 0.2), 10 - 3 * weight, 1e-5) << t;
  }
}

// Exporters write shapes whose triangles have no area until a target opens them.
TEST(Morph, WhatIsFoldedAtRestUnfolds) {
  Square g;
  g.primitive()["attributes"].erase("NORMAL");
  g.primitive()["attributes"].erase("TANGENT");
  g.primitive()["attributes"]["POSITION"] = g.add(Square::same({0, 0, 0}), 5126, "VEC3", 4);
  g.primitive()["targets"] = {{{"POSITION", g.add(Square::corners, 5126, "VEC3", 4)}}};
  g.animate({0, 1, 2}, {0, 1, 0}, "LINEAR");
  Content content = load_at(g, 0);
  Scene scene = Scene::create().value();
  fill(scene, content, {false});
  Tracer tracer = Tracer::create(scene).value();
  EXPECT_TRUE(std::isinf(distance_to(tracer, 0.3, 0.2)));
  pose(content, 0.75);
  move(scene, content);
  EXPECT_NEAR(distance_to(tracer, 0.3, 0.2), 10, 1e-5);
  EXPECT_TRUE(std::isinf(distance_to(tracer, 0.9, 0.2)));
}

// ---- What is broken ----

TEST(Morph, BrokenOnesAreOneLine) {
  const auto error_of = [](auto&& breaks) {
    Square g;
    breaks(g);
    const std::string message = g.load_error();
    EXPECT_THAT(message, AllOf(HasSubstr("scene.gltf"), HasSubstr("; ")));
    EXPECT_EQ(message.find('\n'), std::string::npos);
    return message;
  };
  EXPECT_THAT(error_of([](Square& g) { g.primitive()["targets"][1] = json::object(); }),
              HasSubstr("mesh tri, target 1 has no data"));
  EXPECT_THAT(error_of([](Square& g) { g.primitive()["targets"][1]["POSITION"] = 99; }), HasSubstr("accessor 99"));
  EXPECT_THAT(error_of([](Square& g) { g.primitive()["targets"][1]["POSITION"] = 3; }), HasSubstr("4 components"));
  EXPECT_THAT(error_of([](Square& g) {
                g.primitive()["targets"][0]["POSITION"] = g.add(std::vector<float>{0, 0, 1}, 5126, "VEC3", 1);
              }),
              HasSubstr("1 elements where 4 belong"));
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), INFINITY, 2e15f})
    EXPECT_THAT(error_of([bad](Square& g) {
                  g.primitive()["targets"][0]["POSITION"] = g.add(Square::same({0, bad, 1}), 5126, "VEC3", 4);
                }),
                HasSubstr("target 0, POSITION has numbers that are not finite"));
  EXPECT_THAT(error_of([](Square& g) { g.json["meshes"][0]["weights"] = {1}; }),
              HasSubstr("mesh tri has 1 weights for 2 morph targets"));
  EXPECT_THAT(error_of([](Square& g) { g.json["nodes"][0]["weights"] = {1, 2, 3}; }),
              HasSubstr("node a has 3 weights for 2 morph targets"));
  EXPECT_THAT(error_of([](Square& g) { g.json["nodes"][0]["weights"] = {1e9, 0}; }), HasSubstr("a weight beyond 1e6"));
  EXPECT_THAT(error_of([](Square& g) { g.animate({0, 1}, {0, 1, 2}, "LINEAR"); }), HasSubstr("3 elements where 4"));
  EXPECT_THAT(error_of([](Square& g) { g.animate({0, 1}, {0, 1, 2, NAN}, "LINEAR"); }), HasSubstr("not finite"));
  EXPECT_THAT(error_of([](Square& g) {
                g.json["meshes"][0]["primitives"].push_back(g.primitive());
                g.json["meshes"][0]["primitives"][1]["targets"].erase(1);
              }),
              HasSubstr("has 1 morph targets where another primitive has 2"));
}

// A few characters a target, 50 MB each.
TEST(Morph, TargetsThatShareBytesAreCountedBeforeTheyAreRead) {
  Square g;
  const size_t many = size_t{1} << 22;
  g.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", many}});
  const size_t accessor = g.json["accessors"].size() - 1;
  g.primitive()["attributes"] = {{"POSITION", accessor}};
  g.primitive()["targets"] = json::array();
  for (int t = 0; t < 100; ++t) g.primitive()["targets"].push_back({{"POSITION", accessor}});
  EXPECT_THAT(g.load_error(), HasSubstr("more than 4 GiB"));
}

TEST(Morph, WhatIsLeftOutIsSaid) {
  Square g;
  g.primitive().erase("targets");
  g.json["meshes"][0]["weights"] = {1};
  g.animate({0, 1}, {0, 1}, "LINEAR");
  EXPECT_THAT(load_at(g, 0).warnings,
              testing::UnorderedElementsAre(HasSubstr("node a: it has weights and no morph targets; left out"),
                                            HasSubstr("its node has no morph targets; left out")));
  Square bare;
  bare.primitive()["targets"][0]["NORMAL"] = bare.primitive()["targets"][0]["POSITION"];
  bare.primitive()["attributes"].erase("NORMAL");
  EXPECT_THAT(bare.load().warnings, ElementsAre("mesh tri: its targets have NORMAL, and it has none itself; left out"));
}

// A vertex keeps its position where a product is too large, as splines may cause.
TEST(Morph, NothingIsBlendedBeyondTheWorld) {
  Square g;
  g.primitive()["targets"][0]["POSITION"] = g.add(Square::same({0, 9e14f, 0}), 5126, "VEC3", 4);
  g.animate({0, 1}, {0, 0, 1e30f, 0}, "LINEAR");
  Content content = load_at(g, 0);
  Scene scene = Scene::create().value();
  fill(scene, content, {false});
  pose(content, 0.5);
  EXPECT_EQ(only_mesh(content).positions, Square::corners);
  EXPECT_EQ(message_of([&] { move(scene, content); }), "");
}

// ---- A real file ----

TEST(MorphedAsset, ASparseTargetOfAnExporter) {
  const char* folder = std::getenv("SIDERAY_ASSETS");
  const std::filesystem::path path =
      (folder ? std::filesystem::path(folder)
              : std::filesystem::path(SIDERAY_SOURCE_DIR).parent_path() / "shared" / "assets") /
      "Invalid/tinygltf/SparseMorphTargets-issue280/singleBlendshapeCube_sparse.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no test content at " << path;
  const Content content = load(path);
  EXPECT_THAT(content.warnings, IsEmpty());
  ASSERT_EQ(content.rig->morphed.size(), 1u);
  // Half of the cube's corners go by 0.015 along x; its animation has one key, at weight 0.
  const MorphedMesh& morphed = content.rig->morphed[0];
  Mesh stretched;
  const double one = 1.0;
  blend(morphed.base, *morphed.targets, std::span(&one, 1), stretched);
  const std::vector<float>&from = content.meshes[0].positions, &to = stretched.positions;
  size_t moved = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    moved += from[i] != to[i];
    EXPECT_NEAR(to[i] - from[i], from[i] != to[i] ? 0.015f : 0.0f, 1e-7f);
  }
  EXPECT_EQ(moved, 12u);
}

}  // namespace
}  // namespace sideray::scenes::morph_test
