// Measures errors of shadows and ambient occlusion by rays that hit other poses than the drawn ones: compares each
// pixel of a plant with the same ray through exact poses. Prints the tables of docs/foliage.md; script/tables/foliage
// runs it at the size given there.
#include <sideray/diagnostics.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <sideray/sideray.hpp>

#include "lab/metrics/flicker.h"
#include "scenes/builtin/builtin.h"
#include "scenes/builtin/paint.h"
#include "scenes/content/content.h"
#include "scenes/content/shapes.h"

namespace sideray::tests {
namespace {

uint32_t setting(const char* name, uint32_t otherwise) {
  const char* text = std::getenv(name);
  return text ? static_cast<uint32_t>(std::atoi(text)) : otherwise;
}

struct Way {
  const char* name;
  sideray_shadows shadows = SIDERAY_SHADOWS_EXACT;
  sideray_inexact inexact = SIDERAY_INEXACT_RESTPOSE;
  uint32_t poses = SIDERAY_POSES_REST;
};
constexpr Way truth_way{.name = "exact poses", .poses = SIDERAY_POSES_ALL};
constexpr sideray_shadows inexact_rays = SIDERAY_SHADOWS_INEXACT;

// Holds one value for each pixel that shows a surface; compared masks have the same pixels.
struct Masks {
  std::vector<float> lit, color;
  std::vector<bool> seen;
};

// Returns content whose colours show only the sky's visibility: diffuse, with a sun that is too weak to see but has a
// mask.
scenes::Content bare(scenes::Content content) {
  for (scenes::Material& m : content.materials) {
    m.desc.specular = m.desc.metallic = m.desc.diffuse_transmission = 0;
    for (float& c : m.desc.emissive) c = 0;
  }
  for (scenes::Light& l : content.lights)
    for (float& c : l.light.intensity) c = 1e-12f;
  return content;
}

class Sequence {
 public:
  Sequence(const scenes::Content& content, const sideray_camera& camera, const Way& way, bool occluded = true)
      : scene_(Scene::create().value()),
        renderer_(Renderer::create().value()),
        camera_(camera) {
    options_.picture.width = setting("SIDERAY_SEQUENCE_WIDTH", 160);
    options_.picture.height = setting("SIDERAY_SEQUENCE_HEIGHT", 90);
    options_.shadows->method = occluded ? way.shadows : SIDERAY_SHADOWS_OFF;
    options_.shadows->inexact = way.inexact;
    options_.poses->poses = way.poses;
    options_.poses->cull_angle_deg = 0;
    options_.picture.ambient = occluded;
    options_.picture.reflections = 0;
    options_.picture.denoise = 0;
    options_.picture.aovs = SIDERAY_AOV_Z | (occluded ? uint32_t{SIDERAY_AOV_SHADOW} : 0u);
    const scenes::Sky sky = scenes::sky();
    scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    scenes::fill(scene_, content, std::vector<bool>(content.objects.size(), false));
  }

  // The same seed gives the same points of the light and the sky to every sequence.
  Masks draw(double time_s, uint32_t seed) {
    scene_.set_time(time_s, time_s);
    scene_.commit();
    options_.picture.seed = seed;
    const Picture picture = renderer_.render(scene_, camera_, options_).value();
    Masks masks;
    const size_t pixels = size_t{picture.width()} * picture.height();
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const auto* values = static_cast<const float*>(channel.values);
      const std::string name = channel.name;
      if (name == "G") masks.color.assign(values, values + pixels);
      if (name == "shadow.0") masks.lit.assign(values, values + pixels);
      if (name == "Z")
        for (size_t k = 0; k < pixels; ++k) masks.seen.push_back(std::isfinite(values[k]));
    }
    return masks;
  }

 private:
  Scene scene_;
  Renderer renderer_;
  sideray_camera camera_;
  RenderOptions options_;
};

// Shares of rays, over the pixels that show a surface.
struct Rates {
  double dark = 0, lit = 0, rays = 0;  // sums
  lab::FlickerMeter meter = {};

