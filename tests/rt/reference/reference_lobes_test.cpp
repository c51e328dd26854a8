// Tests the reference on one surface: lobes against their densities, albedos against the table and a quadrature, and
// furnaces, in which white surfaces are invisible.
#include "rt/reference/reference_lobes.h"

#include <gtest/gtest.h>

#include "model/snapshot.h"
#include "rt/base/sampling.h"
#include "rt/textures/environment_lookup.h"
#include "rt/tracer_scene.h"

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
  p.surface.albedo_terms = albedo_terms(model::albedo_table(), n_v, p.surface.roughness);
  return p;
}

// The same surface as pictures have it.
SurfacePoint as_seen(SurfacePoint p) {
  p.surface = shading::sr_seen(p.surface, p.to_eye, p.surface.albedo_terms, 0.0f);
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
      const float roughness = static_cast<float>(row) / (size - 1), n_v = static_cast<float>(column) / (size - 1);
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
      const float roughness = static_cast<float>(row) / (size - 1), n_v = static_cast<float>(column) / (size - 1);
      SurfacePoint p = point_seen_at(n_v, 1.0f);
      p.surface.sheen = glm::vec3(1);
      p.surface.sheen_roughness = roughness;
      p.surface = shading::sr_seen(p.surface, p.to_eye, p.surface.albedo_terms, table.values[row * size + column].z);
      EXPECT_NEAR(albedo(p), static_cast<double>(table.values[row * size + column].z), 1e-3) << roughness << ' ' << n_v;
    }
}

// White surfaces lose nothing at any roughness: multiple scattering of rough metals is included. The bound is the
// table's interpolation error.
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
      metal = as_seen(metal);
      EXPECT_NEAR(albedo(metal), 1.0, 2e-3) << roughness << ' ' << n_v;
      EXPECT_NEAR(albedo_by_quadrature(metal), 1.0, 2e-3) << roughness << ' ' << n_v;
      const glm::vec3 one(1), lit = shading::sr_environment(metal.surface, n_v, {one, one, one, one});
      EXPECT_NEAR(lit.x, 1.0f, 1e-6f) << roughness << ' ' << n_v;
    }
  }
}

// Rough clear glass reflects or lets through all that arrives. A smooth one, whose transmittance is Fresnel's at the
// angle itself, does so to within what the table knows of that.
TEST(ReferenceLobes, GlassLosesNothing) {
  for (const float n_v : {0.05f, 0.1f, 0.5f, 1.0f})
    for (const float roughness : {0.0f, 0.04f, 0.05f, 0.3f, 0.6f, 1.0f}) {
      SurfacePoint glass = point_seen_at(n_v, roughness);
      glass.surface.f0 = glm::vec3(0.04f), glass.surface.f90 = glass.surface.tint = glm::vec3(1);
      glass = as_seen(glass);
      const double through = static_cast<double>(shading::sr_transmittance(glass.surface, glass.to_eye).x);
      const double tolerance = roughness > 0.04f ? 1e-3 : 4e-3;
      EXPECT_NEAR(through + albedo(glass), 1.0, tolerance) << "roughness " << roughness << ", n.v " << n_v;
    }
}

// Under surroundings that are the same everywhere the split sum, by which pictures are lit, is the integral of the lobes.
TEST(ReferenceLobes, TheSplitSumIsTheIntegralUnderUniformSurroundings) {
  constexpr uint32_t size = model::AlbedoTable::size;
  for (const uint32_t row : {12u, 32u, 63u})
    for (const uint32_t column : {4u, 20u, 40u, 63u}) {
      const float roughness = static_cast<float>(row) / (size - 1), n_v = static_cast<float>(column) / (size - 1);
      SurfacePoint p = point_seen_at(n_v, roughness);
      p.surface.diffuse = glm::vec3(0.8f), p.surface.f0 = glm::vec3(0.04f), p.surface.f90 = glm::vec3(1);
      const glm::vec3 one(1);
      p = as_seen(p);
      const glm::vec3 lit = shading::sr_environment(p.surface, n_v, {one, one, one, one});
      EXPECT_NEAR(static_cast<double>(lit.x), albedo(p), 1e-3) << "roughness " << roughness << ", n.v " << n_v;
    }
}

