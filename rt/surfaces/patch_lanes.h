// Makes the geometry of hits for rt/surfaces/surface_lanes.h: position, normals, tangent and the footprint in the
// triangle. Memory is read hit by hit, four numbers at once, with prefetching; the arithmetic runs in lanes.
#pragma once

#include "rt/surfaces/block_lanes.h"
#include "rt/surfaces/surface_records.h"

namespace sideray::rt::SIDERAY_LANES {

// Sixteen roundings, relative to the triangle's largest coordinate, as in surface.cpp.
constexpr float share_of_rounding = 0x1p-20f;

SIDERAY_LANE Four magnitude(Four v) {
  using Bits = int32_t __attribute__((vector_size(16)));
  return __builtin_bit_cast(Four, __builtin_bit_cast(Bits, v) & 0x7fffffff);
}

SIDERAY_LANE Four larger(Four a, Four b) {
  return a < b ? b : a;
}

SIDERAY_LANE Four turned(const float (*columns)[4], Four v) {
  return four(columns[0]) * v[0] + four(columns[1]) * v[1] + four(columns[2]) * v[2];
}

// Holds the data read for a hit. The unused fourth components hold another number.
struct alignas(16) Patch {
  Four edge1;     // fourth: the largest coordinate in the transform of the corners
  Four edge2;     // fourth: 1 if the instance is mirrored
  Four normal;    // not unit
  Four position;  // fourth: 1 if the ray leaves a volume, whose thickness absorbs only on entering
  Four tangent;   // not unit
};

struct alignas(64) PatchBlock {
  BlockRow edge1[3], largest, edge2[3], mirrored, normal[3], unused, position[3], leaves, tangent[3], sign;
  static constexpr uint32_t rows = sizeof(Patch) / sizeof(float);
};
static_assert(sizeof(PatchBlock) == PatchBlock::rows * sizeof(BlockRow));

struct Corners {
  uint32_t vertex[3];
  float weight[3];
  SIDERAY_LANE Four weigh(const float* values, uint32_t size) const {
    if (size == 4)
      return four(values + 4 * vertex[0]) * weight[0] + four(values + 4 * vertex[1]) * weight[1] +
             four(values + 4 * vertex[2]) * weight[2];
    return three(values + 3 * vertex[0]) * weight[0] + three(values + 3 * vertex[1]) * weight[1] +
           three(values + 3 * vertex[2]) * weight[2];
  }
};

SIDERAY_LANE Corners corners_of(const SurfaceTables& tables, const HitBlock& hits, uint32_t i) {
  const uint32_t* t = tables.instances[hits.instance[i]].triangles + uint64_t{3} * hits.primitive[i];
  return {{t[0], t[1], t[2]}, {1.0f - hits.u[i] - hits.v[i], hits.u[i], hits.v[i]}};
}

SIDERAY_LANE void fetch_vertices(const SurfaceTables& tables, const HitBlock& hits, uint32_t i) {
  const InstanceRecord& in = tables.instances[hits.instance[i]];
  const uint32_t* t = in.triangles + uint64_t{3} * hits.primitive[i];
  for (int k = 0; k < 3; ++k) {
    __builtin_prefetch(in.positions + uint64_t{3} * t[k]);
    __builtin_prefetch(in.normals + uint64_t{3} * t[k]);
    __builtin_prefetch(in.uv[0] + uint64_t{2} * t[k]);
  }
}

SIDERAY_LANE Patch patch_of(const InstanceRecord& in, const Corners& c, bool front, bool framed) {
  const Four p0 = three(in.positions + uint64_t{3} * c.vertex[0]), p1 = three(in.positions + uint64_t{3} * c.vertex[1]),
             p2 = three(in.positions + uint64_t{3} * c.vertex[2]);
  Patch p;
  p.edge1 = turned(in.columns, p1 - p0);
  p.edge2 = turned(in.columns, p2 - p0);
  const Four extent = larger(magnitude(p0), larger(magnitude(p1), magnitude(p2)));
  const Four sum = magnitude(four(in.columns[0])) * extent[0] + magnitude(four(in.columns[1])) * extent[1] +
                   magnitude(four(in.columns[2])) * extent[2] + magnitude(four(in.columns[3]));
  float most = sum[0] < sum[1] ? sum[1] : sum[0];
  most = most < sum[2] ? sum[2] : most;
  p.edge1[3] = most;
  p.edge2[3] = in.mirrored ? 1.0f : 0.0f;
  p.normal = turned(in.normal_columns, c.weigh(in.normals, 3));
  p.position = turned(in.columns, p0 * c.weight[0] + p1 * c.weight[1] + p2 * c.weight[2]) + four(in.columns[3]);
  p.position[3] = in.solid && !front ? 1.0f : 0.0f;
  p.tangent = Four{};
  if (framed && in.tangents) {
    const Four tangent = c.weigh(in.tangents, 4);
    p.tangent = turned(in.columns, tangent);
    p.tangent[3] = in.mirrored ? -tangent[3] : tangent[3];
  }
  return p;
}

SIDERAY_LANE real3 unit_or(real3 v, real3 otherwise) {
  const real squared = dot(v, v);
  const boolean sound = squared > 1e-24f && squared <= 3.402823466e38f;
  return sr_select(sound, v * (1.0f / sqrt(squared)), otherwise);
}

SIDERAY_LANE real3 broadcast(const float* v) {
  return real3(real(v[0]), real(v[1]), real(v[2]));
}

// Computes texture_footprint(): x and y of the first diameter, then of the second.
SIDERAY_LANE void store_footprint(const PatchBlock& patches, const HitBlock& hits, BlockRow (&rows)[4], int at) {
  const real3 edge1 = load3(patches.edge1, at), edge2 = load3(patches.edge2, at), normal = cross(edge1, edge2);
  const real3 direction = load3(hits.direction, at);
  const real width = load(hits.width + at);
  const real squared_area = dot(normal, normal);
  const boolean sound = squared_area > 1e-36f;
  const real3 unit = normal * (1.0f / sqrt(squared_area));
  const real cosine = dot(unit, direction);
  real3 first, second;
  if (const float* const steps = hits.steps) {
    const real slope = 1.0f / sr_select(abs(cosine) > 1e-4f, cosine, real(1e-4f));
    const auto on_plane = [&](real3 step) { return (step - direction * (dot(unit, step) * slope)) * width; };
    first = on_plane(broadcast(steps));
    second = on_plane(broadcast(steps + 3));
  } else {
    const real3 slide = direction - unit * cosine;
    const real sine = length(slide);
    const real3 along = sr_select(sine > 1e-6f, slide * (1.0f / sine), normalize(edge1));
    first = along * (width / max(abs(cosine), 1e-4f));
    second = cross(unit, along) * width;
  }
  const real inverse = 1.0f / squared_area;
  const real3 to_second = cross(edge2, normal) * inverse, to_third = cross(normal, edge1) * inverse;
  const auto put = [&](int row, real value) { store(rows[row] + at, sr_select(sound, value, real(0.0f))); };
  put(0, dot(first, to_second));
  put(1, dot(first, to_third));
  put(2, dot(second, to_second));
  put(3, dot(second, to_third));
}

}  // namespace sideray::rt::SIDERAY_LANES
