// Samples environments for rt/surfaces/shade_lanes.cpp: float RGB images, bilinearly.
#pragma once

#include "rt/surfaces/block_lanes.h"

namespace sideray::rt::SIDERAY_LANES {

// Holds two neighbouring texels along one axis, and the second one's weight.
struct Pair {
  integer first, second;
  real weight;
};

// Limits x to 0 .. most, and returns 0 where x is NaN: an index made from it stays inside the image.
SIDERAY_LANE real within(real x, float most) {
  return min(max(real(0.0f), x), most);
}

SIDERAY_LANE Pair clamped_pair(real s, int32_t size) {
  const real x = within(s * static_cast<float>(size) - 0.5f, static_cast<float>(size - 1));
  const integer i = truncate(x);
  return {i, min(i + 1, integer(size - 1)), x - to_real(i)};
}

// `s` is within 0..1.
SIDERAY_LANE Pair repeated_pair(real s, int32_t size) {
  const real x = within(s, 1.0f) * static_cast<float>(size) - 0.5f;
  const real base = floor(x);
  const integer i = truncate(base);
  const integer first = sr_select(i < 0, i + size, i), next = i + 1;
  return {first, sr_select(next < size, next, next - size), x - base};
}

SIDERAY_LANE real blend(const float* texels, const integer (&corner)[4], real x, real y) {
  return mix(mix(gather(texels, corner[0]), gather(texels, corner[1]), x),
             mix(gather(texels, corner[2]), gather(texels, corner[3]), x), y);
}

SIDERAY_LANE real3 sample(TexelView image, Pair x, Pair y) {
  const integer row0 = y.first * image.width, row1 = y.second * image.width;
  const integer corner[4] = {(row0 + x.first) * 3, (row0 + x.second) * 3, (row1 + x.first) * 3, (row1 + x.second) * 3};
  return {blend(image.texels, corner, x.weight, y.weight), blend(image.texels + 1, corner, x.weight, y.weight),
          blend(image.texels + 2, corner, x.weight, y.weight)};
}

SIDERAY_LANE real3 sample_latlong(TexelView image, real3 direction) {
  if (image.width == 0) return sr_real3(0.0f);
  if (image.width == 1) return {real(image.texels[0]), real(image.texels[1]), real(image.texels[2])};  // is_uniform()
  const real2 uv = sr_latlong(direction);
  return sample(image, repeated_pair(uv.x, image.width), clamped_pair(uv.y, image.height));
}

// Holds sixteen bilinear look-ups: the level, the texels, and the weights of the second ones.
struct alignas(64) SpecularBlock {
  int32_t level[block_size], corner[4][block_size];
  BlockRow x, y;
};

SIDERAY_LANE integer load_indices(const int32_t* values) {
  return integer(*reinterpret_cast<const IntVector*>(values));
}
SIDERAY_LANE void store_indices(int32_t* values, integer v) {
  *reinterpret_cast<IntVector*>(values) = v.v;
}

SIDERAY_LANE Pair clamped_pair(real s, real size) {
  const real x = min(max(real(0.0f), s * size - 0.5f), size - 1.0f);
  const integer i = truncate(x), last = truncate(size) - 1;
  return {i, min(i + 1, last), x - to_real(i)};
}

SIDERAY_LANE Pair repeated_pair(real s, real size) {
  const real x = within(s, 1.0f) * size - 0.5f;
  const real base = floor(x);
  const integer i = truncate(base), count = truncate(size);
  const integer first = sr_select(i < 0, i + count, i), next = i + 1;
  return {first, sr_select(next < count, next, next - count), x - base};
}

SIDERAY_LANE void find_texels(const EnvironmentLevels& levels, const BlockRow (&uv)[2], integer level,
                              SpecularBlock& block, int at) {
  const real width = gather(levels.width, level), height = gather(levels.height, level);
  const Pair x = repeated_pair(load(uv[0] + at), width), y = clamped_pair(load(uv[1] + at), height);
  const integer row0 = y.first * truncate(width), row1 = y.second * truncate(width);
  store_indices(block.level + at, level);
  store_indices(block.corner[0] + at, (row0 + x.first) * 3);
  store_indices(block.corner[1] + at, (row0 + x.second) * 3);
  store_indices(block.corner[2] + at, (row1 + x.first) * 3);
  store_indices(block.corner[3] + at, (row1 + x.second) * 3);
  store(block.x + at, x.weight);
  store(block.y + at, y.weight);
}

SIDERAY_LANE Four mix(Four a, Four b, float t) {
  return a * (1.0f - t) + b * t;
}

SIDERAY_LANE Four sample(const EnvironmentLevels& levels, const SpecularBlock& b, uint32_t i) {
  const float* texels = levels.texels[b.level[i]];
  return mix(mix(three(texels + b.corner[0][i]), three(texels + b.corner[1][i]), b.x[i]),
             mix(three(texels + b.corner[2][i]), three(texels + b.corner[3][i]), b.x[i]), b.y[i]);
}

// Prefetches all texels, because single look-ups would spend most of their time waiting for memory.
void specular_block(const EnvironmentLevels& levels, const BlockRow (&uv)[2], const BlockRow& roughness,
                    BlockRow (&radiance)[3]) {
  if (levels.uniform) {
    for (int c = 0; c < 3; ++c)
      for (int at = 0; at < static_cast<int>(block_size); at += lane_count)
        store(radiance[c] + at, real(levels.texels[0][c]));
    return;
  }
  SpecularBlock blocks[2];
  alignas(64) BlockRow weight;
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const real level = within(load(roughness + at), 1.0f) * static_cast<float>(levels.count - 1);
    const integer below = truncate(level);
    const real softer = level - to_real(below);
    store(weight + at, softer);
    find_texels(levels, uv, below, blocks[0], at);
    find_texels(levels, uv, sr_select(softer > 0.0f, below + 1, below), blocks[1], at);
  }
  for (const SpecularBlock& b : blocks)
    for (uint32_t i = 0; i < block_size; ++i)
      for (const auto& corner : b.corner) __builtin_prefetch(levels.texels[b.level[i]] + corner[i]);
  for (uint32_t i = 0; i < block_size; ++i) {
    Four value = sample(levels, blocks[0], i);
    if (weight[i] > 0.0f) value = mix(value, sample(levels, blocks[1], i), weight[i]);
    for (int c = 0; c < 3; ++c) radiance[c][i] = value[c];
  }
}

}  // namespace sideray::rt::SIDERAY_LANES
