// Compares light that passes straight through translucent surfaces with closed forms.
#include "rt/light/straight_light.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>

#include "rt/kernel_sets.h"
#include "rt/refraction/refraction_scene.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt::straight_light_test {
namespace {

using namespace test;

constexpr double angles[] = {0, 30, 50, 70, 85};
constexpr double thicknesses[] = {0.05, 0.4, 1.5};
const glm::vec3 colour(0.9f, 0.2f, 0.1f);
constexpr float attenuation_distance = 0.3f;

glm::dvec3 kept(double length) {
  glm::dvec3 left;
  for (int c = 0; c < 3; ++c) left[c] = std::pow(static_cast<double>(colour[c]), length / static_cast<double>(attenuation_distance));
  return left;
}

sideray_material_desc coloured_glass() {
  sideray_material_desc m = solid_glass(1.5f, colour, attenuation_distance);
  m.roughness = 0.0f;
  return m;
}

// A slab across z = 0, from -thickness to 0.
void add_slab(TestScene& scene, double thickness, const sideray_material_desc& material, float half = 50.0f) {
  const auto low = static_cast<float>(-thickness);
  Triangles::box({-half, -half, low}, {half, half, 0.0f}).add_to(scene, material);
}

// A ray in the plane y = 0.1 that arrives at the origin of x and z at the angle to z, from below.
Ray upward(double degrees, float before = 3.0f, float length = 1e30f) {
  const double a = glm::radians(degrees);
  const glm::vec3 direction(glm::dvec3(std::sin(a), 0, std::cos(a)));
  return {glm::vec3(0.013f, 0.1f, 0.0f) - direction * before, 0.0f, direction, length};
}

struct Lit {
  explicit Lit(TestScene& built, const char* isa = "") : scene({.threads = 1, .isa = isa}) {
    scene.set_scene(built.commit());
    light.begin(scene.shading(), scene.intersector());
  }
  glm::vec3 through(const Ray& ray) {
    light.follow({&ray, 1});
    return light.through(0);
  }
  TracedScene scene;
  StraightLight light;
};

void expect_light(glm::vec3 value, glm::dvec3 expected, const std::string& what) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(static_cast<double>(value[c]), expected[c], 4e-4) << what << " channel " << c;
}

TEST(StraightLight, SlabsKeepWhatFresnelAndBeerSay) {
  for (const double thickness : thicknesses)
    for (const double angle : angles) {
      TestScene scene;
      add_slab(scene, thickness, coloured_glass());
      const double cosine = std::cos(glm::radians(angle)), passed = 1 - schlick(cosine, 1.5);
      const glm::dvec3 expected = passed * passed * kept(thickness / cosine);
      const glm::dvec3 seen = std::max({expected.x, expected.y, expected.z}) > 1e-4 ? expected : glm::dvec3(0.0);
      Lit lit(scene);
      expect_light(lit.through(upward(angle, 200.0f)), seen, fmt::format("{} at {}", thickness, angle));
    }
}

TEST(StraightLight, ToALampInTheGlassCountsTheWayInIt) {
  TestScene scene;
  add_slab(scene, 2.0, coloured_glass());
  Lit lit(scene);
  // The ray begins 3 below z = 0, so 1 below the slab, and ends 1.5 further on, half of a unit inside.
  expect_light(lit.through(upward(0, 3.0f, 1.5f)), 0.96 * kept(0.5), "lamp inside");
}

// The wall's reflection of the lamp's light leaves on the other side, but only if the lamp is inside the solid, not in
// front of it or behind it.
TEST(StraightLight, FrostedSolidsScatterTheLampInside) {
  sideray_material_desc frosted = solid_glass(1.5f);
  frosted.roughness = 0.0f;
  frosted.transmission = 0.4f;
  frosted.base_color[1] = 0.5f;
  TestScene scene;
  add_slab(scene, 2.0, frosted);
  Lit lit(scene);
  const glm::dvec3 base(1.0, 0.5, 1.0), passed = 0.96 * 0.4 * base, scattered = 0.96 * 0.6 * base;
  expect_light(lit.through(upward(0, 3.0f, 0.5f)), glm::dvec3(1.0), "lamp in front");
  expect_light(lit.through(upward(0, 3.0f, 1.5f)), passed * (1.0 + scattered), "lamp inside");
  expect_light(lit.through(upward(0, 3.0f, 9.0f)), passed * passed, "lamp behind");
  expect_light(lit.through(upward(0, 3.0f)), passed * passed, "sky");
  expect_light(lit.through(upward(0, 1.0f, 0.5f)), glm::dvec3(1.0), "both inside");
}

