#include "scenes/content/animation.h"

#include <gmock/gmock.h>

#include <cmath>

#include "scenes/support.h"

namespace sideray::scenes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pointwise;

constexpr double pi = 3.14159265358979323846;

Channel channel(Property property, Interpolation interpolation, std::vector<float> times, std::vector<float> values) {
  Channel c;
  c.property = property, c.interpolation = interpolation;
  c.times = std::move(times), c.values = std::move(values);
  return c;
}

// ---- Sampling ----

TEST(Animation, LinearAndStepBetweenKeys) {
  Channel c = channel(Property::translation, Interpolation::linear, {1, 3}, {0, 0, 0, 2, 4, -8});
  EXPECT_EQ(glm::dvec3(sample(c, 1.5)), glm::dvec3(0.5, 1, -2));
  EXPECT_EQ(glm::dvec3(sample(c, 0.0)), glm::dvec3(0)) << "before the first key";
  EXPECT_EQ(glm::dvec3(sample(c, 9.0)), glm::dvec3(2, 4, -8)) << "behind the last key";
  c.interpolation = Interpolation::step;
  EXPECT_EQ(glm::dvec3(sample(c, 2.999)), glm::dvec3(0));
  EXPECT_EQ(glm::dvec3(sample(c, 3.0)), glm::dvec3(2, 4, -8));
  c.times = {1};
  EXPECT_EQ(glm::dvec3(sample(c, 0.5)), glm::dvec3(0)) << "a single key";
}

// A cubic polynomial is its own Hermite spline, whatever the keys.
TEST(Animation, CubicSplinesAreExactForCubics) {
  const auto p = [](double t) { return glm::dvec3(t * t * t - 2 * t, 3 * t * t - t, 5 - t * t * t); };
  const auto slope = [](double t) { return glm::dvec3(3 * t * t - 2, 6 * t - 1, -3 * t * t); };
  std::vector<float> times = {0, 0.5f, 2}, values;
  for (const float t : times) {
    for (const glm::dvec3& v : {slope(double{t}), p(double{t}), slope(double{t})})
      for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(v[c]));
  }
  const Channel c = channel(Property::scale, Interpolation::cubic, times, values);
  for (double t = 0; t <= 2; t += 0.0625)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(sample(c, t)[k], p(t)[k], 1e-6) << t;
  EXPECT_EQ(glm::dvec3(sample(c, 5)), p(2));
}

// A key has two tangents: the segment before it uses the in-tangent, the one after it the out-tangent.
TEST(Animation, CubicSplinesUseTheOutTangentThenTheInTangent) {
  const float wrong = 1e6f;
  const Channel c = channel(Property::translation, Interpolation::cubic, {0, 2},
                            {wrong, 0, 0, 1, 0, 0, 3, 0, 0, /**/ -5, 0, 0, 7, 0, 0, wrong, 0, 0});
  // h00 1 + 2 h10 3 + h01 7 + 2 h11 (-5) at the middle: 1/2 + 6/8 + 7/2 + 10/8.
  EXPECT_NEAR(sample(c, 1).x, 6.0, 1e-12);
}

TEST(Animation, RotationsTurnAtConstantSpeedTheShorterWay) {
  const auto about_y = [](double degrees, float sign) {
    const double half = degrees * pi / 360;
    return std::vector<float>{0, sign * static_cast<float>(std::sin(half)), 0,
                              sign * static_cast<float>(std::cos(half))};
  };
  for (const float sign : {1.0f, -1.0f}) {
    std::vector<float> values = about_y(10, 1), to = about_y(100, sign);
    values.insert(values.end(), to.begin(), to.end());
    const Channel c = channel(Property::rotation, Interpolation::linear, {0, 1}, values);
    for (double t = 0; t <= 1; t += 0.125) {
      const glm::dvec4 q = sample(c, t);
      const double half = (10 + 90 * t) * pi / 360;
      // q and -q are the same rotation.
      EXPECT_NEAR(std::abs(q.y * std::sin(half) + q.w * std::cos(half)), 1.0, 1e-12) << t;
      EXPECT_NEAR(glm::length(q), 1.0, 1e-12);
    }
  }
}

TEST(Animation, CubicRotationsKeepUnitLength) {
  const Channel c = channel(Property::rotation, Interpolation::cubic, {0, 1},
                            {0, 0, 0, 0, 0, 0, 0, 1, 1, 2, 3, 4, /**/ 4, 3, 2, 1, 0, 1, 0, 0, 0, 0, 0, 0});
  for (double t = 0; t <= 1; t += 0.1) EXPECT_NEAR(glm::length(sample(c, t)), 1.0, 1e-12);
}

