// Tests that stages that the plan leaves out change no picture and are not run.
#include <sideray/plan.h>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests::plan_test {
namespace {

scenes::Content panes(int count) {
  return scenes::generate("panes", {{"count", std::to_string(count)}});
}

// Adds a black light before all others, so that lights and masks have different numbers.
scenes::Content with_dark_light(scenes::Content content) {
  scenes::Light dark = content.lights.at(0);
  for (float& channel : dark.light.intensity) channel = 0.0f;
  content.lights.insert(content.lights.begin(), dark);
  return content;
}

TEST(Plan, ALightThatSendsNothingCastsNoMask) {
  const tests::Setup setup{.width = 96, .height = 54, .shadows = SIDERAY_SHADOWS_EXACT, .repeats = 1};
  const scenes::Content content = scenes::generate("empty", {});
  ASSERT_EQ(content.lights.size(), 1u);
  const Frame one = render(content, setup), two = render(with_dark_light(content), setup);
  EXPECT_EQ(two.planes, one.planes);
  EXPECT_GT(one.stats.rays_shadow, 0u);
  EXPECT_EQ(two.stats.rays_shadow, one.stats.rays_shadow);
  EXPECT_EQ(two.stats.bytes_cache, one.stats.bytes_cache);
  EXPECT_EQ(one.stats.bytes_cache, uint64_t{96} * 54);
}

// Up to eight lamps always have rays; of nine, those that add less than is visible have none.
TEST(Plan, WhereManyLightsAddLittleNoRayGoes) {
  const tests::Setup setup{.width = 96, .height = 54, .shadows = SIDERAY_SHADOWS_EXACT, .repeats = 1};
  const auto rays_of = [&](size_t lamps, float candela) {
    scenes::Content content = scenes::generate("empty", {});
    content.lights.clear();
    for (size_t i = 0; i < lamps; ++i) {
      sideray_light lamp = sideray_light_defaults();
      lamp.type = SIDERAY_LIGHT_POINT;
      lamp.position[1] = 20.0;
      std::fill_n(lamp.intensity, 3, candela);
      content.lights.push_back({"lamp", lamp});
    }
    return render(content, setup).stats.rays_shadow;
  };
  const uint64_t one = rays_of(1, 0.01f);
  EXPECT_GT(one, 0u);
  EXPECT_EQ(rays_of(8, 0.01f), 8 * one);
  EXPECT_EQ(rays_of(9, 0.01f), 0u);
  EXPECT_EQ(rays_of(9, 1e9f), 9 * one);
}

TEST(Plan, AMaskThatIsShownIsThere) {
  const Frame frame = render(with_dark_light(scenes::generate("empty", {})),
                             {.width = 32, .height = 18, .shadows = SIDERAY_SHADOWS_EXACT, .aovs = SIDERAY_AOV_SHADOW});
  EXPECT_TRUE(frame.planes.contains("shadow.0"));
  EXPECT_TRUE(frame.planes.contains("shadow.1"));
}

TEST(Plan, TheCacheHasNoLayerThatNoRayNeeds) {
  tests::Setup setup{.width = 96, .height = 54, .layers = 8, .repeats = 1};
  // Whole pixels have two more textures of eight bytes.
  const Frame few = render(panes(3), setup);
  EXPECT_EQ(few.stats.bytes_cache, uint64_t{96} * 54 * (3 * 16 + 16));
  setup.aovs = SIDERAY_AOV_LAYERS;
  const Frame all = render(panes(3), setup);
  EXPECT_EQ(all.stats.bytes_cache, uint64_t{96} * 54 * (8 * 16 + 16));
  for (const char* channel : {"R", "G", "B", "A"}) EXPECT_EQ(few.planes.at(channel), all.planes.at(channel)) << channel;
  EXPECT_EQ(few.stats.layers_found, all.stats.layers_found);
  EXPECT_EQ(few.stats.layers_matched, all.stats.layers_matched);
}

TEST(Plan, NothingTranslucentNeedsNothing) {
  const Frame frame = render(scenes::generate("empty", {}), {.width = 96, .height = 54, .repeats = 1});
  EXPECT_EQ(frame.stats.bytes_cache + frame.stats.bytes_readback + frame.stats.bytes_upload, 0u);
  EXPECT_EQ(frame.stats.rays_primary + frame.stats.rays_shadow, 0u);
  EXPECT_EQ(frame.stage_ms.at(SIDERAY_STAGE_MASK), 0.0);
  EXPECT_EQ(frame.stage_ms.at(SIDERAY_STAGE_BUILD), 0.0);
}

TEST(Plan, RefusesWhatARendererRefuses) {
  sideray_error error{};
  sideray_plan* plan = nullptr;
  Scene scene = Scene::create().value();
  RenderOptions options;
  const auto create = [&] {
    const sideray_render_options given = options.c();
    return sideray_plan_create(scene.get(), &given, &plan, &error);
  };
  EXPECT_EQ(create(), SIDERAY_INVALID_ARGUMENT);
  EXPECT_NE(std::string(error.message).find("committed"), std::string::npos) << error.message;
  scene.commit();
  options.translucency->layers = 9;
  EXPECT_EQ(create(), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(plan, nullptr);
  options.translucency->layers = 4;
  ASSERT_EQ(create(), SIDERAY_OK) << error.message;
  EXPECT_EQ(sideray_plan_pass_count(plan), size_t{SIDERAY_STAGE_TOTAL_FRAME});
  EXPECT_EQ(sideray_plan_pass_at(plan, 99), nullptr);
  sideray_plan_release(plan);
}

}  // namespace
}  // namespace sideray::tests::plan_test
