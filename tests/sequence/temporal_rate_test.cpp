// Temporal cache rates, and rays that are reused, over a moving camera: error and flicker against full tracing, and what they save. Prints the
// table of docs/translucency.md; script/temporal runs it at the size given there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <sideray/sideray.hpp>

#include "lab/metrics/flicker.h"
#include "lab/metrics/metrics.h"
#include "scenes/builtin/builtin.h"
#include "scenes/content/content.h"

namespace sideray::tests::temporal_rate_test {
namespace {

uint32_t setting(const char* name, uint32_t otherwise) {
  const char* text = std::getenv(name);
  return text ? static_cast<uint32_t>(std::atoi(text)) : otherwise;
}

// A scene and a renderer that draw a sequence in one way.
class Sequence {
 public:
  Sequence(const scenes::Content& content, bool refraction, sideray_translucency translucency, sideray_cache_rate rate,
           float ray_reuse = 0.0f, float shading_reuse = 0.0f)
      : scene_(Scene::create().value()), renderer_(Renderer::create().value()) {
    options_.picture.width = setting("SIDERAY_SEQUENCE_WIDTH", 320);
    options_.picture.height = setting("SIDERAY_SEQUENCE_HEIGHT", 180);
    options_.picture.ao = options_.picture.reflections = 0;
    options_.translucency->refraction = refraction;
    options_.translucency->method = translucency;
    options_.translucency->cache_rate = rate;
    options_.translucency->ray_reuse = ray_reuse;
    options_.translucency->shading_reuse = shading_reuse;
    options_.picture.repeats = 1;
    options_.shadows->method = SIDERAY_SHADOWS_MAP;  // so that all rays are those of layers
    const scenes::Sky sky = scenes::sky();
    scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    scenes::fill(
        scene_, content,
        scenes::select_ray_traced(content, "auto", content.cameras[0].camera, options_.picture.width,
                                  options_.picture.height));
  }

  scenes::Image draw(const sideray_camera& camera) {
    const Picture picture = renderer_.render(scene_, camera, options_).value();
    const sideray_render_stats stats = picture.stats();
    trace_ms.push_back(picture.stage(SIDERAY_STAGE_TRACE).median);
    if (options_.picture.continues) rays += stats.rays_primary + stats.rays_reflection + stats.rays_shadow;
    options_.picture.continues = 1;
    scenes::Image image{picture.width(), picture.height(), {}, true};
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const auto* values = static_cast<const float*>(channel.values);
      image.planes.push_back({channel.name,
                              scenes::Plane::Type::half,
                              std::vector<float>(values, values + size_t{image.width} * image.height),
                              {}});
    }
    return image;
  }

  std::vector<double> trace_ms;
  uint64_t rays = 0;  // of all frames but the first

 private:
  Scene scene_;
  Renderer renderer_;
  RenderOptions options_;
};

struct Row {
  const char* name;
  Sequence sequence;
  lab::FlickerMeter meter = {};
  double flip = 0, relmse = 0, worst_flip = 0;
};

const sideray_camera& dolly(const scenes::Content& content) {
  return std::find_if(content.cameras.begin(), content.cameras.end(),
                      [](const scenes::Camera& c) { return c.name == "dolly"; })
      ->camera;
}

void print(Row& row, uint32_t frames) {
  std::sort(row.sequence.trace_ms.begin(), row.sequence.trace_ms.end());
  const lab::Flicker flicker = row.meter.result();
  fmt::print("{:<10} {:>9.1f} {:>10} {:>8.4f} {:>8.4f} {:>9.5f} {:>10.2e} {:>10.2e} {:>10.2e}\n", row.name,
             row.sequence.trace_ms[row.sequence.trace_ms.size() / 2], row.sequence.rays / (frames - 1),
             row.flip / frames, row.worst_flip, row.relmse / frames, flicker.excess_energy(), flicker.error_energy,
             flicker.excess_variance);
}

// What is compared, over one sequence.
struct Rows {
  Row full, temporal4, temporal8, reusing, kept, raster;

