#include "model/texture.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace sideray::model {
namespace {

std::vector<uint8_t> noise(size_t texels) {
  std::mt19937 random(7);
  std::vector<uint8_t> rgba(4 * texels);
  for (uint8_t& code : rgba) code = static_cast<uint8_t>(random() % 256);
  return rgba;
}

// For any size the last level is the mean of all texels, here of noise whose left half is brighter.
TEST(Texture, every_texel_counts_alike_in_the_last_level) {
  for (const auto& [width, height] : {std::pair{64u, 32u}, {100u, 100u}, {3u, 3u}, {127u, 5u}, {1u, 7u}, {31u, 1u}}) {
    std::vector<uint8_t> rgba = noise(size_t{width} * height);
    double mean[4] = {};
    for (size_t i = 0; i < rgba.size(); ++i) {
      if (i / 4 % width >= width / 2) rgba[i] /= 4;
      mean[i % 4] += rgba[i] / static_cast<double>(rgba.size() / 4);
    }
    const auto texture = build_texture(width, height, SIDERAY_RGBA8, rgba.data());
    const Texture::Level& last = texture->levels.back();
    ASSERT_EQ(last.rgba.size(), 4u);
    for (size_t c = 0; c < 4; ++c)
      EXPECT_NEAR(last.rgba[c], mean[c], 2.5) << width << "x" << height << " channel " << c;
  }
}

}  // namespace
}  // namespace sideray::model