TEST(Animation, TimeLoops) {
  Channel c = channel(Property::translation, Interpolation::linear, {0, 2}, {0, 0, 0, 4, 0, 0});
  c.period_s = 3;
  EXPECT_DOUBLE_EQ(sample(c, 0.5).x, 1);
  EXPECT_DOUBLE_EQ(sample(c, 2.5).x, 4) << "another channel is longer";
  EXPECT_DOUBLE_EQ(sample(c, 3.5).x, 1);
  EXPECT_DOUBLE_EQ(sample(c, 300.5).x, 1);
}

// ---- Files ----

json animation_of(const json& channels, const json& samplers, const char* name = "") {
  json animation = {{"name", name}};
  // One in braces alone is itself, not a list of one.
  for (const json& c : channels.is_array() ? channels : json::array({channels})) animation["channels"].push_back(c);
  for (const json& c : samplers.is_array() ? samplers : json::array({samplers})) animation["samplers"].push_back(c);
  return animation;
}

json target(int sampler, int node, const char* path) {
  return {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}};
}

// A mesh, a camera and two lights under one node that moves along x by 1 a second for 4 seconds.
SmallGltf moving() {
  SmallGltf g;
  g.json["extensionsUsed"] = {"KHR_lights_punctual"};
  g.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}},
                                                           {{"type", "spot"}, {"spot", json::object()}}};
  g.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
  const auto light = [](int i) { return json{{"KHR_lights_punctual", {{"light", i}}}}; };
  g.json["nodes"] = {{{"children", {1, 2, 3}}, {"name", "cart"}},
                     {{"mesh", 0}, {"translation", {0, 1, 0}}},
                     {{"camera", 0}, {"name", "cam"}, {"translation", {0, 0, 5}}},
                     {{"extensions", light(0)}, {"name", "lamp"}, {"translation", {0, 2, 0}}},
                     {{"extensions", light(1)}, {"name", "fixed"}, {"translation", {0, 3, 0}}}};
  g.json["scenes"][0]["nodes"] = {0, 4};
  const size_t times = g.add(std::vector<float>{0, 4}, 5126, "SCALAR", 2);
  const size_t places = g.add(std::vector<float>{0, 0, 0, 4, 0, 0}, 5126, "VEC3", 2);
  g.json["animations"] =
      json::array({animation_of({target(0, 0, "translation")}, {{{"input", times}, {"output", places}}}, "drive")});
  return g;
}

Content load_at(SmallGltf g, double time_s, const std::string& animation = "") {
  const ScratchFolder folder;
  return load(g.write(folder), {.animation = animation, .time_s = time_s});
}

TEST(Animation, MovesObjectsCamerasAndLights) {
  const Content c = load_at(moving(), 1.25);
  ASSERT_EQ(c.animations.size(), 1u);
  EXPECT_EQ(c.animations[0].name, "drive");
  EXPECT_EQ(c.animations[0].length_s, 4.0);
  EXPECT_TRUE(c.warnings.empty());
  EXPECT_DOUBLE_EQ(c.objects.at(0).world_from_object[9], 1.25);
  EXPECT_DOUBLE_EQ(c.objects[0].world_from_object[10], 1.0);
  EXPECT_DOUBLE_EQ(c.cameras.at(0).camera.world_from_camera[9], 1.25);
  EXPECT_THAT(c.lights.at(0).light.position, ElementsAre(1.25, 2, 0));
  EXPECT_THAT(c.lights.at(1).light.position, ElementsAre(0, 3, 0));
}

void expect_same_pose(const Content& a, const Content& b) {
  for (size_t i = 0; i < a.objects.size(); ++i)
    EXPECT_TRUE(std::equal(a.objects[i].world_from_object, a.objects[i].world_from_object + 12,
                           b.objects[i].world_from_object));
  for (size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i].positions, b.meshes[i].positions);
    EXPECT_EQ(a.meshes[i].normals, b.meshes[i].normals);
  }
  for (size_t i = 0; i < a.lights.size(); ++i)
    EXPECT_TRUE(std::equal(a.lights[i].light.position, a.lights[i].light.position + 3, b.lights[i].light.position));
  for (size_t i = 0; i < a.cameras.size(); ++i)
    EXPECT_TRUE(std::equal(a.cameras[i].camera.world_from_camera, a.cameras[i].camera.world_from_camera + 12,
                           b.cameras[i].camera.world_from_camera));
}

