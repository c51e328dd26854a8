// Shadows by rays in whole frames: plants that wind has moved away from what rays meet.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "frame/frame.h"
#include "scenes/builtin.h"

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

}  // namespace
}  // namespace sideray::tests
