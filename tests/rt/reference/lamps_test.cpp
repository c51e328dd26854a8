// Tests how paths find lamps and emissive surfaces: by sampling, straight through glass, by refraction, and by
// reflection from nearby surfaces. Compares with sums over the emitters.
#include <gtest/gtest.h>

#include <random>

#include "rt/light/emitters.h"
#include "rt/reference/lamp_guide.h"
#include "rt/refraction/refraction_scene.h"

namespace sideray::rt::lamps_test {
namespace {

using namespace test;

struct Mean {
  double value = 0, deviation = 0;
};

Mean trace(TestScene& scene, const TraceView& view, uint32_t light_samples, bool caustics = false) {
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  ReferenceRequest request;
  request.views = {view};
  request.width = request.height = 8;
  request.light_samples = light_samples;
  request.bounces = 2;
  request.refraction = true;
  request.caustics = caustics;
  ReferenceImage image;
  tracer.trace_reference(request, image);
  Mean mean;
  const auto count = static_cast<double>(image.color.size());
  for (size_t i = 0; i < image.color.size(); ++i) {
    const double d = static_cast<double>(image.half_difference[i].y);
    mean.value += static_cast<double>(image.color[i].y) / count;
    mean.deviation += d * d / (count * count);
  }
  mean.deviation = std::sqrt(mean.deviation);
  return mean;
}

sideray_material_desc diffuse(float albedo) {
  sideray_material_desc m = plain_material();
  m.base_color[0] = m.base_color[1] = m.base_color[2] = albedo;
  m.specular = 0.0f;
  return m;
}

TraceView from_above(glm::dvec3 at, double height = 0.3, double half_width = 0.001) {
  return perspective(at + glm::dvec3(0, height, 0), at, 2 * std::atan(half_width / height), 1.0, 1e-4);
}

double let_through(double cosine, double absorption, double thickness) {
  const double fresnel = 0.04 + 0.96 * std::pow(1 - cosine, 5);
  return (1 - fresnel) * (1 - fresnel) * std::exp(-absorption * thickness / cosine);
}

constexpr double absorption = 1.5;  // per unit

// Adds a slab that absorbs 1 - exp(-absorption * way) of green light.
void add_slab(TestScene& scene, float low, float thickness) {
  const auto left = static_cast<float>(std::exp(-absorption));
  Triangles::box({-50, low, -50}, {50, low + thickness, 50}).add_to(scene, solid_glass(1.5f, glm::vec3(left), 1.0f));
}

// Compares straight light through parallel walls, of a point and of a small sphere, with its closed form.
TEST(Lamps, StraightLightThroughASlab) {
  constexpr float albedo = 0.02f;  // little comes back from the slab
  for (const float thickness : {0.05f, 0.2f, 0.8f})
    for (const double degrees : {0.0, 20.0, 45.0, 65.0, 80.0}) {
      SCOPED_TRACE(testing::Message() << thickness << ' ' << degrees);
      const double angle = degrees * M_PI / 180, cosine = std::cos(angle);
      const double expected = static_cast<double>(albedo) / M_PI * cosine * let_through(cosine, absorption, static_cast<double>(thickness));
      TestScene scene;
      scene.quad({0, 0, 0}, {0, 0, 400}, {400, 0, 0}, diffuse(albedo));
      add_slab(scene, 1, thickness);
      scene.lights({directional_light({static_cast<float>(std::sin(angle)), static_cast<float>(-cosine), 0}, 1.0f)});
      EXPECT_NEAR(trace(scene, from_above({0, 0, 0}), 4).value, expected, 0.02 * expected + 1e-5);
      const double distance = 20;
      sideray_light lamp = point_light({static_cast<float>(-distance * std::sin(angle)),
                                        static_cast<float>(distance * cosine), 0}, 400.0f);
      lamp.radius = 0.05f;
      scene.lights({lamp});
      if (distance * cosine > 2) {
        EXPECT_NEAR(trace(scene, from_above({0, 0, 0}), 16).value, expected, 0.03 * expected + 1e-5);
      }
    }
}

// With caustics a disc under 5 degrees is found only by refracted paths: a plate passes (1 - R) / (1 + R) of it.
TEST(Lamps, CausticsAreFoundByWhatBends) {
  constexpr float albedo = 0.05f;
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 400}, {400, 0, 0}, diffuse(albedo));
  Triangles::box({-200, 1, -200}, {200, 1.2f, 200}).add_to(scene, solid_glass(1.5f));
  sideray_light sun = directional_light({0, -1, 0}, 3.0f);
  sun.angular_diameter_deg = 4.9f;
  scene.lights({sun});
  const double whole = static_cast<double>(albedo) * 3 / M_PI;
  const Mean straight = trace(scene, from_above({0, 0, 0}), 64), bent = trace(scene, from_above({0, 0, 0}), 8192, true);
  EXPECT_NEAR(straight.value / whole, 0.96 * 0.96, 0.005);
  EXPECT_NEAR(bent.value / whole, 0.96 / 1.04, 5 * bent.deviation / whole);
  EXPECT_LT(bent.deviation, 0.1 * bent.value);
  EXPECT_GT(bent.deviation, 10 * straight.deviation);
}

