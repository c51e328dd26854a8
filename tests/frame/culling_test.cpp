// Tests that objects that look too small are not traced, and that mask, rays and rasterizer agree on them in every
// frame.
#include <cmath>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests::culling_test {
namespace {

constexpr int pane_count = 4;
constexpr double gap = 0.2, first_pane = 3.0;
constexpr float half_way = 25.0f;  // degrees, between the angles of a whole and of a shrunk pane

// Every other pane is a fifth of its size, about its own middle.
scenes::Content panes() {
  scenes::Content content = scenes::generate("panes", {{"count", std::to_string(pane_count)}});
  for (size_t pane = 1; pane < pane_count; pane += 2) {
    scenes::Object& object = content.objects.at(2 + pane);  // after the walls
    for (int i = 0; i < 9; ++i) object.world_from_object[i] *= 0.2;
    object.world_from_object[11] -= 0.8 * (first_pane + static_cast<double>(pane) * gap);
  }
  return content;
}

std::vector<bool> whole_panes(const scenes::Content& content) {
  std::vector<bool> traced(content.objects.size());
  for (size_t pane = 0; pane < pane_count; pane += 2) traced.at(2 + pane) = true;
  return traced;
}

struct Result {
  std::vector<float> red, green, blue;
  sideray_render_stats stats{};
  bool operator==(const Result& other) const { return red == other.red && green == other.green && blue == other.blue; }
};

class Culling : public ::testing::Test {
 protected:
  Culling() {
    options_.picture.width = 160, options_.picture.height = 90;
    options_.picture.repeats = 1;
    options_.picture.ambient = options_.picture.reflections = 0;
    options_.picture.denoise = 0;
    fill(content_, std::vector<bool>(content_.objects.size(), true));
  }
  void fill(const scenes::Content& content, const std::vector<bool>& traced) {
    scene_ = Scene::create().value();
    scenes::fill(scene_, content, traced);
  }
  Result draw(float cull_angle_deg) {
    options_.poses->cull_angle_deg = cull_angle_deg;
    const Picture picture = renderer_.render(scene_, camera_, options_).value();
    Result result{{}, {}, {}, picture.stats()};
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const auto* values = static_cast<const float*>(channel.values);
      std::vector<float>* plane = channel.name == std::string("R")   ? &result.red
                                  : channel.name == std::string("G") ? &result.green
                                  : channel.name == std::string("B") ? &result.blue
                                                                     : nullptr;
      if (plane) plane->assign(values, values + size_t{options_.picture.width} * options_.picture.height);
    }
    return result;
  }

  scenes::Content content_ = panes();
  sideray_camera camera_ = content_.cameras.front().camera;
  Renderer renderer_ = Renderer::create(sideray_renderer_defaults()).value();
  Scene scene_ = Scene::create().value();
  RenderOptions options_;
};

void expect_same_counts(const sideray_render_stats& a, const sideray_render_stats& b) {
  EXPECT_EQ(a.pixels_masked, b.pixels_masked);
  EXPECT_EQ(a.layers_found, b.layers_found);
  EXPECT_EQ(a.layers_matched, b.layers_matched);
  EXPECT_EQ(a.layers_missed, b.layers_missed);
  EXPECT_EQ(a.traversals_wasted, b.traversals_wasted);
  EXPECT_EQ(a.rays_primary, b.rays_primary);
}

// Compares with the same objects without layers from the start. Shadows are off, since culled objects cast none by
// rays.
TEST_F(Culling, InHybridWhatIsCulledIsRasterAndInNoMask) {
  options_.shadows->method = SIDERAY_SHADOWS_OFF;
  for (const sideray_mask mask : {SIDERAY_COUNT_MASK, SIDERAY_STENCIL_MASK})
    for (const sideray_cache_rate rate : {SIDERAY_RATE_FULL, SIDERAY_RATE_CHECKERBOARD}) {
      options_.translucency->mask = mask;
      options_.translucency->cache_rate = rate;
      fill(content_, std::vector<bool>(content_.objects.size(), true));
      const Result all = draw(0.0f), culled = draw(half_way);
      fill(content_, whole_panes(content_));
      const Result unmarked = draw(0.0f);
      EXPECT_EQ(culled, unmarked);
      EXPECT_NE(culled, all);
      expect_same_counts(culled.stats, unmarked.stats);
      // Without counts the mask requests all layers of the cache, of which the plan for unmarked objects has fewer.
      if (mask == SIDERAY_COUNT_MASK) {
        EXPECT_EQ(culled.stats.layers_requested, unmarked.stats.layers_requested);
      }
      EXPECT_LT(culled.stats.layers_matched, all.stats.layers_matched);
      EXPECT_GT(culled.stats.layers_matched, 0u);
    }
}

