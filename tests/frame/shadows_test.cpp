// Tests ray-traced shadows in whole frames: plants whose drawn poses differ from those that rays hit.
#include <gtest/gtest.h>

#include <algorithm>
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

// Splits the scene's light into equal parts at the same place.
scenes::Content with_parts_of_light(scenes::Content content, size_t parts) {
  scenes::Light part = content.lights.at(0);
  part.light.radius = part.light.angular_diameter_deg = 0.0f;
  for (float& channel : part.light.intensity) channel /= static_cast<float>(parts);
  content.lights.assign(parts, part);
  return content;
}

TEST(ManyLights, ThoseBeyondThe32ndShareAMaskInsteadOfShadowMaps) {
  const tests::Setup setup{
      .width = 160, .height = 90, .shadows = SIDERAY_SHADOWS_EXACT, .aovs = SIDERAY_AOV_SHADOW, .repeats = 1};
  const scenes::Content content = scenes::generate("empty", {});
  ASSERT_EQ(content.lights.size(), 1u);
  const Frame one = render(with_parts_of_light(content, 1), setup),
              many = render(with_parts_of_light(content, 48), setup);
  // All shared lights are at the place of the single one, so the drawn light does not matter. Pixels behind which all
  // lights are have no rays; there the mask is lit and has no effect.
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
      ASSERT_NEAR(many.planes.at(channel)[i], one.planes.at(channel)[i], 1e-5f * (1.0f + one.planes.at(channel)[i]))
          << i;
  EXPECT_EQ(many.stage_ms.at(SIDERAY_STAGE_SHADOW_MAP), 0.0);
  EXPECT_LE(many.stats.rays_shadow, 33 * one.stats.rays_shadow);
  EXPECT_GT(many.stats.rays_shadow, 33 * one.stats.rays_shadow - combined.size() / 100);
}

// Occluders reflect as much light as they hide where everything is white under a constant environment, and hardly any
// where they are nearly black.
TEST(Occlusion, IsMadeUpForByWhatHidesTheSurroundings) {
  const auto red_of = [](float albedo, bool ao) {
    scenes::Content content = scenes::generate("empty", {});
    content.lights.clear();
    for (scenes::Material& m : content.materials) {
      const sideray_material_desc plain = sideray_material_defaults();
      m.desc = plain;
      for (int c = 0; c < 3; ++c) m.desc.base_color[c] = albedo;
    }
    const tests::Setup setup{.width = 96, .height = 54, .shadows = SIDERAY_SHADOWS_OFF, .furnace = true, .ao = ao};
    return render(content, setup).planes.at("R");
  };
  const std::vector<float> white = red_of(1.0f, true), open = red_of(1.0f, false);
  for (size_t i = 0; i < open.size(); ++i) ASSERT_NEAR(white[i], open[i], 0.01f * open[i]) << i;
  const std::vector<float> dark = red_of(0.1f, true), dark_open = red_of(0.1f, false);
  EXPECT_GT(mean_difference(dark, dark_open), 0.002);
}

// Draws a scene that stands still as a sequence, and returns the shadow and occlusion rays of each picture.
std::vector<uint64_t> rays_of_a_still_sequence(uint32_t pictures) {
  Renderer renderer = Renderer::create().value();
  Scene scene = Scene::create().value();
  const scenes::Content content = scenes::generate("empty", {});
  const sideray_camera camera = content.cameras.at(0).camera;
  scenes::fill(scene, content, scenes::select_ray_traced(content, "all", camera, 64, 36));
  RenderOptions options;
  options.picture.width = 64;
  options.picture.height = 36;
  options.picture.ambient = options.picture.repeats = 1;
  options.picture.reflections = 0;
  options.shadows->method = SIDERAY_SHADOWS_EXACT;
  std::vector<uint64_t> rays;
  std::vector<float> before;
  for (uint32_t i = 0; i < pictures; ++i) {
    options.picture.seed = i + 1;
    options.picture.continues = i > 0;
    const Picture picture = renderer.render(scene, camera, options).value();
    rays.push_back(picture.stats().rays_shadow + picture.stats().rays_ao);
    EXPECT_GT(picture.stage(SIDERAY_STAGE_KEPT_FRAME).median, 0.0) << i;
    const auto* red = static_cast<const float*>(picture.channel(0).values);
    const std::vector<float> now(red, red + 64 * 36);
    EXPECT_TRUE(rays.back() > 0 || now == before) << i;
    before = now;
  }
  return rays;
}

// The mean over 8 frames converges after 47.
TEST(StillSequence, IsTracedUntilItsMasksHaveSettled) {
  const std::vector<uint64_t> rays = rays_of_a_still_sequence(52);
  const auto first = static_cast<size_t>(std::find(rays.begin(), rays.end(), uint64_t{0}) - rays.begin());
  EXPECT_EQ(first, 48u);
  for (size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(rays[i] == 0, i >= first) << i;
}

class ForestShadows : public testing::Test {
 protected:
  std::vector<float> lit(sideray_shadows shadows, uint32_t poses) {
    setup_.shadows = shadows, setup_.poses = poses;
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
  const std::vector<float> truth = lit(SIDERAY_SHADOWS_EXACT, SIDERAY_POSES_ALL);
  const double streaks = mean_difference(lit(SIDERAY_SHADOWS_EXACT, SIDERAY_POSES_REST), truth);
  const double resting = mean_difference(lit(SIDERAY_SHADOWS_INEXACT, SIDERAY_POSES_REST), truth);
  std::cout << "  masks differ from exact poses by " << streaks << ", by " << resting << " from the rest pose\n";
  EXPECT_GT(streaks, 0.0);
  EXPECT_LT(resting, streaks);
}

TEST_F(ForestShadows, TheSameBitsForAnyThreadCount) {
  setup_.threads = 1;
  const std::vector<float> one = lit(SIDERAY_SHADOWS_INEXACT, 1);
  setup_.threads = 2;
  EXPECT_EQ(lit(SIDERAY_SHADOWS_INEXACT, 1), one);
}

// Glass reduces the sky's light and reflects none: a white floor under panes is darker, while a white wall that hid as
// much would reflect it back.
TEST(Occlusion, GlassThrowsNothingBack) {
  const auto floor_under = [](bool ao) {
    scenes::Content content = scenes::generate("solids", {});
    content.lights.clear();
    for (scenes::Material& m : content.materials) {
      const bool glass = m.desc.transmission > 0.0f;
      m.desc = sideray_material_defaults();
      if (glass) m.desc.alpha_mode = SIDERAY_BLEND, m.desc.base_color[3] = 0.5f;
    }
    const tests::Setup setup{.width = 96,
                             .height = 54,
                             .translucency = SIDERAY_TRANSLUCENCY_OFF,
                             .shadows = SIDERAY_SHADOWS_OFF,
                             .furnace = true,
                             .ao = ao};
    return render(content, setup).planes.at("R");
  };
  const std::vector<float> veiled = floor_under(true), open = floor_under(false);
  size_t darker = 0;
  for (size_t i = 0; i < open.size(); ++i) {
    ASSERT_LE(veiled[i], 1.01f * open[i]) << i;
    darker += veiled[i] < 0.9f * open[i] ? 1 : 0;
  }
  EXPECT_GT(darker, open.size() / 50);
}

}  // namespace
}  // namespace sideray::tests
