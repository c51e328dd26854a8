// Contains the kernels that make surfaces of hits, a part of rt/surfaces/shade_lanes.cpp. Memory is read hit by hit,
// four numbers at once, with prefetching; the arithmetic runs in lanes. Each step does what surface_point() does,
// operation by operation, so the bits are the same.
#pragma once

#include "rt/surfaces/surface_records.h"

namespace sideray::rt::SIDERAY_LANES {

// Sixteen roundings, relative to the triangle's largest coordinate, as in surface.cpp.
constexpr float share_of_rounding = 0x1p-20f;

// Transposes: rows[r][i] = from[i][r], for `count` rows, a multiple of four.
SIDERAY_LANE void transpose(const float* const (&from)[block_size], uint32_t count, BlockRow* rows) {
  for (uint32_t i = 0; i < block_size; i += 4)
    for (uint32_t r = 0; r < count; r += 4) {
      Four t[4] = {four(from[i] + r), four(from[i + 1] + r), four(from[i + 2] + r), four(from[i + 3] + r)};
      transpose_four(t);
      for (uint32_t k = 0; k < 4; ++k) *reinterpret_cast<Four*>(&rows[r + k][i]) = t[k];
    }
}

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
SIDERAY_LANE void store_footprint(real3 edge1, real3 edge2, real3 normal, real3 direction, real width,
                                  const float* steps, BlockRow (&rows)[4], int at) {
  const real squared_area = dot(normal, normal);
  const boolean sound = squared_area > 1e-36f;
  const real3 unit = normal * (1.0f / sqrt(squared_area));
  const real cosine = dot(unit, direction);
  real3 first, second;
  if (steps) {
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

// The functions below sample textures, sixteen look-ups at a time, of any hits and textures:
// rt/textures/texture_sample.cpp.

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

SIDERAY_LANE integer load_integers(const float* bits) {
  return integer(as_int(load(bits).v));
}
SIDERAY_LANE void store_integers(float* bits, integer v) {
  store(bits, real(as_float(v.v)));
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

// Holds textures' values and vertex colours of hits. `any` false: nothing was written.
struct alignas(64) TexelBlock {
  BlockRow rows[texel_rows];
  bool any;
};

SIDERAY_LANE void clear_texels(TexelBlock& texels) {
  for (uint32_t r = 0; r < texel_rows; ++r) {
    const bool tangent_plane = (r >= row_normal && (r - row_normal) % 3 != 2) || r == row_anisotropy_across;
    for (int at = 0; at < static_cast<int>(block_size); at += lane_count)
      store(texels.rows[r] + at, real(tangent_plane ? 0.0f : 1.0f));
  }
}

SIDERAY_LANE SrTexels load_texels(const TexelBlock& texels, int at) {
  SurfaceReader r{texels.rows, at};
  SrTexels t;
  t.base_color = r.four(), t.emissive = r.three(), t.metallic = r.one(), t.roughness = r.one();
  t.occlusion = r.one(), t.transmission = r.one(), t.thickness = r.one(), t.specular = r.one();
  t.specular_color = r.three(), t.clearcoat = r.one(), t.clearcoat_roughness = r.one();
  t.sheen_color = r.three(), t.sheen_roughness = r.one();
  t.diffuse_transmission = r.one(), t.diffuse_transmission_color = r.three();
  t.iridescence = r.one(), t.iridescence_thickness = r.one();
  t.anisotropy_along = r.one(), t.anisotropy_across = r.one(), t.anisotropy = r.one();
  return t;
}

SIDERAY_LANE SrTexels no_texels() {
  const real one(1.0f);
  const real3 ones(one, one, one);
  return {real4(one, one, one, one),
          ones,
          one,
          one,
          one,
          one,
          one,
          one,
          ones,
          one,
          one,
          ones,
          one,
          one,
          ones,
          one,
          one,
          one,
          real(0.0f),
          one};
}

struct alignas(64) MaterialBlock {
  BlockRow rows[MaterialRecord::rows];
  const BlockRow& perturbs() const { return rows[MaterialRecord::words]; }
  const BlockRow& normal_scale() const { return rows[MaterialRecord::words + 1]; }
  const BlockRow& coat_normal_scale() const { return rows[MaterialRecord::words + 2]; }
};
static_assert(MaterialRecord::rows * sizeof(float) <= sizeof(MaterialRecord));

SIDERAY_LANE SrMaterial load_material(const MaterialBlock& material, int at) {
  SurfaceReader r{material.rows, at};
  SrMaterial m;
  m.base_color = r.four(), m.emissive = r.three(), m.specular_color = r.three(), m.absorption = r.three();
  m.metallic = r.one(), m.roughness = r.one(), m.transmission = r.one(), m.ior = r.one(), m.thickness = r.one();
  m.specular = r.one(), m.clearcoat = r.one(), m.clearcoat_roughness = r.one();
  m.sheen_color = r.three(), m.sheen_roughness = r.one();
  m.diffuse_transmission = r.one(), m.diffuse_transmission_color = r.three();
  m.iridescence = r.one(), m.iridescence_ior = r.one();
  m.iridescence_thickness_min = r.one(), m.iridescence_thickness_max = r.one();
  m.anisotropy = r.one(), m.anisotropy_cosine = r.one(), m.anisotropy_sine = r.one();
  m.alpha_mode = integer(as_int(r.one().v));
  m.unlit = boolean{as_int(r.one().v)};
  return m;
}

// Computes the transmittance of volumes, with the same exponential as for single hits.
SIDERAY_LANE void fill_volumes(const MaterialBlock& material, const BlockRow* thickness, const BlockRow& leaves,
                               uint32_t absorbing, BlockRow (&volume)[3]) {
  for (int c = 0; c < 3; ++c)
    for (int at = 0; at < static_cast<int>(block_size); at += lane_count) store(volume[c] + at, real(1.0f));
  constexpr uint32_t row_absorption = 10, row_of_thickness = 17;
  for (; absorbing != 0; absorbing &= absorbing - 1) {
    const auto i = static_cast<uint32_t>(__builtin_ctz(absorbing));
    const float depth = material.rows[row_of_thickness][i] * (leaves[i] > 0.0f ? 0.0f
                                                              : thickness      ? (*thickness)[i]
                                                                               : 1.0f);
    if (!(depth > 0.0f)) continue;
    for (uint32_t c = 0; c < 3; ++c) volume[c][i] = elementary::exp(-material.rows[row_absorption + c][i] * depth);
  }
}

// Stores everything that sr_seen() does not fill.
SIDERAY_LANE void store_surface(const SrSurface& s, SurfaceBlock& block, int at) {
  BlockRow* row = block.surface;
  const auto one = [&](real v) { store(*row++ + at, v); };
  const auto three = [&](real3 v) { one(v.x), one(v.y), one(v.z); };
  three(s.normal), three(s.albedo), one(s.metallic);
  three(s.diffuse), three(s.behind), three(s.f0), three(s.f90), three(s.emissive);
  three(s.tint), one(s.alpha), one(s.roughness), one(s.occlusion);
  one(s.coat), one(s.coat_roughness), three(s.coat_normal);
  three(s.sheen), one(s.sheen_roughness);
  three(s.along), one(s.anisotropy);
}

// Returns the coordinate of x in model::AlbedoTable, whose ends are texel centres.
SIDERAY_LANE real place_in_table(real x, float size) {
  return (x * (size - 1.0f) + 0.5f) * (1.0f / size);
}

SIDERAY_LANE real3 albedos(TexelView table, real n_v, real roughness) {
  const auto size = static_cast<float>(table.width);
  return sample(table, clamped_pair(place_in_table(n_v, size), table.width),
                clamped_pair(place_in_table(roughness, size), table.height));
}

SIDERAY_LANE real sheen_albedo(const SrSurface& s, real n_v, TexelView table) {
  const boolean sheen = largest(s.sheen) > 0.0f;
  if (!sr_any(sheen)) return real(0.0f);
  return sr_select(sheen, albedos(table, n_v, s.sheen_roughness).z, real(0.0f));
}

// Stores what sr_seen() changes.
SIDERAY_LANE void store_seen(const SrSurface& s, real3 to_eye, TexelView table, SurfaceBlock& block, int at) {
  const real n_v = abs(dot(s.normal, to_eye));
  const bool brushed = sr_any(s.anisotropy > 0.0f);
  const real roughness = brushed ? sr_round_roughness(s) : s.roughness;
  const real3 found = albedos(table, n_v, roughness);
  real2 terms(found.x, found.y);
  if (brushed) {
    const real3 masked = albedos(table, sr_round_cosine(s, to_eye), roughness);
    terms = sr_brushed_terms(s, terms, real2(masked.x, masked.y));
  }
  const SrSurface seen = sr_seen(s, to_eye, terms, sheen_albedo(s, n_v, table));
  constexpr int row_of_f0 = 13, row_of_coat_share = 41;
  const real from_f0[] = {seen.f0.x, seen.f0.y, seen.f0.z, seen.f90.x, seen.f90.y, seen.f90.z};
  for (int i = 0; i < 6; ++i) store(block.surface[row_of_f0 + i] + at, from_f0[i]);
  const real rest[] = {seen.coat_share, seen.below_sheen, seen.sheen_albedo, terms.x, terms.y};
  for (int i = 0; i < 5; ++i) store(block.surface[row_of_coat_share + i] + at, rest[i]);
}

SIDERAY_LANE real4 tangent_of(const PatchBlock& patches, int at) {
  const real3 along = load3(patches.tangent, at);
  const real squared = dot(along, along);
  const boolean framed = squared > 1e-24f;
  const real3 unit = along * (1.0f / sqrt(squared));
  const real zero(0.0f);
  return {sr_select(framed, unit.x, zero), sr_select(framed, unit.y, zero), sr_select(framed, unit.z, zero),
          sr_select(framed, load(patches.sign + at), zero)};
}

// Perturbs a normal by a map, if the material has normal maps.
SIDERAY_LANE real3 perturbed(real3 normal, real4 tangent, const BlockRow (&map)[3], const BlockRow& scale,
                             boolean perturbs, int at) {
  return sr_select(perturbs, sr_perturb(normal, tangent, load3(map, at), load(scale + at)), normal);
}

struct HitReads {
  uint32_t textured, absorbing, colored, perturbed;  // bits of hits
};

SIDERAY_LANE HitReads gather_hits(const SurfaceTables& tables, const HitBlock& hits, PatchBlock& patches,
                                  MaterialBlock& materials) {
  alignas(64) Patch patch[block_size];
  const float *patch_words[block_size], *material_words[block_size];
  HitReads reads{0, 0, 0, 0};
  for (uint32_t i = 0; i < block_size; ++i)
    __builtin_prefetch(tables.instances[hits.instance[i]].triangles + uint64_t{3} * hits.primitive[i]);
  for (uint32_t i = 0; i < block_size; ++i) fetch_vertices(tables, hits, i);
  for (uint32_t i = 0; i < block_size; ++i) {
    const InstanceRecord& in = tables.instances[hits.instance[i]];
    const MaterialRecord& material = tables.materials[in.material];
    const bool perturbs = material.perturbs > 0.0f;
    patch[i] = patch_of(in, corners_of(tables, hits, i), hits.front[i] > 0.0f, material.framed > 0.0f);
    patch_words[i] = reinterpret_cast<const float*>(&patch[i]);
    material_words[i] = material.shading;
    reads.textured |= static_cast<uint32_t>(material.reads > 0) << i;
    reads.absorbing |= static_cast<uint32_t>(material.absorbs > 0.0f) << i;
    reads.colored |= static_cast<uint32_t>(in.colors != nullptr) << i;
    reads.perturbed |= static_cast<uint32_t>(perturbs) << i;
  }
  transpose(patch_words, PatchBlock::rows, patches.edge1);
  transpose(material_words, MaterialRecord::rows, materials.rows);
  return reads;
}

SIDERAY_LANE void read_block(const SurfaceTables& tables, const HitBlock& hits, const HitReads& reads,
                             const BlockRow (&footprint)[4], TexelBlock& texels) {
  texels.any = (reads.textured | reads.colored) != 0;
  if (!texels.any) return;
  clear_texels(texels);
  SampleList lists[2];
  lists[0].srgb = nullptr;
  lists[1].srgb = tables.srgb;
  alignas(16) float places[block_size][2][8];
  for (uint32_t bits = reads.textured; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(__builtin_ctz(bits));
    const InstanceRecord& in = tables.instances[hits.instance[i]];
    const MaterialRecord& material = tables.materials[in.material];
    uint32_t known = 0;
    for (uint32_t r = 0; r < material.reads; ++r) {
      const ReadRecord& read = tables.reads[material.first_read + r];
      if (!(known >> read.uv_set & 1u))
        coordinates(in.uv[read.uv_set], corners_of(tables, hits, i), places[i][read.uv_set]);
      known |= 1u << read.uv_set;
      SampleList& list = lists[read.srgb];
      list.samples[list.count++] = {&read, places[i][read.uv_set], i};
      if (list.count == block_size) make_look_ups(tables, footprint, list, texels.rows);
    }
  }
  for (SampleList& list : lists) make_look_ups(tables, footprint, list, texels.rows);
  for (uint32_t bits = reads.colored; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(__builtin_ctz(bits));
    const Four color = corners_of(tables, hits, i).weigh(tables.instances[hits.instance[i]].colors, 4);
    // The fixed function uses texture and vertex colour separately.
    constexpr uint32_t apart[] = {row_diffuse_transmission_color, row_diffuse_transmission_color + 1,
                                  row_diffuse_transmission_color + 2, row_diffuse_transmission};
    for (uint32_t k = 0; k < 4; ++k)
      if (tables.fixed)
        texels.rows[apart[k]][i] = color[k];
      else
        texels.rows[row_base_color + k][i] *= color[k];
  }
}

SIDERAY_LANE SrFixedMaterial load_fixed(const BlockRow* rows, int at) {
  SurfaceReader r{rows, at};
  SrFixedMaterial m;
  m.color = r.four(), m.ambient = r.three(), m.diffuse = r.three(), m.specular = r.three(), m.emission = r.three();
  m.reflectance = r.three(), m.fresnel = r.one(), m.shininess = r.one(), m.lit = r.one();
  m.ambient_follows = r.one(), m.diffuse_follows = r.one(), m.specular_follows = r.one(), m.emission_follows = r.one();
  m.of_none = r.one(), m.of_texel = r.one(), m.of_alpha = r.one(), m.adds = r.one(), m.adds_alpha = r.one();
  m.replaces_alpha = r.one(), m.modulates_alpha = r.one(), m.bends = r.one();
  return m;
}

// Replaces the surfaces of a block by fixed-function ones.
void fix_surfaces(const SurfaceTables& tables, const HitBlock& hits, const MaterialBlock& materials,
                  const TexelBlock& texels, SurfaceBlock& block) {
  alignas(64) BlockRow rows[FixedRecord::words];
  const float* words[block_size];
  for (uint32_t i = 0; i < block_size; ++i)
    words[i] = tables.fixed[tables.instances[hits.instance[i]].material].shading;
  transpose(words, FixedRecord::words, rows);
  const FixedModelTerms& terms = tables.model;
  const SrFixedModel model = {{terms.ambient[0], terms.ambient[1], terms.ambient[2]}, terms.two_sided, terms.separate};
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    SrTexels t = no_texels();
    if (texels.any) t = load_texels(texels, at);
    const real3 color = t.diffuse_transmission_color;
    const SrSurface s = sr_fixed_surface(
        load_surface(block, at), load_fixed(rows, at), model, t.base_color,
        real4(color.x, color.y, color.z, t.diffuse_transmission), load(hits.front + at) > 0.0f,
        load_material(materials, at).alpha_mode == 2, load3(block.to_eye, at));
    store_surface(s, block, at);
    constexpr int row_of_coat_share = 41;
    const real rest[] = {s.coat_share, s.below_sheen, s.sheen_albedo, s.albedo_terms.x, s.albedo_terms.y};
    for (int i = 0; i < 5; ++i) store(block.surface[row_of_coat_share + i] + at, rest[i]);
  }
}

void surfaces_of_hits(const SurfaceTables& tables, const HitBlock& hits, SurfaceBlock& block) {
  PatchBlock patches;
  MaterialBlock materials;
  TexelBlock texels;
  alignas(64) BlockRow footprint[4], smooth[3], volume[3];
  const HitReads reads = gather_hits(tables, hits, patches, materials);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const real3 edge1 = load3(patches.edge1, at), edge2 = load3(patches.edge2, at);
    const real3 normal = cross(edge1, edge2), direction = load3(hits.direction, at);
    const boolean mirrored = load(patches.mirrored + at) > 0.0f, front = load(hits.front + at) > 0.0f;
    const real3 unit = unit_or(sr_select(mirrored, -normal, normal), real3(real(0.0f), real(1.0f), real(0.0f)));
    store3(smooth, at, unit_or(load3(patches.normal, at), unit));
    store3(block.geometric_normal, at, sr_select(front, unit, -unit));
    store3(block.to_eye, at, -direction);
    store3(block.position, at, load3(patches.position, at));
    store(block.offset + at, load(patches.largest + at) * share_of_rounding);
    if (reads.textured != 0)
      store_footprint(edge1, edge2, normal, direction, load(hits.width + at), hits.steps, footprint, at);
  }
  read_block(tables, hits, reads, footprint, texels);
  fill_volumes(materials, texels.any ? &texels.rows[row_thickness] : nullptr, patches.leaves, reads.absorbing, volume);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const boolean front = load(hits.front + at) > 0.0f;
    real3 normal = load3(smooth, at), coat_normal = normal;
    SrTexels t = no_texels();
    if (texels.any) t = load_texels(texels, at);
    if (reads.perturbed != 0) {
      const boolean perturbs = load(materials.perturbs() + at) > 0.0f;
      const BlockRow(&maps)[texel_rows] = texels.rows;
      const real4 tangent = tangent_of(patches, at);
      normal = perturbed(normal, tangent, reinterpret_cast<const BlockRow(&)[3]>(maps[row_normal]),
                         materials.normal_scale(), perturbs, at);
      coat_normal = perturbed(coat_normal, tangent, reinterpret_cast<const BlockRow(&)[3]>(maps[row_coat_normal]),
                              materials.coat_normal_scale(), perturbs, at);
    }
    const SrMaterial m = load_material(materials, at);
    t.thickness = real(0.0f);
    const real3 to_eye = load3(block.to_eye, at);
    // The normals are turned toward the eye first; sr_facing() would copy the whole surface to do so.
    SrSurface s = sr_surface(m, t, sr_toward_eye(sr_select(front, normal, -normal), to_eye),
                             sr_toward_eye(sr_select(front, coat_normal, -coat_normal), to_eye));
    // This sr_surface() computes no volume, because its exponential differs from that of single hits.
    const real transmission = sr_saturate(m.transmission * t.transmission) * (1.0f - s.metallic);
    s.tint = sr_times(s.albedo, load3(volume, at)) * transmission;
    if (sr_any(m.anisotropy > 0.0f)) s = sr_brushed(s, m, t, load3(smooth, at), tangent_of(patches, at));
    if (sr_any(m.iridescence > 0.0f)) s = sr_filmed(s, m, t, to_eye);
    store_surface(s, block, at);
    store_seen(s, to_eye, tables.albedo, block, at);
  }
  if (tables.fixed) fix_surfaces(tables, hits, materials, texels, block);
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
