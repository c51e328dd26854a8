// Tests particle systems: accepted descriptions, and the places of particles.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>

#include "scenes/builtin/builtin.h"
#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double here[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};

Particles parse(const json& description) {
  Warnings warnings;
  Particles particles = parse_particles("test", "node", description.dump(), warnings);
  EXPECT_THAT(warnings, ElementsAre());
  return particles;
}

bool same_bits(const std::vector<sideray_sprite>& a, const std::vector<sideray_sprite>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

const json everything = {{"count", 300},
                         {"lifetime", {1, 2}},
                         {"start", "cone"},
                         {"radius", 0.2},
                         {"cone_deg", 20},
                         {"velocity", {0, 1, 0}},
                         {"spread", 0.3},
                         {"acceleration", {0, -1, 0.5}},
                         {"drag", 0.5},
                         {"turbulence", 0.1},
                         {"turbulence_hz", 2},
                         {"size", {0.1, 0.3}},
                         {"size_variation", 0.5},
                         {"aspect", 2},
                         {"color", {{1, 0, 0}, {0, 1, 0}}},
                         {"alpha", {0, 1, 0}},
                         {"rotation_deg", {0, 360}},
                         {"spin_deg", {-90, 90}},
                         {"columns", 4},
                         {"rows", 2},
                         {"frames_per_second", 12},
                         {"random_frame", true},
                         {"blend", "additive"},
                         {"soft_distance", 0.25},
                         {"lit", true},
                         {"seed", 77}};

TEST(Particles, StateIsAFunctionOfTheTimeAlone) {
  const Particles particles = parse(everything);
  const std::vector<double> times = {0, 0.1, 7.3, 0.1, -2, 1000.25, 7.3, 0};
  std::vector<std::vector<sideray_sprite>> forward, backward;
  for (const double t : times) forward.push_back(sprites_at(particles, here, t));
  for (auto t = times.rbegin(); t != times.rend(); ++t) backward.push_back(sprites_at(particles, here, *t));
  std::reverse(backward.begin(), backward.end());
  for (size_t i = 0; i < times.size(); ++i) {
    EXPECT_FALSE(forward[i].empty()) << times[i];
    EXPECT_TRUE(same_bits(forward[i], backward[i])) << times[i];
  }
  EXPECT_TRUE(same_bits(forward[1], forward[3]));
  EXPECT_FALSE(same_bits(forward[0], forward[1]));
  Particles other = particles;
  other.seed = 78;
  EXPECT_FALSE(same_bits(forward[0], sprites_at(other, here, 0)));
}

// Returns the time of birth of the only particle of a system that runs once, by bisection.
double birth_of(const Particles& particles) {
  double before = 0, after = particles.lifetime.high;
  while (sprites_at(particles, here, after).empty()) after *= 0.75;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (before + after);
    (sprites_at(particles, here, middle).empty() ? before : after) = middle;
  }
  return after;
}

// The motion without and with drag against steps of x'' = a - k x' (Runge and Kutta).
TEST(Particles, BallisticMotionIsTheSolutionOfItsEquation) {
  for (const double drag : {0.0, 1e-6, 0.7, 5.0}) {
    const Particles particles = parse({{"count", 1},
                                       {"lifetime", 4},
                                       {"velocity", {1, 5, -2}},
                                       {"acceleration", {0.5, -9.81, 0}},
                                       {"drag", drag},
                                       {"loop", false}});
    const double birth = birth_of(particles);
    const glm::dvec3 acceleration(0.5, -9.81, 0);
    glm::dvec3 x(0), v(1, 5, -2);
    constexpr int steps = 2000;
    const double h = 2.0 / steps;
    const auto slope = [&](glm::dvec3 velocity) { return acceleration - drag * velocity; };
    for (int i = 0; i < steps; ++i) {
      const glm::dvec3 k1 = slope(v), k2 = slope(v + 0.5 * h * k1), k3 = slope(v + 0.5 * h * k2),
                       k4 = slope(v + h * k3);
      x += h * v + h * h / 6 * (k1 + k2 + k3);
      v += h / 6 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    const std::vector<sideray_sprite> sprites = sprites_at(particles, here, birth + 2.0);
    ASSERT_EQ(sprites.size(), 1u) << drag;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sprites[0].position[c], x[c], 1e-9) << "drag " << drag;
  }
}

