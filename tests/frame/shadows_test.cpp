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
