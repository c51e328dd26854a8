// What the reference makes of one surface: lobes against their densities, albedos against the table and a quadrature.
#include "rt/reference/reference_lobes.h"

#include <gtest/gtest.h>

#include "model/snapshot.h"
#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

// A point of a surface about +Z, seen at the cosine n_v.
SurfacePoint point_seen_at(float n_v, float roughness) {
  SurfacePoint p{};
  p.surface.normal = p.surface.coat_normal = p.geometric_normal = glm::vec3(0, 0, 1);
  p.to_eye = glm::vec3(std::sqrt(1 - n_v * n_v), 0, n_v);
  p.surface.roughness = std::clamp(roughness, 0.04f, 1.0f);
  p.surface.coat_roughness = p.surface.sheen_roughness = 1.0f;
  p.surface.occlusion = p.surface.alpha = p.surface.below_sheen = 1.0f;
  return p;
}

// Directional albedo by sampling the point's lobes.
double albedo(const SurfacePoint& p, uint32_t samples = 1u << 17) {
  const LobeSampler lobes(p);
  const PointSet points(1);
  double sum = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const glm::vec3 l = lobes.sample(points[i]);
    if (l == glm::vec3(0)) continue;
    const shading::SrReflection r = shading::sr_reflection(p.surface, p.to_eye, l);
    sum += static_cast<double>((r.wide.x + r.glossy.x) / lobes.density(l));
  }
  return sum / samples;
}

// The same by the midpoint rule over the hemisphere, in angles about the normal.
double albedo_by_quadrature(const SurfacePoint& p) {
  constexpr int polars = 1024, azimuths = 1024;
  double sum = 0;
  for (int i = 0; i < polars; ++i)
    for (int j = 0; j < azimuths; ++j) {
      const double polar = (i + 0.5) / polars * M_PI / 2, azimuth = (j + 0.5) / azimuths * 2 * M_PI;
      const glm::vec3 l(
          glm::dvec3(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)));
      sum += static_cast<double>(shading::sr_reflect_light(p.surface, p.to_eye, l).x) * std::sin(polar);
    }
  return sum * (M_PI / 2 / polars) * (2 * M_PI / azimuths);
}

TEST(ReferenceLobes, DirectionalAlbedosAreThoseOfTheTable) {
  const model::AlbedoTable& table = model::albedo_table();
  constexpr uint32_t size = model::AlbedoTable::size;
  for (const uint32_t row : {6u, 12u, 32u, 63u})
    for (const uint32_t column : {2u, 8u, 20u, 63u}) {
      const float roughness = (static_cast<float>(row) + 0.5f) / size, n_v = (static_cast<float>(column) + 0.5f) / size;
      const glm::vec3 expected = table.values[row * size + column];
      SurfacePoint p = point_seen_at(n_v, roughness);
      p.surface.f0 = glm::vec3(1);
      const double scale = albedo(p);
      EXPECT_NEAR(scale, static_cast<double>(expected.x), 1e-3) << "f0, roughness " << roughness << " n.v " << n_v;
      p.surface.f90 = glm::vec3(1);
      const double both = albedo(p);
      EXPECT_NEAR(both, static_cast<double>(expected.x + expected.y), 1e-3) << roughness << ' ' << n_v;
      EXPECT_LE(both, 1.0 + 1e-4);
    }
}

TEST(ReferenceLobes, SheenIsThatOfTheTable) {
  const model::AlbedoTable& table = model::albedo_table();
  constexpr uint32_t size = model::AlbedoTable::size;
  for (const uint32_t row : {20u, 32u, 63u})
    for (const uint32_t column : {8u, 20u, 63u}) {
      const float roughness = (static_cast<float>(row) + 0.5f) / size, n_v = (static_cast<float>(column) + 0.5f) / size;
      SurfacePoint p = point_seen_at(n_v, 1.0f);
      p.surface.sheen = glm::vec3(1);
      p.surface.sheen_roughness = roughness;
      p.surface = shading::sr_seen(p.surface, p.to_eye, table.values[row * size + column].z);
      EXPECT_NEAR(albedo(p), static_cast<double>(table.values[row * size + column].z), 1e-3) << roughness << ' ' << n_v;
    }
}