// A surface about `normal` that reflects alone, seen at the cosine n_v.
SurfacePoint glossy_point(glm::vec3 normal, float n_v, float roughness) {
  SurfacePoint p = point_seen_at(n_v, roughness);
  const model::Frame frame(normal);
  p.to_eye = frame.world(p.to_eye);
  p.surface.normal = p.surface.coat_normal = p.geometric_normal = normal;
  p.surface.f0 = p.surface.f90 = glm::vec3(1);
  return p;
}

// What the lobe reflects of the environment, over what it reflects of a white one.
float seen_by_lobe(const SurfacePoint& p, const model::Environment& environment) {
  const LobeSampler lobes(p);
  const PointSet points(1);
  float sum = 0, weights = 0;
  for (uint32_t i = 0; i < 2048; ++i) {
    const glm::vec3 l = lobes.sample(points[i]);
    if (l == glm::vec3(0)) continue;
    const float weight = shading::sr_reflection(p.surface, p.to_eye, l).glossy.x / lobes.density(l);
    sum += weight * environment_specular(environment, l, 0.0f).x;
    weights += weight;
  }
  return sum / weights;
}

// Prefiltered radiance is looked up where a rough lobe is brightest, which lies between the mirror direction and the
// normal.
TEST(ReferenceLobes, RoughLobesAreLookedUpAtTheirDominantDirection) {
  test::TestScene scene;
  std::vector<glm::vec3> sky(64 * 32, glm::vec3(0.1f));
  for (uint32_t row = 4; row < 12; ++row)
    for (uint32_t column = 10; column < 26; ++column) sky[row * 64 + column] = glm::vec3(4.0f);
  scene.scene.set_environment(64, 32, &sky[0].x, 1.0f, 0.0f);
  const std::shared_ptr<const model::Snapshot> snapshot = scene.commit();
  double of_mirror = 0, of_dominant = 0;
  for (const float roughness : {0.4f, 0.6f, 0.8f})
    for (const float n_v : {0.2f, 0.5f, 0.8f})
      for (uint32_t i = 0; i < 16; ++i) {
        const float z = 1.0f - (static_cast<float>(i) + 0.5f) / 8.0f, azimuth = 2.4f * static_cast<float>(i);
        const float r = std::sqrt(1 - z * z);
        const SurfacePoint p = glossy_point({r * std::cos(azimuth), z, r * std::sin(azimuth)}, n_v, roughness);
        const glm::vec3 normal = p.surface.normal, mirror = glm::reflect(-p.to_eye, normal);
        const float truth = seen_by_lobe(p, *snapshot->environment);
        const auto square = [&](glm::vec3 direction) {
          const double off = double{environment_specular(*snapshot->environment, direction, roughness).x - truth};
          return off * off;
        };
        of_mirror += square(mirror);
        of_dominant += square(shading::sr_dominant(normal, mirror, roughness));
      }
  EXPECT_LT(of_dominant, 0.5 * of_mirror);
}

TEST(ReferenceLobes, TheDominantDirectionOfAMirrorIsItsOwn) {
  const glm::vec3 normal(0, 0, 1), mirror = glm::normalize(glm::vec3(1, 0, 1));
  EXPECT_GT(glm::dot(shading::sr_dominant(normal, mirror, 0.04f), mirror), 1.0f - 1e-6f);
  EXPECT_GT(glm::dot(shading::sr_dominant(normal, mirror, 1.0f), normal), 1.0f - 1e-6f);
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
    p.surface = shading::sr_seen(p.surface, p.to_eye, p.surface.albedo_terms, 0.2f);
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