struct Square {
  double half, height, aside;
};

// What a shining square, seen from the floor beside it, sends there; `along(cosine)` is what its light keeps on its way.
template <typename Along>
double irradiance(const Square& s, const Along& along) {
  constexpr int steps = 100;
  double sum = 0;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j) {
      const glm::dvec3 to(s.half * (2 * (i + 0.5) / steps - 1) - s.aside, s.height, s.half * (2 * (j + 0.5) / steps - 1));
      const double d2 = glm::dot(to, to), cosine = s.height / std::sqrt(d2);
      sum += along(cosine) * cosine * cosine / d2 * 4 * s.half * s.half / (steps * steps);
    }
  return sum;
}

TEST(Lamps, ShiningSurfacesBehindGlassAreFound) {
  constexpr Square square{0.05, 2, 0.7};
  constexpr float albedo = 0.02f, radiance = 40;
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 90}, {90, 0, 0}, diffuse(albedo));
  scene.quad({0, 2, 0}, {0, 0, 0.05f}, {0.05f, 0, 0}, glowing(glm::vec3(radiance)));
  add_slab(scene, 1, 0.2f);
  const double expected = static_cast<double>(albedo * radiance) / M_PI *
                          irradiance(square, [](double c) { return let_through(c, absorption, 0.2); });
  const Mean straight = trace(scene, from_above({0.7, 0, 0}), 64);
  EXPECT_NEAR(straight.value, expected, 5 * straight.deviation + 0.02 * expected);
  EXPECT_LT(straight.deviation, 0.02 * expected);
}

// Translucent emitters are sampled by their coverage; so are textured ones, and few among many.
TEST(Lamps, TranslucentOnesAreSampled) {
  constexpr Square square{0.05, 0.8, 0.5};
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, diffuse(0.6f));
  sideray_material_desc veil = blended({0, 0, 0}, 0.25f);
  veil.specular = 0.0f;
  for (float& e : veil.emissive) e = 40.0f;
  scene.quad({0, 0.8f, 0}, {0, 0, 0.05f}, {0.05f, 0, 0}, veil);
  for (int i = 0; i < 300; ++i)  // far away and behind the floor
    scene.quad({100, -5, static_cast<float>(i)}, {0, 0, 0.4f}, {0.4f, 0, 0}, glowing(glm::vec3(10.0f)));
  const double expected = 0.6 / M_PI * 40 * 0.25 * irradiance(square, [](double) { return 1.0; });
  const Mean mean = trace(scene, from_above({0.5, 0, 0}), 64);
  EXPECT_NEAR(mean.value, expected, 5 * mean.deviation + 0.005 * expected);
  EXPECT_LT(mean.deviation, 0.02 * expected);
}

