#include "rt/masks/coarse_sky.h"

#include <algorithm>
#include <cmath>

namespace sideray::rt {
namespace {

// Samples within this relative difference of depth count as the same surface; others get the small weight.
constexpr float same_depth = 1.0f / 16.0f, share_of_others = 1.0f / 1024.0f;

}  // namespace

void CoarseSky::begin(uint32_t width, uint32_t height) {
  width_ = width, height_ = height;
  tiles_.assign(size_t{tile_count(width)} * tile_count(height), {});
}

SkyShare CoarseSky::at(size_t tile, uint32_t x, uint32_t y, std::span<const float> depths) const {
  const Tile& t = tiles_[tile];
  const uint32_t x0 = x / frame_tile_size * frame_tile_size, y0 = y / frame_tile_size * frame_tile_size;
  const float own = depths[size_t{y} * width_ + x];
  float open = 0.0f, unhidden = 0.0f, sum = 0.0f;
  for (uint32_t i = 0; i < t.samples.size(); ++i) {
    const Sample& sample = t.samples[i];
    if (!sample.exists) continue;
    const uint32_t u = x0 + i % across * step + step / 2, v = y0 + i / across * step + step / 2;
    const float dx = (static_cast<float>(u) - static_cast<float>(x)) / step, dy = (static_cast<float>(v) - static_cast<float>(y)) / step;
    const float apart = std::abs(depths[size_t{v} * width_ + u] - own);
    // The weight falls by three quarters from one sample to the next, so that the mean is smooth and noise averages
    // out.
    const float near = 1.0f / (1.0f + 3.0f * (dx * dx + dy * dy));
    const float weight = near * near * (apart <= same_depth * own ? 1.0f : share_of_others);
    open += weight * sample.share.open;
    unhidden += weight * sample.share.unhidden;
    sum += weight;
  }
  if (!(sum > 0.0f)) return {};
  return {static_cast<uint8_t>(open / sum + 0.5f), static_cast<uint8_t>(unhidden / sum + 0.5f)};
}

}  // namespace sideray::rt
