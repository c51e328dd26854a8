// Bounds of alpha hold what look-ups read: every wrap and filter, sizes that cells do not divide, and the ends.
#include "rt/textures/alpha_grid.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "rt/textures/texture_sample.h"

namespace sideray::rt {
namespace {

model::Texture leaf_like(uint32_t width, uint32_t height, std::mt19937& random) {
  model::Texture texture;
  texture.levels.push_back({width, height, std::vector<uint8_t>(size_t{4} * width * height, 255)});
  // Squares of a few texels, so that some cells are one value and some are not.
  std::vector<uint8_t> values((width / 5 + 1) * (height / 5 + 1));
  for (uint8_t& v : values) v = static_cast<uint8_t>(random() % 3 ? 255 * (random() % 2) : random() % 256);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      texture.levels[0].rgba[4 * (y * width + x) + 3] = values[y / 5 * (width / 5 + 1) + x / 5];
  return texture;
}

TEST(AlphaGrid, bounds_hold_every_look_up) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> anywhere(-2.5f, 2.5f);
  const std::array<float, 9> ends{-1.0f, -0.5f, -1e-9f, 0.0f, 1e-9f, 0.5f, 1.0f, 1.5f, 2.0f};
  size_t narrow = 0, all = 0;
  for (const glm::uvec2 size : {glm::uvec2(1, 1), glm::uvec2(3, 2), glm::uvec2(5, 64), glm::uvec2(67, 33)}) {
    const model::Texture texture = leaf_like(size.x, size.y, random);
    const AlphaGrid grid(texture.levels[0]);
    for (const sideray_wrap wrap_u : {SIDERAY_REPEAT, SIDERAY_CLAMP, SIDERAY_MIRROR})
      for (const sideray_wrap wrap_v : {SIDERAY_REPEAT, SIDERAY_CLAMP, SIDERAY_MIRROR})
        for (const sideray_filter filter : {SIDERAY_NEAREST, SIDERAY_TRILINEAR})
          for (int i = 0; i < 2000; ++i) {
            const sideray_texture_slot slot{1, 0, wrap_u, wrap_v, filter, {1, 0, 0, 1, 0, 0}};
            const bool at_end = i % 4 == 0;
            const glm::vec2 uv(at_end ? ends[random() % ends.size()] : anywhere(random),
                               i % 8 == 0 ? ends[random() % ends.size()] : anywhere(random));
            const float alpha = sample_alpha(texture, slot, uv, 0.0f);
            const AlphaRange range = alpha_range(grid, slot, uv);
            ASSERT_LE(range.least, alpha) << size.x << " at " << uv.x << ", " << uv.y << " wraps " << wrap_u << wrap_v;
            ASSERT_GE(range.most, alpha) << size.x << " at " << uv.x << ", " << uv.y << " wraps " << wrap_u << wrap_v;
            narrow += range.most - range.least < 0.5f, ++all;
          }
  }
  EXPECT_GT(narrow * 8, all);  // they say something
}

// Alpha alone is what a look-up of all channels reads, at every mip level.
TEST(AlphaGrid, alpha_has_the_bits_of_colour) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> anywhere(-2.5f, 2.5f), level(-1.0f, 4.0f);
  model::Texture texture;
  for (const uint32_t size : {16u, 8u, 4u}) texture.levels.push_back(leaf_like(size, size, random).levels[0]);
  for (const sideray_wrap wrap : {SIDERAY_REPEAT, SIDERAY_CLAMP, SIDERAY_MIRROR})
    for (const sideray_filter filter : {SIDERAY_NEAREST, SIDERAY_TRILINEAR})
      for (int i = 0; i < 2000; ++i) {
        const sideray_texture_slot slot{1, 0, wrap, wrap, filter, {1, 0, 0, 1, 0, 0}};
        const glm::vec2 uv(anywhere(random), anywhere(random));
        const float at = i % 3 == 0 ? std::floor(level(random)) : level(random);
        ASSERT_EQ(sample_alpha(texture, slot, uv, at), sample(texture, slot, uv, at).w) << uv.x << ", " << uv.y << " level " << at;
      }
}

}  // namespace
}  // namespace sideray::rt
