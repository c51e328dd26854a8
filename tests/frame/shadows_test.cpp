// Shadows by rays in whole frames: plants that wind has moved away from what rays meet.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

double mean_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
  return sum / static_cast<double>(a.size());
}

// The scene's one light as many, each a part of it at the same place.
scenes::Content with_parts_of_light(scenes::Content content, size_t parts) {
  scenes::Light part = content.lights.at(0);
  part.light.radius = part.light.angular_diameter_deg = 0.0f;
  for (float& channel : part.light.intensity) channel /= static_cast<float>(parts);
  content.lights.assign(parts, part);
  return content;
}

TEST(ManyLights, ThoseBeyondThe32ndShareAMaskInsteadOfShadowMaps) {
  const tests::Setup setup{.width = 160, .height = 90, .shadows = SIDERAY_SHADOWS_EXACT, .aovs = SIDERAY_AOV_SHADOW, .repeats = 1};
  const scenes::Content content = scenes::generate("empty", {});
  ASSERT_EQ(content.lights.size(), 1u);
  const Frame one = render(with_parts_of_light(content, 1), setup), many = render(with_parts_of_light(content, 48), setup);
  // Whichever of the shared lights a pixel's ray goes to, it is at the place of the single one. No ray goes from where
  // all of them are behind the surface: there the mask is lit, and counts for nothing.
  ASSERT_TRUE(many.planes.contains("shadow.combined"));
  const std::vector<float>& combined = many.planes.at("shadow.combined");
  const std::vector<float>& single = one.planes.at("shadow.0");
  uint64_t behind = 0;
  for (size_t i = 0; i < combined.size(); ++i) {
    if (combined[i] == single[i]) continue;
    ASSERT_EQ(combined[i], 1.0f) << i;
    ++behind;
  }
  EXPECT_LT(behind, combined.size() / 100);
  EXPECT_EQ(many.planes.at("shadow.31"), one.planes.at("shadow.0"));
  EXPECT_FALSE(many.planes.contains("shadow.32"));
  for (const char* channel : {"R", "G", "B"})
    for (size_t i = 0; i < one.planes.at(channel).size(); ++i)
      ASSERT_NEAR(many.planes.at(channel)[i], one.planes.at(channel)[i], 1e-5f * (1.0f + one.planes.at(channel)[i])) << i;
  EXPECT_EQ(many.stage_ms.at(SIDERAY_STAGE_SHADOW_MAP), 0.0);
  EXPECT_LE(many.stats.rays_shadow, 33 * one.stats.rays_shadow);
  EXPECT_GT(many.stats.rays_shadow, 33 * one.stats.rays_shadow - combined.size() / 100);
}

class ForestShadows : public testing::Test {
 protected:
  std::vector<float> lit(sideray_shadows shadows, sideray_foliage foliage) {
    setup_.shadows = shadows, setup_.foliage = foliage;
    return render(content_, setup_, &camera()).planes.at("shadow.0");
  }
  const sideray_camera& camera() const {
    for (const scenes::Camera& c : content_.cameras)
      if (c.name == "closeup") return c.camera;
    return content_.cameras.at(0).camera;
  }

  scenes::Content content_ = scenes::generate("forest", {{"count", "200"}});
  tests::Setup setup_{.width = 160, .height = 90, .aovs = SIDERAY_AOV_SHADOW, .time_s = 1.0};
};

// Each pixel takes the same point of the light, so that what differs is geometry alone.
TEST_F(ForestShadows, TheRestPoseIsNearerToExactPosesThanExactRaysAre) {
  const std::vector<float> truth = lit(SIDERAY_SHADOWS_EXACT, SIDERAY_FOLIAGE_UNIQUE);
  const double streaks = mean_difference(lit(SIDERAY_SHADOWS_EXACT, SIDERAY_FOLIAGE_STATIC), truth);
  const double resting = mean_difference(lit(SIDERAY_SHADOWS_INEXACT, SIDERAY_FOLIAGE_STATIC), truth);
  std::cout << "  masks differ from exact poses by " << streaks << ", by " << resting << " from the rest pose\n";
  EXPECT_GT(streaks, 0.0);
  EXPECT_LT(resting, streaks);
}

TEST_F(ForestShadows, TheSameBitsForAnyThreadCount) {
  setup_.threads = 1;
  const std::vector<float> one = lit(SIDERAY_SHADOWS_INEXACT, SIDERAY_FOLIAGE_SHARED);
  setup_.threads = 2;
  EXPECT_EQ(lit(SIDERAY_SHADOWS_INEXACT, SIDERAY_FOLIAGE_SHARED), one);
}

// The same filter on both sides: its results differ by rounding and the last bit of a byte.
TEST_F(ForestShadows, MasksAreFilteredAlikeOnTheProcessorAndTheDevice) {
  setup_.denoise = true;
  const std::vector<float> cpu = lit(SIDERAY_SHADOWS_INEXACT, SIDERAY_FOLIAGE_SHARED);
  setup_.denoise_on = SIDERAY_DENOISE_GPU;
  const std::vector<float> gpu = lit(SIDERAY_SHADOWS_INEXACT, SIDERAY_FOLIAGE_SHARED);
  setup_.denoise = false;
  const std::vector<float> raw = lit(SIDERAY_SHADOWS_INEXACT, SIDERAY_FOLIAGE_SHARED);
  size_t off = 0;
  for (size_t i = 0; i < cpu.size(); ++i) off += std::abs(cpu[i] - gpu[i]) > 1.5f / 255.0f;
  EXPECT_LE(off, cpu.size() / 1000);
  EXPECT_GT(mean_difference(cpu, raw), 0.001);
}

TEST_F(ForestShadows, OcclusionIsFilteredAlikeOnTheProcessorAndTheDevice) {
  setup_.denoise = setup_.ao = true;
  setup_.shadows = SIDERAY_SHADOWS_OFF, setup_.aovs = 0;
  const std::vector<float> cpu = render(content_, setup_, &camera()).rgb();
  setup_.denoise_on = SIDERAY_DENOISE_GPU;
  const std::vector<float> gpu = render(content_, setup_, &camera()).rgb();
  setup_.denoise = false;
  const std::vector<float> raw = render(content_, setup_, &camera()).rgb();
  EXPECT_LT(mean_difference(cpu, gpu), 0.0005);
  EXPECT_GT(mean_difference(cpu, raw), 0.001);
}

}  // namespace
}  // namespace sideray::tests
