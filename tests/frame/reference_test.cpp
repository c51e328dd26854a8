// Compares the reference with the other ways of drawing where they must agree.
#include <gtest/gtest.h>

#include <cmath>

#include "frame/frame.h"
#include "lab/metrics/metrics.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

double relmse(const Frame& test, const Frame& reference) {
  const std::vector<float> x = test.rgb(), r = reference.rgb();
  double sum = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double difference = static_cast<double>(x[i] - r[i]), value = static_cast<double>(r[i]);
    sum += difference * difference / (value * value + 0.01);
  }
  return sum / static_cast<double>(x.size());
}

scenes::Content without_light_sizes(const char* name) {
  scenes::Content content = scenes::generate(name, {});
  for (scenes::Light& light : content.lights) light.light.radius = light.light.angular_diameter_deg = 0;
  return content;
}

// Without shadows, an environment and light sizes nothing is sampled: only texture filters and edges differ. Measured:
// 4.8e-5 (empty) and 3.9e-5 (panes).
TEST(Reference, EqualsRasterWhereThatTakesNoShortcuts) {
  for (const char* name : {"empty", "panes"}) {
    const scenes::Content content = without_light_sizes(name);
    tests::Setup setup{.width = 160, .height = 90, .translucency = SIDERAY_TRANSLUCENCY_RASTER};
    setup.shadows = SIDERAY_SHADOWS_OFF;
    setup.samples = 4;
    setup.sky = false;
    const Frame raster = render(content, setup);
    setup.reference = true;
    setup.light_samples = 2;
    const Frame reference = render(content, setup);
    EXPECT_LT(relmse(raster, reference), 1e-4) << name;
  }
}

// The reference samples the sky, for which raster has lookups. With more samples the difference falls to the error of
// the lookups.
TEST(Reference, ConvergesTowardRasterAsSamplesGrow) {
  const scenes::Content content = without_light_sizes("empty");
  tests::Setup setup{.width = 80, .height = 45, .translucency = SIDERAY_TRANSLUCENCY_RASTER};
  setup.shadows = SIDERAY_SHADOWS_OFF;
  const Frame raster = render(content, setup);
  setup.reference = true;
  double before = INFINITY;
  for (const uint32_t samples : {2u, 8u, 64u}) {
    setup.light_samples = samples;
    const Frame reference = render(content, setup);
    const double error = relmse(raster, reference);
    EXPECT_LT(error, before) << samples;
    if (samples > 2) {
      EXPECT_LT(reference.stats.reference_self_error, 0.1) << samples;
    }
    before = error;
    RecordProperty("relmse" + std::to_string(samples), std::to_string(error));
    if (samples == 64) {
      EXPECT_LT(error, 2e-3);
    }
  }
}

// The same layers through the service, over the rasterizer's opaque picture.
TEST(Reference, OfTheLayersAloneIsTheSamePicture) {
  const scenes::Content content = without_light_sizes("panes");
  tests::Setup setup{.width = 160, .height = 90, .translucency = SIDERAY_TRANSLUCENCY_REFERENCE};
  setup.shadows = SIDERAY_SHADOWS_OFF;
  setup.sky = false;
  setup.samples = 4;
  setup.light_samples = 2;
  const Frame layers = render(content, setup);
  EXPECT_EQ(layers.stats.reference_light_samples, 2u);
  setup.reference = true;
  EXPECT_LT(relmse(layers, render(content, setup)), 1e-4);
}

TEST(Reference, AovsAreThoseOfTheGBuffer) {
  const scenes::Content content = without_light_sizes("empty");
  tests::Setup setup{.width = 160, .height = 90, .translucency = SIDERAY_TRANSLUCENCY_RASTER};
  setup.aovs = SIDERAY_AOV_Z | SIDERAY_AOV_NORMAL | SIDERAY_AOV_ID;
  const Frame raster = render(content, setup);
  setup.reference = true;
  setup.light_samples = 1;
  const Frame reference = render(content, setup);
  size_t same = 0;
  const std::vector<uint32_t>&a = raster.uint_planes.at("id.surface"), &b = reference.uint_planes.at("id.surface");
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] != b[i] || raster.uint_planes.at("id.primitive")[i] != reference.uint_planes.at("id.primitive")[i])
      continue;
    ++same;
    const float z = raster.planes.at("Z")[i];
    if (std::isinf(z)) {
      EXPECT_EQ(reference.planes.at("Z")[i], z);
    } else {
      EXPECT_NEAR(reference.planes.at("Z")[i], z, 1e-3f * z);
    }
    EXPECT_NEAR(raster.planes.at("N.Y")[i], reference.planes.at("N.Y")[i], 0.05f);
  }
  EXPECT_GT(static_cast<double>(same) / static_cast<double>(a.size()), 0.995);
  EXPECT_LT(reference.stats.reference_self_error, 0.0);  // one sample has no halves
}

}  // namespace
}  // namespace sideray::tests
