// Makes the rays of points to lights, a part of rt/points/point_lanes.cpp. Operations have the same order as in
// rt/base/sampling.h.
#pragma once

#include "rt/base/lane_reads.h"
#include "rt/points/point_kernels.h"

namespace sideray::rt::SIDERAY_LANES {

using UintVector = uint32_t __attribute__((vector_size(4 * SIDERAY_LANE_COUNT)));

SIDERAY_LANE UintVector lane_hash(UintVector x) {
  const UintVector state = x * 747796405u + 2891336453u;
  const UintVector word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
  return (word >> 22) ^ word;
}
SIDERAY_LANE real lane_unit_float(UintVector bits) {
  return to_real(integer(__builtin_bit_cast(IntVector, bits >> 8))) * 0x1p-24f;
}
SIDERAY_LANE UintVector lane_reverse(UintVector x) {
  x = (x << 16) | (x >> 16);
  x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
  x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
  return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}
// Scrambles a number whose bits are reversed already; see scramble_nested().
SIDERAY_LANE UintVector lane_scramble_reversed(UintVector x, uint32_t key) {
  x = x + key;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return lane_reverse(x);
}

SIDERAY_LANE real3 load_any(const float (&planes)[3][point_tile_pixels], int at) {
  return {load_any(planes[0] + at), load_any(planes[1] + at), load_any(planes[2] + at)};
}
SIDERAY_LANE real3 every(const float (&v)[3]) {
  return {real(v[0]), real(v[1]), real(v[2])};
}

SIDERAY_LANE bool has_place(const RayLight& light) {
  return light.kind == rays_to_point || light.kind == rays_to_spot;
}

struct ToLight {
  real3 axis;
  real distance;
  boolean reaches;
};

// Returns direction and distance from a point to a positional light.
SIDERAY_LANE ToLight to_light(const RayLight& light, real3 front) {
  const real3 offset = every(light.position) - front;
  const real distance = length(offset);
  boolean reaches = distance > light.radius;
  if (light.range > 0.0f) reaches = reaches && !(distance > light.range);
  const real3 axis{offset.x / distance, offset.y / distance, offset.z / distance};
  if (light.kind == rays_to_spot) reaches = reaches && !(-dot(axis, every(light.direction)) < light.cos_outer);
  return {axis, distance, reaches};
}

// Returns the indices of lanes in their block, from `first` on.
SIDERAY_LANE UintVector lanes_from(int first) {
  UintVector v{};
  for (int i = 0; i < lane_count; ++i) v[i] = static_cast<uint32_t>(first + i);
  return v;
}

void sample_tile(const RayLight& light, const SampleKeys& keys, const PointTile& tile, RaySamples& samples) {
  constexpr uint32_t all = lane_count == 32 ? ~0u : (1u << lane_count) - 1u;
  for (int block = 0; block < tile_blocks; ++block) {
    samples.wanted[block] = 0;
    for (int lane = 0; lane < block_pixels; lane += lane_count) {
      const int at = block * block_pixels + lane;
      uint32_t wanted = static_cast<uint32_t>(tile.drawn[block]) >> lane & all;
      if (wanted != 0 && has_place(light)) wanted &= lane_bits(to_light(light, load_any(tile.front, at)).reaches);
      samples.wanted[block] = static_cast<uint16_t>(samples.wanted[block] | wanted << lane);
      if (wanted == 0 || !light.samples) continue;
      // Four blocks of 4x4 pixels share a set of points.
      const int column = block % blocks_across, row = block / blocks_across;
      const int set = row / 2 * 4 + column / 2;
      const UintVector pixel = lanes_from(lane);
      const UintVector x = (pixel & 3u) + static_cast<uint32_t>(column % 2 * 4);
      const UintVector y = (pixel >> 2) + static_cast<uint32_t>(row % 2 * 4);
      const UintVector sample = (y * 8u + x) * light.count + light.index;
      const UintVector index = lane_scramble_reversed(lane_reverse(sample), keys.order[set]);
      // Sobol's second coordinate, reversed, is the Pascal triangle modulo 2 applied to the index.
      UintVector second = index;
      second ^= (second >> 16) & 0x0000ffffu;
      second ^= (second >> 8) & 0x00ff00ffu;
      second ^= (second >> 4) & 0x0f0f0f0fu;
      second ^= (second >> 2) & 0x33333333u;
      second ^= (second >> 1) & 0x55555555u;
      store_any(samples.u + at, lane_unit_float(lane_scramble_reversed(index, keys.x[set])));
      const real v = lane_unit_float(lane_scramble_reversed(second, keys.y[set]));
      store_any(samples.azimuth + at, 6.28318530717958647692528676655900576f * v);
    }
  }
}

struct LaneRays {
  real3 origin, direction;
  real t_near, t_far;
};

SIDERAY_LANE real3 in_frame(real3 x, real3 y, real3 z, real3 v) {
  return {x.x * v.x + y.x * v.y + z.x * v.z, x.y * v.x + y.y * v.y + z.y * v.z, x.z * v.x + y.z * v.y + z.z * v.z};
}

// Rotates a direction into the frame about z; see frame_about().
SIDERAY_LANE real3 about(real3 z, real3 v) {
  const boolean sideways = abs(z.x) < 0.5f;
  const real one(1.0f), zero(0.0f);
  const real3 side{sr_select(sideways, one, zero), sr_select(sideways, zero, one), zero};
  const real3 x = normalize(cross(side, z));
  return in_frame(x, cross(z, x), z, v);
}

// See sample_cone().
SIDERAY_LANE real3 lane_cone(const RaySamples& samples, int at, real aperture) {
  const real below = load_any(samples.u + at) * aperture;
  const real sine = sqrt(below * (2.0f - below));
  return {sine * load_any(samples.cosine + at), sine * load_any(samples.sine + at), 1.0f - below};
}

// See sample_cosine().
SIDERAY_LANE real3 lane_cosine(const RaySamples& samples, int at) {
  const real u = load_any(samples.u + at), sine = sqrt(u);
  return {sine * load_any(samples.cosine + at), sine * load_any(samples.sine + at), sqrt(1.0f - u)};
}

// See distance_to_sphere().
SIDERAY_LANE real distance_to_disc(real radius, real distance, real below) {
  const real across2 = distance * distance * below * (2.0f - below);
  return distance * (1.0f - below) - sqrt(max(radius * radius - across2, real(0.0f)));
}

SIDERAY_LANE LaneRays light_rays_of(const RayLight& light, const RaySamples& samples, const PointTile& tile, int at) {
  LaneRays rays;
  rays.t_far = real(light.t_far);
  if (light.kind == rays_to_directional) {
    rays.direction = every(light.position);
    if (light.samples)
      rays.direction = in_frame(every(light.frame[0]), every(light.frame[1]), every(light.frame[2]),
                                lane_cone(samples, at, real(light.aperture)));
    return rays;
  }
  if (light.kind == rays_to_sky) {
    rays.direction = about(load_any(tile.normal, at), lane_cosine(samples, at));
    return rays;
  }
  if (light.kind == rays_to_drawn) {
    rays.direction = load_any(samples.drawn, at);
    return rays;
  }
  const ToLight to = to_light(light, load_any(tile.front, at));
  rays.direction = to.axis;
  real reach = to.distance;
  if (light.samples) {
    const real radius(light.radius), sine = radius / to.distance, sine2 = sine * sine;
    const real3 sample = lane_cone(samples, at, sine2 / (1.0f + sqrt(1.0f - sine2)));
    rays.direction = about(to.axis, sample);
    reach = distance_to_disc(radius, to.distance, 1.0f - sample.z);
  }
  rays.t_far = reach * (1.0f - 0x1p-20f);
  return rays;
}

// Moves or shortens the rays of pixels that take the inexact test.
SIDERAY_LANE void start_inexact(const InexactStart& start, const PointTile& tile, int block, int lane, LaneRays& rays) {
  const UintVector pixel = lanes_from(lane);
  const UintVector x = (pixel & 3u) + (tile.x0 + static_cast<uint32_t>(block % blocks_across * point_block));
  const UintVector y = (pixel >> 2) + (tile.y0 + static_cast<uint32_t>(block / blocks_across * point_block));
  const real u = lane_unit_float(lane_hash((y << 16 | x) + start.key));
  const UintVector marks = ((UintVector{} + tile.inexact[block]) >> pixel) & 1u;
  const boolean inexact{__builtin_bit_cast(IntVector, marks) == 1};
  const real share = u * load_any(tile.bias + block * block_pixels + lane);
  if (start.kind == starts_further)
    rays.origin = sr_select(inexact, rays.origin + rays.direction * share, rays.origin);
  else
    rays.t_near = sr_select(inexact, max(rays.t_near, share), rays.t_near);
}

SIDERAY_LANE void append(const LaneRays& lanes, uint32_t wanted, int at, const RayArrays& rays, uint32_t count) {
  const real values[] = {lanes.origin.x,    lanes.origin.y,    lanes.origin.z, lanes.direction.x,
                         lanes.direction.y, lanes.direction.z, lanes.t_near,   lanes.t_far};
  float* const to[] = {rays.origin[0],    rays.origin[1],    rays.origin[2], rays.direction[0],
                       rays.direction[1], rays.direction[2], rays.t_near,    rays.t_far};
#if defined(__AVX512F__) && SIDERAY_LANE_COUNT == 16
  for (int i = 0; i < 8; ++i)
    _mm512_storeu_ps(to[i] + count, _mm512_maskz_compress_ps(static_cast<__mmask16>(wanted),
                                                             __builtin_bit_cast(__m512, values[i].v)));
#else
  constexpr uint32_t all = (1u << lane_count) - 1u;
  for (int i = 0; i < 8; ++i) {
    if (wanted == all) {
      store_any(to[i] + count, values[i]);
      continue;
    }
    float* next = to[i] + count;
    for (uint32_t bits = wanted; bits != 0; bits &= bits - 1) *next++ = values[i].v[__builtin_ctz(bits)];
  }
#endif
  uint16_t* pixel = rays.pixel + count;
  for (uint32_t bits = wanted; bits != 0; bits &= bits - 1) *pixel++ = static_cast<uint16_t>(at + __builtin_ctz(bits));
}

uint32_t rays_of_tile(const RayLight& light, const InexactStart& start, const RaySamples& samples,
                      const PointTile& tile, const RayArrays& rays) {
  constexpr uint32_t all = (1u << lane_count) - 1u;
  uint32_t count = 0;
  for (int block = 0; block < tile_blocks; ++block)
    for (int lane = 0; lane < block_pixels; lane += lane_count) {
      const uint32_t wanted = static_cast<uint32_t>(samples.wanted[block]) >> lane & all;
      if (wanted == 0) continue;
      const int at = block * block_pixels + lane;
      LaneRays made = light_rays_of(light, samples, tile, at);
      made.origin = load_any(tile.front, at);
      if (light.kind != rays_to_sky && light.kind != rays_to_drawn) {
        const boolean in_front = dot(made.direction, load_any(tile.normal, at)) >= -load_any(tile.doubt + at);
        made.origin = sr_select(in_front, made.origin, load_any(tile.back, at));
      }
      made.t_near = load_any(tile.skip + at);
      if (start.kind != starts_as_others && tile.inexact[block] != 0) start_inexact(start, tile, block, lane, made);
      append(made, wanted, at, rays, count);
      count += static_cast<uint32_t>(__builtin_popcount(wanted));
    }
  return count;
}

}  // namespace sideray::rt::SIDERAY_LANES
