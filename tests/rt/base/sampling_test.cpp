// Sampled distributions against their densities, by chi-square tests over independent keys.
#include "rt/base/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <set>
#include <vector>

namespace sideray::rt {
namespace {

constexpr int z_bins = 24, azimuth_bins = 24, steps_in_bin = 24;
constexpr uint32_t samples = 1u << 17;

size_t bin_of(glm::vec3 d) {
  const auto index = [](double unit, int bins) {
    return static_cast<size_t>(std::clamp(static_cast<int>(unit * bins), 0, bins - 1));
  };
  const double azimuth = std::atan2(static_cast<double>(d.y), static_cast<double>(d.x));
  return index(0.5 * static_cast<double>(d.z) + 0.5, z_bins) * azimuth_bins +
         index(azimuth / (2 * M_PI) + 0.5, azimuth_bins);
}

// Midpoint rule over each bin of equal solid angle.
std::vector<double> expected_shares(const std::function<double(glm::vec3)>& density) {
  std::vector<double> shares(size_t{z_bins} * azimuth_bins);
  constexpr int zs = z_bins * steps_in_bin, azimuths = azimuth_bins * steps_in_bin;
  for (int i = 0; i < zs; ++i)
    for (int j = 0; j < azimuths; ++j) {
      const double z = (i + 0.5) / zs * 2 - 1, azimuth = ((j + 0.5) / azimuths - 0.5) * 2 * M_PI;
      const double sine = std::sqrt(1 - z * z);
      const glm::vec3 d(glm::dvec3(sine * std::cos(azimuth), sine * std::sin(azimuth), z));
      shares[bin_of(d)] += density(d) * 4 * M_PI / (double{zs} * azimuths);
    }
  return shares;
}

// Four standard deviations of the statistic: once in about 30,000 where the sampler is right.
void expect_distribution(const std::vector<double>& expected, const std::vector<double>& counts, double drawn) {
  double statistic = 0, rest_expected = 0, rest_count = 0;
  int bins = -1;
  for (size_t i = 0; i < expected.size(); ++i) {
    const double wanted = expected[i] * drawn;
    if (wanted < 10) {  // too few for the statistic: all of them together
      rest_expected += wanted, rest_count += counts[i];
      continue;
    }
    statistic += (counts[i] - wanted) * (counts[i] - wanted) / wanted;
    ++bins;
  }
  EXPECT_GT(bins, 20);
  EXPECT_NEAR((statistic - bins) / std::sqrt(2.0 * bins), 0.0, 4.0) << bins << " bins";
  EXPECT_NEAR(rest_count, rest_expected, 4 * std::sqrt(rest_expected) + 1);
}

void check_sampler(const std::function<glm::vec3(glm::vec2)>& sample, const std::function<double(glm::vec3)>& density,
                   uint32_t purpose) {
  const std::vector<double> expected = expected_shares(density);
  std::vector<double> counts(expected.size());
  for (uint32_t i = 0; i < samples; ++i) {
    const glm::vec3 d = sample(PointSet(random_key({purpose, i}))[0]);
    ASSERT_NEAR(glm::length(d), 1.0f, 1e-5f);
    ++counts[bin_of(d)];
  }
  expect_distribution(expected, counts, samples);
}

TEST(Sampling, PointsOfDifferentKeysAreUniformAndIndependent) {
  constexpr size_t side = 32;
  std::vector<double> expected(side * side, 1.0 / (side * side)), counts(side * side), lagged(side * side);
  float last = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const glm::vec2 p = PointSet(random_key({7, i}))[0];
    ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
    const auto cell = [](float x, float y) {
      return static_cast<size_t>(y * float{side}) * side + static_cast<size_t>(x * float{side});
    };
    ++counts[cell(p.x, p.y)];
    ++lagged[cell(p.x, last)];  // one key's against the next one's
    last = p.x;
  }
  expect_distribution(expected, counts, samples);
  expect_distribution(expected, lagged, samples);
}

TEST(Sampling, APointSetIsStratifiedInEveryElementaryInterval) {
  for (uint32_t key = 0; key < 50; ++key) {
    const PointSet points(key);
    for (uint32_t first = 0; first < 256; first += 64)
      for (uint32_t log_columns = 0; log_columns <= 6; ++log_columns) {
        std::set<uint32_t> met;
        for (uint32_t i = first; i < first + 64; ++i) {
          const glm::vec2 p = points[i];
          const auto column = static_cast<uint32_t>(p.x * static_cast<float>(1u << log_columns));
          const auto row = static_cast<uint32_t>(p.y * static_cast<float>(64u >> log_columns));
          met.insert(row << log_columns | column);
        }
        EXPECT_EQ(met.size(), 64u) << key << ' ' << first << ' ' << log_columns;
      }
  }
}

TEST(Sampling, CosineHemisphere) {
  check_sampler(
      sample_cosine, [](glm::vec3 d) { return static_cast<double>(cosine_density(d.z)); }, 1);
}

TEST(Sampling, ConeIsUniform) {
  const float aperture = cone_aperture(1.2f);
  const float solid_angle = cone_solid_angle(aperture);
  EXPECT_NEAR(solid_angle, 2 * M_PI * (1 - std::cos(1.2)), 1e-5);
  // The cone's end falls inside a row of bins, whose share the midpoint rule knows to one of its steps: whole rows.
  const float whole = 1.0f - 0.5f;
  check_sampler(
      [&](glm::vec2 u) { return sample_cone(u, whole); },
      [&](glm::vec3 d) { return d.z > 1.0f - whole ? 1.0 / static_cast<double>(cone_solid_angle(whole)) : 0; }, 2);
}

// A narrow one keeps its digits: the sun's disc, 0.53 degrees across.
TEST(Sampling, TheSunsDiscHasItsSize) {
  const double angle = 0.265 * M_PI / 180;
  const float aperture = cone_aperture(static_cast<float>(angle));
  EXPECT_NEAR(static_cast<double>(cone_solid_angle(aperture)) / (2 * M_PI * (1 - std::cos(angle))), 1.0, 1e-6);
  double sum = 0;  // of sin^2, whose mean over the disc is half its largest
  const PointSet points(5);
  for (uint32_t i = 0; i < 4096; ++i) {
    const glm::vec3 d = sample_cone(points[i], aperture);
    sum += static_cast<double>(d.x) * static_cast<double>(d.x) + static_cast<double>(d.y) * static_cast<double>(d.y);
  }
  EXPECT_NEAR(sum / 4096 / (std::sin(angle) * std::sin(angle)), 0.5, 1e-3);
}

TEST(Sampling, VisibleNormalsReflectWithTheirDensity) {
  uint32_t purpose = 10;
  for (const float alpha : {0.15f, 0.5f, 1.0f})
    for (const float z : {1.0f, 0.6f, 0.1f}) {
      const glm::vec3 to_eye(std::sqrt(1 - z * z), 0, z);
      const auto reflect = [&](glm::vec2 u) {
        const glm::vec3 h = sample_visible_normal(to_eye, alpha, u);
        return glm::normalize(2.0f * glm::dot(to_eye, h) * h - to_eye);
      };
      const auto density = [&](glm::vec3 d) {
        return static_cast<double>(visible_reflection_density(to_eye, glm::normalize(to_eye + d), alpha));
      };
      SCOPED_TRACE(testing::Message() << "alpha " << alpha << " z " << z);
      check_sampler(reflect, density, purpose++);
    }
}

TEST(Sampling, ASphereIsWhereItsConeSays) {
  const double radius = 0.7, distance = 1.3;
  const float aperture = sphere_aperture(0.7f, 1.3f);
  EXPECT_NEAR(static_cast<double>(aperture), 1 - std::sqrt(1 - radius * radius / (distance * distance)), 1e-6);
  const PointSet points(3);
  for (uint32_t i = 0; i < 256; ++i) {
    const glm::dvec3 d(sample_cone(points[i], aperture));
    const double t = static_cast<double>(distance_to_sphere(0.7f, 1.3f, static_cast<float>(1 - d.z)));
    EXPECT_NEAR(glm::length(d * t - glm::dvec3(0, 0, distance)), radius, 2e-3);  // the root is steep at the rim
    EXPECT_LT(t, std::sqrt(distance * distance - radius * radius) + 1e-3);
  }
}

}  // namespace
}  // namespace sideray::rt
