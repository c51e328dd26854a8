// The base's long lobe (KHR_materials_anisotropy): its closed forms, and what samples it.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "rt/base/sampling.h"
#include "rt/reference/reference_lobes.h"
#include "rt/textures/environment_lookup.h"
#include "rt/textures/surface_textures.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

using shading::SrMaterial;
using shading::SrSurface;

// A white metal about +Z whose lobe lies along `azimuth`, seen at an angle.
SurfacePoint brushed_point(float roughness, float strength, float n_v, float azimuth) {
  SrMaterial m{};
  m.base_color = glm::vec4(1), m.specular_color = glm::vec3(1);
  m.metallic = m.specular = 1, m.roughness = roughness, m.ior = 1.5f;
  m.anisotropy = strength, m.anisotropy_cosine = std::cos(azimuth), m.anisotropy_sine = std::sin(azimuth);
  SurfacePoint p{};
  const glm::vec3 up(0, 0, 1);
  p.to_eye = glm::vec3(std::sqrt(1 - n_v * n_v), 0, n_v);
  p.geometric_normal = up;
  p.surface = shading::sr_facing(shading::sr_surface(m, no_texels, up, up), p.to_eye);
  p.surface.occlusion = 1;
  p.surface = shading::sr_brushed(p.surface, m, no_texels, up, glm::vec4(1, 0, 0, 1));
  const float alike = shading::sr_round_roughness(p.surface);
  const auto terms = [&](float cosine) { return albedo_terms(model::albedo_table(), cosine, alike); };
  const glm::vec2 seen =
      shading::sr_brushed_terms(p.surface, terms(n_v), terms(shading::sr_round_cosine(p.surface, p.to_eye)));
  p.surface = shading::sr_seen(p.surface, p.to_eye, seen, 0);
  return p;
}

