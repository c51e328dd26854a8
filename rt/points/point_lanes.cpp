// Is compiled once for each instruction set (sideray_lanes() in rt/CMakeLists.txt; rt/base/lanes.h). Operations have
// the same order as in rt/base/view_rays.cpp, rt/masks/depth_points.cpp and rt/base/sampling.h. Any thread may call the
// kernels.
#include "rt/points/double_lanes.h"
#include "rt/points/point_kernels.h"

namespace sideray::rt::SIDERAY_LANES {

// --- Content of the depth buffer.

constexpr double nothing = __builtin_inf();
constexpr double farthest_point = 1e30;

SIDERAY_LANE Doubles3 every(const double (&v)[3]) {
  return {every(v[0]), every(v[1]), every(v[2])};
}
SIDERAY_LANE Doubles3 load_doubles(const double (&planes)[3][seen_rows * seen_stride], int at) {
  return {load_doubles(planes[0] + at), load_doubles(planes[1] + at), load_doubles(planes[2] + at)};
}
SIDERAY_LANE Doubles3 load_widened(const float (&planes)[3][seen_rows * seen_stride], int at) {
  NarrowVector v[3];
  for (int i = 0; i < 3; ++i) __builtin_memcpy(&v[i], planes[i] + at, sizeof(v[i]));
  return {widened(v[0]), widened(v[1]), widened(v[2])};
}

// Returns the distance along the rays for a window depth.
SIDERAY_LANE DoubleVector distance_at(const PointView& view, DoubleVector depth, DoubleVector pixel_w,
                                      DoubleVector length) {
  const DoubleVector z = view.zero_to_one ? depth : 2.0 * depth - 1.0;
  const DoubleVector w = view.sign * (pixel_w + view.w_z * z + view.w_one);
  return w * farthest_point > length ? length / w : every(nothing);
}

// Returns twice the largest difference between the stored depth and the one that the rasterizer computed.
SIDERAY_LANE DoubleVector depth_step(const PointView& view, DoubleVector depth) {
  if (view.step > 0.0) return every(view.step);
  using Bits = int32_t __attribute__((vector_size(sizeof(NarrowVector))));
  const NarrowVector stored = narrowed(depth), zero{};
  const NarrowVector f = zero < stored ? stored : zero;
  const NarrowVector next = __builtin_bit_cast(NarrowVector, __builtin_bit_cast(Bits, f) + 1);
  const DoubleVector ulp = widened(next) - widened(f);
  return view.zero_to_one ? ulp : greater(ulp, every(0x1p-24));
}

void see_row(const PointView& view, const double* depth, double x, double y, int row, SeenPixels& seen) {
  const bool inner = row >= seen_border && row < seen_border + point_tile_size;
  const double ndc_y = (y + 0.5) * view.pixel_y - 1.0;
  const Doubles3 from_y{every(ndc_y * view.along_y[0]), every(ndc_y * view.along_y[1]), every(ndc_y * view.along_y[2])};
  const Doubles3 center = every(view.center), along_x = every(view.along_x);
  const Doubles3 eye{every(static_cast<double>(view.eye[0])), every(static_cast<double>(view.eye[1])),
                     every(static_cast<double>(view.eye[2]))};
  for (int i = 0; i < seen_stride; i += double_count) {
    const int at = row * seen_stride + i;
    DoubleVector column;
    for (int k = 0; k < double_count; ++k) column[k] = static_cast<double>(i + k);
    const DoubleVector ndc_x = (x + column + 0.5) * view.pixel_x - 1.0;
    const Doubles3 ray = center + along_x * ndc_x + from_y;
    const DoubleVector length = root(dot(ray, ray)), pixel_w = view.w_x * ndc_x + view.w_y * ndc_y;
    const Doubles3 unit = ray * (1.0 / length);
    const NarrowVector direction[3] = {narrowed(unit.x), narrowed(unit.y), narrowed(unit.z)};
    for (int k = 0; k < 3; ++k) __builtin_memcpy(seen.direction[k] + at, &direction[k], sizeof(NarrowVector));
    const DoubleVector stored = load_doubles(depth + i);
    const DoubleVector distance = stored < 0.0 ? every(nothing) : distance_at(view, stored, pixel_w, length);
    const Doubles3 drawn =
        eye + Doubles3{widened(direction[0]), widened(direction[1]), widened(direction[2])} * distance;
    store_doubles(seen.distance + at, distance);
    store_doubles(seen.inverse + at, 1.0 / distance);
    store_doubles(seen.w + at, length / distance);
    store_doubles(seen.drawn[0] + at, drawn.x);
    store_doubles(seen.drawn[1] + at, drawn.y);
    store_doubles(seen.drawn[2] + at, drawn.z);
    if (!inner) continue;
    const DoubleVector off = view.half_steps * (0.5 * depth_step(view, stored));
    const DoubleVector nearer = stored + (view.reversed ? off : -off);
    const DoubleVector inside = lesser(greater(nearer, every(0.0)), every(1.0));
    const DoubleVector end = distance_at(view, inside, pixel_w, length) - 0x1p-21 * distance;
    const DoubleVector finite = lesser(greater(end, every(0.0)), every(farthest_point));
    store_doubles(seen.off + at, distance - widened(narrowed(finite)));
  }
}

// --- Points.

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

// --- Random numbers.

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

// --- Rays to a light.

SIDERAY_LANE real load_floats(const float* values) {
  FloatVector v;
  __builtin_memcpy(&v, values, sizeof(v));
  return v;
}
SIDERAY_LANE void store_floats(float* values, real a) {
  __builtin_memcpy(values, &a.v, sizeof(a.v));
}
SIDERAY_LANE real3 load_floats(const float (&planes)[3][point_tile_pixels], int at) {
  return {load_floats(planes[0] + at), load_floats(planes[1] + at), load_floats(planes[2] + at)};
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
      if (wanted != 0 && has_place(light)) wanted &= lane_bits(to_light(light, load_floats(tile.front, at)).reaches);
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
      store_floats(samples.u + at, lane_unit_float(lane_scramble_reversed(index, keys.x[set])));
      const real v = lane_unit_float(lane_scramble_reversed(second, keys.y[set]));
      store_floats(samples.azimuth + at, 6.28318530717958647692528676655900576f * v);
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
  const real below = load_floats(samples.u + at) * aperture;
  const real sine = sqrt(below * (2.0f - below));
  return {sine * load_floats(samples.cosine + at), sine * load_floats(samples.sine + at), 1.0f - below};
}

// See sample_cosine().
SIDERAY_LANE real3 lane_cosine(const RaySamples& samples, int at) {
  const real u = load_floats(samples.u + at), sine = sqrt(u);
  return {sine * load_floats(samples.cosine + at), sine * load_floats(samples.sine + at), sqrt(1.0f - u)};
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
    rays.direction = about(load_floats(tile.normal, at), lane_cosine(samples, at));
    return rays;
  }
  if (light.kind == rays_to_drawn) {
    rays.direction = load_floats(samples.drawn, at);
    return rays;
  }
  const ToLight to = to_light(light, load_floats(tile.front, at));
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
  const real share = u * load_floats(tile.bias + block * block_pixels + lane);
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
      store_floats(to[i] + count, values[i]);
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
      made.origin = load_floats(tile.front, at);
      if (light.kind != rays_to_sky && light.kind != rays_to_drawn) {
        const boolean in_front = dot(made.direction, load_floats(tile.normal, at)) >= -load_floats(tile.doubt + at);
        made.origin = sr_select(in_front, made.origin, load_floats(tile.back, at));
      }
      made.t_near = load_floats(tile.skip + at);
      if (start.kind != starts_as_others && tile.inexact[block] != 0) start_inexact(start, tile, block, lane, made);
      append(made, wanted, at, rays, count);
      count += static_cast<uint32_t>(__builtin_popcount(wanted));
    }
  return count;
}

const PointKernels& point_kernels() {
  static constexpr PointKernels table{see_row, points_row, sample_tile, rays_of_tile};
  return table;
}

}  // namespace sideray::rt::SIDERAY_LANES