TEST(Particles, ValuesOverLifeAreLinearBetweenTheirKeys) {
  const Particles particles = parse({{"count", 1},
                                     {"lifetime", 2},
                                     {"size", {1, 3, 2}},
                                     {"alpha", {0, 1}},
                                     {"color", {{0, 1, 0}, {1, 0, 0}}},
                                     {"spin_deg", 90},
                                     {"columns", 4},
                                     {"rows", 4},
                                     {"aspect", 0.5},
                                     {"loop", false}});
  const double birth = birth_of(particles);
  const sideray_sprite s = sprites_at(particles, here, birth + 0.5).at(0),
                       late = sprites_at(particles, here, birth + 1.5).at(0);
  EXPECT_FLOAT_EQ(s.width, 2.0f);
  EXPECT_FLOAT_EQ(s.height, 1.0f);
  EXPECT_FLOAT_EQ(late.width, 2.5f);
  EXPECT_FLOAT_EQ(s.color[3], 0.25f);
  EXPECT_FLOAT_EQ(late.color[0], 0.75f);
  EXPECT_NEAR(s.rotation, 0.25 * 3.14159265, 1e-5);
  EXPECT_EQ(s.cell, 4.0f);  // a quarter of the sixteen
  EXPECT_EQ(late.cell, 12.0f);
  EXPECT_TRUE(sprites_at(particles, here, birth + 2.01).empty());
}

TEST(Particles, LoopsKeepTheirNumberAndWarmUpOnRequest) {
  const json base = {{"count", 500}, {"lifetime", 2}};
  const auto with = [&](const char* key, bool value) {
    json description = base;
    description[key] = value;
    return parse(description);
  };
  for (const double t : {0.0, 0.9, 55.0}) EXPECT_EQ(sprites_at(parse(base), here, t).size(), 500u) << t;
  const Particles cold = with("prewarm", false), once = with("loop", false);
  EXPECT_TRUE(sprites_at(cold, here, 0.0).empty());
  EXPECT_NEAR(static_cast<double>(sprites_at(cold, here, 1.0).size()), 250.0, 1.0);
  EXPECT_EQ(sprites_at(cold, here, 3.0).size(), 500u);
  EXPECT_NEAR(static_cast<double>(sprites_at(once, here, 1.0).size()), 250.0, 1.0);
  EXPECT_TRUE(sprites_at(once, here, 4.1).empty());
  EXPECT_EQ(parse({{"rate", 30}, {"lifetime", {1, 4}}}).count, 120u);
}

TEST(Particles, NodesPlaceTurnAndScaleThem) {
  // A quarter turn about +Y that doubles: +X goes to -Z.
  const double node[12] = {0, 0, -2, 0, 2, 0, 2, 0, 0, 10, 20, 30};
  const Particles particles =
      parse({{"count", 1}, {"lifetime", 2}, {"velocity", {1, 0, 0}}, {"size", 1}, {"loop", false}});
  const double birth = birth_of(particles);
  const sideray_sprite s = sprites_at(particles, node, birth + 1).at(0);
  EXPECT_NEAR(s.position[0], 10, 1e-9);
  EXPECT_NEAR(s.position[1], 20, 1e-9);
  EXPECT_NEAR(s.position[2], 28, 1e-9);
  EXPECT_FLOAT_EQ(s.width, 2.0f);
}