// All light of a lamp in a closed shell leaves but for what the walls absorb.
TEST(StraightLight, FrostedShellsScatterTheLampInside) {
  sideray_material_desc frosted = glass();
  frosted.roughness = frosted.thickness = 0.0f;
  frosted.transmission = 0.4f;
  frosted.base_color[1] = 0.5f;
  for (const bool two_sided : {true, false}) {
    frosted.double_sided = two_sided ? 1 : 0;
    TestScene scene;
    add_slab(scene, 2.0, frosted);
    Lit lit(scene);
    const glm::dvec3 base(1.0, 0.5, 1.0), passed = 0.96 * 0.4 * base, kept_inside = 0.96 * 0.6 * base;
    const glm::dvec3 out = passed / (1.0 - kept_inside);
    EXPECT_NEAR(out.x, 0.384 / (0.384 + 0.04), 1e-9) << "Fresnel's term is the only loss of white walls";
    expect_light(lit.through(upward(0, 3.0f, 1.5f)), two_sided ? out : passed, "lamp inside");
    expect_light(lit.through(upward(0, 3.0f, 9.0f)), passed * passed, "lamp behind");
  }
}

// Another solid that the ray enters and leaves before a lamp takes nothing of the frosted solid's scattering.
TEST(StraightLight, FrostedSolidsScatterAroundAnotherInside) {
  sideray_material_desc frosted = solid_glass(1.0f), marble = solid_glass(1.0f);
  frosted.roughness = marble.roughness = 0.0f;
  frosted.transmission = 0.4f;
  TestScene with, without;
  for (TestScene* scene : {&with, &without}) add_slab(*scene, 2.0, frosted);
  Triangles::box({-9, -9, -1.5f}, {9, 9, -1}).add_to(with, marble);
  Lit lit_with(with), lit_without(without);
  const Ray to_lamp = upward(0, 3.0f, 2.5f);
  const glm::vec3 alone = lit_without.through(to_lamp);
  EXPECT_GT(alone.x, 0.41f);
  expect_light(lit_with.through(to_lamp), alone, "past a marble");
}

TEST(StraightLight, RaysThatBeginInGlassLeaveOneFace) {
  TestScene scene;
  add_slab(scene, 2.0, coloured_glass());
  Lit lit(scene);
  for (const double angle : {0.0, 40.0, 60.0}) {
    const double cosine = std::cos(glm::radians(angle));
    expect_light(lit.through(upward(angle, 0.5f)), (1 - schlick(cosine, 1.5)) * kept(0.5),
                 fmt::format("from inside at {}", angle));
  }
}

TEST(StraightLight, GrazingLightFadesAndIsANumber) {
  TestScene scene;
  add_slab(scene, 1e-4, solid_glass(1.5f), 5000.0f);
  Lit lit(scene);
  float last = 1.0f;
  for (const double angle : {80.0, 85.0, 88.0, 89.0, 89.5, 89.9, 89.99}) {
    const glm::vec3 through = lit.through(upward(angle, 3.0f));
    EXPECT_TRUE(through.x >= 0.0f && through.x <= last) << angle << ' ' << through.x;
    last = through.x;
  }
  EXPECT_LT(last, 0.01f);
}

TEST(StraightLight, ThinWallsTakeTheirFresnelTermAndTint) {
  TestScene scene;
  sideray_material_desc m = glass();
  m.roughness = 0.0f;
  m.thickness = 0.0f;
  for (int c = 0; c < 3; ++c) m.base_color[c] = colour[c];
  scene.quad({0, 0, 0}, {50, 0, 0}, {0, 50, 0}, m);
  Lit lit(scene);
  for (const double angle : angles) {
    const double passed = 1 - schlick(std::cos(glm::radians(angle)), 1.5);
    expect_light(lit.through(upward(angle)), passed * glm::dvec3(colour), fmt::format("thin wall at {}", angle));
  }
}