// Integral of f(direction) over the hemisphere by the midpoint rule.
template <typename F>
double over_hemisphere(const F& f, int polars = 800, int azimuths = 1600) {
  double sum = 0;
  for (int i = 0; i < polars; ++i)
    for (int j = 0; j < azimuths; ++j) {
      const double polar = (i + 0.5) / polars * M_PI / 2, azimuth = (j + 0.5) / azimuths * 2 * M_PI;
      const glm::dvec3 d(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
      sum += f(glm::vec3(d)) * std::sin(polar);
    }
  return sum * (M_PI / 2 / polars) * (2 * M_PI / azimuths);
}

TEST(Brushed, TheDistributionsProjectedAreaIsOne) {
  for (const glm::vec2 alpha : {glm::vec2(0.9f, 0.1f), glm::vec2(0.5f, 0.2f), glm::vec2(1.0f, 0.3f)})
    EXPECT_NEAR(over_hemisphere([&](glm::vec3 h) { return double{ggx_distribution(h, alpha)} * double{h.z}; }), 1.0,
                2e-3)
        << alpha.x << ' ' << alpha.y;
}

// D and V as the extension's text has them, in double precision.
TEST(Brushed, ReflectsWhatTheExtensionStates) {
  const PointSet points(5);
  for (const float roughness : {0.2f, 0.5f, 0.9f})
    for (const float strength : {0.25f, 0.7f, 1.0f}) {
      const SurfacePoint p = brushed_point(roughness, strength, 0.6f, 0.4f);
      const glm::dvec3 v(p.to_eye), t(std::cos(0.4), std::sin(0.4), 0), b(-std::sin(0.4), std::cos(0.4), 0);
      const double r = double{roughness}, s = double{strength}, ab = r * r, at = ab + (1 - ab) * s * s;
      for (uint32_t i = 0; i < 500; ++i) {
        const glm::vec3 light = sample_cosine(points[i]);
        const glm::dvec3 l(light), h = glm::normalize(v + l);
        const double x = glm::dot(t, h) / at, y = glm::dot(b, h) / ab, f = x * x + y * y + h.z * h.z;
        const double d = 1 / (M_PI * at * ab * f * f);
        const auto masked = [&](glm::dvec3 w) { return glm::length(glm::dvec3(at * dot(t, w), ab * dot(b, w), w.z)); };
        const double visibility = 0.5 / (l.z * masked(v) + v.z * masked(l));
        const double stated = d * visibility * l.z * double{p.surface.f0.x};
        const double ours = double{shading::sr_reflection(p.surface, p.to_eye, light).glossy.x};
        ASSERT_NEAR(ours, stated, 2e-4 * std::max(stated, 1e-3)) << roughness << ' ' << strength << ' ' << i;
      }
    }
}

TEST(Brushed, IsReciprocal) {
  const PointSet points(6);
  SurfacePoint p = brushed_point(0.4f, 0.8f, 0.7f, 1.0f);
  for (uint32_t i = 0; i < 200; ++i) {
    const glm::vec3 a = sample_cosine(points[2 * i]), b = sample_cosine(points[2 * i + 1]);
    const float there = shading::sr_reflection(p.surface, a, b).glossy.x * a.z;
    const float back = shading::sr_reflection(p.surface, b, a).glossy.x * b.z;
    ASSERT_NEAR(there, back, 1e-4f * std::max(there, 1e-3f)) << i;
  }
}

TEST(Brushed, OfNoStrengthIsTheRoundLobeToTheBit) {
  const SurfacePoint round = brushed_point(0.4f, 0.0f, 0.7f, 1.0f);
  EXPECT_EQ(round.surface.along, glm::vec3(0));
  EXPECT_EQ(shading::sr_alphas(round.surface), glm::vec2(0.4f * 0.4f));
  EXPECT_EQ(shading::sr_round_roughness(round.surface), 0.4f);
  EXPECT_EQ(shading::sr_bent(round.surface, round.to_eye), round.surface.normal);
  // As strength goes to 0, so does the difference.
  const SurfacePoint nearly = brushed_point(0.4f, 1e-3f, 0.7f, 1.0f);
  const PointSet points(7);
  for (uint32_t i = 0; i < 200; ++i) {
    const glm::vec3 l = sample_cosine(points[i]);
    const float a = shading::sr_reflect_light(round.surface, round.to_eye, l).x,
                b = shading::sr_reflect_light(nearly.surface, nearly.to_eye, l).x;
    ASSERT_NEAR(a, b, 1e-4f * std::max(a, 1e-3f));
  }
}

// A quarter turn of the direction is a quarter turn of the lobe.
TEST(Brushed, TurnsWithItsDirection) {
  const SurfacePoint p = brushed_point(0.3f, 0.9f, 1.0f, 0.0f),
                     turned = brushed_point(0.3f, 0.9f, 1.0f, glm::half_pi<float>());
  const PointSet points(8);
  for (uint32_t i = 0; i < 200; ++i) {
    const glm::vec3 l = sample_cosine(points[i]), quarter(-l.y, l.x, l.z);
    const float a = shading::sr_reflect_light(p.surface, p.to_eye, l).x,
                b = shading::sr_reflect_light(turned.surface, p.to_eye, quarter).x;
    ASSERT_NEAR(a, b, 1e-3f * std::max(a, 1e-3f));
  }
  const glm::vec3 along = glm::normalize(glm::vec3(1, 0, 1)), across = glm::normalize(glm::vec3(0, 1, 1));
  EXPECT_GT(shading::sr_reflect_light(p.surface, p.to_eye, along).x,
            10 * shading::sr_reflect_light(p.surface, p.to_eye, across).x);
}

// Sampling and density are one, and the weights of samples add up to what quadrature finds.
TEST(Brushed, IsSampledWithItsDensity) {
  const PointSet points(9);
  for (const float n_v : {1.0f, 0.6f, 0.2f})
    for (const float azimuth : {0.0f, 0.7f, 1.5f}) {
      const SurfacePoint p = brushed_point(0.45f, 0.8f, n_v, azimuth);
      const LobeSampler lobes(p);
      constexpr uint32_t samples = 1u << 16;
      constexpr int bins = 8;
      double counted[bins] = {}, weights = 0;
      const auto bin_of = [](glm::vec3 l) {
        return (l.x > 0 ? 1 : 0) + (l.y > 0 ? 2 : 0) + (std::abs(l.x) > std::abs(l.y) ? 4 : 0);
      };
      for (uint32_t i = 0; i < samples; ++i) {
        const glm::vec3 l = lobes.sample(points[i]);
        if (l == glm::vec3(0)) continue;
        counted[bin_of(l)] += 1.0 / samples;
        weights += double{shading::sr_reflect_light(p.surface, p.to_eye, l).x / lobes.density(l)} / samples;
      }
      for (int bin = 0; bin < bins; ++bin)
        EXPECT_NEAR(
            counted[bin],
            over_hemisphere([&](glm::vec3 l) { return bin_of(l) == bin ? double{lobes.density(l)} : 0.0; }, 300, 600),
            4e-3)
            << "n.v " << n_v << " azimuth " << azimuth << " bin " << bin;
      const double albedo =
          over_hemisphere([&](glm::vec3 l) { return double{shading::sr_reflect_light(p.surface, p.to_eye, l).x}; });
      EXPECT_NEAR(weights, albedo, 4e-3) << n_v << ' ' << azimuth;
    }
}

// White metals lose no more, and gain no more, than the albedo of the round lobe that stands for theirs is off.
TEST(Brushed, Furnace) {
  double worst = 0;
  for (const float roughness : {0.05f, 0.2f, 0.4f, 0.7f, 1.0f})
    for (const float strength : {0.3f, 0.5f, 0.8f, 1.0f})
      for (const float n_v : {0.15f, 0.5f, 0.9f})
        for (const float azimuth : {0.0f, 0.8f, 1.5f}) {
          const SurfacePoint p = brushed_point(roughness, strength, n_v, azimuth);
          const LobeSampler lobes(p);
          const PointSet points(3);
          double sum = 0;
          for (uint32_t i = 0; i < 1u << 14; ++i) {
            const glm::vec3 l = lobes.sample(points[i]);
            if (l == glm::vec3(0)) continue;
            sum += double{shading::sr_reflect_light(p.surface, p.to_eye, l).x / lobes.density(l)} / (1u << 14);
          }
          worst = std::max(worst, std::abs(sum - 1));
          EXPECT_NEAR(sum, 1.0, 0.08) << roughness << ' ' << strength << ' ' << n_v << ' ' << azimuth;
        }
  std::cout << "  worst loss or gain " << worst << "\n";
}

TEST(Brushed, IsRoundWhereThereIsNoFrame) {
  const SurfacePoint p = brushed_point(0.4f, 0.8f, 0.7f, 0.0f);
  SrMaterial m{};
  m.anisotropy = 0.8f, m.anisotropy_cosine = 1;
  const glm::vec3 up(0, 0, 1);
  for (const glm::vec4 tangent : {glm::vec4(0), glm::vec4(0, 0, 1, 1)})
    EXPECT_EQ(shading::sr_brushed(p.surface, m, no_texels, up, tangent).anisotropy, 0.0f);
}

}  // namespace
}  // namespace sideray::rt
