// With a layer threshold no pixel of any picture is farther off than it promises, and rays are spared.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "frame/rays/stage.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests::layer_needs_test {
namespace {

constexpr float counted_threshold = 1.0f / 255.0f;
constexpr float thresholds[] = {1e-4f, counted_threshold, 1.0f / 16.0f};

struct Mode {
  const char* name;
  RenderOptions options;
};

RenderOptions automatic() {
  RenderOptions o;
  o.picture.ao = o.picture.reflections = 0;
  o.shadows->method = SIDERAY_SHADOWS_MAP;
  o.translucency->layers = 8;
  o.translucency->ray_reuse = 0.0f;
  return o;
}

// Every ray is traced.
RenderOptions defaults() {
  RenderOptions o = automatic();
  o.translucency->layer_threshold = 0.0f;
  return o;
}

std::vector<Mode> modes() {
  std::vector<Mode> all{{"sorted", defaults()},
                        {"peel, unfiltered", defaults()},
                        {"checkerboard", defaults()},
                        {"raytraced", defaults()}};
  all[1].options.translucency->oit = SIDERAY_OIT_PEEL;
  all[1].options.filters.reset();
  all[2].options.translucency->cache_rate = SIDERAY_RATE_CHECKERBOARD;
  all[3].options.translucency->method = SIDERAY_TRANSLUCENCY_RAYTRACED;
  all[3].options.translucency->layers = 0;
  return all;
}

// Without the slowest, which the other cases of panes hold.
std::vector<Mode> but_peeling() {
  std::vector<Mode> few = modes();
  few.erase(few.begin() + 1);
  return few;
}

// What halfs make of it, in the cache and at each of up to 16 blends into the picture: steps of 2^-10 of the value.
constexpr float rounding = 16.0f / 1024.0f;

// By how much the worst pixel is off beyond `threshold` and rounding; negative: by nothing.
float worst_excess(const std::vector<float>& test, const std::vector<float>& truth, float threshold) {
  float worst = -INFINITY;
  for (size_t i = 0; i < test.size(); ++i) {
    const float allowed = threshold + rounding * std::max(std::abs(truth[i]), std::abs(test[i]));
    worst = std::max(worst, std::abs(test[i] - truth[i]) - allowed);
  }
  return worst;
}

// Draws pictures at all thresholds, and at the one that is left to the plan, in all modes, against that of threshold 0.
// Returns the share of rays spared at 1/255.
double expect_bound(const scenes::Content& content, std::vector<Mode> drawn_in = modes()) {
  Stage stage(content);
  uint64_t all = 0, spared = 0;
  for (Mode& mode : drawn_in) {
    const Stage::Drawn truth = stage.draw(mode.options, true);
    EXPECT_EQ(truth.stats.rays_skipped, 0u) << mode.name;
    for (const float threshold : thresholds) {
      const bool counted = threshold == counted_threshold;
      mode.options.translucency->layer_threshold = threshold;
      const Stage::Drawn drawn = stage.draw(mode.options, counted);
      EXPECT_LE(worst_excess(drawn.rgb, truth.rgb, threshold), 0.0f) << mode.name << " " << threshold;
      if (!counted) continue;
      EXPECT_EQ(drawn.rays() < truth.rays(), drawn.stats.rays_skipped > 0) << mode.name;
      EXPECT_LE(drawn.rays(), truth.rays()) << mode.name;
      EXPECT_LE(drawn.stats.layers_skipped, drawn.stats.layers_found) << mode.name;
      all += truth.rays(), spared += truth.rays() - drawn.rays();
    }
    mode.options.translucency->layer_threshold = SIDERAY_LAYER_THRESHOLD_AUTO;
    const Stage::Drawn drawn = stage.draw(mode.options, false);
    EXPECT_EQ(stage.planned().layer_threshold, content.lights.size() > 1 ? 0x1p-10f : 0.0f) << mode.name;
    EXPECT_LE(worst_excess(drawn.rgb, truth.rgb, stage.planned().layer_threshold), 0.0f) << mode.name << " auto";
  }
  return static_cast<double>(spared) / static_cast<double>(all);
}

void add_light(scenes::Content& content, glm::dvec3 position, float intensity) {
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_POINT;
  for (int c = 0; c < 3; ++c)
    light.position[c] = position[c], light.intensity[c] = intensity * (1.0f - 0.2f * float(c));
  content.lights.push_back({"", light});
}

// Panes, each looked over by `change`, with lights before them, between them and behind the wall, where none reaches.
template <typename Change>
scenes::Content panes(int count, const Change& change) {
  scenes::Content content = scenes::generate("panes", {{"count", std::to_string(count)}});
  int i = 0;
  for (scenes::Material& material : content.materials)
    if (material.desc.alpha_mode == SIDERAY_BLEND) change(material.desc, i++);
  for (int k = 0; k < 6; ++k)
    add_light(content, {k - 2.5, 1.0 - 0.3 * k, k % 2 ? -1.0 : -12.0}, 8.0f / static_cast<float>(1 << k));
  return content;
}

TEST(LayerThreshold, HoldsOnAlphaBlendedPanes) {
  const double spared = expect_bound(panes(4, [](sideray_material_desc& d, int i) {
    d.roughness = 0.05f + 0.2f * static_cast<float>(i);
    d.blend_mode = i == 1 ? SIDERAY_BLEND_PREMULTIPLIED : i == 2 ? SIDERAY_BLEND_ADDITIVE : SIDERAY_BLEND_ALPHA;
  }));
  EXPECT_GT(spared, 0.0);
}

TEST(LayerThreshold, HoldsBehindWhatIsNearlyOpaque) {
  const double spared =
      expect_bound(panes(8, [](sideray_material_desc& d, int i) { d.base_color[3] = i % 3 == 0 ? 0.995f : 0.9f; }),
                   but_peeling());
  EXPECT_GT(spared, 0.2);
}

TEST(LayerThreshold, HoldsBehindTintedGlass) {
  const double spared = expect_bound(panes(6, [](sideray_material_desc& d, int i) {
    d.alpha_mode = SIDERAY_OPAQUE;
    d.transmission = 1.0f;
    d.roughness = 0.0f;
    d.base_color[i % 3] = 0.05f;
    d.base_color[(i + 1) % 3] = 0.5f;
    d.base_color[3] = 1.0f;
    d.clearcoat = i == 2 ? 1.0f : 0.0f;
    d.clearcoat_roughness = 0.1f;
  }), but_peeling());
  EXPECT_GT(spared, 0.2);
}

class SlowLayerThresholdIn : public testing::TestWithParam<const char*> {};

TEST_P(SlowLayerThresholdIn, Holds) {
  expect_bound(scenes::generate(GetParam(), {}));
}

INSTANTIATE_TEST_SUITE_P(Slow, SlowLayerThresholdIn, testing::Values("crossing", "solids", "edges", "frosted", "haze"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(SlowLayerThreshold, HoldsInTheBistro) {
  const double spared = expect_bound(scenes::generate("bistro", {{"tables", "1"}}), {{"sorted", defaults()}});
  EXPECT_GT(spared, 0.02);
}

TEST(LayerThreshold, SameBitsForAnyThreads) {
  const scenes::Content content = panes(5, [](sideray_material_desc& d, int) { d.base_color[3] = 0.8f; });
  RenderOptions options = defaults();
  options.translucency->layer_threshold = 1.0f / 255.0f;
  Stage one(content, 1), two(content, 2);
  const Stage::Drawn a = one.draw(options, true), b = two.draw(options, true);
  EXPECT_EQ(a.rgb, b.rgb);
  EXPECT_EQ(a.stats.rays_skipped, b.stats.rays_skipped);
  EXPECT_GT(a.stats.rays_skipped, 0u);
}

// Behind the first of such panes hardly a ray counts.
scenes::Content dense_panes() {
  return panes(4, [](sideray_material_desc& d, int) { d.base_color[3] = 0.99f; });
}

TEST(LayerThreshold, IsLeftToThePlanWhereNothingIsSaid) {
  EXPECT_EQ(sideray_translucency_defaults().layer_threshold, SIDERAY_LAYER_THRESHOLD_AUTO);
  EXPECT_EQ(sideray_layer_inputs_defaults().layer_threshold, 0.0f) << "a host says what it shows";
  Stage stage(dense_panes());
  RenderOptions options = automatic();
  const Stage::Drawn by_plan = stage.draw(options, true);
  EXPECT_GT(by_plan.stats.rays_skipped, 0u);
  EXPECT_THAT(stage.planned().reason, testing::HasSubstr("0.0009765625"));
  options.translucency->layer_threshold = stage.planned().layer_threshold;
  const Stage::Drawn as_given = stage.draw(options, true);
  EXPECT_EQ(by_plan.rgb, as_given.rgb);
  EXPECT_EQ(by_plan.stats.rays_skipped, as_given.stats.rays_skipped);
}

// A picture that is shown brighter by 4 stops shows 16 times the change, so that AUTO is a sixteenth there.
TEST(LayerThreshold, AutoIsOfThePictureAsItIsShown) {
  Stage stage(dense_panes());
  RenderOptions options = automatic();
  options.picture.exposure = 4.0f;
  const Stage::Drawn shown_brighter = stage.draw(options, true);
  EXPECT_EQ(stage.planned().layer_threshold, 0x1p-14f);
  options.translucency->layer_threshold = 0x1p-14f;
  EXPECT_EQ(stage.draw(options, true).rgb, shown_brighter.rgb);
  EXPECT_EQ(stage.planned().layer_threshold, 0x1p-14f) << "a value that is given is taken as it is";
  options.translucency->layer_threshold = SIDERAY_LAYER_THRESHOLD_AUTO;
  options.picture.exposure = -4.0f;
  EXPECT_EQ(stage.plan(options).layer_threshold, 0x1p-10f) << "such a picture may be shown brighter later";
  options.picture.exposure = NAN;
  EXPECT_THROW(stage.plan(options), Error);
}

// The same picture and rays as with 0, and the plan says why.
void expect_unsupported(Stage& stage, RenderOptions options, const char* reason) {
  options.translucency->layer_threshold = 0.0f;
  const Stage::Drawn traced = stage.draw(options, true);
  options.translucency->layer_threshold = SIDERAY_LAYER_THRESHOLD_AUTO;
  const Stage::Drawn by_plan = stage.draw(options, true);
  EXPECT_EQ(stage.planned().layer_threshold, 0.0f) << reason;
  EXPECT_THAT(stage.planned().reason, testing::HasSubstr(reason));
  EXPECT_EQ(by_plan.rgb, traced.rgb) << reason;
  EXPECT_EQ(by_plan.rays(), traced.rays()) << reason;
  EXPECT_EQ(by_plan.stats.rays_skipped, 0u) << reason;
}

void shade_black(void*, const sideray_shading_point*, size_t count, sideray_shading_result* results) {
  for (size_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) results[i].radiance[c] = 0.0f, results[i].reflectance[c] = 0.0f;
}

TEST(LayerThreshold, AutoTracesAllWhereNothingBoundsAShare) {
  Stage stage(dense_panes());
  RenderOptions weighted = automatic(), front = automatic(), refracted = automatic(), exact = automatic();
  weighted.translucency->oit = SIDERAY_OIT_WEIGHTED;
  front.translucency->oit = SIDERAY_OIT_FRONT;
  refracted.translucency->method = SIDERAY_TRANSLUCENCY_RAYTRACED;
  refracted.translucency->refraction = 1;
  exact.translucency->method = SIDERAY_TRANSLUCENCY_REFERENCE;
  exact.translucency->light_samples = 1;
  expect_unsupported(stage, weighted, "weighted blending bounds no");
  expect_unsupported(stage, front, "weighted blending bounds no");
  EXPECT_EQ(stage.plan(refracted).layer_threshold, 0x1p-10f) << "panes bend nothing";
  expect_unsupported(stage, exact, "shaded as the reference does");
  Stage solids(scenes::generate("solids", {}));
  expect_unsupported(solids, refracted, "along several paths");
  refracted.translucency->layer_threshold = 0.5f;
  expect_unsupported(solids, refracted, "along several paths");
  RenderOptions raster = automatic(), everything = automatic();
  raster.translucency->method = SIDERAY_TRANSLUCENCY_RASTER;
  everything.reference = sideray_reference_defaults();
  EXPECT_EQ(stage.plan(raster).layer_threshold, 0.0f);
  EXPECT_EQ(stage.plan(everything).layer_threshold, 0.0f);
  Stage one_light(scenes::generate("panes", {}));
  expect_unsupported(one_light, automatic(), "under one light");
  sideray_shader_desc shader = sideray_shader_defaults();
  shader.shade = shade_black;
  stage.scene().set_shader(shader);
  stage.scene().commit();
  expect_unsupported(stage, automatic(), "host's shader");
}

TEST(LayerThreshold, RefusesWhereNothingBoundsAShare) {
  Renderer renderer = Renderer::create(sideray_renderer_defaults()).value();
  Scene scene = Scene::create().value();
  const scenes::Content content = scenes::generate("panes", {{"count", "1"}});
  const sideray_camera camera = camera_of(content, {});
  scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
  const auto refused = [&](const auto& change) {
    RenderOptions options = defaults();
    options.translucency->layer_threshold = 0.01f;
    change(options);
    return std::string(renderer.render(scene, camera, options).error().message);
  };
  using testing::HasSubstr;
  EXPECT_THAT(refused([](auto& o) { o.translucency->oit = SIDERAY_OIT_WEIGHTED; }), HasSubstr("oit"));
  EXPECT_THAT(refused([](auto& o) { o.translucency->oit = SIDERAY_OIT_FRONT; }), HasSubstr("oit"));
  EXPECT_THAT(refused([](auto& o) { o.translucency->layer_threshold = -0.5f; }), HasSubstr("layer_threshold"));
  EXPECT_THAT(refused([](auto& o) { o.translucency->layer_threshold = NAN; }), HasSubstr("layer_threshold"));
}

}  // namespace
}  // namespace sideray::tests::layer_needs_test