TEST(Animation, PosingEqualsLoadingAtThatTime) {
  Content posed = load_at(moving(), 3.0);
  pose(posed, 0.75);
  expect_same_pose(posed, load_at(moving(), 0.75));
  pose(posed, 4.75);
  expect_same_pose(posed, load_at(moving(), 0.75));
}

TEST(Animation, OneAnimationPlaysOrAllOfThem) {
  SmallGltf g = moving();
  const size_t times = g.add(std::vector<float>{0, 1}, 5126, "SCALAR", 2);
  const size_t scales = g.add(std::vector<float>{1, 1, 1, 3, 3, 3}, 5126, "VEC3", 2);
  g.json["animations"].push_back(
      animation_of({target(0, 1, "scale")}, {{{"input", times}, {"output", scales}, {"interpolation", "STEP"}}}));
  const auto place_and_scale = [&](double time_s, const char* animation) {
    const Content c = load_at(g, time_s, animation);
    return std::pair(c.objects.at(0).world_from_object[9], c.objects[0].world_from_object[0]);
  };
  EXPECT_EQ(place_and_scale(2, ""), std::pair(2.0, 1.0));
  EXPECT_EQ(place_and_scale(0.5, "animation1"), std::pair(0.0, 1.0));
  EXPECT_EQ(place_and_scale(2.5, "all"), std::pair(2.5, 1.0)) << "each loops on its own";
  const std::string message = message_of([&] { load_at(g, 0, "walk"); });
  EXPECT_THAT(message, AllOf(HasSubstr("no animation walk"), HasSubstr("drive, animation1")));
  EXPECT_THROW(load_at(g, 0, "walk"), UnknownAnimation);
  EXPECT_THROW(load("panes", {.animation = "walk", .time_s = 0}), UnknownAnimation);
}

TEST(Animation, WhatIsScaledToNothingComesBack) {
  SmallGltf g;
  const size_t times = g.add(std::vector<float>{0, 1, 2}, 5126, "SCALAR", 3);
  const size_t scales = g.add(std::vector<float>{0, 0, 0, 1, 1, 1, 0, 0, 0}, 5126, "VEC3", 3);
  g.json["animations"] = json::array({animation_of({target(0, 0, "scale")}, {{{"input", times}, {"output", scales}}})});
  Content c = load_at(g, 0);
  ASSERT_EQ(c.objects.size(), 1u);
  Scene scene = Scene::create().value();
  fill(scene, c, {false});
  EXPECT_LT(std::abs(c.objects[0].world_from_object[0]), 1e-6);
  pose(c, 1);
  EXPECT_DOUBLE_EQ(c.objects[0].world_from_object[0], 1);
}

TEST(Animation, RotationsInBytesAndShortsAreNormalized) {
  SmallGltf g;
  const size_t times = g.add(std::vector<float>{0}, 5126, "SCALAR", 1);
  const size_t bytes = g.add(std::vector<int8_t>{0, 127, 0, 0}, 5120, "VEC4", 1);
  const size_t shorts = g.add(std::vector<int16_t>{0, 32767, 0, 0}, 5122, "VEC4", 1);
  for (const size_t values : {bytes, shorts}) {
    g.json["accessors"][values]["normalized"] = true;
    g.json["animations"] =
        json::array({animation_of({target(0, 0, "rotation")}, {{{"input", times}, {"output", values}}})});
    EXPECT_NEAR(load_at(g, 0).objects.at(0).world_from_object[0], -1.0, 1e-12) << "half a turn about +Y";
  }
}

TEST(Animation, WhatCannotPlayIsSaid) {
  SmallGltf weights = moving();
  weights.json["animations"][0]["channels"].push_back(target(0, 1, "weights"));
  EXPECT_THAT(load_at(weights, 0).warnings, Contains(HasSubstr("morph targets")));
  SmallGltf matrix = moving();
  matrix.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1};
  const Content c = load_at(matrix, 2);
  EXPECT_THAT(c.warnings, Contains(HasSubstr("matrix")));
  EXPECT_EQ(c.objects.at(0).world_from_object[9], 7.0);
}

