// Reads and writes sixteen points or hits, a row for each number of a point, for the kernels of
// rt/surfaces/shade_lanes.cpp.
#pragma once

#include "rt/base/lanes.h"
#include "rt/surfaces/shade_kernels.h"

namespace sideray::rt::SIDERAY_LANES {

static_assert(sizeof(SrSurface) == sizeof(real) * SurfaceBlock::surface_rows);

SIDERAY_LANE real3 load3(const BlockRow (&rows)[3], int at) {
  return {load(rows[0] + at), load(rows[1] + at), load(rows[2] + at)};
}

SIDERAY_LANE void store3(BlockRow (&rows)[3], int at, real3 v) {
  store(rows[0] + at, v.x), store(rows[1] + at, v.y), store(rows[2] + at, v.z);
}

SIDERAY_LANE integer load_integers(const float* bits) {
  return integer(as_int(load(bits).v));
}
SIDERAY_LANE void store_integers(float* bits, integer v) {
  store(bits, real(as_float(v.v)));
}

// Reads a block's rows in the order of SrSurface.
struct SurfaceReader {
  const BlockRow* row;
  int at;
  SIDERAY_LANE real one() { return load(*row++ + at); }
  SIDERAY_LANE real3 three() {
    row += 3;
    return {load(row[-3] + at), load(row[-2] + at), load(row[-1] + at)};
  }
  SIDERAY_LANE real4 four() {
    row += 4;
    return {load(row[-4] + at), load(row[-3] + at), load(row[-2] + at), load(row[-1] + at)};
  }
};

SIDERAY_LANE SrSurface load_surface(const SurfaceBlock& block, int at) {
  SurfaceReader r{block.surface, at};
  SrSurface s;
  s.normal = r.three(), s.albedo = r.three(), s.metallic = r.one();
  s.diffuse = r.three(), s.behind = r.three(), s.f0 = r.three(), s.f90 = r.three(), s.emissive = r.three();
  s.tint = r.three(), s.alpha = r.one(), s.roughness = r.one(), s.occlusion = r.one();
  s.coat = r.one(), s.coat_roughness = r.one(), s.coat_normal = r.three();
  s.sheen = r.three(), s.sheen_roughness = r.one();
  s.along = r.three(), s.anisotropy = r.one();
  s.coat_share = r.one(), s.below_sheen = r.one(), s.sheen_albedo = r.one();
  const real scale = r.one(), bias = r.one();
  s.albedo_terms = real2(scale, bias);
  return s;
}

using Four = float __attribute__((vector_size(16)));

SIDERAY_LANE Four four(const float* values) {
  Four v;
  __builtin_memcpy(&v, values, sizeof(v));
  return v;
}

SIDERAY_LANE Four three(const float* v) {
  return Four{v[0], v[1], v[2], 0.0f};
}

SIDERAY_LANE void transpose_four(Four (&v)[4]) {
  const Four ab0 = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5),
             ab1 = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
  const Four cd0 = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5),
             cd1 = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
  v[0] = __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
  v[2] = __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
  v[3] = __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7);
}

// Transposes: rows[r][i] = from[i][r], for `count` rows, a multiple of four.
SIDERAY_LANE void transpose(const float* const (&from)[block_size], uint32_t count, BlockRow* rows) {
  for (uint32_t i = 0; i < block_size; i += 4)
    for (uint32_t r = 0; r < count; r += 4) {
      Four t[4] = {four(from[i] + r), four(from[i + 1] + r), four(from[i + 2] + r), four(from[i + 3] + r)};
      transpose_four(t);
      for (uint32_t k = 0; k < 4; ++k) *reinterpret_cast<Four*>(&rows[r + k][i]) = t[k];
    }
}

// Loads a block; the last point fills unused lanes.
void load_points(const float* points, uint32_t stride, uint32_t count, SurfaceBlock& block) {
  constexpr uint32_t rows = sizeof(SurfaceBlock) / sizeof(BlockRow);
  static_assert(rows % 4 == 0);
  float* out = &block.surface[0][0];
  for (uint32_t i = 0; i < block_size; i += 4) {
    const float* from[4];
    for (uint32_t k = 0; k < 4; ++k) from[k] = points + (i + k < count ? i + k : count - 1) * stride;
    for (uint32_t r = 0; r < rows; r += 4) {
      Four t[4] = {four(from[0] + r), four(from[1] + r), four(from[2] + r), four(from[3] + r)};
      transpose_four(t);
      for (uint32_t k = 0; k < 4; ++k) *reinterpret_cast<Four*>(out + (r + k) * block_size + i) = t[k];
    }
  }
}

void unload_points(const SurfaceBlock& block, uint32_t count, float* points, uint32_t stride) {
  constexpr uint32_t rows = SurfaceBlock::surface_rows + 10;
  static_assert(rows % 4 == 0);
  const float* in = &block.surface[0][0];
  for (uint32_t i = 0; i < count; i += 4) {
    const uint32_t some = count - i < 4 ? count - i : 4;
    for (uint32_t r = 0; r < rows; r += 4) {
      Four t[4] = {four(in + r * block_size + i), four(in + (r + 1) * block_size + i),
                   four(in + (r + 2) * block_size + i), four(in + (r + 3) * block_size + i)};
      transpose_four(t);
      for (uint32_t k = 0; k < some; ++k) __builtin_memcpy(points + uint64_t{i + k} * stride + r, &t[k], sizeof(Four));
    }
  }
}

}  // namespace sideray::rt::SIDERAY_LANES
