// Is compiled once for each instruction set (sideray_lanes() in rt/CMakeLists.txt; rt/base/lanes.h). Any thread may
// call the kernels.
#include "rt/base/lane_reads.h"
#include "rt/masks/kernels/shadow_kernels.h"

namespace sideray::rt::SIDERAY_LANES {

#define SR_FN SIDERAY_LANE
#include "shaders/light/shadow_filter.h"
#undef SR_FN

SIDERAY_LANE SfLight light_of(const ShadowTerms& t) {
  return {{t.light_position[0], t.light_position[1], t.light_position[2]},
          t.light_radius,
          t.light_tan_radius,
          t.light_most_penumbra,
          t.light_most_frames};
}

SIDERAY_LANE SfView view_of(const ShadowTerms& t) {
  return {t.origin_x, t.origin_y, t.step_x, t.step_y, {t.before[0], t.before[1], t.before[2]}, t.before_offset};
}

SIDERAY_LANE SfPlane plane_at(const ShadowPlanes& p, int32_t at) {
  return {load_any(p.inverse + at), load_any(p.slope_x + at), load_any(p.slope_y + at)};
}

void invert_row(const float* depth, float* inverse) {
  for (int i = 0; i < shadow_tile; i += lane_count) store_any(inverse + i, sf_inverse_depth(load_any(depth + i)));
}

void slope_row(const ShadowPlanes& p, int32_t first) {
  for (int32_t at = first; at < first + shadow_tile; at += lane_count) {
    const real inverse = load_any(p.inverse + at);
    store_any(p.slope_x + at, sf_slope(load_any(p.inverse + at - 1), inverse, load_any(p.inverse + at + 1)));
    store_any(p.slope_y + at,
              sf_slope(load_any(p.inverse + at - p.stride), inverse, load_any(p.inverse + at + p.stride)));
  }
}

void load_row(const float* visibility, const float* darkest, const float* hit_distance, const ShadowPlanes& planes,
              int32_t at, ShadowColumns& columns) {
  for (int i = 0; i < shadow_tile; i += lane_count) {
    const real seen = load_any(visibility + i);
    const boolean there = load_any(planes.inverse + at + i) > 0.0f;
    const real nearness = sr_select(there, sf_nearness(load_any(darkest + i), load_any(hit_distance + i)), real(0.0f));
    const boolean hit = nearness > 0.0f;
    store_any(planes.visibility + at + i, seen);
    store_any(planes.filtered + at + i, seen);
    store_any(planes.nearness + at + i, nearness);
    store(columns.least + i, min(load(columns.least + i), sr_select(there, seen, real(1.0f))));
    store(columns.most + i, max(load(columns.most + i), sr_select(there, seen, real(0.0f))));
    const real distance = 1.0f / max(nearness, real(1e-20f));
    store(columns.distances + i, load(columns.distances + i) + sr_select(hit, distance, real(0.0f)));
    store(columns.hits + i, load(columns.hits + i) + sr_select(hit, real(1.0f), real(0.0f)));
  }
}

// Returns the mean nearness of the occluders in the 5x5 pixels around, counting only pixels on the plane.
SIDERAY_LANE real nearness_around(const ShadowPlanes& p, SfPlane plane, int32_t at, float otherwise) {
  real sum(0.0f), total(0.0f);
  for (int32_t dy = -2; dy <= 2; ++dy)
    for (int32_t dx = -2; dx <= 2; ++dx) {
      const int32_t other = at + dy * p.stride + dx;
      const real nearness = load_any(p.nearness + other);
      if (!sr_any(nearness > 0.0f)) continue;  // skips most rows early: few pixels have a measured distance
      const real on = sf_on_plane(plane, static_cast<float>(dx), static_cast<float>(dy), load_any(p.inverse + other));
      const real weight = sr_select(nearness > 0.0f, on, real(0.0f));
      sum = sum + weight * nearness;
      total = total + weight;
    }
  return mix(real(otherwise), sum / max(total, real(1e-6f)), min(total, real(1.0f)));
}

void prepare_row(const ShadowTerms& terms, const ShadowPlanes& p, int32_t x, int32_t y, ShadowTileReach& tile) {
  for (int i = 0; i < shadow_tile; i += lane_count) {
    const int32_t at = p.origin + y * p.stride + x + i;
    const SfPlane plane = plane_at(p, at);
    const real reach = sf_reach(light_of(terms), view_of(terms), to_real(ramp(x + i)), real(static_cast<float>(y)),
                                plane.inverse, nearness_around(p, plane, at, tile.nearness));
    store_any(p.reach + at, reach);
    store(tile.longest + i, max(load(tile.longest + i), reach));
  }
}

// Returns whether the lanes and all eight neighbours at `step` are lit, or all in shadow: then the weights do not
// change the mean.
SIDERAY_LANE bool is_even(const float* visibility, int32_t stride, int32_t step) {
  const float value = visibility[0];
  if (value != 0.0f && value != 1.0f) return false;
  boolean even = load_any(visibility) == real(value);
  for (int32_t dy = -1; dy <= 1; ++dy)
    for (int32_t dx = -1; dx <= 1; ++dx) even = even && load_any(visibility + (dy * stride + dx) * step) == real(value);
  return !sr_any(!even);
}

// Blurs images that share all planes except visibility and filtered.
template <int Count>
SIDERAY_LANE void blur_lanes(const ShadowPlanes* images, int32_t at, int32_t step) {
  const ShadowPlanes& p = images[0];
  const SfPlane plane = plane_at(p, at);
  const real reach = load_any(p.reach + at);
  // Beyond the end of sf_bell every weight is 0, whatever the neighbour's reach is.
  const auto reaches = [&](int32_t square) { return sr_any(reach * reach * 8.01f > static_cast<float>(square)); };
  const bool reaches_any = reaches(step * step), reaches_corners = reaches(2 * step * step);
  real sum[Count];
  bool stays[Count], all_stay = true;
  for (int c = 0; c < Count; ++c) {
    sum[c] = load_any(images[c].visibility + at);
    stays[c] = !reaches_any || is_even(images[c].visibility + at, p.stride, step);
    if (stays[c]) store_any(images[c].filtered + at, sum[c]);
    all_stay = all_stay && stays[c];
  }
  if (all_stay) return;
  real total(1.0f);
  for (int32_t dy = -1; dy <= 1; ++dy)
    for (int32_t dx = -1; dx <= 1; ++dx) {
      if ((dx == 0 && dy == 0) || (dx != 0 && dy != 0 && !reaches_corners)) continue;
      const int32_t other = at + (dy * p.stride + dx) * step;
      const real on = sf_on_plane(plane, static_cast<float>(dx * step), static_cast<float>(dy * step),
                                  load_any(p.inverse + other));
      const float kernel = dx != 0 && dy != 0 ? 0.25f : 0.5f;
      const real weight =
          sf_weight(on, reach, load_any(p.reach + other), static_cast<float>((dx * dx + dy * dy) * step * step)) *
          kernel;
      for (int c = 0; c < Count; ++c) sum[c] = sum[c] + load_any(images[c].visibility + other) * weight;
      total = total + weight;
    }
  for (int c = 0; c < Count; ++c)
    if (!stays[c]) store_any(images[c].filtered + at, sum[c] / total);
}

void blur_row(const ShadowPlanes* images, int32_t count, int32_t first, int32_t step) {
  for (int32_t at = first; at < first + shadow_tile; at += lane_count) {
    if (count == 3)
      blur_lanes<3>(images, at, step);
    else
      for (int32_t i = 0; i < count; ++i) blur_lanes<1>(images + i, at, step);
  }
}

SIDERAY_LANE SfMoments moments_around(const ShadowPlanes& p, SfPlane plane, int32_t at) {
  real total(0.0f), sum(0.0f), square(0.0f);
  for (int32_t dy = -2; dy <= 2; ++dy)
    for (int32_t dx = -2; dx <= 2; ++dx) {
      const int32_t other = at + dy * p.stride + dx;
      const real seen = load_any(p.visibility + other);
      const real on = sf_on_plane(plane, static_cast<float>(dx), static_cast<float>(dy), load_any(p.inverse + other));
      total = total + on;
      sum = sum + on * seen;
      square = square + on * seen * seen;
    }
  const real most = max(total, real(1e-6f));
  return {total, sum / most, square / most};
}

// Says where a lane's surface was in the previous frame.
struct ShadowOrigin {
  real x, y;
  SfPlane plane;
};

SIDERAY_LANE ShadowOrigin origin_of(const ShadowSequence& s, const float* motion, int32_t x, int32_t y, SfPlane plane) {
  const real here_x = to_real(ramp(x)), here_y(static_cast<float>(y));
  plane.inverse = sf_inverse_before(view_of(s.terms), here_x, here_y, plane.inverse);
  // A NaN or a coordinate outside the picture reads the border.
  return {min(max(real(-2.0f), here_x - load_any(motion)), static_cast<float>(s.width + 1)),
          min(max(real(-2.0f), here_y - load_any(motion + shadow_tile)), static_cast<float>(s.height + 1)), plane};
}

// Returns the previous frame's value there, interpolated between the four pixels around that lie on the plane.
SIDERAY_LANE SfHistory history_at(const ShadowSequence& s, const ShadowOrigin& there) {
  const ShadowHistoryPlanes& before = s.before;
  const int32_t stride = s.planes.stride;
  const real corner_x = floor(there.x), corner_y = floor(there.y);
  const integer corner = truncate(corner_y) * stride + truncate(corner_x) + s.planes.origin;
  real value(0.0f), frames(0.0f), total(0.0f);
  const boolean everywhere = corner == corner;
  read_at(corner, everywhere, [&](const auto& read) {
    for (int32_t tap = 0; tap < 4; ++tap) {
      const real dx = corner_x + static_cast<float>(tap & 1) - there.x;
      const real dy = corner_y + static_cast<float>(tap >> 1) - there.y;
      const int32_t other = (tap & 1) + (tap >> 1) * stride;
      const real share = (1.0f - abs(dx)) * (1.0f - abs(dy));
      const real weight = share * sf_on_plane(there.plane, dx, dy, read(before.inverse + other));
      value = value + weight * read(before.value + other);
      frames = frames + weight * read(before.frames + other);
      total = total + weight;
    }
  });
  const real most = max(total, real(1e-6f));
  return {value / most, sr_select(total > 0.05f, frames / most, real(0.0f))};
}

void accumulate_row(const ShadowSequence& s, const float* motion, int32_t x, int32_t y) {
  const ShadowPlanes& p = s.planes;
  for (int i = 0; i < shadow_tile; i += lane_count) {
    const int32_t at = p.origin + y * p.stride + x + i;
    const SfPlane plane = plane_at(p, at);
    const SfHistory known = history_at(s, origin_of(s, motion + i, x + i, y, plane));
    const real seen = load_any(p.visibility + at);
    // An exact history needs no clamping to its neighbourhood.
    SfMoments around{0.0f, 0.0f, 0.0f};
    if (sr_any(known.frames > 0.0f && !(known.value == seen))) around = moments_around(p, plane, at);
    const SfHistory now =
        sf_accumulate(light_of(s.terms), known, seen, around, sf_samples(load_any(p.reach + at)));
    store_any(s.after.value + at, now.value);
    store_any(s.after.frames + at, now.frames);
    store_any(s.after.inverse + at, plane.inverse);
  }
}

const ShadowKernels& shadow_kernels() {
  static constexpr ShadowKernels table{invert_row, slope_row, load_row, prepare_row, blur_row, accumulate_row};
  return table;
}

}  // namespace sideray::rt::SIDERAY_LANES