TEST(Animation, BrokenOnesAreOneLine) {
  const auto error_of = [](auto&& breaks) {
    SmallGltf g = moving();
    breaks(g, g.json["animations"][0]);
    const std::string message = g.load_error();
    EXPECT_EQ(message.find('\n'), std::string::npos);
    return message;
  };
  EXPECT_THAT(error_of([](SmallGltf&, json& a) { a["channels"][0]["sampler"] = 4; }), HasSubstr("sampler 4"));
  EXPECT_THAT(error_of([](SmallGltf&, json& a) { a["channels"][0]["target"]["node"] = 44; }), HasSubstr("node 44"));
  EXPECT_THAT(error_of([](SmallGltf&, json& a) { a["samplers"][0]["interpolation"] = "CUBICSPLINE"; }),
              HasSubstr("2 elements where 6"));
  EXPECT_THAT(error_of([](SmallGltf&, json& a) { a["samplers"][0]["input"] = a["samplers"][0]["output"]; }),
              HasSubstr("components"));
  EXPECT_THAT(error_of([](SmallGltf& g, json& a) {
                a["samplers"][0]["input"] = g.add(std::vector<float>{4, 0}, 5126, "SCALAR", 2);
              }),
              HasSubstr("growing"));
  EXPECT_THAT(error_of([](SmallGltf& g, json& a) {
                a["samplers"][0]["output"] = g.add(std::vector<float>{0, 0, 0, INFINITY, 0, 0}, 5126, "VEC3", 2);
              }),
              HasSubstr("not finite"));
}

// ---- Skins ----

// An upright strip of three quads from y = 0 to 3 on two bones, the joint at y = 1.5: below it bone 0, above it bone 1;
// node 3 turns the upper bone to 90 degrees about +Z in a second.
struct Arm : SmallGltf {
  template <typename T>
  void joints_and_weights(int joint_type, int weight_type, double one) {
    std::vector<uint8_t> joints8;
    std::vector<uint16_t> joints16;
    std::vector<T> weights;
    for (int row = 0; row < 4; ++row) {
      for (int side = 0; side < 2; ++side) {
        const uint8_t bone = row < 2 ? 0 : 1;
        // The unused place names a joint that is not there, which its weight of 0 allows.
        for (const uint8_t j : {bone, uint8_t{99}, uint8_t{0}, uint8_t{0}}) joints8.push_back(j), joints16.push_back(j);
        for (const double w : {one, 0.0, 0.0, 0.0}) weights.push_back(static_cast<T>(w));
      }
    }
    auto& attributes = primitive()["attributes"];
    attributes["JOINTS_0"] = joint_type == 5121 ? add(joints8, 5121, "VEC4", 8) : add(joints16, 5123, "VEC4", 8);
    attributes["WEIGHTS_0"] = add(weights, weight_type, "VEC4", 8);
    if (weight_type != 5126) json["accessors"].back()["normalized"] = true;
  }

  Arm() {
    std::vector<float> positions, normals, tangents;
    for (int row = 0; row < 4; ++row) {
      for (const float x : {-0.5f, 0.5f}) {
        positions.insert(positions.end(), {x, static_cast<float>(row), 0});
        normals.insert(normals.end(), {0.6f, 0, 0.8f});
        tangents.insert(tangents.end(), {0, 1, 0, -1});
      }
    }
    auto& attributes = primitive()["attributes"];
    attributes = {{"POSITION", add(positions, 5126, "VEC3", 8)},
                  {"NORMAL", add(normals, 5126, "VEC3", 8)},
                  {"TANGENT", add(tangents, 5126, "VEC4", 8)}};
    primitive()["indices"] =
        add(std::vector<uint16_t>{0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4, 4, 5, 7, 4, 7, 6}, 5123, "SCALAR", 18);
    joints_and_weights<float>(5121, 5126, 1.0);
    // The mesh's node is moved far away, which has no effect; the skeleton is at x = 10.
    auto& nodes = json["nodes"];
    nodes = {{{"mesh", 0}, {"skin", 0}, {"name", "arm"}, {"translation", {100, 100, 100}}},
             {{"children", {2}}, {"translation", {10, 0, 0}}},
             {{"children", {3}}},
             {{"translation", {0, 1.5, 0}}}};
    json["scenes"][0]["nodes"] = {0, 1};
    const size_t inverse = add(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,     0, 1,
                                                  1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1.5f, 0, 1},
                               5126, "MAT4", 2);
    json["skins"] = {{{"joints", {2, 3}}, {"inverseBindMatrices", inverse}}};
    const size_t times = add(std::vector<float>{0, 1}, 5126, "SCALAR", 2);
    const float half = static_cast<float>(std::sqrt(0.5));
    const size_t turns = add(std::vector<float>{0, 0, 0, 1, 0, 0, half, half}, 5126, "VEC4", 2);
    // The last key is repeated after the first second, so that time 1 is not the start of the next period.
    json["animations"] =
        json::array({animation_of({target(0, 3, "rotation"), target(1, 1, "scale")},
                                  {{{"input", times}, {"output", turns}},
                                   {{"input", add(std::vector<float>{0, 2}, 5126, "SCALAR", 2)},
                                    {"output", add(std::vector<float>{1, 1, 1, 1, 1, 1}, 5126, "VEC3", 2)}}})});
  }
};

