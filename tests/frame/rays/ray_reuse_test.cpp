// Tests layers that reuse rays of their neighbours: fewer rays for about the same picture, as planned.
#include <gmock/gmock.h>

#include <cmath>

#include "frame/rays/stage.h"

namespace sideray::tests::ray_reuse_test {
namespace {

RenderOptions drawn(float ray_reuse) {
  RenderOptions o;
  o.picture.ambient = o.picture.reflections = 0;
  o.shadows->method = SIDERAY_SHADOWS_MAP;
  o.translucency->ray_reuse = ray_reuse;
  return o;
}

double mean_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(double{a[i]} - double{b[i]});
  return sum / static_cast<double>(a.size());
}

struct Case {
  const char* scene;
  scenes::Settings parameters;
  double most_rays;  // as a share
};

// Two lamps, since eight with six faces of a shadow map each take longer than all rays of so small a picture.
const scenes::Settings small_bistro = {{"lamps", "2"}, {"tables", "2"}};

// In so small pictures neighbours seldom see the same.
TEST(RayReuse, TracesFewerRaysForAboutTheSamePicture) {
  for (const Case& c : {Case{"panes", {}, 0.85}, Case{"bistro", small_bistro, 0.95}, Case{"frosted", {}, 0.95}}) {
    Stage stage(scenes::generate(c.scene, c.parameters));
    const Stage::Drawn all = stage.draw(drawn(0.0f), true), reused = stage.draw(drawn(0x1p-6f), true);
    EXPECT_EQ(all.stats.layers_borrowed, 0u);
    EXPECT_GT(reused.stats.layers_borrowed, 0u) << c.scene;
    EXPECT_LT(reused.stats.layers_borrowed, reused.stats.layers_found) << c.scene;
    EXPECT_EQ(reused.stats.layers_found, all.stats.layers_found) << c.scene << ": every surface is found";
    EXPECT_EQ(reused.stats.layers_matched, all.stats.layers_matched) << c.scene;
    EXPECT_EQ(reused.stats.rays_primary, all.stats.rays_primary);
    EXPECT_LT(static_cast<double>(reused.rays()), c.most_rays * static_cast<double>(all.rays())) << c.scene;
    EXPECT_LT(mean_difference(reused.rgb, all.rgb), 0x1p-8) << c.scene;
    const Stage::Drawn strict = stage.draw(drawn(0x1p-10f), true);
    EXPECT_LE(strict.stats.layers_borrowed, reused.stats.layers_borrowed) << c.scene;
    EXPECT_LE(mean_difference(strict.rgb, all.rgb), mean_difference(reused.rgb, all.rgb)) << c.scene;
  }
}

// Most rays of solids are along refracted paths behind their first surface, few at that surface.
TEST(RayReuse, LendsAlongBentPathsToo) {
  Stage stage(scenes::generate("solids", {}));
  RenderOptions options = drawn(0.0f);
  options.shadows->method = SIDERAY_SHADOWS_OFF;
  const Stage::Drawn all = stage.draw(options, true);
  options.translucency->ray_reuse = 0x1p-6f;
  const Stage::Drawn reused = stage.draw(options, true);
  EXPECT_EQ(reused.stats.layers_refracted, all.stats.layers_refracted);
  EXPECT_EQ(reused.stats.rays_primary, all.stats.rays_primary) << "every pixel follows its own path";
  EXPECT_LT(reused.stats.rays_reflection, 0.8 * static_cast<double>(all.stats.rays_reflection));
  EXPECT_LT(mean_difference(reused.rgb, all.rgb), 0x1p-8);
}

TEST(RayReuse, TheSameBitsForAnyThreadCount) {
  for (const scenes::Content& content : {scenes::generate("frosted", {}), scenes::generate("solids", {})}) {
    Stage one(content, 1), five(content, 5);
    const RenderOptions options = drawn(0x1p-6f);
    EXPECT_EQ(one.draw(options, true).rgb, five.draw(options, true).rgb);
  }
}

TEST(RayReuse, IsLeftToThePlanWhereNothingIsSaid) {
  EXPECT_EQ(sideray_translucency_defaults().ray_reuse, SIDERAY_RAY_REUSE_AUTO);
  EXPECT_EQ(sideray_layer_inputs_defaults().ray_reuse, 0.0f) << "a host says what it shows";
  Stage stage(scenes::generate("panes", {}));
  RenderOptions options;
  EXPECT_EQ(stage.plan(options).ray_reuse, 0x1p-6f);
  EXPECT_THAT(stage.plan(options).reason, testing::HasSubstr("0.015625"));
  options.picture.exposure = 3.0f;
  EXPECT_EQ(stage.plan(options).ray_reuse, 0x1p-9f) << "errors are shown brighter";
  options.picture.exposure = -3.0f;
  EXPECT_EQ(stage.plan(options).ray_reuse, 0x1p-6f) << "such a picture may be shown brighter later";
  options.translucency->ray_reuse = 0.25f;
  EXPECT_EQ(stage.plan(options).ray_reuse, 0.25f);
}

void shade_black(void*, const sideray_shading_point*, size_t count, sideray_shading_result* results) {
  for (size_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) results[i].radiance[c] = 0.0f, results[i].reflectance[c] = 0.0f;
}

TEST(RayReuse, EveryLayerTracesItsOwnWhereNothingCanBeLent) {
  Stage stage(scenes::generate("panes", {}));
  const auto planned = [&](const auto& change) {
    RenderOptions options;
    change(options);
    const Stage::Planned p = stage.plan(options);
    EXPECT_EQ(p.ray_reuse, 0.0f);
    return p.reason;
  };
  using testing::HasSubstr;
  EXPECT_THAT(planned([](RenderOptions& o) { o.translucency->cache_rate = SIDERAY_RATE_QUARTER; }),
              HasSubstr("the cache rate spares"));
  Stage solids(scenes::generate("solids", {}));
  for (const float given : {SIDERAY_RAY_REUSE_AUTO, 0.125f}) {
    RenderOptions refracted;
    refracted.translucency->method = SIDERAY_TRANSLUCENCY_RAYTRACED;
    refracted.translucency->ray_reuse = given;
    EXPECT_EQ(solids.plan(refracted).ray_reuse, 0.0f);
    EXPECT_THAT(solids.plan(refracted).reason, HasSubstr("along several paths"));
  }
  sideray_shader_desc shader = sideray_shader_defaults();
  shader.shade = shade_black;
  stage.scene().set_shader(shader);
  stage.scene().commit();
  EXPECT_THAT(planned([](RenderOptions&) {}), HasSubstr("host's shader"));
}

TEST(RayReuse, RefusesWhatRulesItOut) {
  Stage stage(scenes::generate("panes", {}));
  const auto refused = [&](const auto& change) -> std::string {
    RenderOptions options = drawn(0.01f);
    change(options);
    try {
      stage.plan(options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_THAT(refused([](RenderOptions& o) { o.translucency->cache_rate = SIDERAY_RATE_QUARTER; }),
              HasSubstr("ray-reuse"));
  EXPECT_THAT(refused([](RenderOptions& o) { o.translucency->ray_reuse = -0.5f; }), HasSubstr("ray-reuse"));
  EXPECT_THAT(refused([](RenderOptions& o) { o.translucency->ray_reuse = NAN; }), HasSubstr("ray-reuse"));
  EXPECT_EQ(refused([](RenderOptions&) {}), "");
}

}  // namespace
}  // namespace sideray::tests::ray_reuse_test