  Rows(const scenes::Content& content, bool refraction)
      : full{"full", {content, refraction, SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_RATE_FULL}},
        temporal4{"temporal4", {content, refraction, SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_RATE_TEMPORAL4}},
        temporal8{"temporal8", {content, refraction, SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_RATE_TEMPORAL8}},
        reusing{"ray-reuse", {content, refraction, SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_RATE_FULL, 0x1p-6f}},
        kept{"shading", {content, refraction, SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_RATE_FULL, 0x1p-6f, 0x1p-8f}},
        raster{"raster", {content, refraction, SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_RATE_FULL}} {}
};

Rows over_a_dolly(bool refraction) {
  scenes::Content content = scenes::generate("bistro", {});
  const uint32_t frames = setting("SIDERAY_SEQUENCE_FRAMES", 16);
  Rows rows(content, refraction);
  for (uint32_t frame = 0; frame < frames; ++frame) {
    scenes::pose(content, frame / 30.0);
    const scenes::Image wanted = rows.full.sequence.draw(dolly(content));
    rows.full.meter.add(wanted, wanted);
    for (Row* row : {&rows.temporal4, &rows.temporal8, &rows.reusing, &rows.kept, &rows.raster}) {
      const scenes::Image drawn = row->sequence.draw(dolly(content));
      row->meter.add(drawn, wanted);
      const lab::Metrics metrics = lab::compare(drawn, wanted).metrics;
      row->flip += metrics.flip.value();
      row->worst_flip = std::max(row->worst_flip, metrics.flip.value());
      row->relmse += metrics.relmse_trimmed.value();
    }
  }
  fmt::print("--refraction {}\n", refraction ? "on" : "off");
  fmt::print("rate        trace ms rays/frame     flip  worst    relmse-t  flicker+   of error  variance+\n");
  for (Row* row : {&rows.full, &rows.temporal4, &rows.temporal8, &rows.reusing, &rows.kept, &rows.raster})
    print(*row, frames);
  return rows;
}

TEST(TemporalRate, ErrorAndFlickerAgainstFullTracingOverADolly) {
  const Rows rows = over_a_dolly(false);
  // Primary rays stay; of the rest a share and what was hidden are traced.
  EXPECT_LT(rows.temporal4.sequence.rays, rows.full.sequence.rays * 2 / 5);
  EXPECT_LT(rows.temporal8.sequence.rays, rows.temporal4.sequence.rays);
  EXPECT_LT(rows.temporal4.flip, rows.temporal8.flip);
  EXPECT_LT(rows.reusing.sequence.rays, rows.full.sequence.rays * 3 / 5);
  EXPECT_LT(rows.reusing.flip, rows.temporal4.flip) << "no light is old";
  EXPECT_LT(rows.kept.sequence.rays, rows.reusing.sequence.rays);
  EXPECT_LT(rows.temporal8.flip, rows.raster.flip / 2) << "what is left of rays must be worth them";
}

// Along bent paths temporal rates take nothing over: they save less there, and err less.
TEST(TemporalRate, ErrorAndFlickerAlongBentPaths) {
  const Rows rows = over_a_dolly(true);
  EXPECT_LT(rows.temporal4.sequence.rays, rows.full.sequence.rays);
  EXPECT_LT(rows.temporal8.sequence.rays, rows.temporal4.sequence.rays);
  EXPECT_LT(rows.temporal4.flip, rows.temporal8.flip);
  EXPECT_LT(rows.reusing.sequence.rays, rows.temporal8.sequence.rays) << "ray reuse follows every path";
  EXPECT_LT(rows.kept.sequence.rays, rows.reusing.sequence.rays);
  for (const Row* row : {&rows.temporal8, &rows.reusing, &rows.kept})
    EXPECT_LT(row->flip, rows.raster.flip / 2) << row->name;
}

}  // namespace
}  // namespace sideray::tests::temporal_rate_test
