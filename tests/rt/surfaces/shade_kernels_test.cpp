// Compares shading in lanes with shading of single points, over materials, angles and lights; bits of the instruction
// sets with each other; and the lanes' functions with the library's in double precision.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <vector>

#include "rt/kernel_sets.h"
#include "rt/surfaces/surface_batch.h"
#include "rt/textures/environment_lookup.h"
#include "rt/tracer_scene.h"

#define SIDERAY_LANES lanes_of_the_test
#define SIDERAY_LANE_COUNT 4
#include "rt/base/lanes.h"

namespace sideray::rt {
namespace {

using namespace test;

using lanes_of_the_test::real;

float first_lane(real v) {
  return v.v[0];
}

// Largest error over many arguments, relative to `unit_of` the true value.
double largest_error(const std::function<double(float)>& truth, const std::function<real(real)>& function, float from,
                     float to, const std::function<double(double)>& unit_of) {
  double worst = 0.0;
  constexpr int steps = 400000;
  for (int i = 0; i <= steps; ++i) {
    const float x = from + (to - from) * (static_cast<float>(i) / steps);
    const double expected = truth(x);
    worst =
        std::max(worst, std::abs(static_cast<double>(first_lane(function(real(x)))) - expected) / unit_of(expected));
  }
  return worst;
}

double one(double) {
  return 1.0;
}
double ulp(double x) {
  const float f = std::abs(static_cast<float>(x));
  return static_cast<double>(std::nextafter(f, INFINITY) - f);
}

// The errors that rt/base/lanes.h states.
TEST(Lanes, transcendental_functions_are_as_near_as_stated) {
  const auto of = [](double (*f)(double)) { return [f](float x) { return f(static_cast<double>(x)); }; };
  const auto exp = [](real x) { return lanes_of_the_test::exp(x); };
  EXPECT_LT(largest_error(of(std::exp), exp, -87.0f, 88.3f, ulp), 2.0);
  EXPECT_LT(largest_error(of(std::exp), exp, -1.0f, 1.0f, ulp), 2.0);
  EXPECT_EQ(first_lane(exp(real(-1000.0f))), 0.0f);
  EXPECT_EQ(first_lane(exp(real(0.0f))), 1.0f);
  const auto log = [](real x) { return lanes_of_the_test::log(x); };
  EXPECT_LT(largest_error(of(std::log), log, 1e-7f, 0.9f, ulp), 2.0);
  EXPECT_LT(largest_error(of(std::log), log, 1.1f, 1e6f, ulp), 2.0);
  EXPECT_LT(largest_error(of(std::log), log, 0.9f, 1.1f, one), 1e-8);
  const auto acos = [](real x) { return lanes_of_the_test::acos(x); };
  EXPECT_LT(largest_error(of(std::acos), acos, -1.0f, 1.0f, one), 4e-7);
  for (const float radius : {1e-20f, 1.0f, 1e10f}) {
    const auto angle = [&](float t) {
      return std::atan2(static_cast<double>(radius * std::sin(t)), static_cast<double>(radius * std::cos(t)));
    };
    const auto mine = [&](real t) {
      const float x = first_lane(t);
      return lanes_of_the_test::sr_atan2(real(radius * std::sin(x)), real(radius * std::cos(x)));
    };
    EXPECT_LT(largest_error(angle, mine, -3.14159f, 3.14159f, one), 4e-7);
  }
  EXPECT_EQ(first_lane(lanes_of_the_test::sr_atan2(real(0.0f), real(0.0f))), 0.0f);
}

sideray_material_desc random_material(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto maybe = [&] { return unit(random) < 0.5f ? 0.0f : unit(random); };
  sideray_material_desc m = blended({unit(random), unit(random), unit(random)}, unit(random));
  m.metallic = maybe(), m.roughness = maybe(), m.transmission = maybe(), m.specular = unit(random);
  m.ior = 1.0f + unit(random);
  m.clearcoat = maybe(), m.clearcoat_roughness = maybe(), m.sheen_roughness = unit(random);
  m.diffuse_transmission = maybe();
  m.iridescence = maybe(), m.iridescence_ior = 1.0f + unit(random);
  m.anisotropy = maybe(), m.anisotropy_rotation = 6.0f * unit(random);
  m.unlit = unit(random) < 0.05f;
  for (int c = 0; c < 3; ++c) {
    m.emissive[c] = maybe(), m.specular_color[c] = unit(random), m.sheen_color[c] = maybe();
    m.diffuse_transmission_color[c] = unit(random);
  }
  return m;
}

enum class Sky { noise, uniform };

// Quads of many materials under a sky and one light of each type, hit from all sides.
struct Scenario {
  explicit Scenario(size_t count, Sky kind = Sky::noise) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    TestScene scene;
    constexpr uint32_t materials = 60;
    for (uint32_t i = 0; i < materials; ++i)
      scene.quad({unit(random), unit(random), unit(random)}, {unit(random), unit(random), 1}, {unit(random), 1, 0},
                 random_material(random));
    std::vector<sideray_light> lights{point_light({1, 2, 3}, 5.0f), directional_light({0.3f, -1, 0.2f}, 2.0f),
                                      point_light({-2, 1, 0}, 3.0f), point_light({0, -3, 1}, 4.0f)};
    lights[1].direction[1] = -1;
    lights[2].range = 4.0f;
    lights[3].type = SIDERAY_LIGHT_SPOT, lights[3].direction[1] = 1, lights[3].outer_cone = 0.6f;
    scene.lights(lights);
    std::vector<glm::vec3> sky(64 * 32);
    for (glm::vec3& t : sky) t = glm::abs(glm::vec3(unit(random), unit(random), unit(random)));
    if (kind == Sky::uniform) std::ranges::fill(sky, sky[0]);
    scene.scene.set_environment(64, 32, &sky[0].x, 1.0f, 0.0f);
    shading = std::make_unique<ShadingScene>(scene.commit());
    for (size_t i = 0; i < count; ++i) {
      Hit hit{};
      hit.instance = static_cast<uint32_t>(i % materials), hit.primitive = random() % 2;
      hit.u = 0.5f * std::abs(unit(random)), hit.v = 0.5f * std::abs(unit(random));
      hit.front = random() % 2 == 0, hit.distance = 2.0;
      const glm::vec3 front = geometric_normal(*shading->snapshot, hit), side = hit.front ? front : -front;
      Ray ray{};
      ray.direction = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)) - side);
      if (glm::dot(ray.direction, side) > 0.0f) ray.direction = glm::reflect(ray.direction, side);
      points.push_back(surface_point(*shading, hit, ray, {}));
    }
  }

  // Shades without rays: all lights are visible, and mirrors show the environment.
  std::vector<glm::vec3> batched(const char* isa) {
    SurfaceBatch batch;
    batch.begin(*shading, isa);
    std::vector<glm::vec3> radiance(points.size());
    batch.load(points);
    batch.reflect_environment();
    batch.finish(radiance.data());
    for (const shading::SrLight& light : shading->lights) {
      size_t first = 0;
      for (const LightBlock& block : batch.light(light)) {
        for (size_t i = 0; i < block_size; ++i)
          if (block.reached >> i & 1u) radiance[first + i] += vector_at(block.gain, i);
        first += block_size;
      }
    }
    return radiance;
  }

  glm::vec3 scalar(const SurfacePoint& p) const {
    const model::Environment& sky = *shading->snapshot->environment;
    const shading::SrSurface& s = p.surface;
    const auto dominant = [&](glm::vec3 n, float roughness) {
      const glm::vec3 r = glm::reflect(-p.to_eye, n);
      const glm::vec3 mirror =
          glm::normalize(r + p.geometric_normal * std::max(1e-3f - glm::dot(r, p.geometric_normal), 0.0f));
      return shading::sr_dominant(n, mirror, roughness);
    };
    const float n_v = std::abs(glm::dot(s.normal, p.to_eye));
    const glm::vec3 bent = shading::sr_bent(s, p.to_eye);
    glm::vec3 sum = shading::sr_emitted(s) +
                    shading::sr_environment(
                        s, n_v,
                        {environment_irradiance(sky, s.normal), environment_irradiance(sky, -s.normal),
                         environment_specular(sky, dominant(bent, s.roughness), s.roughness),
                         environment_specular(sky, dominant(s.coat_normal, s.coat_roughness), s.coat_roughness)});
    for (const shading::SrLight& light : shading->lights) {
      const shading::SrIncidence in = shading::sr_incidence(light, p.position);
      if (shading::sr_faces(s, in.to_light)) sum += shading::sr_reflect_light(s, p.to_eye, in.to_light) * in.irradiance;
    }
    return sum;
  }

  std::unique_ptr<ShadingScene> shading;
  std::vector<SurfacePoint> points;
};