// Where energy is compensated nothing is lost: white diffuse without a specular lobe. A white metal loses what
// reflects more than once between its microfacets, and just that much by either way of integrating.
TEST(ReferenceLobes, Furnace) {
  for (const float n_v : {0.1f, 0.5f, 1.0f}) {
    SurfacePoint diffuse = point_seen_at(n_v, 1.0f);
    diffuse.surface.diffuse = glm::vec3(1);
    EXPECT_NEAR(albedo(diffuse), 1.0, 1e-5);
    diffuse.surface.diffuse = diffuse.surface.behind = glm::vec3(0.5f);
    EXPECT_NEAR(albedo(diffuse), 1.0, 1e-5);
    for (const float roughness : {0.3f, 0.6f, 1.0f}) {
      SurfacePoint metal = point_seen_at(n_v, roughness);
      metal.surface.f0 = metal.surface.f90 = glm::vec3(1);
      const double sampled = albedo(metal), integrated = albedo_by_quadrature(metal);
      EXPECT_NEAR(sampled, integrated, 1e-3) << roughness << ' ' << n_v;
      testing::Test::RecordProperty("loss", std::to_string(1 - integrated));
    }
  }
}

// Under surroundings that are the same everywhere the split sum, by which pictures are lit, is the integral of the lobes.
TEST(ReferenceLobes, TheSplitSumIsTheIntegralUnderUniformSurroundings) {
  const model::AlbedoTable& table = model::albedo_table();
  constexpr uint32_t size = model::AlbedoTable::size;
  for (const uint32_t row : {12u, 32u, 63u})
    for (const uint32_t column : {4u, 20u, 40u, 63u}) {
      const float roughness = (static_cast<float>(row) + 0.5f) / size, n_v = (static_cast<float>(column) + 0.5f) / size;
      SurfacePoint p = point_seen_at(n_v, roughness);
      p.surface.diffuse = glm::vec3(0.8f), p.surface.f0 = glm::vec3(0.04f), p.surface.f90 = glm::vec3(1);
      const glm::vec3 one(1);
      const glm::vec3 lit =
          shading::sr_environment(p.surface, n_v, glm::vec2(table.values[row * size + column]), {one, one, one, one});
      EXPECT_NEAR(static_cast<double>(lit.x), albedo(p), 1e-3) << "roughness " << roughness << ", n.v " << n_v;
    }
}

// Everything at once: coat over sheen over a rough dielectric that also transmits.
TEST(ReferenceLobes, AMixtureOfAllLobesIsComplete) {
  for (const float n_v : {0.2f, 0.8f}) {
    SurfacePoint p = point_seen_at(n_v, 0.4f);
    p.surface.f0 = glm::vec3(0.04f), p.surface.f90 = glm::vec3(1);
    p.surface.diffuse = glm::vec3(0.5f);
    p.surface.sheen = glm::vec3(0.3f), p.surface.sheen_roughness = 0.6f;
    p.surface.coat = 0.7f, p.surface.coat_roughness = 0.3f;
    p.surface.coat_normal = glm::normalize(glm::vec3(0.1f, 0.1f, 1));
    p.surface = shading::sr_seen(p.surface, p.to_eye, 0.2f);
    EXPECT_NEAR(albedo(p), albedo_by_quadrature(p), 1e-3);
  }
}

// A shading normal that bends away from the eye.
TEST(ReferenceLobes, ABackFacingNormalLosesNothing) {
  SurfacePoint p = point_seen_at(0.3f, 0.5f);
  p.surface.f0 = p.surface.f90 = glm::vec3(1);
  p.to_eye.z = -p.to_eye.z;
  EXPECT_NEAR(albedo(p, 1u << 18) / albedo_by_quadrature(p), 1.0, 0.01);
}

}  // namespace
}  // namespace sideray::rt
