// Is compiled once for each instruction set (sideray_lanes() in rt/CMakeLists.txt; rt/base/lanes.h). Operations have
// the same order as in rt/masks/depth_points.cpp. Any thread may call the kernels.
#include "rt/points/double_lanes.h"
#include "rt/points/point_kernels.h"
#include "rt/points/ray_lanes.h"
#include "rt/points/seen_lanes.h"

namespace sideray::rt::SIDERAY_LANES {

constexpr double point_rounding = 0x1p-21, slope_margin = 2.0, steepest_step = 4.0, pixel_share = 0.5;
constexpr double bent_share = 0.125, bent_noise = 8.0;
constexpr double plane_share = 0x1p-6, straighter_factor = 2.0, straighter_noise = 8.0;

// Describes a pixel's neighbour along an axis.
struct SeenNeighbor {
  DoubleVector distance, cost;  // cost: infinite if it certainly shows another surface
  LongVector is_there;          // it shows a surface, and has a rest pose if the pixel has one
};

// Describes how the depth continues on one side of a pixel; see DepthPoints::Single::Side.
struct SeenSide {
  DoubleVector change, bend;
  LongVector is_there, straight, plane;
};

struct SeenStep {
  Doubles3 along;
  DoubleVector slope, breadth;
  LongVector known;
};

// Examines the pixels of a row of a tile, from `at` on; their neighbours are `stride` apart.
class SeenAxis {
 public:
  SIDERAY_LANE SeenAxis(const SeenPixels& seen, int at, int stride, DoubleVector noise)
      : seen_(seen), at_(at), stride_(stride), noise_(noise) {
    distance_ = load_doubles(seen.distance + at);
    for (int k = -2; k <= 2; ++k)
      if (k != 0) neighbors_[k + 2] = neighbor(k);
    down_ = look(-1), up_ = look(1);
  }

  // See DepthPoints::Sides.
  SIDERAY_LANE LongVector plane() const { return down_.plane | up_.plane; }

  // See DepthPoints::step().
  SIDERAY_LANE SeenStep step(LongVector planes) const {
    const SeenNeighbor &before = neighbors_[1], &after = neighbors_[3];
    const SeenSide &down = down_, &up = up_;
    const LongVector goes_on_after =
        ~(planes & straighter(down, up)) & ((planes & straighter(up, down)) | (after.cost <= before.cost));
    const DoubleVector slope = goes_on_after ? after.cost : before.cost;
    const double(&positions)[3][seen_rows * seen_stride] = seen_.rests ? seen_.position : seen_.drawn;
    const Doubles3 here = load_doubles(positions, at_);
    const Doubles3 along = chosen(goes_on_after, load_doubles(positions, at_ + stride_) - here,
                                  here - load_doubles(positions, at_ - stride_));
    const Doubles3 drawn = chosen(goes_on_after, load_doubles(seen_.drawn, at_ + stride_),
                                  load_doubles(seen_.drawn, at_ - stride_)) -
                           load_doubles(seen_.drawn, at_);
    const DoubleVector steepest = steepest_side(down, up, goes_on_after);
    const DoubleVector breadth = root(greater(dot(drawn, drawn) - slope * slope, every(0.0)));
    const LongVector goes_on = slope < nothing;
    const LongVector known = goes_on & ((slope <= steepest_step * breadth) | is_straight(goes_on_after));
    const Doubles3 none{every(0.0), every(0.0), every(0.0)};
    const DoubleVector width = goes_on ? breadth : every(0.0);
    const DoubleVector widest = goes_on ? steepest_step * breadth : every(0.0);
    return {chosen(known, along, none), known ? steepest : widest, width, known};
  }

 private:
  SIDERAY_LANE SeenNeighbor neighbor(int steps) const {
    const int other = at_ + steps * stride_;
    const DoubleVector distance = load_doubles(seen_.distance + other);
    LongVector is_there = distance < nothing;
    if (seen_.rests) {
      LongVector resting, resting_here;
      __builtin_memcpy(&resting, seen_.resting + other, sizeof(resting));
      __builtin_memcpy(&resting_here, seen_.resting + at_, sizeof(resting));
      is_there &= resting == resting_here;
    }
    return {distance, is_there ? absolute(distance - distance_) : every(nothing), is_there};
  }

  // Returns the change of depth to a pixel. In perspective the distance changes from ray to ray even at constant depth.
  SIDERAY_LANE DoubleVector change(DoubleVector w) const {
    return (1.0 - w / load_doubles(seen_.w + at_)) * distance_;
  }