constexpr size_t many = 20001;  // not a multiple of the block

TEST(ShadeKernels, agree_with_single_numbers) {
  Scenario scenario(many);
  const std::vector<glm::vec3> batched = scenario.batched(kernel_sets().back());
  size_t lit = 0;
  for (size_t i = 0; i < many; ++i) {
    const glm::vec3 expected = scenario.scalar(scenario.points[i]);
    // The lobe of a smooth surface is a thousand times as steep as its argument's rounding.
    const float steepness =
        1.0f / std::min(scenario.points[i].surface.roughness, scenario.points[i].surface.coat_roughness);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(batched[i][c], expected[c], 1e-5f * std::max(expected[c], 0.1f) * std::max(1.0f, 0.3f * steepness))
          << "point " << i;
    lit += expected.x > 0.1f;
  }
  EXPECT_GT(lit, many / 2);
}

TEST(ShadeKernels, give_the_same_bits_with_every_instruction_set) {
  Scenario scenario(many);
  const std::vector<glm::vec3> first = scenario.batched(kernel_sets().front());
  for (const char* isa : kernel_sets()) {
    EXPECT_EQ(std::string(shade_kernels(isa).name), std::string(isa) == "sse4.2" ? "baseline" : isa);
    const std::vector<glm::vec3> other = scenario.batched(isa);
    EXPECT_EQ(std::memcmp(first.data(), other.data(), first.size() * sizeof(glm::vec3)), 0) << isa;
  }
}

