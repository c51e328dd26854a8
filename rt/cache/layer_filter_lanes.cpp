// Is compiled once for each instruction set (sideray_lanes() in rt/CMakeLists.txt; rt/base/lanes.h). Any thread may
// call the kernels.
//
// The filter runs edge-avoiding a-trous wavelets (Dammertz et al. 2010) with the 3x3 kernel of the linear B-spline.
// Edges are those of surfaces, never of the noisy signal. The filter's radius follows from the lobe: if the point moves
// by x on the surface, the lobe's footprint at distance d moves by x (1 + d / D), with D the eye's distance, because
// the mirrored eye's rays spread as the eye's do. The lobe's own width there is about 2 alpha d. A radius that is a
// share of that blurs only what the lobe has blurred already. It shrinks to zero where surfaces touch, so contacts stay
// sharp.
#include "rt/base/lane_reads.h"
#include "rt/cache/layer_filter_kernels.h"

namespace sideray::rt::SIDERAY_LANES {

constexpr float least_reach_px = 0.5f;
constexpr float like_roughness = 0.2f;  // largest relative difference of roughness
constexpr int around_count = 8;

SIDERAY_LANE real3 load_any(float* const (&values)[3], int32_t at) {
  return {load_any(values[0] + at), load_any(values[1] + at), load_any(values[2] + at)};
}

SIDERAY_LANE real4 load_any(float* const (&values)[4], int32_t at) {
  return {load_any(values[0] + at), load_any(values[1] + at), load_any(values[2] + at), load_any(values[3] + at)};
}

SIDERAY_LANE void store_any(float* const (&values)[4], int32_t at, real4 a) {
  store_any(values[0] + at, a.x);
  store_any(values[1] + at, a.y);
  store_any(values[2] + at, a.z);
  store_any(values[3] + at, a.w);
}

SIDERAY_LANE boolean is_some(integer layer) {
  return integer(-1) < layer;
}

template <typename Read>
SIDERAY_LANE real3 read3(const Read& read, float* const (&values)[3]) {
  return {read(values[0]), read(values[1]), read(values[2])};
}

constexpr float bell_end = 8.0f;

// Approximates exp(-q / 2), with the same bits everywhere.
SIDERAY_LANE real bell(real q) {
  const real rest = max(1.0f - q * (1.0f / bell_end), real(0.0f));
  return rest * rest * rest * rest;
}

// Holds up to sixteen layers whose neighbours are searched for.
struct Centre {
  real3 position, geometric_normal;
  integer surface;
  integer heads[around_count];  // first layers of the eight pixels around
};

SIDERAY_LANE int32_t offset_of(const LayerColumns& c, int k, int32_t step) {
  const int i = k < 4 ? k : k + 1;  // in rows, without the centre
  return ((i / 3 - 1) * c.stride + i % 3 - 1) * step;
}

SIDERAY_LANE Centre centre_at(const LayerColumns& c, int32_t at) {
  Centre centre;
  centre.position = load_any(c.position, at);
  centre.geometric_normal = load_any(c.geometric_normal, at);
  centre.surface = load_any(c.surface + at);
  return centre;
}

SIDERAY_LANE void find_heads(const LayerColumns& c, int32_t at, int32_t step, boolean wanted, Centre& centre) {
  read_at(load_any(c.pixel + at), wanted, [&](const auto& read) {
    for (int k = 0; k < around_count; ++k)
      centre.heads[k] = sr_select(wanted, read(c.first + offset_of(c, k, step)), integer(-1));
  });
}

// Returns a layer of the pixel whose layers start at `head`, or none. The layer must be on the same part of the same
// surface: near the plane of `a`, with a tolerance for the bend between the two normals.
SIDERAY_LANE integer like(const LayerColumns& c, const Centre& a, integer head) {
  constexpr float flat = 0.05f, most_bend = 0.5f;
  integer candidate = head, best(-1);
  real least(0.0f);
  for (boolean some = is_some(candidate); sr_any(some); some = is_some(candidate)) {
    read_at(candidate, some, [&](const auto& read) {
      const boolean same = some && read(c.surface) == a.surface;
      if (sr_any(same)) {
        const real3 apart = read3(read, c.position) - a.position;
        const real3 bend = read3(read, c.geometric_normal) - a.geometric_normal;
        const real off = abs(dot(apart, a.geometric_normal)), bend2 = dot(bend, bend), bound = sqrt(bend2) + flat;
        const boolean on_one_part = bend2 < most_bend * most_bend && off * off <= bound * bound * dot(apart, apart);
        const boolean nearest = same && on_one_part && (!is_some(best) || off < least);
        best = sr_select(nearest, candidate, best);
        least = sr_select(nearest, off, least);
      }
      candidate = sr_select(some, read(c.next), candidate);
    });
  }
  return best;
}

// Returns whether a layer of the same surface is within `reach`, which ends where bell() does.
SIDERAY_LANE bool reaches(const LayerColumns& c, const Centre& a, real reach, integer head) {
  integer candidate = head;
  boolean within = integer(0) < integer(0);
  for (boolean some = is_some(candidate); sr_any(some) && !sr_any(within); some = is_some(candidate))
    read_at(candidate, some, [&](const auto& read) {
      const real3 apart = read3(read, c.position) - a.position;
      within = some && read(c.surface) == a.surface && !(dot(apart, apart) / (reach * reach) >= bell_end);
      candidate = sr_select(some, read(c.next), candidate);
    });
  return sr_any(within);
}

// Returns how many equal weights would average as well as all passes do within the reach. Steps 1, 2, 4, 8 of [1 2 1] /
// 4 have a total variance of 0.5 (1 + 4 + 16 + 64) along each axis, which the reach limits. A Gaussian of variance v
// averages 4 pi v samples.
SIDERAY_LANE real samples_averaged(real reach_px) {
  constexpr float variance = 0.5f * ((1 << 2 * layer_filter_passes) - 1) / 3;
  return max(real(12.566f) / (1.0f / variance + 1.0f / (reach_px * reach_px)), real(1.0f));
}

// Limits each direction's light relative to the mean of its neighbours, because where few layers are averaged a far
// brighter one would show as a spot. Directions above at least four times the mean lose energy. Layers that are not
// averaged are not limited.
void prepare_layers(const LayerColumns& c, int32_t first) {
  for (int32_t at = first; at < first + layers_at_once; at += lane_count) {
    Centre centre = centre_at(c, at);
    const real4 own = load_any(c.reflected, at);
    const real own_light = max(max(own.x, own.y), own.z);
    real nearness = load_any(c.nearness + at), light = own_light, count(1.0f);
    for (int32_t pass = 0; pass < kept_steps; ++pass) {
      find_heads(c, at, 1 << pass, integer(0) == integer(0), centre);
      for (int k = 0; k < around_count; ++k) {
        const integer other = like(c, centre, centre.heads[k]);
        store_any(c.near[pass][k] + at, other);
        const boolean some = is_some(other);
        if (!sr_any(some)) continue;
        read_at(other, some, [&](const auto& read) {
          const real3 there = read3(read, {c.reflected[0], c.reflected[1], c.reflected[2]});
          nearness = sr_select(some, nearness + read(c.nearness), nearness);
          light = sr_select(some, light + max(max(there.x, there.y), there.z), light);
          count = sr_select(some, count + 1.0f, count);
        });
      }
    }
    nearness = nearness / count;
    light = light / count;
    const real width = load_any(c.width + at);
    const real reach_px = load_any(c.lobe + at) / (width * nearness + load_any(c.spread + at));
    const boolean is_short = reach_px < least_reach_px;
    const real most = max(samples_averaged(reach_px) * 0.5f, real(4.0f)) * light;
    const real kept = sr_select(reach_px >= least_reach_px && own_light > most, most / own_light, real(1.0f));
    store_any(c.reach + at, sr_select(is_short, real(-1.0f), reach_px * width));
    store_any(c.filtered, at, {own.x * kept, own.y * kept, own.z * kept, own.w});
  }
}

// Holds layers that are blurred, and the weighted sum of what they and their neighbours reflect.
struct Blurred {
  Centre centre;
  real reach, roughness;
  real3 normal;
  real4 sum;
  real weights;
};

// Adds neighbours where `wanted`. Weights are relative to 1 in the middle: `kernel` for an equal normal and roughness
// nearby, falling to 0.
SIDERAY_LANE void add_neighbours(const LayerColumns& c, integer other, boolean wanted, float kernel, Blurred& to) {
  read_at(other, wanted, [&](const auto& read) {
    const real reach_there = read(c.reach), shorter = min(to.reach, reach_there);
    const real3 apart = read3(read, c.position) - to.centre.position;
    const real far = dot(apart, apart) / (shorter * shorter);
    const boolean is_near = wanted && !(reach_there < 0.0f) && !(far >= bell_end);
    if (!sr_any(is_near)) return;
    const real3 bend = read3(read, c.normal) - to.normal;
    const real roughness_there = read(c.roughness), turn = to.roughness * to.roughness * share_of_lobe;
    const real rougher = (roughness_there - to.roughness) / (min(to.roughness, roughness_there) * like_roughness);
    const real weight = bell(far + dot(bend, bend) / (turn * turn) + rougher * rougher) * kernel;
    const boolean counts = is_near && !(weight <= 0.0f);
    if (!sr_any(counts)) return;
    to.sum.x = sr_select(counts, to.sum.x + read(c.reflected[0]) * weight, to.sum.x);
    to.sum.y = sr_select(counts, to.sum.y + read(c.reflected[1]) * weight, to.sum.y);
    to.sum.z = sr_select(counts, to.sum.z + read(c.reflected[2]) * weight, to.sum.z);
    to.sum.w = sr_select(counts, to.sum.w + read(c.reflected[3]) * weight, to.sum.w);
    to.weights = sr_select(counts, to.weights + weight, to.weights);
  });
}

void blur_layers(const LayerColumns& c, int32_t first, int32_t pass) {
  constexpr float kernel[around_count] = {0.25f, 0.5f, 0.25f, 0.5f, 0.5f, 0.25f, 0.5f, 0.25f};
  for (int32_t at = first; at < first + layers_at_once; at += lane_count) {
    const real reach = load_any(c.reach + at);
    const boolean wanted = !(reach < 0.0f);
    const real4 own = load_any(c.reflected, at);
    if (!sr_any(wanted)) {
      store_any(c.filtered, at, own);
      continue;
    }
    Blurred to{centre_at(c, at), reach, load_any(c.roughness + at), load_any(c.normal, at), own, real(1.0f)};
    if (pass >= kept_steps) find_heads(c, at, 1 << pass, wanted, to.centre);
    for (int k = 0; k < around_count; ++k) {
      if (pass >= kept_steps && !reaches(c, to.centre, reach, to.centre.heads[k])) continue;
      const integer other = pass < kept_steps ? load_any(c.near[pass][k] + at) : like(c, to.centre, to.centre.heads[k]);
      const boolean some = wanted && is_some(other);
      if (sr_any(some)) add_neighbours(c, other, some, kernel[k], to);
    }
    store_any(c.filtered, at,
              {sr_select(wanted, to.sum.x / to.weights, own.x), sr_select(wanted, to.sum.y / to.weights, own.y),
               sr_select(wanted, to.sum.z / to.weights, own.z), sr_select(wanted, to.sum.w / to.weights, own.w)});
  }
}

const LayerFilterKernels& layer_filter_kernels() {
  static constexpr LayerFilterKernels table{prepare_layers, blur_layers};
  return table;
}

}  // namespace sideray::rt::SIDERAY_LANES
