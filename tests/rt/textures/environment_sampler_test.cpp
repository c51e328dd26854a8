// The environment's sampler against its own density, and against directions that know nothing of the environment.
#include "rt/textures/environment_sampler.h"

#include <gtest/gtest.h>

#include <random>

#include "model/environment.h"
#include "model/hemisphere.h"
#include "rt/base/sampling.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr uint32_t width = 32, height = 16;

// Dim and uneven, half of it black, with one texel that outshines the rest.
std::shared_ptr<const model::Environment> uneven(float scale = 1, float rotation_deg = 0) {
  std::mt19937 random(3);
  std::vector<float> rgb;
  for (uint32_t i = 0; i < width * height; ++i)
    for (int c = 0; c < 3; ++c) rgb.push_back(i < width * height / 2 ? static_cast<float>(random() % 100) / 100 : 0.0f);
  for (int c = 0; c < 3; ++c) rgb[3 * (5 * width + 20) + static_cast<size_t>(c)] = 200.0f;
  return model::build_environment(width, height, rgb.data(), scale, rotation_deg);
}

glm::vec3 direction_at(double u, double v) {
  const double azimuth = (u - 0.5) * 2 * M_PI, polar = v * M_PI;
  return {glm::dvec3(std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth))};
}

TEST(EnvironmentSampler, TheDensityIntegratesToOne) {
  for (const float rotation : {0.0f, 37.0f}) {
    const EnvironmentSampler sampler(uneven(2, rotation));
    constexpr int columns = 8 * width, rows = 64 * height;
    double sum = 0;
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < columns; ++x) {
        const double v = (y + 0.5) / rows;
        const double solid_angle = (std::cos(M_PI * y / rows) - std::cos(M_PI * (y + 1) / rows)) * 2 * M_PI / columns;
        sum += static_cast<double>(sampler.density(direction_at((x + 0.5) / columns, v))) * solid_angle;
      }
    EXPECT_NEAR(sum, 1.0, 1e-3);
  }
}

TEST(EnvironmentSampler, SamplesFallAsTheDensitySays) {
  const EnvironmentSampler sampler(uneven());
  constexpr uint32_t samples = 1u << 18;
  std::vector<double> counts(width * height), expected(width * height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      expected[y * width + x] =
          static_cast<double>(sampler.density(direction_at((x + 0.5) / width, (y + 0.5) / height))) *
          (std::cos(M_PI * y / height) - std::cos(M_PI * (y + 1) / height)) * 2 * M_PI / width;
  for (uint32_t i = 0; i < samples; ++i) {
    const EnvironmentSampler::Sample s = sampler.sample(PointSet(random_key({11, i}))[0]);
    ASSERT_NEAR(s.density / sampler.density(s.direction), 1.0f, 1e-4f);
    const glm::dvec3 d(s.direction);
    const auto x = static_cast<uint32_t>((0.5 + std::atan2(d.x, -d.z) / (2 * M_PI)) * width) % width;
    const auto y = std::min(static_cast<uint32_t>(std::acos(d.y) / M_PI * height), height - 1);
    ++counts[y * width + x];
  }
  double statistic = 0;
  int bins = -1;
  for (size_t i = 0; i < counts.size(); ++i) {
    const double wanted = expected[i] * samples;
    if (wanted < 10) {
      EXPECT_LT(counts[i], 40) << i;
      continue;
    }
    statistic += (counts[i] - wanted) * (counts[i] - wanted) / wanted;
    ++bins;
  }
  EXPECT_GT(bins, 20);
  EXPECT_NEAR((statistic - bins) / std::sqrt(2.0 * bins), 0.0, 4.0);
}

struct Estimate {
  double mean, standard_error;
};
template <typename Sample>
Estimate estimate(uint32_t samples, const Sample& sample) {
  double sum = 0, squares = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const double x = sample(i);
    sum += x, squares += x * x;
  }
  const double mean = sum / samples;
  return {mean, std::sqrt((squares / samples - mean * mean) / samples)};
}

// Irradiance by both.
TEST(EnvironmentSampler, AgreesWithCosineSampling) {
  const auto environment = uneven(0.7f, 100);
  const EnvironmentSampler sampler(environment);
  uint32_t purpose = 20;
  for (const glm::vec3 normal : {glm::vec3(0, 1, 0), glm::normalize(glm::vec3(1, 0.2, -0.5)), glm::vec3(0, 0, 1)}) {
    ++purpose;
    const Estimate by_light = estimate(1u << 16, [&](uint32_t i) {
      const EnvironmentSampler::Sample s = sampler.sample(PointSet(random_key({purpose, 0, i}))[0]);
      const double cosine = std::max(glm::dot(normal, s.direction), 0.0f);
      return static_cast<double>(sampler.radiance(s.direction).y) * cosine / static_cast<double>(s.density);
    });
    const model::Frame frame(normal);
    const Estimate by_cosine = estimate(1u << 19, [&](uint32_t i) {
      const glm::vec3 d = frame.world(sample_cosine(PointSet(random_key({purpose, 1, i}))[0]));
      return static_cast<double>(environment_specular(*environment, d, 0.0f).y) * M_PI;
    });
    EXPECT_LT(by_light.standard_error, 0.02 * by_light.mean);
    EXPECT_NEAR(by_light.mean, by_cosine.mean, 4 * std::hypot(by_light.standard_error, by_cosine.standard_error));
  }
}

}  // namespace
}  // namespace sideray::rt