TEST(StraightLight, BlendedSurfacesTakeTheirCover) {
  for (const float alpha : {0.25f, 0.5f, 1.0f})
    for (const bool from_behind : {false, true}) {
      TestScene scene;
      sideray_material_desc m = model::default_material();
      m.alpha_mode = SIDERAY_BLEND;
      m.base_color[3] = alpha;
      scene.quad({0, 0, 0}, {from_behind ? -50.0f : 50.0f, 0, 0}, {0, 50, 0}, m);
      Lit lit(scene);
      expect_light(lit.through(upward(30)), glm::dvec3(1.0 - static_cast<double>(alpha)), "blended");
    }
}

// With a texture in every slot, those of diffuse transmission and of emission do not change straight light.
TEST(StraightLight, TexturesTintIt) {
  const uint8_t texel[] = {255, 0, 255, 255}, black[] = {0, 0, 0, 255};
  for (const bool base : {false, true}) {
    TestScene scene;
    sideray_material_desc m = glass();
    m.thickness = 0.0f;
    m.occlusion_texture.texture = m.emissive_texture.texture = scene.scene.add_texture(1, 1, SIDERAY_RGBA8, black);
    for (float& c : m.emissive) c = 1.0f;
    if (base) m.base_color_texture.texture = scene.scene.add_texture(1, 1, SIDERAY_RGBA8, texel);
    scene.quad({0, 0, 0}, {50, 0, 0}, {0, 50, 0}, m);
    Lit lit(scene);
    const double passed = 1 - schlick(std::cos(glm::radians(30.0)), 1.5);
    expect_light(lit.through(upward(30)), glm::dvec3(passed, base ? 0.0 : passed, passed), base ? "base" : "others");
  }
}

TEST(StraightLight, ColoursOfVerticesTintIt) {
  const float positions[][3] = {{-50, -50, 0}, {50, -50, 0}, {0, 90, 0}};
  const float colours[][4] = {{1, 0, 1, 1}, {1, 0, 1, 1}, {1, 0, 1, 1}};
  TestScene scene;
  sideray_mesh_desc mesh{};
  mesh.size = sizeof(mesh);
  mesh.vertex_count = 3;
  mesh.positions = {positions[0], 0};
  mesh.colors = {colours[0], 0};
  sideray_instance_desc instance{};
  instance.mesh = scene.scene.add_mesh(mesh, nullptr);
  sideray_material_desc m = glass();
  m.thickness = 0.0f;
  instance.material = scene.scene.add_material(m);
  for (int c = 0; c < 3; ++c) instance.world_from_object[4 * c] = 1.0;
  instance.surface_id = 1;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.scene.add_instances(&instance, 1);
  Lit lit(scene);
  const double passed = 1 - schlick(std::cos(glm::radians(30.0)), 1.5);
  expect_light(lit.through(upward(30)), glm::dvec3(passed, 0.0, passed), "magenta");
}

TEST(StraightLight, ManyPanesMultiply) {
  TestScene scene;
  sideray_material_desc m = model::default_material();
  m.alpha_mode = SIDERAY_BLEND;
  m.base_color[3] = 0.1f;
  for (int i = 0; i < 20; ++i) scene.quad({0, 0, 0.05f * static_cast<float>(i)}, {50, 0, 0}, {0, 50, 0}, m);
  Lit lit(scene);
  const Ray ray = upward(20);
  expect_light(lit.through(ray), glm::dvec3(std::pow(0.9, 20)), "panes");
  EXPECT_NEAR(lit.light.distance(0), 3.0f, 1e-4f) << "of the nearest";
}

