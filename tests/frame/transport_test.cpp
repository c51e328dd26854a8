// How layers are stored and moved, on whole frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

constexpr float pane_alpha = 0.25f;  // of every pane of the scene

// A layer's radiance is off by 1/511 of its largest component at most; a pane adds at most its alpha of that.
TEST(RadianceFormat, SharedExponentStaysWithinItsBound) {
  const scenes::Content content = scenes::generate("panes", {});
  tests::Setup setup{.width = 160, .height = 90, .aovs = SIDERAY_AOV_LAYERS, .repeats = 1};
  setup.whole_pixels = false;  // they are half floats in either format
  const Frame exact = render(content, setup);
  setup.radiance_format = SIDERAY_RADIANCE_RGB9E5;
  const Frame packed = render(content, setup);
  float largest_error = 0;
  for (size_t i = 0; i < exact.planes.at("R").size(); ++i) {
    float bound = 1e-4f;
    for (uint32_t k = 0; k < setup.layers; ++k) {
      const std::string layer = "layer" + std::to_string(k) + ".";
      float most = 0;
      for (const char* channel : {"R", "G", "B"}) most = std::max(most, exact.planes.at(layer + channel)[i]);
      bound += pane_alpha * most / 511;
    }
    for (const char* channel : {"R", "G", "B"}) {
      const float error = std::abs(packed.planes.at(channel)[i] - exact.planes.at(channel)[i]);
      ASSERT_LE(error, bound + 0x1p-11f * exact.planes.at(channel)[i]) << "pixel " << i;  // pictures are halfs
      largest_error = std::max(largest_error, error);
    }
  }
  EXPECT_GT(largest_error, 0.0f);
  const uint64_t texels = 160 * 90 * 4;
  EXPECT_EQ(exact.stats.bytes_cache, texels * 16);
  EXPECT_EQ(packed.stats.bytes_cache, texels * 12);
  EXPECT_NEAR(static_cast<double>(packed.stats.bytes_upload), 0.75 * static_cast<double>(exact.stats.bytes_upload), 1);
}

// Which way the bytes take is measured, so it must not be seen in the picture.
TEST(Transport, IsNotSeenInThePicture) {
  const scenes::Content content = scenes::generate("panes", {});
  for (const sideray_translucency translucency : {SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_TRANSLUCENCY_RAYTRACED}) {
    tests::Setup setup{.width = 160, .height = 90, .translucency = translucency, .samples = 3};
    setup.radiance_format = SIDERAY_RADIANCE_RGB9E5;
    std::map<std::string, std::vector<float>> copied;
    for (const char* way : {"copy", "persistent", "packed", ""}) {
      setenv("SIDERAY_TRANSPORT", way, 1);
      const Frame frame = render(content, setup);
      if (copied.empty()) copied = frame.planes;
      EXPECT_EQ(frame.planes, copied) << way;
    }
    unsetenv("SIDERAY_TRANSPORT");
  }
}

}  // namespace
}  // namespace sideray::tests
