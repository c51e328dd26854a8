// Samples textures for rt/surfaces/surface_lanes.h, sixteen look-ups at a time, of any hits and textures:
// rt/textures/texture_sample.cpp.
#pragma once

#include "elementary/functions.h"
#include "rt/surfaces/block_lanes.h"
#include "rt/surfaces/patch_lanes.h"
#include "rt/surfaces/surface_records.h"

namespace sideray::rt::SIDERAY_LANES {

// Names one texture look-up of a hit.
struct Sample {
  const ReadRecord* read;
  const float* place;  // coordinates() of the hit
  uint32_t hit;
};

// Writes eight numbers: texture coordinates of the hit, then their differences along the triangle's edges.
SIDERAY_LANE void coordinates(const float* uv, const Corners& c, float* place) {
  const float *u0 = uv + uint64_t{2} * c.vertex[0], *u1 = uv + uint64_t{2} * c.vertex[1],
              *u2 = uv + uint64_t{2} * c.vertex[2];
  for (int k = 0; k < 2; ++k) {
    place[k] = u0[k] * c.weight[0] + u1[k] * c.weight[1] + u2[k] * c.weight[2];
    place[2 + k] = u1[k] - u0[k];
    place[4 + k] = u2[k] - u0[k];
    place[6 + k] = 0.0f;
  }
}

SIDERAY_LANE real floor_of(real x) {
  // From 2^23 on every float is an integer.
  const boolean has_parts = abs(x) < 0x1p23f;
  return sr_select(has_parts, floor(sr_select(has_parts, x, real(0.0f))), x);
}

SIDERAY_LANE real reduce(real s, integer wrap) {
  const real limited = sr_select(s < 0.0f, real(0.0f), sr_select(real(1.0f) < s, real(1.0f), s));
  const boolean mirror = wrap == ReadRecord::mirror;
  const real whole = floor_of(sr_select(mirror, s * 0.5f, s));
  const real repeated = s - sr_select(mirror, whole * 2.0f, whole);
  const real reduced = sr_select(wrap == ReadRecord::clamp, limited, repeated);
  return sr_select(abs(s) <= 3.402823466e38f, reduced, real(0.0f));
}

// `i` is at most one texel outside the period of reduce().
SIDERAY_LANE integer wrap_texel(integer i, integer size, integer wrap) {
  const integer last = size - 1;
  const integer inside = min(sr_select(i < 0, integer(0), i), last);
  const integer period = sr_select(wrap == ReadRecord::mirror, size + size, size);
  const integer up = sr_select(i < 0, i + period, i);
  const integer down = sr_select(up < period, up, up - period);
  const integer folded = sr_select(down < size, down, last + size - down);
  return sr_select(wrap == ReadRecord::clamp, inside, folded);
}

// Holds sixteen look-ups in one mip level: its size and the texels' indices, both as integers' bits, and the weights of
// the second texels along x and y.
struct alignas(64) LevelBlock {
  BlockRow size[2], texel[4], weight[2];
  const uint8_t* rgba[block_size];
};

struct alignas(64) SampleBlock {
  BlockRow map[8];                 // ReadRecord::map, width, height
  BlockRow place[8];               // coordinates()
  BlockRow hit, nearest, wrap[2];  // integers' bits
  BlockRow squared;                // of the longer diameter, in texels squared
  BlockRow st[2];
  LevelBlock levels[2];
  BlockRow weight;  // of the coarser level
};

// Fills in the data of a look-up's texture and hit.
SIDERAY_LANE void gather_samples(const Sample (&samples)[block_size], SampleBlock& block) {
  const float *maps[block_size], *places[block_size];
  int32_t hit[block_size], nearest[block_size], wrap[2][block_size];
  for (uint32_t i = 0; i < block_size; ++i) {
    const ReadRecord& read = *samples[i].read;
    maps[i] = read.map;
    places[i] = samples[i].place;
    hit[i] = static_cast<int32_t>(samples[i].hit);
    nearest[i] = read.nearest ? -1 : 0;
    wrap[0][i] = read.wrap[0];
    wrap[1][i] = read.wrap[1];
  }
  transpose(maps, 8, block.map);
  transpose(places, 8, block.place);
  __builtin_memcpy(block.hit, hit, sizeof(hit));
  __builtin_memcpy(block.nearest, nearest, sizeof(nearest));
  __builtin_memcpy(block.wrap, wrap, sizeof(wrap));
}

// Computes the squared length of a diameter of the footprint, as texture_level() does.
SIDERAY_LANE real squared_texels(const SampleBlock& b, const BlockRow (&footprint)[4], int axis, int at) {
  const integer hit = load_integers(b.hit + at);
  const real x = gather(footprint[2 * axis], hit), y = gather(footprint[2 * axis + 1], hit);
  const real u = load(b.place[2] + at) * x + load(b.place[4] + at) * y;
  const real v = load(b.place[3] + at) * x + load(b.place[5] + at) * y;
  const real s = (load(b.map[0] + at) * u + load(b.map[2] + at) * v) * load(b.map[6] + at);
  const real t = (load(b.map[1] + at) * u + load(b.map[3] + at) * v) * load(b.map[7] + at);
  return s * s + t * t;
}

SIDERAY_LANE void set_level(const LevelRecord& level, LevelBlock& block, uint32_t i) {
  block.rgba[i] = level.rgba;
  __builtin_memcpy(&block.size[0][i], &level.width, sizeof(int32_t));
  __builtin_memcpy(&block.size[1][i], &level.height, sizeof(int32_t));
}

// Chooses the two mip levels of a look-up.
SIDERAY_LANE void choose_levels(const ReadRecord& read, SampleBlock& block, uint32_t i) {
  const float squared = block.squared[i];
  const float level = read.leveled && squared > 1.0f ? 0.5f * elementary::log2(squared) : 0.0f;
  const auto last = static_cast<float>(read.level_count - 1);
  const float clamped = level > 0.0f ? (last < level ? last : level) : 0.0f;
  const auto index = static_cast<uint32_t>(static_cast<int32_t>(clamped));
  block.weight[i] = clamped - static_cast<float>(static_cast<int32_t>(index));
  set_level(read.levels[index], block.levels[0], i);
  set_level(read.levels[block.weight[i] != 0.0f ? index + 1 : index], block.levels[1], i);
}

// Finds the texels of a level and their weights; a nearest look-up gives its only texel the whole weight.
SIDERAY_LANE void find_texels(const SampleBlock& b, LevelBlock& level, int at) {
  const integer nearest = load_integers(b.nearest + at);
  const boolean one{nearest.v};
  integer texel[2][2];
  for (int axis = 0; axis < 2; ++axis) {
    const integer size = load_integers(level.size[axis] + at), wrap = load_integers(b.wrap[axis] + at);
    const real scaled = load(b.st[axis] + at) * to_real(size);
    const real x = sr_select(one, scaled, scaled - 0.5f), base = floor(x);
    const integer i = truncate(base);
    texel[axis][0] = wrap_texel(i, size, wrap);
    texel[axis][1] = wrap_texel(sr_select(one, i, i + 1), size, wrap);
    store(level.weight[axis] + at, sr_select(one, real(0.0f), x - base));
  }
  const integer width = load_integers(level.size[0] + at);
  for (int k = 0; k < 4; ++k) store_integers(level.texel[k] + at, texel[1][k / 2] * width + texel[0][k % 2]);
}

SIDERAY_LANE real decoded(integer codes, int channel, const float* srgb) {
  const integer code((codes.v >> (8 * channel)) & 255);
  return srgb && channel < 3 ? gather(srgb, code) : to_real(code) * (1.0f / 255.0f);
}

// Filters a level; `codes` are its texels.
SIDERAY_LANE real filtered(const LevelBlock& level, const integer (&codes)[4], int channel, const float* srgb, int at) {
  const real x = load(level.weight[0] + at), y = load(level.weight[1] + at);
  const auto texel = [&](int k) { return decoded(codes[k], channel, srgb); };
  return mix(mix(texel(0), texel(1), x), mix(texel(2), texel(3), x), y);
}

using TexelCodes = BlockRow[4];

SIDERAY_LANE void fetch_texels(const LevelBlock& level, TexelCodes& codes) {
  for (int k = 0; k < 4; ++k)
    for (uint32_t i = 0; i < block_size; ++i) {
      uint32_t texel;
      __builtin_memcpy(&texel, &level.texel[k][i], sizeof(texel));
      __builtin_memcpy(&codes[k][i], level.rgba[i] + uint64_t{4} * texel, sizeof(texel));
    }
}

// Makes sixteen look-ups; `srgb` is null if all textures are linear, and set if all have sRGB colours.
SIDERAY_LANE void sample_textures(const Sample (&samples)[block_size], const BlockRow (&footprint)[4],
                                  const float* srgb, BlockRow (&values)[4]) {
  SampleBlock b;
  gather_samples(samples, b);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    store(b.squared + at, max(squared_texels(b, footprint, 0, at), squared_texels(b, footprint, 1, at)));
    const real u = load(b.place[0] + at), v = load(b.place[1] + at);
    for (int k = 0; k < 2; ++k) {
      const real along = load(b.map[k] + at) * u + load(b.map[2 + k] + at) * v + load(b.map[4 + k] + at);
      store(b.st[k] + at, reduce(along, load_integers(b.wrap[k] + at)));
    }
  }
  for (uint32_t i = 0; i < block_size; ++i) choose_levels(*samples[i].read, b, i);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count)
    for (LevelBlock& level : b.levels) find_texels(b, level, at);
  alignas(64) TexelCodes codes[2];
  for (int k = 0; k < 2; ++k) fetch_texels(b.levels[k], codes[k]);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    integer fine[4], coarse[4];
    for (int k = 0; k < 4; ++k) {
      fine[k] = load_integers(codes[0][k] + at);
      coarse[k] = load_integers(codes[1][k] + at);
    }
    const real weight = load(b.weight + at);
    for (int channel = 0; channel < 4; ++channel)
      store(values[channel] + at, mix(filtered(b.levels[0], fine, channel, srgb, at),
                                      filtered(b.levels[1], coarse, channel, srgb, at), weight));
  }
}