TEST_F(Culling, TheEyeIsTheCamerasWhereverTheSceneLies) {
  const Result here = draw(half_way);
  scenes::Content far = content_;
  const double away[3] = {40000.0, -3000.0, 9000.0};
  for (scenes::Object& object : far.objects)
    for (int i = 0; i < 3; ++i) object.world_from_object[9 + i] += away[i];
  for (int i = 0; i < 3; ++i) camera_.world_from_camera[9 + i] += away[i];
  fill(far, std::vector<bool>(far.objects.size(), true));
  const Result there = draw(half_way);
  // Bits differ, since the local origin is a multiple of 1024.
  EXPECT_NEAR(static_cast<double>(there.stats.layers_matched), static_cast<double>(here.stats.layers_matched),
              0.01 * static_cast<double>(here.stats.layers_matched));
}

TEST_F(Culling, NothingVanishesWhereRaysAloneShowIt) {
  options_.translucency->method = SIDERAY_TRANSLUCENCY_RAYTRACED;
  options_.translucency->layers = 0;
  const Result all = draw(0.0f), culled = draw(half_way);
  EXPECT_EQ(all, culled);
  expect_same_counts(all.stats, culled.stats);
}

TEST_F(Culling, ReferencesCullNothing) {
  options_.picture.width = 64, options_.picture.height = 36;
  options_.translucency->light_samples = 1;
  options_.translucency->method = SIDERAY_TRANSLUCENCY_REFERENCE;
  EXPECT_EQ(draw(0.0f), draw(90.0f));
  options_.reference = sideray_reference_defaults();
  options_.reference->light_samples = 1;
  EXPECT_EQ(draw(0.0f), draw(90.0f));
}

TEST_F(Culling, OrthographicViewsCullNothing) {
  camera_.orthographic = 1;
  camera_.half_height = 1.0f;
  camera_.z_far = 100.0f;
  const Result all = draw(0.0f), culled = draw(90.0f);
  EXPECT_EQ(all, culled);
  EXPECT_GT(all.stats.layers_matched, 0u);
}

// A long focal length, even along rows alone, enlarges objects beyond their angle.
TEST_F(Culling, ALensThatIsLongAcrossCullsLess) {
  options_.shadows->method = SIDERAY_SHADOWS_OFF;
  EXPECT_NE(draw(half_way), draw(0.0f));
  camera_.fx_per_fy = 8.0f;
  EXPECT_EQ(draw(half_way), draw(0.0f));
}

// Culled objects cast no traced shadow, and are hit again once they look large.
TEST_F(Culling, ShadowsOfWhatIsCulledGo) {
  scenes::Content content = scenes::generate("empty", {});
  camera_ = content.cameras.front().camera;
  fill(content, std::vector<bool>(content.objects.size(), true));
  options_.shadows->method = SIDERAY_SHADOWS_EXACT;
  const Result all = draw(0.0f), culled = draw(45.0f), again = draw(1.0f);
  EXPECT_NE(all, culled);
  EXPECT_EQ(all, again);
}

// In a sequence a culled object returns at 1.1 times the angle; single pictures have no hysteresis.
TEST_F(Culling, ASequenceHasHysteresis) {
  content_.objects.pop_back();  // one small pane is left
  fill(content_, std::vector<bool>(content_.objects.size(), true));
  const std::vector<float>& corners = content_.meshes.at(content_.objects.at(3).mesh).positions;
  const double radius =
      0.1 * std::hypot(double{corners[6]} - double{corners[0]}, double{corners[7]} - double{corners[1]});
  constexpr float limit = 6.0f;
  struct Step {
    double degrees;  // that the small pane appears under
    bool continues, traced;
  };
  const Step steps[] = {{6.1, false, true}, {5.9, true, false}, {6.1, true, false},  {6.5, true, false},
                        {6.7, true, true},  {6.1, true, true},  {5.9, true, false},  {6.5, false, true},
                        {5.9, true, false}, {6.5, true, false}, {6.501, false, true}};
  const auto stand = [&](const Step& step) {
    camera_.world_from_camera[11] = radius / std::sin(step.degrees * 3.14159265358979 / 360.0) - (first_pane + gap);
    options_.picture.continues = step.continues;
  };
  std::vector<sideray_render_stats> drawn;
  for (const Step& step : steps) {
    stand(step);
    drawn.push_back(draw(limit).stats);
  }
  for (size_t i = 0; i < std::size(steps); ++i) {
    stand(steps[i]);
    options_.picture.continues = 0;
    SCOPED_TRACE(i);
    expect_same_counts(drawn[i], draw(steps[i].traced ? 0.5f * limit : 2.0f * limit).stats);
  }
  EXPECT_NE(drawn[0].layers_matched, drawn[1].layers_matched);
}

}  // namespace
}  // namespace sideray::tests::culling_test