std::vector<float> bent_arm(double angle) {
  std::vector<float> expected;
  for (int row = 0; row < 4; ++row) {
    for (const double x : {-0.5, 0.5}) {
      const double y = row - 1.5;
      const bool upper = row >= 2;
      const double bx = upper ? x * std::cos(angle) - y * std::sin(angle) : x;
      const double by = upper ? x * std::sin(angle) + y * std::cos(angle) + 1.5 : row;
      expected.insert(expected.end(), {static_cast<float>(10 + bx), static_cast<float>(by), 0.0f});
    }
  }
  return expected;
}

TEST(Skin, AnArmBendsAtItsJoint) {
  for (const double t : {0.0, 0.25, 1.0}) {
    SCOPED_TRACE(t);
    const double angle = t * pi / 2;
    const Content c = load_at(Arm(), t);
    ASSERT_EQ(c.objects.size(), 1u);
    EXPECT_EQ(c.objects[0].name, "arm");
    EXPECT_EQ(c.objects[0].world_from_object[9], 0.0) << "the node's own place is not used";
    const Mesh& mesh = c.meshes[c.objects[0].mesh];
    EXPECT_THAT(mesh.positions, Pointwise(FloatNear(2e-6f), bent_arm(angle)));
    const std::vector<float> lower(mesh.normals.begin(), mesh.normals.begin() + 3),
        upper(mesh.normals.end() - 3, mesh.normals.end()), tangent(mesh.tangents.end() - 4, mesh.tangents.end());
    EXPECT_THAT(lower, Pointwise(FloatNear(1e-6f), {0.6f, 0.0f, 0.8f}));
    const auto cosine = static_cast<float>(std::cos(angle)), sine = static_cast<float>(std::sin(angle));
    EXPECT_THAT(upper, Pointwise(FloatNear(1e-6f), {0.6f * cosine, 0.6f * sine, 0.8f}));
    EXPECT_THAT(tangent, Pointwise(FloatNear(1e-6f), {-sine, cosine, 0.0f, -1.0f}));
  }
}

TEST(Skin, EveryFormatOfJointsAndWeights) {
  Arm bytes, shorts, halves;
  bytes.joints_and_weights<uint8_t>(5123, 5121, 255);
  shorts.joints_and_weights<uint16_t>(5121, 5123, 65535);
  halves.joints_and_weights<float>(5121, 5126, 0.5);  // no shares yet
  for (Arm* arm : {&bytes, &shorts, &halves})
    EXPECT_THAT(load_at(*arm, 0.5).meshes.at(0).positions, Pointwise(FloatNear(2e-6f), bent_arm(pi / 4)));
}

// With two bones linear blend skinning averages their positions of the vertex.
TEST(Skin, TwoSetsBlend) {
  Arm arm;
  const size_t lower = arm.add(std::vector<uint8_t>(32, 0), 5121, "VEC4", 8),
               upper = arm.add(std::vector<uint8_t>(32, 1), 5121, "VEC4", 8);
  std::vector<float> quarter, three_quarters;
  for (int i = 0; i < 8; ++i) {
    quarter.insert(quarter.end(), {0.25f, 0, 0, 0});
    three_quarters.insert(three_quarters.end(), {0, 0, 0, 0.75f});
  }
  json& attributes = arm.primitive()["attributes"];
  attributes["JOINTS_0"] = lower, attributes["WEIGHTS_0"] = arm.add(quarter, 5126, "VEC4", 8);
  attributes["JOINTS_1"] = upper, attributes["WEIGHTS_1"] = arm.add(three_quarters, 5126, "VEC4", 8);
  const Content c = load_at(arm, 1.0);
  // Vertex 7 at (0.5, 3): bone 0 leaves it at (10.5, 3), bone 1 turns it to (10 - 1.5, 1.5 + 0.5).
  const std::vector<float>& p = c.meshes.at(0).positions;
  EXPECT_NEAR(p[21], 0.25 * 10.5 + 0.75 * 8.5, 2e-6);
  EXPECT_NEAR(p[22], 0.25 * 3 + 0.75 * 2, 2e-6);
}