  // See DepthPoints::look().
  SIDERAY_LANE SeenSide look(int steps) const {
    const SeenNeighbor &next = neighbors_[2 + steps], &beyond = neighbors_[2 + 2 * steps];
    const DoubleVector first = change(load_doubles(seen_.w + at_ + steps * stride_));
    const DoubleVector second = change(load_doubles(seen_.w + at_ + 2 * steps * stride_));
    const DoubleVector bend = absolute(second - 2.0 * first);
    const LongVector both = next.is_there & beyond.is_there;
    return {first, both ? bend : every(nothing), next.is_there,
            both & (bend <= bent_share * absolute(first) + bent_noise * noise_),
            both & (bend <= plane_share * absolute(first) + 0.5 * straighter_noise * noise_)};
  }
  SIDERAY_LANE LongVector straighter(const SeenSide& side, const SeenSide& other) const {
    return side.plane & (straighter_factor * side.bend + straighter_noise * noise_ < other.bend);
  }

  // See DepthPoints::slope().
  SIDERAY_LANE DoubleVector steepest_side(const SeenSide& down, const SeenSide& up, LongVector goes_on_after) const {
    const DoubleVector best = slope_margin * absolute(goes_on_after ? up.change : down.change);
    const DoubleVector other = absolute(goes_on_after ? down.change : up.change);
    const LongVector other_there = goes_on_after ? down.is_there : up.is_there;
    const LongVector folds = goes_on_after ? down.straight : up.straight;
    const DoubleVector steeper = folds ? greater(best, slope_margin * other) : best;
    return other_there ? steeper : 2.0 * best;
  }

  // Returns whether a third pixel on either side is on one plane with the two.
  SIDERAY_LANE LongVector is_straight(LongVector goes_on_after) const {
    const DoubleVector here = load_doubles(seen_.inverse + at_);
    const auto inverse = [&](int steps) { return load_doubles(seen_.inverse + at_ + steps * stride_); };
    const DoubleVector before = inverse(-1), after = inverse(1);
    const DoubleVector first = (goes_on_after ? after : before) - here;
    const DoubleVector beyond = (goes_on_after ? inverse(2) : inverse(-2)) - here;
    const DoubleVector opposite = (goes_on_after ? before : after) - here;
    const DoubleVector bound = 0.1 * absolute(first);
    const LongVector beyond_there = goes_on_after ? neighbors_[4].cost < nothing : neighbors_[0].cost < nothing;
    const LongVector opposite_there = goes_on_after ? neighbors_[1].cost < nothing : neighbors_[3].cost < nothing;
    return (beyond_there & (absolute(beyond - 2.0 * first) <= bound)) |
           (opposite_there & (absolute(opposite - -1.0 * first) <= bound));
  }