TEST(Particles, MistakesNameFileNodeAndKey) {
  const struct {
    json description;
    const char* message;
  } cases[] = {{{{"size", 1}}, "has none of count and rate"},
               {{{"count", 1}, {"rate", 1}}, "has both of count and rate"},
               {{{"count", 0}}, "count of particles of node a is 0; give a number from 1 to 50000"},
               {{{"count", 1.5}}, "a whole number"},
               {{{"count", 1e9}}, "count of particles of node a"},
               {{{"rate", 1e6}, {"lifetime", 10}}, "give less of either"},
               {{{"count", 1}, {"lifetime", {2, 1}}}, "the smaller one first"},
               {{{"count", 1}, {"lifetime", 0}}, "lifetime of particles of node a"},
               {{{"count", 1}, {"start", "ring"}}, "give point, box, sphere, cone"},
               {{{"count", 1}, {"velocity", {1, 2}}}, "velocity of particles of node a is [1,2]; give three numbers"},
               {{{"count", 1}, {"alpha", 2}}, "alpha of particles"},
               {{{"count", 1}, {"color", "red"}}, "color of particles of node a is \"red\"; give a colour"},
               {{{"count", 1}, {"blend", "multiply"}}, "give alpha, premultiplied, additive"},
               {{{"count", 1}, {"lit", 1}}, "give true or false"},
               {{{"count", 1}, {"columns", 300}}, "columns of particles"},
               {{{"count", 1}, {"prewarm", true}, {"loop", false}}, "prewarm of particles"},
               {{{"count", 1}, {"texture", 5}}, "particles of node a uses texture 5"}};
  for (const auto& test : cases) {
    SmallGltf g;
    g.json["nodes"][0]["extras"]["sideray"]["particles"] = test.description;
    EXPECT_THAT(g.load_error(), HasSubstr(test.message));
    EXPECT_THAT(g.load_error(), HasSubstr(".gltf"));
  }
  SmallGltf g;
  g.json["nodes"][0]["extras"]["sideray"]["particles"] = {{"count", 1}, {"colour", {1, 1, 1}}};
  EXPECT_THAT(g.load().warnings, ElementsAre("node a: particles.colour is unknown and left out"));
}

TEST(Particles, AreWrittenBackWithTheirTexture) {
  const ScratchFolder folder;
  const Content made = generate("smoke", {{"count", "50"}});
  write_glb(folder / "smoke.glb", made);
  const Content read = load(folder / "smoke.glb");
  EXPECT_THAT(read.warnings, ElementsAre());
  ASSERT_EQ(made.emitters.size(), 1u);
  ASSERT_EQ(read.emitters.size(), 1u);
  EXPECT_GT(made.emitters[0].sprites.size(), 30u);
  EXPECT_TRUE(same_bits(made.emitters[0].sprites, read.emitters[0].sprites));
  const Texture &a = made.textures[made.emitters[0].texture - 1], &b = read.textures[read.emitters[0].texture - 1];
  EXPECT_EQ(a.rgba, b.rgba);
  EXPECT_EQ(a.srgb, b.srgb);
}

TEST(Particles, FollowTheTimeOfTheScene) {
  Content content = load("smoke", {.animation = "", .time_s = 1.5});
  const std::vector<sideray_sprite> at_load = content.emitters[0].sprites;
  pose(content, 0);
  EXPECT_TRUE(same_bits(content.emitters[0].sprites, generate("smoke", {}).emitters[0].sprites));
  EXPECT_FALSE(same_bits(content.emitters[0].sprites, at_load));
  pose(content, 1.5);
  EXPECT_TRUE(same_bits(content.emitters[0].sprites, at_load));
  EXPECT_THAT(info_text(content), HasSubstr("smoke: up to 4000 sprites"));
  EXPECT_EQ(json::parse(info_json(content))["particles"][0]["blend"], "alpha");
}

TEST(Particles, BistroHasSmokeAndFlames) {
  const Content content = generate("bistro", {});
  size_t sprites = 0, flames = 0, soft = 0;
  for (const Emitter& e : content.emitters) {
    sprites += e.sprites.size();
    flames += e.node.starts_with("flame") && e.particles.desc.blend_mode == SIDERAY_BLEND_ADDITIVE;
    soft += e.node.starts_with("smoke") && e.particles.desc.soft_distance > 0;
    EXPECT_NE(e.texture, 0u) << e.node;
  }
  EXPECT_THAT(content.warnings, ElementsAre());
  EXPECT_GT(sprites, 2000u);
  EXPECT_LT(sprites, 10000u);
  EXPECT_GE(flames, 6u);
  EXPECT_GE(soft, 2u);
}

}  // namespace
}  // namespace sideray::scenes