// A marble in water, the ray from below it and from inside: each interface by the two indices, each medium by its length.
TEST(StraightLight, NestedLiquidsCountOnce) {
  TestScene scene;
  sideray_material_desc water = solid_glass(1.33f, {0.3f, 0.7f, 0.9f}, 1.0f), marble = solid_glass(1.5f, colour, 0.3f);
  water.roughness = marble.roughness = 0.0f;
  Triangles::box({-50, -50, -2}, {50, 50, 0}).add_to(scene, water);
  Triangles::box({-9, -9, -1.25f}, {9, 9, -1}).add_to(scene, marble);
  Lit lit(scene);
  for (const double angle : {0.0, 30.0, 60.0}) {
    const double cosine = std::cos(glm::radians(angle));
    const double between = 1 - static_cast<double>(dielectric_reflectance(static_cast<float>(cosine), 1.33f, 1.5f));
    const double top = 1 - schlick(cosine, 1.33);
    glm::dvec3 in_water;
    for (int c = 0; c < 3; ++c)
      in_water[c] = std::pow(static_cast<double>(water.attenuation_color[c]), 1.75 / cosine);
    const glm::dvec3 below = top * top * between * between * in_water * kept(0.25 / cosine);
    expect_light(lit.through(upward(angle, 10.0f)), below, fmt::format("from below at {}", angle));
    // The floor of the water: it has no face below.
    const Ray floor = upward(angle, static_cast<float>(1.999999 / cosine));
    expect_light(lit.through(floor), below / top, fmt::format("from the floor at {}", angle));
    const Ray inside = upward(angle, static_cast<float>(1.125 / cosine));
    glm::dvec3 above;
    for (int c = 0; c < 3; ++c) above[c] = std::pow(static_cast<double>(water.attenuation_color[c]), 1.0 / cosine);
    expect_light(lit.through(inside), top * between * above * kept(0.125 / cosine),
                 fmt::format("from the marble at {}", angle));
  }
}

// Liquid that touches its glass: no air between them, whichever of the two faces is found first.
TEST(StraightLight, LiquidTouchesItsGlass) {
  for (const bool liquid_first : {false, true}) {
    TestScene scene;
    sideray_material_desc water = solid_glass(1.33f), wall = solid_glass(1.5f);
    water.roughness = wall.roughness = 0.0f;
    const auto add_water = [&] { Triangles::box({-50, -50, -1}, {50, 50, 0}).add_to(scene, water); };
    if (liquid_first) add_water();
    Triangles::box({-50, -50, -2}, {50, 50, -1}).add_to(scene, wall);
    if (!liquid_first) add_water();
    Lit lit(scene);
    const double between = 1 - static_cast<double>(dielectric_reflectance(1.0f, 1.33f, 1.5f));
    const double expected = (1 - schlick(1.0, 1.5)) * between * (1 - schlick(1.0, 1.33));
    expect_light(lit.through(upward(0, 10.0f)), glm::dvec3(expected), "touching");
  }
}

TEST(StraightLight, WhatGlowsAddsOrCastsNoShadowTakesNothing) {
  for (int kind = 0; kind < 3; ++kind) {
    TestScene scene;
    sideray_material_desc m = model::default_material();
    m.alpha_mode = SIDERAY_BLEND;
    m.base_color[3] = 0.5f;
    if (kind == 0) m.unlit = 1;
    if (kind == 1) m.blend_mode = SIDERAY_BLEND_ADDITIVE;
    scene.quad({0, 0, 0}, {50, 0, 0}, {0, 50, 0}, m,
               kind == 2 ? SIDERAY_VISIBLE_ALL & ~SIDERAY_VISIBLE_SHADOW : SIDERAY_VISIBLE_ALL);
    Lit lit(scene);
    EXPECT_FALSE(lit.light.is_tinted()) << kind;
  }
}

TEST(StraightLight, HasTheSameBitsForEveryInstructionSet) {
  std::vector<std::vector<glm::vec3>> all;
  for (const char* isa : kernel_sets()) {
    TestScene scene;
    add_slab(scene, 0.4, coloured_glass());
    sideray_material_desc m = glass();
    m.roughness = 0.3f;
    scene.quad({0, 0, 1}, {50, 0, 3}, {0, 50, 1}, m);
    Lit lit(scene, isa);
    std::vector<Ray> rays;
    for (int i = 0; i < 500; ++i) rays.push_back(upward(0.17 * i, 1.0f + 0.01f * static_cast<float>(i)));
    lit.light.follow(rays);
    std::vector<glm::vec3>& through = all.emplace_back();
    for (size_t i = 0; i < rays.size(); ++i) through.push_back(lit.light.through(i));
    EXPECT_EQ(all.front(), through) << isa;
  }
}

}  // namespace
}  // namespace sideray::rt::straight_light_test