  const SeenPixels& seen_;
  int at_, stride_;
  DoubleVector noise_, distance_;
  SeenNeighbor neighbors_[5];
  SeenSide down_, up_;
};

// See DepthPoints::normal().
SIDERAY_LANE Doubles3 depth_normal(const SeenStep& across, const SeenStep& up, Doubles3 toward) {
  const LongVector both = across.known & up.known;
  Doubles3 n = cross(across.along, up.along);
  if (double_bits(~both) != 0) {
    const Doubles3 along = chosen(across.known, across.along, up.along);
    const DoubleVector square = dot(along, along);
    const Doubles3 tilted = along * (dot(along, toward) / square) - toward;
    n = chosen(both, n, chosen(square > 0.0, tilted, -toward));
  }
  const DoubleVector length = root(dot(n, n));
  return chosen((length > 0.0) & (length < nothing), n / length, -toward);
}

// Writes the values of a row's pixels, from `column` on, in the tile's block order.
SIDERAY_LANE void store_blocked(float* values, int column, int row, DoubleVector v) {
  const NarrowVector narrow = narrowed(v);
  constexpr int piece = double_count < point_block ? double_count : point_block;
  for (int i = 0; i < double_count; i += piece) {
    const int x = column + i;
    const int block = row / point_block * blocks_across + x / point_block;
    float* to = values + block * block_pixels + row % point_block * point_block + x % point_block;
    __builtin_memcpy(to, reinterpret_cast<const char*>(&narrow) + 4 * i, 4 * piece);
  }
}
SIDERAY_LANE void store_blocked(float (&planes)[3][point_tile_pixels], int column, int row, Doubles3 v) {
  store_blocked(planes[0], column, row, v.x);
  store_blocked(planes[1], column, row, v.y);
  store_blocked(planes[2], column, row, v.z);
}

SIDERAY_LANE void note_drawn(PointTile& tile, int column, int row, uint32_t bits) {
  for (int i = 0; i < double_count; ++i) {
    const int x = column + i;
    uint16_t& block = tile.drawn[row / point_block * blocks_across + x / point_block];
    const uint32_t bit = (bits >> i & 1u) << (row % point_block * point_block + x % point_block);
    block = static_cast<uint16_t>(block | bit);
  }
}

// Returns the length that rays skip if the surface's tilt is unknown.
SIDERAY_LANE DoubleVector unknown_share(const SeenPixels& seen, int at, DoubleVector distance) {
  NarrowVector turn[3];
  for (int i = 0; i < 3; ++i) {
    NarrowVector here, beside;
    __builtin_memcpy(&here, seen.direction[i] + at, sizeof(here));
    __builtin_memcpy(&beside, seen.direction[i] + at + 1, sizeof(beside));
    turn[i] = beside - here;
  }
  const Doubles3 move = Doubles3{widened(turn[0]), widened(turn[1]), widened(turn[2])} * distance;
  return pixel_share * root(dot(move, move));
}

void points_row(const PointView& view, const SeenPixels& seen, int seen_row, PointTile& tile) {
  const int row = seen_row - seen_border;
  for (int column = 0; column < point_tile_size; column += double_count) {
    const int at = seen_row * seen_stride + column + seen_border;
    const DoubleVector distance = load_doubles(seen.distance + at);
    const LongVector drawn = distance < nothing;
    const uint32_t bits = double_bits(drawn);
    if (bits == 0) continue;
    note_drawn(tile, column, row, bits);
    const DoubleVector seen_off = load_doubles(seen.off + at), noise = seen_off * view.noise;
    const SeenAxis columns(seen, at, 1, noise), rows(seen, at, seen_stride, noise);
    const LongVector planes = columns.plane() & rows.plane();
    const SeenStep across = columns.step(planes), up = rows.step(planes);
    const auto moved_by = [&](DoubleVector stored) {
      return stored + (across.slope + up.slope + 4.0 * stored) * view.subpixel;
    };
    const DoubleVector off = moved_by(seen_off);
    const Doubles3 toward = load_widened(seen.direction, at);
    Doubles3 normal = depth_normal(across, up, toward);
    LongVector resting{};
    if (seen.rests) __builtin_memcpy(&resting, seen.resting + at, sizeof(resting));
    const LongVector turned = ~resting & (dot(normal, toward) > 0.0);
    normal = chosen(turned, -normal, normal);
    const Doubles3 position = load_doubles(seen.rests ? seen.position : seen.drawn, at);
    const DoubleVector least =
        point_rounding * greater(greater(absolute(position.x), absolute(position.y)), absolute(position.z));
    const LongVector unknown = ~(across.known & up.known);
    Doubles3 moved = -toward * off + normal * least;
    Doubles3 moved_back = moved;
    if (double_bits(unknown) != 0)
      moved_back = chosen(unknown, -toward * moved_by(noise) + normal * least, moved);
    if (seen.rests) {
      const DoubleVector any_way = off + (across.breadth + up.breadth) * view.subpixel;
      moved = chosen(resting, normal * (any_way + least), moved);
      moved_back = chosen(resting, moved, moved_back);
    }
    const auto doubt = [&](const SeenStep& s) {
      return s.known ? 2.0 * seen_off / root(dot(s.along, s.along)) : every(0.0);
    };
    store_blocked(tile.front, column, row, position + moved);
    store_blocked(tile.back, column, row, position - moved_back);
    store_blocked(tile.normal, column, row, normal);
    store_blocked(tile.doubt, column, row, lesser(doubt(across) + doubt(up), every(2.0)));
    DoubleVector skip = every(0.0);
    if (double_bits(unknown) != 0) skip = unknown ? unknown_share(seen, at, distance) : skip;
    store_blocked(tile.skip, column, row, skip);
  }
}

const PointKernels& point_kernels() {
  static constexpr PointKernels table{see_row, points_row, sample_tile, rays_of_tile};
  return table;
}

}  // namespace sideray::rt::SIDERAY_LANES
