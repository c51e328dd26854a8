// Is compiled once for each instruction set (sideray_lanes() in rt/CMakeLists.txt; rt/base/lanes.h). Any thread may
// call the kernels.
//
// The filter is an edge-avoiding a-trous wavelet filter with the 3x3 kernel of the linear B-spline;
// rt/irradiance/irradiance_filter.h explains its edges.
#include "rt/base/lane_reads.h"
#include "rt/irradiance/irradiance_kernels.h"

namespace sideray::rt::SIDERAY_LANES {

constexpr float pixels_a_cell = 2.0f;  // along each side
constexpr float reach = 0.5f;          // of the harmonic mean distance
constexpr float least_reach = 8.0f;    // widths of a pixel: noise is worse than light that leaks so far
constexpr float wall_margin = 2.0f;    // because few paths hit an occluder at its nearest point
constexpr float same_normal = 0.8f;    // cosine, at which cells share no light
constexpr float off_plane = 2.0f;      // widths of a pixel: a position so far away is on another plane
constexpr float least_share = 0.5f, whole_share = 0.99f;  // how well a position lies on a plane
constexpr float spline[3] = {0.25f, 0.5f, 0.25f};

SIDERAY_LANE real3 load_any(float* const (&values)[3], int32_t at) {
  return {load_any(values[0] + at), load_any(values[1] + at), load_any(values[2] + at)};
}

SIDERAY_LANE void store_any(float* const (&values)[3], int32_t at, real3 a) {
  store_any(values[0] + at, a.x);
  store_any(values[1] + at, a.y);
  store_any(values[2] + at, a.z);
}

SIDERAY_LANE boolean none() {
  return {IntVector{}};
}

struct Cell {
  real3 position, normal;
  real width;
};

SIDERAY_LANE Cell cell_at(const CellColumns& c, int32_t at) {
  return {load_any(c.position, at), load_any(c.normal, at), load_any(c.width + at)};
}

// Returns 1 / the distance from the plane at which cells that far apart are on another surface: a pixel's width for
// each pixel between them.
SIDERAY_LANE real off_plane_scale(real width, float cells) {
  return 1.0f / (width * (pixels_a_cell * cells));
}

// Returns how much of their light cells share: 1 on the same plane, 0 on another surface.
SIDERAY_LANE real likeness(real3 normal, real3 normal_there, real3 apart, real scale) {
  const real off = abs(dot(normal, apart)) * scale;
  const real turned = (dot(normal, normal_there) - same_normal) * (1.0f / (1.0f - same_normal));
  return max(1.0f - off, real(0.0f)) * max(turned, real(0.0f));
}

// Returns the upper limit of nearness for cells of that width.
SIDERAY_LANE real most_nearness(real width) {
  return 1.0f / (least_reach * width);
}

// Returns how much light a cell shares with another at a distance, 1 to 0, by the nearness of the light's origins.
SIDERAY_LANE real nearby(real most, real nearness, real nearness_there, real distance) {
  return max(1.0f - distance * min(max(nearness, nearness_there) * (1.0f / reach), most), real(0.0f));
}

// Returns whether an occluder may be as near to a cell as the root of `squared`.
SIDERAY_LANE boolean is_near(real most_near, real squared) {
  const real share = wall_margin * most_near;
  return squared * share * share > 1.0f;
}

SIDERAY_LANE boolean is_open(integer walls, int32_t bit) {
  return integer(walls.v & bit) == 0;
}

// Returns the bit of a forward direction.
SIDERAY_LANE int32_t wall_bit(int32_t number, int32_t i, int32_t j) {
  return 1 << (wall_ways * number + (j == 0 ? 0 : i + 2));
}

// Calls visit(index, lanes, weight, distance) for the cells themselves and those around, 1 << number apart, that may
// share light.
template <typename Visit>
SIDERAY_LANE void for_taps(const CellColumns& c, int32_t at, int32_t number, const Visit& visit) {
  const int32_t step = 1 << number;
  const Cell own = cell_at(c, at);
  const boolean drawn = own.width > 0.0f;
  if (!sr_any(drawn)) return;
  const real scale = off_plane_scale(own.width, static_cast<float>(step));
  const integer own_walls = load_any(c.walls + at);
  for (int32_t j = -1; j <= 1; ++j)
    for (int32_t i = -1; i <= 1; ++i) {
      const float tap = spline[i + 1] * spline[j + 1];
      const int32_t other = at + (j * c.stride + i) * step;
      if (other == at) {
        visit(at, drawn, real(tap), real(0.0f));
        continue;
      }
      const boolean both = drawn && load_any(c.width + other) > 0.0f;
      if (!sr_any(both)) continue;
      const real3 apart = load_any(c.position, other) - own.position;
      const real like = likeness(own.normal, load_any(c.normal, other), apart, scale);
      const bool forward = j > 0 || (j == 0 && i > 0);
      const integer walls = forward ? own_walls : load_any(c.walls + other);
      const int32_t bit = forward ? wall_bit(number, i, j) : wall_bit(number, -i, -j);
      const boolean shared = both && like > 0.0f && is_open(walls, bit);
      if (sr_any(shared)) visit(other, shared, tap * like, length(apart));
    }
}

void smooth(const CellColumns& c, int32_t first, int32_t number) {
  for (int32_t at = first; at < first + cells_at_once; at += lane_count) {
    real near(0.0f), open(0.0f), weights(0.0f);
    for_taps(c, at, number, [&](int32_t other, boolean which, real weight, real) __attribute__((always_inline)) {
      const real w = weight * load_any(c.samples + other);
      near = sr_select(which, near + w * load_any(c.nearness + other), near);
      open = sr_select(which, open + w * load_any(c.open + other), open);
      weights = sr_select(which, weights + w, weights);
    });
    const boolean some = weights > 0.0f;
    store_any(c.next_nearness + at, sr_select(some, near / weights, load_any(c.nearness + at)));
    store_any(c.next_open + at, sr_select(some, open / weights, load_any(c.open + at)));
  }
}

void pass(const CellColumns& c, int32_t first, int32_t number) {
  for (int32_t at = first; at < first + cells_at_once; at += lane_count) {
    const real most = most_nearness(load_any(c.width + at)), nearness = load_any(c.nearness + at);
    real3 sum(real(0.0f), real(0.0f), real(0.0f));
    real weights(0.0f);
    for_taps(c, at, number, [&](int32_t other, boolean which, real weight, real distance) __attribute__((always_inline)) {
      const real w =
          weight * nearby(most, nearness, load_any(c.nearness + other), distance) * load_any(c.samples + other);
      sum = sr_select(which, sum + load_any(c.light, other) * w, sum);
      weights = sr_select(which, weights + w, weights);
    });
    const real3 mean(sum.x / weights, sum.y / weights, sum.z / weights);
    store_any(c.next_light, at, sr_select(weights > 0.0f, mean, load_any(c.light, at)));
  }
}

void ask_for_walls(const CellColumns& c, int32_t first, int32_t number, bool by_distance, uint32_t (&ways)[wall_ways]) {
  const int32_t step = 1 << number;
  const auto cells = static_cast<float>(step);
  for (uint32_t& way : ways) way = 0;
  for (int32_t at = first; at < first + cells_at_once; at += lane_count) {
    const Cell own = cell_at(c, at);
    const boolean drawn = own.width > 0.0f;
    if (!sr_any(drawn)) continue;
    const real most_near = load_any(c.most_near + at), samples = load_any(c.samples + at), nearness = load_any(c.nearness + at);
    for (int32_t way = 0; way < wall_ways; ++way) {
      const int32_t other = at + (wall_way_y[way] * c.stride + wall_way_x[way]) * step;
      const real3 apart = load_any(c.position, other) - own.position;
      const real squared = dot(apart, apart), width_there = load_any(c.width + other);
      boolean asked = drawn && width_there > 0.0f &&
                      (is_near(most_near, squared) || is_near(load_any(c.most_near + other), squared)) &&
                      samples + load_any(c.samples + other) > 0.0f;
      if (!sr_any(asked)) continue;
      const Cell there = cell_at(c, other);
      const real like = likeness(own.normal, there.normal, apart, off_plane_scale(own.width, cells)),
                 like_there = likeness(there.normal, own.normal, apart, off_plane_scale(there.width, cells));
      asked = asked && (like > 0.0f || like_there > 0.0f);
      if (by_distance) {
        const real distance = length(apart), nearness_there = load_any(c.nearness + other);
        asked = asked && (nearby(most_nearness(own.width), nearness, nearness_there, distance) > 0.0f ||
                          nearby(most_nearness(there.width), nearness, nearness_there, distance) > 0.0f);
      }
      ways[way] |= lane_bits(asked) << (at - first);
    }
  }
}

// Describes a pixel's plane: the normal of the nearest cell that shows it, else of the cell whose plane is nearest.
struct Plane {
  real3 normal;
  boolean known;
  real shares[9];    // how well the pixel lies on the planes of the cells around
  boolean drawn[9];  // which of these have a surface
};

// `away`: offset of the pixels from the middle of their cells, in cells.
SIDERAY_LANE void find_plane(const CellColumns& c, int32_t at, real3 position, float away_x, float away_y, Plane& plane) {
  plane.normal = {real(0.0f), real(0.0f), real(0.0f)};
  plane.known = none();
  real best(least_share);
  for (int32_t k = 0; k < 9; ++k) {
    const int32_t i = k % 3 - 1, j = k / 3 - 1, other = at + j * c.stride + i;
    const Cell there = cell_at(c, other);
    const real share = 1.0f - abs(dot(there.normal, position - there.position)) / (off_plane * there.width);
    const float way_x = static_cast<float>(i) - away_x, way_y = static_cast<float>(j) - away_y;
    const real score = sr_select(share > whole_share, real(2.0f - 0.1f * (way_x * way_x + way_y * way_y)), share);
    plane.shares[k] = share;
    plane.drawn[k] = there.width > 0.0f;
    const boolean better = plane.drawn[k] && score > best;
    best = sr_select(better, score, best);
    plane.normal = sr_select(better, there.normal, plane.normal);
    plane.known = plane.known || better;
  }
}

// Returns which pixels a neighbour of their own cell may light: no wall stands between the two cells.
SIDERAY_LANE boolean is_reached(const CellColumns& c, int32_t at, int32_t i, int32_t j) {
  const bool forward = j > 0 || (j == 0 && i > 0);
  const integer walls = load_any(c.walls + (forward ? at : at + j * c.stride + i));
  return is_open(walls, forward ? wall_bit(0, i, j) : wall_bit(0, -i, -j));
}

uint32_t spread(const CellColumns& c, int32_t first, int32_t x, int32_t y, const PixelColumns& pixels) {
  constexpr float beyond = 1.5f;  // cells, where the weight is 0
  const float away_x = (static_cast<float>(x) - 0.5f) / pixels_a_cell, away_y = (static_cast<float>(y) - 0.5f) / pixels_a_cell;
  uint32_t done = 0;
  for (int32_t lane = 0; lane < cells_at_once; lane += lane_count) {
    const int32_t at = first + lane;
    const boolean drawn = load_any(pixels.depth + lane) > 0.0f;
    if (!sr_any(drawn)) {
      done |= ((1u << lane_count) - 1u) << lane;
      continue;
    }
    const real3 position = load_any(pixels.position, lane);
    Plane plane;
    find_plane(c, at, position, away_x, away_y, plane);
    const auto uses = [&](int32_t k, int32_t other) __attribute__((always_inline)) {
      return drawn && plane.known && plane.drawn[k] && load_any(c.samples + other) > 0.0f &&
             dot(load_any(c.normal, other), plane.normal) > same_normal && plane.shares[k] > 0.0f;
    };
    const auto may_stand = [&](int32_t other) __attribute__((always_inline)) {
      const real3 way = load_any(c.position, other) - position;
      return is_near(load_any(c.most_near + other), dot(way, way));
    };
    const boolean own = uses(4, at);
    boolean asks = own && may_stand(at);
    real3 sum(real(0.0f), real(0.0f), real(0.0f));
    real weights(0.0f);
    for (int32_t k = 0; k < 9; ++k) {
      const int32_t i = k % 3 - 1, j = k / 3 - 1, other = at + j * c.stride + i;
      boolean used = k == 4 ? own : uses(k, other);
      if (!sr_any(used)) continue;
      if (k != 4) {
        asks = asks || (used && !own && may_stand(other));
        used = used && (!own || is_reached(c, at, i, j));
      }
      const float way_x = static_cast<float>(i) - away_x, way_y = static_cast<float>(j) - away_y;
      const float near_x = beyond - (way_x < 0.0f ? -way_x : way_x), near_y = beyond - (way_y < 0.0f ? -way_y : way_y);
      const real weight = near_x * near_y * plane.shares[k];
      sum = sr_select(used, sum + load_any(c.light, other) * weight, sum);
      weights = sr_select(used, weights + weight, weights);
    }
    const boolean lit = weights > 0.0f && !asks;
    const real3 zero(real(0.0f), real(0.0f), real(0.0f)), mean(sum.x / weights, sum.y / weights, sum.z / weights);
    store_any(pixels.light, lane, sr_select(lit, mean, zero));
    done |= lane_bits(lit || !drawn) << lane;
  }
  return done;
}

const IrradianceKernels& irradiance_kernels() {
  static constexpr IrradianceKernels table{smooth, pass, ask_for_walls, spread};
  return table;
}

}  // namespace sideray::rt::SIDERAY_LANES