// The tree's densities are those of its samples, and add up to one over all that a point may see.
TEST(Lamps, DensitiesAreThoseOfTheSamples) {
  TestScene scene;
  std::mt19937 random{3};
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int i = 0; i < 60; ++i) {
    sideray_material_desc m = glowing(glm::vec3(1.0f + uniform(random)));
    m.double_sided = i % 2;
    scene.quad(4.0f * glm::vec3(uniform(random), uniform(random), uniform(random)),
               0.2f * glm::vec3(uniform(random), uniform(random), 1), 0.2f * glm::vec3(1, uniform(random), uniform(random)), m);
  }
  const EmitterSampler emitters(*scene.commit());
  for (int k = 0; k < 20; ++k) {
    const LitPoint point{3.0f * glm::vec3(uniform(random), uniform(random), uniform(random)),
                         glm::normalize(glm::vec3(uniform(random), uniform(random), uniform(random))), k % 3 == 0};
    for (int i = 0; i < 200; ++i) {
      const auto u = [&] { return 0.5f + 0.4999f * uniform(random); };
      const EmitterSampler::Sample s = emitters.sample(point, u(), {u(), u()});
      if (s.density > 0.0f) {
        EXPECT_NEAR(emitters.density(point, s.hit, s.ray.direction) / s.density, 1.0f, 1e-3f);
      }
    }
  }
}

TEST(Lamps, DirectionsAroundLampsHaveTheirDensity) {
  LampGuide guide;
  const auto add = [&](glm::vec3 to, float weight) {
    ReferenceLight light{};
    light.light.type = SIDERAY_LIGHT_POINT;
    shading::SrIncidence in{};
    in.to_light = glm::normalize(to), in.irradiance = glm::vec3(weight), in.distance = glm::length(to);
    guide.add(light, in);
  };
  add({1, 2, 0}, 3.0f), add({0, 1, -4}, 1.0f);
  std::mt19937 random{5};
  std::uniform_real_distribution<float> uniform(0, 1);
  // The mean of 1 / density over the samples is the solid angle of both cones.
  double sum = 0;
  constexpr int count = 200000;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 d = guide.sample({uniform(random), uniform(random)});
    EXPECT_NEAR(glm::length(d), 1.0f, 1e-5f);
    const float density = guide.density(d);
    ASSERT_GT(density, 0.0f);
    sum += 1.0 / static_cast<double>(density) / count;
  }
  EXPECT_NEAR(sum / (2 * 2 * M_PI * (1 - std::cos(0.5))), 1.0, 0.02);
}

// A lid hides a lamp from the floor: only light reflected by a small plate right above the lamp arrives.
TEST(Lamps, WhatStandsAroundThemIsFound) {
  constexpr double half = 0.04, height = 2, above = 0.05, aside = 0.6, intensity = 5, albedo = 0.5;
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 90}, {90, 0, 0}, diffuse(static_cast<float>(albedo)));
  scene.quad({0, 2, 0}, {0, 0, 0.04f}, {0.04f, 0, 0}, diffuse(static_cast<float>(albedo)));
  // Hides the floor from the lamp alone: nothing that paths meet.
  scene.quad({0, 1.93f, 0}, {0, 0, 9}, {9, 0, 0}, glowing(glm::vec3(0.0f)), SIDERAY_VISIBLE_SHADOW);
  scene.lights({point_light({0, static_cast<float>(height - above), 0}, static_cast<float>(intensity))});
  double sum = 0;
  constexpr int steps = 200;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j) {
      const glm::dvec2 at(half * (2 * (i + 0.5) / steps - 1), half * (2 * (j + 0.5) / steps - 1));
      const double d2 = glm::dot(at, at) + above * above;
      const double radiance = albedo / M_PI * intensity * above / (d2 * std::sqrt(d2));
      const glm::dvec3 to(at.x - aside, height, at.y);
      const double e2 = glm::dot(to, to);
      sum += radiance * height * height / (e2 * e2) * 4 * half * half / (steps * steps);
    }
  const double expected = albedo / M_PI * sum;
  const Mean mean = trace(scene, from_above({aside, 0, 0}), 256);
  EXPECT_NEAR(mean.value, expected, 5 * mean.deviation + 0.005 * expected);
  EXPECT_LT(mean.deviation, 0.03 * expected);
}

}  // namespace
}  // namespace sideray::rt::lamps_test
