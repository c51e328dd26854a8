// With a layer threshold no pixel of any picture is farther off than it promises, and rays are spared.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

constexpr uint32_t width = 64, height = 36;
constexpr float counted_threshold = 1.0f / 255.0f;
constexpr float thresholds[] = {1e-4f, counted_threshold, 1.0f / 16.0f};

// One scene drawn again and again by one renderer.
class Stage {
 public:
  explicit Stage(const scenes::Content& content, uint32_t threads = 0) : renderer_(with_threads(threads)) {
    const scenes::Sky sky = scenes::sky();
    scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    camera_ = camera_of(content, {.width = width, .height = height});
    scenes::fill(scene_, content, scenes::select_ray_traced(content, "all", camera_, width, height));
  }

  struct Drawn {
    std::vector<float> rgb;
    sideray_render_stats stats;
    uint64_t rays() const { return stats.rays_primary + stats.rays_reflection + stats.rays_shadow; }
  };
  // Only counted pictures have statistics.
  Drawn draw(RenderOptions options, bool counted) {
    options.picture.width = width;
    options.picture.height = height;
    options.picture.repeats = counted ? 1 : 0;
    const Picture picture = renderer_.render(scene_, camera_, options).value();
    Drawn drawn{{}, picture.stats()};
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const std::string name = channel.name;
      if (name != "R" && name != "G" && name != "B") continue;
      const auto* values = static_cast<const float*>(channel.values);
      drawn.rgb.insert(drawn.rgb.end(), values, values + size_t{width} * height);
    }
    return drawn;
  }

 private:
  static Renderer with_threads(uint32_t threads) {
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.threads = threads;
    return Renderer::create(desc).value();
  }

  Renderer renderer_;
  Scene scene_ = Scene::create().value();
  sideray_camera camera_{};
};

struct Mode {
  const char* name;
  RenderOptions options;
};

RenderOptions defaults() {
  RenderOptions o;
  o.shadows->method = SIDERAY_SHADOWS_MAP;
  o.translucency->layers = 8;
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

// Pictures at all thresholds, in all modes, against the one of threshold 0. Returns the share of rays spared at 1/255.
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
      expect_bound(panes(8, [](sideray_material_desc& d, int i) { d.base_color[3] = i % 3 == 0 ? 0.995f : 0.9f; }));
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
  }));
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
    return renderer.render(scene, camera, options).error().message;
  };
  using testing::HasSubstr;
  EXPECT_THAT(refused([](auto& o) { o.translucency->oit = SIDERAY_OIT_WEIGHTED; }), HasSubstr("oit"));
  EXPECT_THAT(refused([](auto& o) { o.translucency->oit = SIDERAY_OIT_FRONT; }), HasSubstr("oit"));
  EXPECT_THAT(refused([](auto& o) { o.translucency->layer_threshold = -1.0f; }), HasSubstr("layer_threshold"));
  EXPECT_THAT(refused([](auto& o) { o.translucency->layer_threshold = NAN; }), HasSubstr("layer_threshold"));
  EXPECT_THAT(refused([](auto& o) {
                o.translucency->method = SIDERAY_TRANSLUCENCY_RAYTRACED;
                o.translucency->refraction = 1;
              }),
              HasSubstr("refraction"));
}

}  // namespace
}  // namespace sideray::tests
