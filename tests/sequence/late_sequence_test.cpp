// Tests frames of a sequence under a deadline that leaves no time: they show the first frame's answers.
#include <gtest/gtest.h>

#include <cmath>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "scenes/builtin/builtin.h"
#include "scenes/content/content.h"

namespace sideray::tests::late_sequence_test {
namespace {

constexpr float ample = 1e6f, none = 1e-3f;

class LateSequence : public testing::TestWithParam<const char*> {
 protected:
  LateSequence() : content_(scenes::generate(GetParam(), {})) {
    options_.picture.width = 160, options_.picture.height = 90;
    options_.picture.repeats = 1;
    options_.translucency->layers = 4;
    options_.translucency->whole_pixels = 1;
    options_.shadows->method = SIDERAY_SHADOWS_EXACT;
    options_.picture.denoise = 0;
    options_.picture.ambient = SIDERAY_AMBIENT_AO;  // because unfiltered bounced light has no history
    const scenes::Sky sky = scenes::sky();
    scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    camera_ = content_.cameras.front().camera;
    scenes::fill(scene_, content_, scenes::select_ray_traced(content_, "all", camera_, 160, 90));
  }
  std::vector<float> draw(float deadline_ms, bool continues, const sideray_camera& camera) {
    options_.picture.deadline_ms = deadline_ms;
    options_.picture.continues = continues;
    const Picture picture = renderer_.render(scene_, camera, options_).value();
    stats = picture.stats();
    std::vector<float> values;
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const std::string name = channel.name;
      if (name != "R" && name != "G" && name != "B") continue;
      const auto* plane = static_cast<const float*>(channel.values);
      values.insert(values.end(), plane, plane + 160 * 90);
    }
    return values;
  }
  static double apart(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::abs(double{a[i]} - double{b[i]});
    return sum / static_cast<double>(a.size());
  }
  sideray_render_stats stats{};

  scenes::Content content_;
  Scene scene_ = Scene::create().value();
  Renderer renderer_ = Renderer::create().value();
  RenderOptions options_;
  sideray_camera camera_{};
};

// Both frames have no filters, no jitter and the same random numbers. With the program's defaults a still view changes
// from frame to frame: StillView of test_cli.
TEST_P(LateSequence, WithoutTimeTheSameRaysHaveTheSameAnswers) {
  const std::vector<float> first = draw(ample, false, camera_);
  EXPECT_EQ(stats.pixels_late, 0u);
  EXPECT_EQ(draw(none, true, camera_), first);
  EXPECT_GT(stats.pixels_masked, 1000u);
  EXPECT_EQ(stats.pixels_older, stats.pixels_masked);
  EXPECT_EQ(stats.mask_pixels_late, 0u);
  EXPECT_NE(draw(none, false, camera_), first);
  EXPECT_EQ(stats.pixels_late, stats.pixels_masked);
}

TEST_P(LateSequence, AMovedViewIsNearerToTheTruthThanRaster) {
  draw(ample, false, camera_);
  sideray_camera moved = camera_;
  moved.world_from_camera[9] += 0.02;
  const std::vector<float> late = draw(none, true, moved);
  EXPECT_GT(stats.pixels_older, stats.pixels_masked * 4 / 5);
  EXPECT_GT(stats.mask_pixels_older, 1000u);
  EXPECT_LT(stats.mask_pixels_late, stats.mask_pixels_older / 20);
  const uint64_t matched = stats.layers_matched;
  const std::vector<float> truth = draw(ample, false, moved);
  EXPECT_GT(matched, stats.layers_matched * 4 / 5);
  const std::vector<float> raster = draw(none, false, moved);
  // Bent light, which solids are full of, moves otherwise than the surfaces that show it.
  const double part = std::string(GetParam()) == "solids" ? 0.6 : 0.4;
  EXPECT_LT(apart(late, truth), part * apart(raster, truth));
}

// Flat glass, and glass that is curved and bends what is seen through it.
INSTANTIATE_TEST_SUITE_P(Scenes, LateSequence, testing::Values("panes", "solids"));

}  // namespace
}  // namespace sideray::tests::late_sequence_test