SIDERAY_LANE void take_values(const SurfaceTables& tables, const Sample& sample, const BlockRow (&values)[4],
                              uint32_t i, BlockRow* rows) {
  const OutputRecord* outputs = tables.outputs + sample.read->first_output;
  for (uint32_t k = 0; k < sample.read->outputs; ++k) {
    float v = values[outputs[k].channel][i];
    if (outputs[k].use == OutputRecord::Use::normal) v = v * 2.0f - 1.0f;
    if (outputs[k].use == OutputRecord::Use::occlusion) v = 1.0f + outputs[k].strength * (v - 1.0f);
    rows[outputs[k].row][sample.hit] = v;
  }
}

// Collects look-ups until there are sixteen.
struct SampleList {
  Sample samples[block_size];
  uint32_t count = 0;
  const float* srgb;
};

inline __attribute__((noinline)) void make_look_ups(const SurfaceTables& tables, const BlockRow (&footprint)[4],
                                                    SampleList& list, BlockRow* rows) {
  const uint32_t count = list.count;
  if (count == 0) return;
  for (uint32_t i = count; i < block_size; ++i) list.samples[i] = list.samples[count - 1];
  alignas(64) BlockRow values[4];
  if (list.srgb)
    sample_textures(list.samples, footprint, list.srgb, values);
  else
    sample_textures(list.samples, footprint, nullptr, values);
  for (uint32_t i = 0; i < count; ++i) take_values(tables, list.samples[i], values, i, rows);
  list.count = 0;
}

}  // namespace sideray::rt::SIDERAY_LANES