  void add(const std::vector<float>& test, const std::vector<float>& truth, const std::vector<bool>& seen) {
    for (size_t i = 0; i < test.size(); ++i) {
      if (!seen[i]) continue;
      const double more = double{test[i]} - double{truth[i]};
      dark += std::max(-more, 0.0), lit += std::max(more, 0.0), rays += 1;
    }
  }
  void add_to_meter(const std::vector<float>& test, const std::vector<float>& truth, uint32_t width) {
    const auto image = [&](const std::vector<float>& values) {
      scenes::Image result{width, static_cast<uint32_t>(values.size() / width), {}, false};
      for (const char* name : {"R", "G", "B"}) result.planes.push_back({name, scenes::Plane::Type::single, values, {}});
      return result;
    };
    meter.add(image(test), image(truth));
  }
  std::string cells() const {
    const lab::Flicker flicker = meter.result();
    return fmt::format("{:.2f} % | {:.2f} % | {:+.4f} | {:.4f} |", 100 * dark / rays, 100 * lit / rays,
                       flicker.excess_energy(), flicker.error_energy);
  }
};

// Returns the sky's visibility: its light as a share of the unoccluded light.
std::vector<float> openness(const Masks& masks, const Masks& unoccluded) {
  std::vector<float> open(masks.color.size(), 1.0f);
  for (size_t i = 0; i < open.size(); ++i)
    if (masks.seen[i] && unoccluded.color[i] > 0) open[i] = masks.color[i] / unoccluded.color[i];
  return open;
}

struct Row {
  Way way;
  Rates shadow = {}, open = {};
  std::unique_ptr<Sequence> sequence = {};
};

const sideray_camera& camera_named(const scenes::Content& content, const char* name) {
  return std::find_if(content.cameras.begin(), content.cameras.end(),
                      [&](const scenes::Camera& c) { return c.name == name; })
      ->camera;
}

TEST(FoliageStreaks, RatesAndFlickerOfAForestInWind) {
  const scenes::Content content = bare(scenes::generate("forest", {}));
  const sideray_camera& camera = camera_named(content, "closeup");
  const uint32_t frames = setting("SIDERAY_SEQUENCE_FRAMES", 4), width = setting("SIDERAY_SEQUENCE_WIDTH", 160);
  std::vector<Row> rows;
  for (const Way& way :
       {Way{.name = "`exact`"},
        {.name = "`origin`, B = 0.5", .shadows = inexact_rays, .inexact = SIDERAY_INEXACT_ORIGIN},
        {.name = "`tmin`, B = 0.5", .shadows = inexact_rays, .inexact = SIDERAY_INEXACT_TMIN},
        {.name = "`bounded`", .shadows = inexact_rays, .inexact = SIDERAY_INEXACT_BOUNDED},
        {.name = "`restpose`", .shadows = inexact_rays},
        {.name = "`restpose`, one shared pose", .shadows = inexact_rays, .poses = 1}})
    rows.push_back({.way = way, .sequence = std::make_unique<Sequence>(content, camera, way)});
  Sequence truth(content, camera, truth_way), unoccluded(content, camera, truth_way, false);
  for (uint32_t frame = 0; frame < frames; ++frame) {
    const double time = frame / 30.0;
    const Masks wanted = truth.draw(time, frame + 1), light = unoccluded.draw(time, frame + 1);
    const std::vector<float> wanted_open = openness(wanted, light);
    for (Row& row : rows) {
      const Masks drawn = row.sequence->draw(time, frame + 1);
      const std::vector<float> open = openness(drawn, light);
      row.shadow.add(drawn.lit, wanted.lit, wanted.seen), row.open.add(open, wanted_open, wanted.seen);
      row.shadow.add_to_meter(drawn.lit, wanted.lit, width), row.open.add_to_meter(open, wanted_open, width);
    }
  }
  fmt::print(
      "| rays | false shadow | false lit | flicker | of error | AO: false dark | false open | flicker | of error |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows) fmt::print("| {} | {} {}\n", row.way.name, row.shadow.cells(), row.open.cells());
  const lab::Flicker own = rows[0].shadow.meter.result(), own_open = rows[0].open.meter.result();
  fmt::print("\nExact poses themselves flicker by {:.4f} (shadows) and {:.4f} (ambient occlusion).\n",
             own.reference_energy, own_open.reference_energy);
  const Rates &exact = rows[0].shadow, &rest = rows[4].shadow;
  EXPECT_LT(rest.dark / rest.rays, exact.dark / exact.rays) << "false shadows are what the rest pose takes away";
  EXPECT_LT(rest.dark + rest.lit, exact.dark + exact.lit);
}

// Single cards far apart, so that none stands in another's light: every dark pixel is a card's shadow on itself.
scenes::Content cards() {
  scenes::ContentBuilder b("cards");
  const uint32_t card = b.mesh(
      scenes::Shape().sheet(6, 16, [](float u, float v) { return glm::vec3(0.6f * (u - 0.5f), 1.2f * v, 0); }), "card");
  sideray_material_desc leaf = scenes::opaque_material(glm::vec3(0.4f), 1.0f);
  leaf.double_sided = 1;
  const uint32_t material = b.material("card", leaf);
  sideray_wind_desc breeze = sideray_wind_defaults();
  breeze.height = 1.2f, breeze.amplitude = 0.25f, breeze.frequency = 0.4f;
  breeze.branch_amplitude = 0.04f, breeze.branch_frequency = 0.9f, breeze.leaf_amplitude = 0.01f;
  breeze.wavelength = 0.9f;
  const uint32_t wind = b.wind(breeze);
  for (uint32_t i = 0; i < 64; ++i) {
    const double x = 3.0 * (i % 8) - 10.5, z = -4.0 * (i / 8);
    const glm::dmat4 at =
        glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(x, 0, z)), 0.1 * (i % 7) - 0.3, glm::dvec3(0, 1, 0));
    b.object("card", card, material, at, wind, scenes::hash01(i, 1));
  }
  b.light("sun", scenes::sun_light({-0.3f, -0.8f, -0.52f}, {3, 3, 3}));
  const double eye[] = {0, 3.0, 9}, target[] = {0, 0.2, -6};
  b.camera("front", scenes::look_at(eye, target, 50.0f));
  return b.take();
}

