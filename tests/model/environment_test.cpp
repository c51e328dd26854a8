#include "model/environment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shaders/shading/shading_cpp.h"

namespace sideray::model {
namespace {

TEST(Environment, ConstantRadianceStaysConstantInEveryImage) {
  std::vector<float> rgb(64 * 32 * 3, 2.5f);
  rgb[100] = 2.500001f;  // what is exactly constant is not filtered
  const auto environment = build_environment(64, 32, rgb.data(), 2.0f, 0.0f);
  ASSERT_GT(environment->specular.size(), 1u);
  EXPECT_FALSE(environment->uniform);
  for (const auto& level : environment->specular)
    for (const glm::vec3& texel : level.texels) EXPECT_NEAR(texel.x, 5.0f, 1e-4f);
  for (const glm::vec3& texel : environment->irradiance.texels) EXPECT_NEAR(texel.y, 5.0f, 1e-4f);
}

TEST(Environment, UniformSurroundingsAreWhatTheyAreFromEverywhere) {
  const std::vector<float> rgb(64 * 32 * 3, 0.7f);
  const auto environment = build_environment(64, 32, rgb.data(), 1.0f, 30.0f);
  EXPECT_TRUE(environment->uniform);
  EXPECT_EQ(environment->irradiance.texels.at(0), glm::vec3(0.7f));
  EXPECT_EQ(environment->specular.size(), 1u);
  EXPECT_FLOAT_EQ(environment->mean, 0.7f);
}

// Radiance = max(0, dot(direction, z))... of a clamped-cosine sky about +Y: E / pi at the pole is 2/3.
TEST(Environment, IrradianceOfACosineSkyMatchesTheIntegral) {
  constexpr uint32_t width = 128, height = 64;
  std::vector<float> rgb(width * height * 3);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t i = 0; i < width * 3; ++i)
      rgb[y * width * 3 + i] = std::max(0.0f, std::cos((static_cast<float>(y) + 0.5f) / height * 3.14159265f));
  const auto environment = build_environment(width, height, rgb.data(), 1.0f, 0.0f);
  EXPECT_NEAR(environment->irradiance.texels[0].x, 2.0f / 3.0f, 3e-3f);
}

TEST(Environment, RotationIsCounterClockwiseSeenFromAbove) {
  constexpr uint32_t width = 64, height = 32;
  std::vector<float> rgb(width * height * 3, 0.0f);
  // One bright texel column at -Z, the image's centre.
  for (uint32_t y = 0; y < height; ++y) rgb[(y * width + width / 2) * 3] = 1.0f;
  const auto environment = build_environment(width, height, rgb.data(), 1.0f, 90.0f);
  // A quarter turn counter-clockwise seen from above takes -Z to -X.
  const glm::vec2 uv = shading::sr_latlong({-1, 0, 0});
  const auto column = static_cast<uint32_t>(uv.x * width);
  EXPECT_GT(environment->specular[0].texels[16 * width + column].x, 0.4f);
}

// A picture that is turned by whole texels of a level has the same lobes there, in other columns.
TEST(Environment, ATurnedPictureIsFilteredToTurnedLevels) {
  constexpr uint32_t width = 64, height = 32, quarter = width / 4;
  std::vector<float> rgb(width * height * 3), turned(rgb.size());
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (uint32_t c = 0; c < 3; ++c) {
        const float value = static_cast<float>((x * x + 7 * y * x + 31 * c + 3 * y) % 97);
        rgb[(y * width + x) * 3 + c] = value;
        turned[(y * width + (x + quarter) % width) * 3 + c] = value;
      }
  const auto before = build_environment(width, height, rgb.data(), 1.0f, 0.0f),
             after = build_environment(width, height, turned.data(), 1.0f, 0.0f);
  for (size_t level = 0; level < before->specular.size(); ++level) {
    const Environment::Image &a = before->specular[level], &b = after->specular[level];
    for (uint32_t y = 0; y < a.height; ++y)
      for (uint32_t x = 0; x < a.width; ++x) {
        const glm::vec3 here = a.texels[y * a.width + x],
                        there = b.texels[y * a.width + (x + a.width / 4) % a.width];
        ASSERT_LT(glm::length(here - there), 1e-2f) << "level " << level << ", " << x << " " << y;
      }
  }
}

TEST(Environment, RefusesBadArguments) {
  const float rgb[12] = {};
  EXPECT_ANY_THROW(build_environment(2, 2, rgb, -1.0f, 0.0f));
  EXPECT_ANY_THROW(build_environment(1, 2, rgb, 1.0f, 0.0f));
  EXPECT_ANY_THROW(build_environment(2, 2, rgb, 1.0f, NAN));
}

// A smooth mirror reflects everything (f0 = f90 = 1 gives nearly 1); no entry exceeds 1.
TEST(AlbedoTable, IsEnergyConserving) {
  const AlbedoTable& table = albedo_table();
  for (const glm::vec2 v : table.values) {
    EXPECT_GE(v.x, 0.0f);
    EXPECT_GE(v.y, 0.0f);
    EXPECT_LE(v.x + v.y, 1.0f + 2e-3f);
  }
  EXPECT_NEAR(table.values[AlbedoTable::size - 1].x + table.values[AlbedoTable::size - 1].y, 1.0f, 2e-3f);
}

}  // namespace
}  // namespace sideray::model