// Normals of a squashed bone follow the inverse transpose: a plane stays a plane.
TEST(Skin, NormalsOfScaledBonesStayPerpendicular) {
  Arm arm;
  arm.json["animations"] = json::array();
  arm.json["nodes"][1]["scale"] = {4, 1, 2};
  const Content c = load_at(arm, 0);
  const Mesh& mesh = c.meshes.at(0);
  const double x = 0.6 / 4, z = 0.8 / 2, length = std::hypot(x, z);
  EXPECT_NEAR(mesh.normals[0], x / length, 1e-6);
  EXPECT_NEAR(mesh.normals[2], z / length, 1e-6);
  EXPECT_EQ(c.rig, nullptr) << "nothing moves";
}

TEST(Skin, NodesWithTheSameMeshHaveShapesOfTheirOwn) {
  Arm arm;
  arm.json["nodes"].push_back({{"mesh", 0}});
  arm.json["scenes"][0]["nodes"].push_back(4);
  const Content c = load_at(arm, 1.0);
  ASSERT_EQ(c.objects.size(), 2u);
  EXPECT_NE(c.objects[0].mesh, c.objects[1].mesh);
  EXPECT_NEAR(c.meshes[c.objects[1].mesh].positions[21], 0.5, 1e-6);
}

TEST(Skin, PosingEqualsLoadingAtThatTime) {
  Content posed = load_at(Arm(), 0.2);
  pose(posed, 0.9);
  expect_same_pose(posed, load_at(Arm(), 0.9));
}

TEST(Skin, BrokenOnesAreOneLine) {
  const auto error_of = [](auto&& breaks) {
    Arm arm;
    breaks(arm);
    const std::string message = arm.load_error();
    EXPECT_EQ(message.find('\n'), std::string::npos);
    return message;
  };
  EXPECT_THAT(error_of([](Arm& a) { a.json["nodes"][0]["skin"] = 3; }), HasSubstr("skin 3"));
  EXPECT_THAT(error_of([](Arm& a) { a.json["skins"][0]["joints"] = {2, 33}; }), HasSubstr("node 33"));
  EXPECT_THAT(error_of([](Arm& a) { a.json["skins"][0]["joints"] = json::array(); }), HasSubstr("joints"));
  EXPECT_THAT(error_of([](Arm& a) { a.json["skins"][0]["joints"] = {2}; }), HasSubstr("joint 1 of 1"));
  EXPECT_THAT(error_of([](Arm& a) { a.json["skins"][0]["joints"] = {2, 3, 1}; }), HasSubstr("2 for 3 joints"));
  EXPECT_THAT(error_of([](Arm& a) { a.json["scenes"][0]["nodes"] = {0}; }), HasSubstr("not in the scene"));
  Arm bare;
  bare.primitive()["attributes"].erase("JOINTS_0");
  EXPECT_THAT(load_at(bare, 0).warnings, Contains(HasSubstr("no joints")));
}

// ---- A real file ----

TEST(AnimatedAsset, TheWheelsOfTheTruckTurn) {
  const fs::path path =
      fs::path(SIDERAY_SOURCE_DIR).parent_path() / "shared/assets/CesiumMilkTruck/CesiumMilkTruck.glb";
  if (!fs::exists(path)) GTEST_SKIP() << "no test content at " << path;
  const Content start = load(path), later = load(path, {.animation = "animation0", .time_s = 0.3125});
  ASSERT_EQ(start.animations.size(), 1u);
  // 31 keys, each 11.6617 degrees on: 349.85 degrees in all.
  EXPECT_NEAR(start.animations[0].length_s, 1.25, 1e-6);
  size_t turned = 0;
  for (size_t i = 0; i < start.objects.size(); ++i) {
    const double *a = start.objects[i].world_from_object, *b = later.objects[i].world_from_object;
    EXPECT_TRUE(std::equal(a + 9, a + 12, b + 9)) << "wheels turn in place";
    double trace = 0;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) trace += a[3 * c + r] * b[3 * c + r];
    const double angle = std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)) * 180 / pi;
    if (angle > 1) {
      ++turned;
      EXPECT_NEAR(angle, 349.85 / 4, 0.01) << start.objects[i].name;
    }
  }
  EXPECT_GT(turned, 1u);
}

}  // namespace
}  // namespace sideray::scenes
