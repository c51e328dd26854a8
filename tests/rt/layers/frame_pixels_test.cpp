// Which pixels a rate traces, against a walk over all pixels that knows nothing of tiles or blocks.
#include "rt/layers/frame_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <random>

namespace sideray::rt {
namespace {

struct Texel {
  float depth;
  uint32_t stencil;
};

struct Pixels {
  uint32_t width, height;
  std::vector<Texel> texels;
  Pixels(uint32_t w, uint32_t h, uint32_t seed) : width(w), height(h), texels(size_t{w} * h) {
    std::mt19937 random(seed);
    const float depths[] = {0.25f, 0.5f, 0.5f, 1.0f};
    for (Texel& t : texels) t = {depths[random() % 4], random() % 5 == 0 ? static_cast<uint32_t>(random() % 64) : 0u};
  }
  CacheRequest request(sideray_cache_rate rate, sideray_mask_source mask) const {
    CacheRequest r;
    r.width = width, r.height = height;
    r.depth = {reinterpret_cast<const std::byte*>(texels.data()), size_t{width} * sizeof(Texel), DepthFormat::d32f_s8};
    r.mask = mask;
    r.cache_rate = rate;
    return r;
  }
  const Texel& at(uint32_t x, uint32_t y) const { return texels[size_t{y} * width + x]; }
};

using Traced = std::map<std::pair<uint32_t, uint32_t>, PixelRequest>;

Traced gather(const CacheRequest& request, FramePixels& frame) {
  Executor executor(1);
  gather_pixels(request, selection_of(request), executor, frame);
  Traced traced;
  for (const PixelRequest& p : frame.pixels)
    EXPECT_TRUE(traced.insert({{p.x, p.y}, p}).second) << "twice: " << p.x << "," << p.y;
  return traced;
}

// The traced pixel whose cell holds (x, y), from the pictures in docs/cli.md; none at the left border of odd rows of a
// checkerboard.
std::optional<std::pair<uint32_t, uint32_t>> owner(sideray_cache_rate rate, uint32_t x, uint32_t y) {
  switch (rate) {
    case SIDERAY_RATE_CHECKERBOARD:
      if ((x + y) % 2 == 0) return {{x, y}};
      if (x == 0) return {};
      return {{x - 1, y}};
    case SIDERAY_RATE_INTERLEAVED:
      return {{x, y - y % 2}};
    case SIDERAY_RATE_QUARTER:
      return {{x - x % 2, y - y % 2}};
    default:
      return {{x, y}};
  }
}

uint32_t layers_of(const CacheRequest& r, const Texel& t) {
  if (r.mask == SIDERAY_MASK_NONE) return r.max_layers;
  if (t.stencil == 0) return 0;
  return r.mask == SIDERAY_MASK_COUNT && t.stencil != 0x3f ? std::min(t.stencil, r.max_layers) : r.max_layers;
}

class RatePixels : public testing::TestWithParam<sideray_cache_rate> {};

TEST_P(RatePixels, TracesTheOrOfEachCellWhereThatCanBeOfUse) {
  for (const sideray_mask_source mask : {SIDERAY_MASK_NONE, SIDERAY_MASK_STENCIL, SIDERAY_MASK_COUNT})
    for (const auto& [w, h] : {std::pair{1u, 1u}, {2u, 1u}, {3u, 5u}, {64u, 32u}, {67u, 45u}}) {
      const Pixels pixels(w, h, w + h);
      const CacheRequest request = pixels.request(GetParam(), mask);
      FramePixels frame;
      const Traced traced = gather(request, frame);
      struct Wanted {
        uint32_t layers = 0;
        float end = 0;
      };
      std::map<std::pair<uint32_t, uint32_t>, Wanted> wanted;
      uint64_t masked = 0, requested = 0;
      for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x) {
          const uint32_t layers = layers_of(request, pixels.at(x, y));
          masked += layers > 0, requested += layers;
          const auto o = owner(GetParam(), x, y);
          if (!o || layers == 0) continue;
          const float own = pixels.at(o->first, o->second).depth, here = pixels.at(x, y).depth;
          if (*o != std::pair(x, y) && here <= own) continue;
          Wanted& cell = wanted[*o];
          cell.layers = std::max(cell.layers, layers);
          cell.end = std::max({cell.end, own, here});
        }
      ASSERT_EQ(traced.size(), wanted.size()) << w << "x" << h;
      for (const auto& [pixel, expected] : wanted) {
        ASSERT_TRUE(traced.contains(pixel));
        EXPECT_EQ(traced.at(pixel).layers, expected.layers);
        EXPECT_EQ(pixels.at(traced.at(pixel).end_x, traced.at(pixel).end_y).depth, expected.end);
      }
      EXPECT_EQ(frame.masked, masked);
      EXPECT_EQ(frame.requested, requested);
    }
}

TEST_P(RatePixels, SixteenInARowAreABlock) {
  const Pixels pixels(64, 64, 7);
  FramePixels frame;
  gather(pixels.request(GetParam(), SIDERAY_MASK_NONE), frame);
  ASSERT_EQ(frame.pixels.size() % 16, 0u);
  const RatePattern pattern = pattern_of(GetParam());
  for (size_t i = 0; i < frame.pixels.size(); i += 16) {
    const auto [left, right] = std::minmax_element(&frame.pixels[i], &frame.pixels[i] + 16,
                                                   [](const auto& a, const auto& b) { return a.x < b.x; });
    const auto [low, high] = std::minmax_element(&frame.pixels[i], &frame.pixels[i] + 16,
                                                 [](const auto& a, const auto& b) { return a.y < b.y; });
    EXPECT_LT(right->x - left->x, 4 * static_cast<int>(pattern.cell_width));
    EXPECT_LT(high->y - low->y, 4 * static_cast<int>(pattern.cell_height));
  }
}

TEST_P(RatePixels, ASecondWaveIsWhatIsAskedFor) {
  Pixels pixels(67, 45, 3);
  for (const auto& [x, y] : {std::pair{1u, 0u}, {66u, 44u}, {30u, 31u}})
    pixels.texels[size_t{y} * 67 + x].stencil = 0x40 | 3;
  pixels.texels[0].stencil = 0x40;  // asked for, but the mask has nothing there
  CacheRequest request = pixels.request(GetParam(), SIDERAY_MASK_COUNT);
  request.requested_bits = 0x40;
  FramePixels frame;
  const Traced traced = gather(request, frame);
  EXPECT_EQ(traced.size(), 3u);
  for (const auto& [pixel, p] : traced) {
    EXPECT_EQ(pixels.at(p.x, p.y).stencil, 0x43u);
    EXPECT_EQ(p.layers, 3u);
    EXPECT_EQ(std::pair(p.end_x, p.end_y), std::pair(p.x, p.y));
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, RatePixels,
                         testing::Values(SIDERAY_RATE_FULL, SIDERAY_RATE_CHECKERBOARD, SIDERAY_RATE_INTERLEAVED,
                                         SIDERAY_RATE_QUARTER));

}  // namespace
}  // namespace sideray::rt