// A point's light does not depend on the other points of its batch.
TEST(ShadeKernels, give_the_same_bits_in_every_company) {
  Scenario scenario(200);
  const std::vector<glm::vec3> together = scenario.batched("avx2");
  const std::vector<SurfacePoint> all = scenario.points;
  for (const size_t first : {3u, 100u, 199u}) {
    scenario.points.assign(all.begin() + static_cast<std::ptrdiff_t>(first), all.end());
    const std::vector<glm::vec3> alone = scenario.batched("avx2");
    EXPECT_EQ(std::memcmp(alone.data(), &together[first], alone.size() * sizeof(glm::vec3)), 0) << first;
  }
}

// Kernels add lights without shadow rays in the same order as lights with shadow rays.
TEST(ShadeKernels, add_lights_as_their_gains_would_be_added) {
  Scenario scenario(many);
  for (const char* isa : kernel_sets()) {
    const std::vector<glm::vec3> expected = scenario.batched(isa);
    SurfaceBatch batch;
    batch.begin(*scenario.shading, isa);
    batch.load(scenario.points);
    batch.reflect_environment();
    std::vector<glm::vec3> radiance(many);
    batch.finish_unblocked(radiance.data());
    EXPECT_EQ(std::memcmp(radiance.data(), expected.data(), many * sizeof(glm::vec3)), 0) << isa;
  }
}

TEST(ShadeKernels, gather_shadow_rays_of_all_points_that_gain) {
  Scenario scenario(many);
  constexpr float share = 0.75f;
  for (const char* isa : kernel_sets()) {
    SurfaceBatch batch;
    batch.begin(*scenario.shading, isa);
    batch.load(scenario.points);
    ShadowRays rays;
    size_t r = 0;
    for (size_t l = 0; l < scenario.shading->lights.size(); ++l) {
      const shading::SrLight& light = scenario.shading->lights[l];
      batch.gather(l, share, rays);
      uint32_t point = 0;
      for (const LightBlock& block : batch.light(light))
        for (size_t i = 0; i < block_size; ++i, ++point) {
          if (!(block.reached >> i & 1u)) continue;
          ASSERT_LT(r, rays.size());
          const Ray ray = rays.columns()[r];
          ASSERT_EQ(rays.point(r), point);
          ASSERT_EQ(rays.gain(r), vector_at(block.gain, i));
          ASSERT_EQ(ray.origin, vector_at(block.origin, i));
          ASSERT_EQ(ray.direction, vector_at(block.direction, i));
          ASSERT_EQ(ray.t_near, 0.0f);
          ASSERT_EQ(ray.t_far, block.distance[i] * share);
          ++r;
        }
    }
    EXPECT_EQ(r, rays.size()) << isa;
    EXPECT_GT(r, many) << isa;
  }
}

class SkyLookUps : public testing::TestWithParam<Sky> {};
INSTANTIATE_TEST_SUITE_P(Skies, SkyLookUps, testing::Values(Sky::noise, Sky::uniform));

TEST_P(SkyLookUps, are_those_of_single_hits_bit_for_bit) {
  Scenario scenario(1, GetParam());
  const model::Environment& sky = *scenario.shading->snapshot->environment;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const float odd[] = {0.0f, 1.0f, 0.5f, 1e-30f, 0x1.fffffep-1f, NAN};
  std::vector<EnvironmentPlace> places;
  for (const float u : odd)
    for (const float v : odd)
      for (const float roughness : odd) places.push_back({{u, v}, roughness});
  for (int i = 0; i < 5003; ++i) places.push_back({{unit(random), unit(random)}, unit(random)});
  for (const char* isa : kernel_sets()) {
    SurfaceBatch batch;
    batch.begin(*scenario.shading, isa);
    std::vector<glm::vec3> radiance(places.size());
    batch.surroundings(places, radiance.data());
    for (size_t i = 0; i < places.size(); ++i) {
      const glm::vec3 expected = environment_specular_at(sky, places[i]);
      ASSERT_EQ(std::memcmp(&radiance[i], &expected, sizeof(expected)), 0) << isa << " place " << i;
    }
  }
}

// Broken geometry reaches the kernels as NaN and infinity; look-ups must stay within their image.
TEST(ShadeKernels, take_anything) {
  Scenario scenario(32);
  for (SurfacePoint& p : scenario.points) p.surface.normal = glm::vec3(NAN), p.to_eye = glm::vec3(INFINITY);
  for (const char* isa : kernel_sets()) EXPECT_EQ(scenario.batched(isa).size(), 32u);
}

}  // namespace
}  // namespace sideray::rt