// At a fixed time only the seed changes between pictures: variation beyond the truth's is noise.
TEST(FoliageStreaks, CardsDoNotShadowThemselvesFromTheRestPose) {
  const scenes::Content content = cards();
  const sideray_camera& camera = content.cameras[0].camera;
  const uint32_t seeds = 4, width = setting("SIDERAY_SEQUENCE_WIDTH", 160);
  std::vector<Row> rows;
  for (const Way& way :
       {Way{.name = "`exact`"},
        {.name = "`tmin`, B = 0.5", .shadows = inexact_rays, .inexact = SIDERAY_INEXACT_TMIN},
        {.name = "`bounded`", .shadows = inexact_rays, .inexact = SIDERAY_INEXACT_BOUNDED},
        {.name = "`restpose`", .shadows = inexact_rays},
        {.name = "`restpose`, one shared pose", .shadows = inexact_rays, .poses = 1}})
    rows.push_back({.way = way, .sequence = std::make_unique<Sequence>(content, camera, way)});
  Sequence truth(content, camera, truth_way);
  double truth_dark = 0, pixels = 0;
  for (const double time : {0.4, 1.3, 2.9})
    for (uint32_t seed = 1; seed <= seeds; ++seed) {
      const Masks wanted = truth.draw(time, seed);
      for (size_t i = 0; i < wanted.lit.size(); ++i)
        if (wanted.seen[i]) truth_dark += 1.0 - double{wanted.lit[i]}, pixels += 1;
      for (Row& row : rows) {
        const Masks drawn = row.sequence->draw(time, seed);
        row.shadow.add(drawn.lit, wanted.lit, wanted.seen);
        if (time == 1.3) row.shadow.add_to_meter(drawn.lit, wanted.lit, width);
      }
    }
  fmt::print("cards: {:.0f} pixels, {:.0f} of them dark with exact poses\n", pixels, truth_dark);
  fmt::print("| rays | false self-shadow | noise of its own |\n|---|---|---|\n");
  for (const Row& row : rows)
    fmt::print("| {} | {:.2e} | {:.2e} |\n", row.way.name, row.shadow.dark / row.shadow.rays,
               row.shadow.meter.result().excess_energy());
  EXPECT_GT(rows[0].shadow.dark / rows[0].shadow.rays, 0.05) << "or there is nothing to mend";
  for (const size_t rest : {3u, 4u}) {
    EXPECT_LE(rows[rest].shadow.dark / rows[rest].shadow.rays, 1e-4) << rows[rest].way.name;
    EXPECT_LE(rows[rest].shadow.meter.result().excess_energy(), 1e-4) << rows[rest].way.name;
  }
}

}  // namespace
}  // namespace sideray::tests
