#include "rt/masks/depth_points.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace sideray::rt {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
constexpr double no_depth = std::numeric_limits<double>::quiet_NaN();  // marks pixels without a surface
// The relative rounding of coordinates that go through an instance's transform and back in floats.
constexpr double rounding = 0x1p-21;
// A factor on slopes, because neighbours give the mean slope of the triangles between them.
constexpr double slope_margin = 2.0;
// Three pixels are on a plane if the second step of depth differs from the first by at most this share of it, plus this
// multiple of the depth's noise.
constexpr double bent_share = 0.125, bent_noise = 8.0;
// The surface continues on a side that differs from a plane by at most this share, and bends less than half as much as
// the other side, apart from the depth's noise.
constexpr double plane_share = 0x1p-6, straighter_factor = 2.0, straighter_noise = 8.0;
// A neighbour alone is taken for the same surface if depth changes by at most this many times the breadth.
constexpr double steep = 4.0;
// Rays skip hits within this share of a pixel's breadth if the surface's tilt is unknown.
constexpr double pixel_share = 0.5;

bool marked(const MaskRequest& r, uint32_t stencil) {
  return r.inexact != SIDERAY_EXACT && (stencil & r.inexact_bits) != 0;
}

// Returns by how many half steps of its format a depth may be off: one for rounding to the format, plus the error of
// the driver's floats. Reversed depth from 0 to 1 has floats as fine as the depth itself; other depths have floats near
// 1, wherever the surface is. tests/embed/shadow_specks_test.cpp measures it.
double half_steps_off(const MaskRequest& r) {
  constexpr double of_floats = 5.5;  // in 2^-24
  double off = 0.5 + static_cast<double>(r.shadow_bias_steps);
  if (!r.view.zero_to_one_depth || !r.view.reversed_depth)
    off += r.depth.format == DepthFormat::d16 ? of_floats * 0x1p-8 : of_floats;
  return 2.0 * off;
}

// Returns the share of that error by which neighbours differ: the rounding to the format, and for depth from -1 to 1
// one before it. The driver's floats have nearly the same error in both.
double noise_of(const MaskRequest& r) {
  return (r.view.zero_to_one_depth ? 1.0 : 1.5) / half_steps_off(r);
}

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

// Computes the points of a tile pixel by pixel.
class DepthPoints::Single {
 public:
  void gather(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0, PointTile& tile);

 private:
  static constexpr uint32_t border = seen_border, side = tile_size + 2 * border;
  struct Seen {
    glm::dvec3 drawn;     // position by the depth buffer
    glm::dvec3 position;  // with the rest pose's offset, if there is one
    double distance;      // along the view ray; infinite = nothing
    double w;             // perspective: inversely proportional to the depth
    double off;           // largest error toward the eye, from the format's step and rounding; not set in the border
    double noise;         // the part of it by which neighbours may differ
    glm::vec3 direction;  // direction of the view ray
    bool resting, marked;
  };

  void see(const MaskRequest& request, const ViewRays& view, uint32_t x0, uint32_t y0);
  // Leads from one pixel of a surface to the next.
  struct Step {
    glm::dvec3 along;
    double slope;  // change of the depth, along the view ray
    double breadth;
    bool known;  // false: neither neighbour shows the same surface, and its tilt may be anything
  };
  // Says how the surface of a pixel lies.
  struct Tilt {
    Step across, up;
    glm::dvec3 normal;
    bool known() const { return across.known && up.known; }
  };
  // Describes how the depth continues on one side of a pixel.
  struct Side {
    double change;  // of the depth to the neighbour
    double bend;    // difference between that and the next step; infinite if a pixel is missing
    bool ends;      // the neighbour is not on the surface
    bool straight;  // pixel and both neighbours are on one plane
    bool plane;     // the same with a tighter tolerance
  };
  // Holds both sides of a pixel along an axis.
  struct Sides {
    Side down, up;
    bool plane() const { return down.plane || up.plane; }
  };
  // Examines the pixels at `index` + `stride` and + 2 `stride`.
  Side look(size_t index, ptrdiff_t stride, bool perspective) const;
  // Steps to the neighbour at `index` + or - `stride` that continues the surface. If both axes show a plane (`planes`)
  // it is the one on the straighter side; if neither or both sides are straight, it is the one nearer in distance.
  Step step(size_t index, ptrdiff_t stride, const Sides& sides, bool planes) const;
  // Bounds the slope of the depth along the view ray, by the steeper of the surface's two sides.
  static double slope(const Side& best, const Side& other);
  static glm::dvec3 normal(const Step& across, const Step& up, const glm::dvec3& toward);
  Tilt tilt(const ViewRays& view, size_t index) const;
  // Sets where rays start in front of the surface and behind it; returns the largest error along the view ray.
  static double start_rays(const Seen& here, const Tilt& tilt, float subpixel, DepthPoint& point);
  // Refines a point by a ray's hit on the surface, of which only the point itself is rounded.
  static DepthPoint exact(DepthPoint point, const Seen& here, const OpaquePoint& met, double least);
  DepthPoint point(const MaskRequest& request, const ViewRays& view, uint32_t x, uint32_t y, size_t index) const;

  std::vector<Seen> seen_ = std::vector<Seen>(size_t{side} * side);
};

void DepthPoints::Single::see(const MaskRequest& r, const ViewRays& view, uint32_t x0, uint32_t y0) {
  const double half_steps = half_steps_off(r), noise = noise_of(r);
  for (uint32_t j = 0; j < side; ++j)
    for (uint32_t i = 0; i < side; ++i) {
      Seen& s = seen_[size_t{j} * side + i];
      s.distance = nothing;
      const uint32_t x = x0 + i - border, y = y0 + j - border;  // wraps to large values below 0
      if (x >= r.width || y >= r.height) continue;
      const DepthTexel texel = read_depth(r.depth, x, y);
      if (r.view.reversed_depth ? texel.depth <= 0.0 : texel.depth >= 1.0) continue;
      const ViewRays::Pixel pixel = view.pixel(x, y);
      s.distance = view.distance(pixel, texel.depth);
      s.drawn = glm::dvec3(pixel.origin) + glm::dvec3(pixel.direction) * s.distance;
      s.position = s.drawn;
      s.direction = pixel.direction;
      s.w = pixel.length / s.distance;
      s.marked = marked(r, texel.stencil);
      s.resting = s.marked && r.inexact == SIDERAY_INEXACT_RESTPOSE && !r.rest_offsets.empty();
      if (s.resting) s.position += glm::dvec3(glm::vec3(r.rest_offsets[size_t{y} * r.width + x]));
      const auto inner = [](uint32_t k) { return k >= border && k < border + tile_size; };
      if (!inner(i) || !inner(j)) continue;
      s.off = s.distance - double{view.end_of_ray(pixel, texel.depth, s.distance, r.depth.format, half_steps)};
      s.noise = s.off * noise;
    }
}

DepthPoints::Single::Side DepthPoints::Single::look(size_t index, ptrdiff_t stride, bool perspective) const {
  const Seen& here = seen_[index];
  const size_t next = index + static_cast<size_t>(stride), beyond = next + static_cast<size_t>(stride);
  // In perspective the distance differs from ray to ray even at constant depth; w is linear on a plane.
  const auto depth = [&](size_t i) {
    const Seen& s = seen_[i];
    return perspective ? (1.0 - s.w / here.w) * here.distance : s.distance - here.distance;
  };
  const auto ends = [&](size_t i) { return !(seen_[i].distance < nothing) || seen_[i].resting != here.resting; };
  Side result{depth(next), nothing, ends(next), false, false};
  if (result.ends || ends(beyond)) return result;
  result.bend = std::abs(depth(beyond) - 2.0 * result.change);
  result.straight = result.bend <= bent_share * std::abs(result.change) + bent_noise * here.noise;
  result.plane = result.bend <= plane_share * std::abs(result.change) + 0.5 * straighter_noise * here.noise;
  return result;
}

double DepthPoints::Single::slope(const Side& best, const Side& other) {
  const double steepest = slope_margin * std::abs(best.change);
  // At a silhouette a surface may curve away, and at a fold the steeper side counts; where another surface occludes it,
  // neither applies.
  if (other.ends) return 2.0 * steepest;
  return other.straight ? std::max(steepest, slope_margin * std::abs(other.change)) : steepest;
}

DepthPoints::Single::Step DepthPoints::Single::step(size_t index, ptrdiff_t stride, const Sides& sides,
                                                    bool planes) const {
  const size_t one_before = index - static_cast<size_t>(stride), one_after = index + static_cast<size_t>(stride);
  const Seen &here = seen_[index], &before = seen_[one_before], &after = seen_[one_after];
  const auto cost = [&](const Seen& other) {
    return other.distance < nothing && other.resting == here.resting ? std::abs(other.distance - here.distance)
                                                                     : nothing;
  };
  const double back = cost(before), forth = cost(after);
  if (std::min(back, forth) == nothing) return {glm::dvec3(0.0), 0.0, 0.0, false};
  // Beside a fold the nearer neighbour may be on the other face.
  const auto& [down, up] = sides;
  const auto straighter = [&](const Side& one, const Side& other) {
    return planes && one.plane && straighter_factor * one.bend + straighter_noise * here.noise < other.bend;
  };
  const bool goes_on_after = !straighter(down, up) && (straighter(up, down) || forth <= back);
  const double slope = goes_on_after ? forth : back;
  const Seen& next = goes_on_after ? after : before;
  const glm::dvec3 along = goes_on_after ? after.position - here.position : here.position - before.position;
  const glm::dvec3 drawn = next.drawn - here.drawn;
  const double steepest = Single::slope(goes_on_after ? up : down, goes_on_after ? down : up);
  const double breadth = std::sqrt(std::max(glm::dot(drawn, drawn) - slope * slope, 0.0));
  if (slope <= steep * breadth) return {along, steepest, breadth, true};
  // On a plane the inverse distance is linear: a third pixel on either side distinguishes a grazing surface from a thin
  // leaf in front of another surface.
  const auto straight = [&](const Seen& other, double steps) {
    const double first = 1.0 / next.distance - 1.0 / here.distance, third = 1.0 / other.distance - 1.0 / here.distance;
    return cost(other) < nothing && std::abs(third - steps * first) <= 0.1 * std::abs(first);
  };
  const Seen& beyond = seen_[goes_on_after ? one_after + static_cast<size_t>(stride) : one_before - static_cast<size_t>(stride)];
  if (straight(beyond, 2.0) || straight(goes_on_after ? before : after, -1.0)) return {along, steepest, breadth, true};
  return {glm::dvec3(0.0), steep * breadth, breadth, false};
}

// Returns the normal on the eye's side. Columns go right and rows up, so that holds for the rest pose too, which is not
// in the picture.
glm::dvec3 DepthPoints::Single::normal(const Step& across, const Step& up, const glm::dvec3& toward) {
  glm::dvec3 n = -toward;
  if (across.known && up.known)
    n = glm::cross(across.along, up.along);
  else if (const glm::dvec3 along = across.known ? across.along : up.along; glm::dot(along, along) > 0.0)
    n = along * (glm::dot(along, toward) / glm::dot(along, along)) - toward;
  const double length = glm::length(n);
  return length > 0.0 && std::isfinite(length) ? n / length : -toward;
}

DepthPoints::Single::Tilt DepthPoints::Single::tilt(const ViewRays& view, size_t index) const {
  const auto sides_along = [&](ptrdiff_t stride) {
    return Sides{look(index, -stride, view.perspective()), look(index, stride, view.perspective())};
  };
  const Sides columns = sides_along(1), rows = sides_along(ptrdiff_t{side});
  // If one axis steps along one face and the other along another, the normal belongs to neither.
  const bool planes = columns.plane() && rows.plane();
  const Seen& here = seen_[index];
  const glm::dvec3 toward(here.direction);
  Tilt tilt{step(index, 1, columns, planes), step(index, ptrdiff_t{side}, rows, planes), {}};
  tilt.normal = normal(tilt.across, tilt.up, toward);
  if (!here.resting && glm::dot(tilt.normal, toward) > 0.0) tilt.normal = -tilt.normal;
  return tilt;
}

DepthPoint DepthPoints::Single::point(const MaskRequest& r, const ViewRays& view, uint32_t x, uint32_t y,
                                      size_t index) const {
  const Seen& here = seen_[index];
  const Tilt tilt = this->tilt(view, index);
  DepthPoint p{};
  p.x = static_cast<uint16_t>(x);
  p.y = static_cast<uint16_t>(y);
  p.normal = glm::vec3(tilt.normal);
  p.inexact = here.marked;
  p.bias = r.inexact_bias;
  if (r.inexact == SIDERAY_INEXACT_BOUNDED && !r.rest_offsets.empty())
    p.bias = std::max(r.rest_offsets[size_t{y} * r.width + x].w, 0.0f);
  const double off = start_rays(here, tilt, r.subpixel, p), least = rounding * largest(here.position);
  if (!r.points.empty() && !here.resting) {
    const OpaquePoint& met = r.points[size_t{y} * r.width + x];
    if (std::abs(met.distance - here.distance) <= off + least) return exact(p, here, met, least);
  }
  if (!tilt.known()) {
    const ViewRays::Pixel pixel = view.pixel(x, y), beside = view.pixel(x + 1, y);
    const glm::dvec3 turn(beside.direction - pixel.direction), move(beside.origin - pixel.origin);
    p.skip = static_cast<float>(pixel_share * glm::length(turn * here.distance + move));
  }
  return p;
}

double DepthPoints::Single::start_rays(const Seen& here, const Tilt& tilt, float subpixel, DepthPoint& p) {
  const Step &across = tilt.across, &up = tilt.up;
  const glm::dvec3 toward(here.direction);
  // The margin covers the depth's error and the rasterizer's snapping to its grid of sub-pixels, times the slope. The
  // slope is exact up to the geometry between neighbours and a step of depth.
  const auto moved_by = [&](double stored) {
    return stored + (across.slope + up.slope + 4.0 * stored) * double{subpixel};
  };
  const double off = moved_by(here.off), least = rounding * largest(here.position);
  const auto doubt = [&](const Step& s) { return s.known ? 2.0 * here.off / glm::length(s.along) : 0.0; };
  p.doubt = static_cast<float>(std::min(doubt(across) + doubt(up), 2.0));
  // In the rest pose the surface has another tilt, so errors along and across the view ray count in full.
  const double any_way = off + (across.breadth + up.breadth) * double{subpixel};
  const glm::dvec3 moved = here.resting ? tilt.normal * (any_way + least) : -toward * off + tilt.normal * least;
  p.front = glm::vec3(here.position + moved);
  // If the tilt is unknown, rays skip nearby hits. Behind the surface they start as close to it as possible, to miss no
  // surface behind it.
  const glm::dvec3 moved_back =
      tilt.known() || here.resting ? moved : -toward * moved_by(here.noise) + tilt.normal * least;
  p.back = glm::vec3(here.position - moved_back);
  return off;
}

DepthPoint DepthPoints::Single::exact(DepthPoint p, const Seen& here, const OpaquePoint& met, double least) {
  const glm::dvec3 toward(here.direction);
  glm::dvec3 normal(met.normal);
  if (glm::dot(normal, toward) > 0.0) normal = -normal;
  const glm::dvec3 position = here.position + toward * (met.distance - here.distance);
  p.normal = glm::vec3(normal);
  p.front = glm::vec3(position + normal * least);
  p.back = glm::vec3(position - normal * least);
  p.doubt = 0.0f;
  return p;
}

namespace {

void set(float (&planes)[3][point_tile_pixels], uint32_t index, const glm::vec3& v) {
  for (int i = 0; i < 3; ++i) planes[i][index] = v[i];
}

glm::vec3 get(const float (&planes)[3][point_tile_pixels], uint32_t index) {
  return {planes[0][index], planes[1][index], planes[2][index]};
}

void put(PointTile& tile, uint32_t index, const DepthPoint& p) {
  set(tile.front, index, p.front);
  set(tile.back, index, p.back);
  set(tile.normal, index, p.normal);
  tile.doubt[index] = p.doubt;
  tile.skip[index] = p.skip;
  tile.bias[index] = p.bias;
  const uint32_t block = index / block_pixels, bit = 1u << index % block_pixels;
  tile.drawn[block] = static_cast<uint16_t>(tile.drawn[block] | bit);
  if (p.inexact) tile.inexact[block] = static_cast<uint16_t>(tile.inexact[block] | bit);
}

void begin(PointTile& tile, uint32_t x0, uint32_t y0) {
  tile.x0 = x0;
  tile.y0 = y0;
  std::fill_n(tile.drawn, tile_blocks, uint16_t{0});
  std::fill_n(tile.inexact, tile_blocks, uint16_t{0});
}

void move_off(PointTile& tile, float bias) {
  for (int i = 0; i < 3; ++i)
    for (uint32_t k = 0; k < point_tile_pixels; ++k) {
      const float move = tile.normal[i][k] * bias;
      tile.front[i][k] += move;
      tile.back[i][k] -= move;
    }
}

void set(double (&to)[3], const glm::dvec3& v) {
  for (int i = 0; i < 3; ++i) to[i] = v[i];
}

double step_of(DepthFormat format) {
  if (format == DepthFormat::d16) return 1.0 / 65535.0;
  return format == DepthFormat::d24 || format == DepthFormat::d24s8 ? 1.0 / 16777215.0 : 0.0;
}

PointView point_view(const MaskRequest& r, const ViewRays& view) {
  const ViewRays::Perspective terms = view.terms();
  PointView v{};
  v.pixel_x = terms.pixel.x;
  v.pixel_y = terms.pixel.y;
  set(v.center, terms.center);
  set(v.along_x, terms.along_x);
  set(v.along_y, terms.along_y);
  // Vectors of doubles are avoided, because g++ 12 drops the rounding of doubles to floats and back (at -O2, two at a
  // time).
  for (int i = 0; i < 3; ++i) v.eye[i] = static_cast<float>(terms.eye[i]);
  v.sign = terms.sign;
  v.w_x = terms.w.x;
  v.w_y = terms.w.y;
  v.w_z = terms.w.z;
  v.w_one = terms.w.w;
  v.half_steps = half_steps_off(r);
  v.noise = noise_of(r);
  v.step = step_of(r.depth.format);
  v.subpixel = static_cast<double>(r.subpixel);
  v.reversed = terms.reversed;
  v.zero_to_one = terms.zero_to_one;
  return v;
}

// Reads the window depths of a row from `first` on into `to`; pixels without a surface get no_depth.
template <typename Read>
void read_row(uint32_t first, uint32_t end, bool reversed, double* to, const Read& read) {
  for (uint32_t x = first; x < end; ++x) {
    const double depth = read(size_t{x});
    to[x - first] = (reversed ? depth <= 0.0 : depth >= 1.0) ? no_depth : depth;
  }
}

template <typename T>
T texel_at(const std::byte* row, size_t offset) {
  T value;
  std::memcpy(&value, row + offset, sizeof(T));
  return value;
}

void read_depths(const DepthImage& image, uint32_t y, uint32_t first, uint32_t end, bool reversed, double* to) {
  const std::byte* row = image.texels + size_t{y} * image.row_bytes;
  switch (image.format) {
    case DepthFormat::d16:
      return read_row(first, end, reversed, to, [&](size_t x) { return texel_at<uint16_t>(row, 2 * x) / 65535.0; });
    case DepthFormat::d24s8:
      return read_row(first, end, reversed, to,
                      [&](size_t x) { return (texel_at<uint32_t>(row, 4 * x) >> 8) / 16777215.0; });
    case DepthFormat::d24:
    case DepthFormat::d32f:
      return read_row(first, end, reversed, to,
                      [&](size_t x) { return static_cast<double>(texel_at<float>(row, 4 * x)); });
    case DepthFormat::d32f_s8:
      return read_row(first, end, reversed, to,
                      [&](size_t x) { return static_cast<double>(texel_at<float>(row, 8 * x)); });
  }
}

bool rests(const MaskRequest& r) {
  return r.inexact == SIDERAY_INEXACT_RESTPOSE && r.inexact_bits != 0 && !r.rest_offsets.empty();
}

}  // namespace

DepthPoint point_at(const PointTile& tile, uint32_t index) {
  DepthPoint p{};
  p.x = static_cast<uint16_t>(tile.x0 + column_in_tile(index));
  p.y = static_cast<uint16_t>(tile.y0 + row_in_tile(index));
  p.front = get(tile.front, index);
  p.back = get(tile.back, index);
  p.normal = get(tile.normal, index);
  p.inexact = (tile.inexact[index / block_pixels] >> index % block_pixels & 1u) != 0;
  p.bias = p.inexact ? tile.bias[index] : 0.0f;
  p.doubt = tile.doubt[index];
  p.skip = tile.skip[index];
  return p;
}

void DepthPoints::Single::gather(const MaskRequest& r, const ViewRays& view, uint32_t x0, uint32_t y0,
                                 PointTile& tile) {
  see(r, view, x0, y0);
  begin(tile, x0, y0);
  for (uint32_t index = 0; index < point_tile_pixels; ++index) {
    const uint32_t i = column_in_tile(index), j = row_in_tile(index);
    const size_t at = size_t{j + border} * side + i + border;
    if (seen_[at].distance != nothing) put(tile, index, point(r, view, x0 + i, y0 + j, at));
  }
}

DepthPoints::DepthPoints(const PointKernels& kernels) : kernels_(&kernels) {}
DepthPoints::~DepthPoints() = default;
DepthPoints::DepthPoints(DepthPoints&&) noexcept = default;
DepthPoints& DepthPoints::operator=(DepthPoints&&) noexcept = default;

const PointTile& DepthPoints::gather_singly(const MaskRequest& r, const ViewRays& view, uint32_t x0, uint32_t y0) {
  if (!single_) single_ = std::make_unique<Single>();
  if (!tile_) tile_ = std::make_unique<PointTile>();
  single_->gather(r, view, x0, y0, *tile_);
  if (r.shadow_bias > 0.0f) move_off(*tile_, r.shadow_bias);
  return *tile_;
}

// Fills in the pixels as drawn, without rest poses.
void DepthPoints::see(const MaskRequest& r, const PointView& view, uint32_t x0, uint32_t y0) {
  const uint32_t first = x0 < seen_border ? 0 : x0 - seen_border;
  const uint32_t end = std::min(x0 + tile_size + seen_border, r.width);
  alignas(64) double depth[seen_stride];
  for (int row = 0; row < seen_rows; ++row) {
    const uint32_t y = y0 + static_cast<uint32_t>(row) - seen_border;  // wraps to large values below 0
    std::fill_n(depth, seen_stride, no_depth);
    if (y < r.height) read_depths(r.depth, y, first, end, view.reversed != 0, depth + (first + seen_border - x0));
    const double first_x = static_cast<double>(x0) - seen_border, first_y = static_cast<double>(y0) - seen_border;
    kernels_->see(view, depth, first_x, first_y + row, row, *seen_);
  }
}

// Notes which pixels take the inexact test, and its bias there.
void DepthPoints::mark(const MaskRequest& r, uint32_t x0, uint32_t y0) {
  const bool bounded = r.inexact == SIDERAY_INEXACT_BOUNDED && !r.rest_offsets.empty();
  for_each_pixel(tile_->drawn, [&](uint32_t index) {
    const uint32_t x = x0 + column_in_tile(index), y = y0 + row_in_tile(index);
    if (!marked(r, read_depth(r.depth, x, y).stencil)) return;
    tile_->inexact[index / block_pixels] |= static_cast<uint16_t>(1u << index % block_pixels);
    tile_->bias[index] = bounded ? std::max(r.rest_offsets[size_t{y} * r.width + x].w, 0.0f) : r.inexact_bias;
  });
}

// Moves the positions of marked pixels into the rest pose.
void DepthPoints::rest(const MaskRequest& r, uint32_t x0, uint32_t y0) {
  seen_->rests = true;
  for (int i = 0; i < 3; ++i) std::copy_n(seen_->drawn[i], seen_rows * seen_stride, seen_->position[i]);
  std::fill_n(seen_->resting, seen_rows * seen_stride, int64_t{0});
  for (uint32_t j = 0; j < seen_rows; ++j)
    for (uint32_t i = 0; i < tile_size + 2 * seen_border; ++i) {
      const uint32_t x = x0 + i - seen_border, y = y0 + j - seen_border;
      if (x >= r.width || y >= r.height || !marked(r, read_depth(r.depth, x, y).stencil)) continue;
      const size_t at = size_t{j} * seen_stride + i;
      const glm::dvec3 offset(glm::vec3(r.rest_offsets[size_t{y} * r.width + x]));
      seen_->resting[at] = -1;
      for (int k = 0; k < 3; ++k) seen_->position[k][at] += offset[k];
    }
}

const PointTile& DepthPoints::gather(const MaskRequest& r, const ViewRays& view, uint32_t x0, uint32_t y0) {
  if (!view.perspective() || !r.points.empty()) return gather_singly(r, view, x0, y0);
  if (!seen_) seen_ = std::make_unique<SeenPixels>();
  if (!tile_) tile_ = std::make_unique<PointTile>();
  const PointView terms = point_view(r, view);
  begin(*tile_, x0, y0);
  see(r, terms, x0, y0);
  seen_->rests = false;
  if (rests(r)) rest(r, x0, y0);
  for (int row = seen_border; row < seen_border + static_cast<int>(tile_size); ++row)
    kernels_->points(terms, *seen_, row, *tile_);
  if (r.inexact != SIDERAY_EXACT && r.inexact_bits != 0) mark(r, x0, y0);
  if (r.shadow_bias > 0.0f) move_off(*tile_, r.shadow_bias);
  return *tile_;
}

const PointTile& DepthPoints::thin(uint32_t step) {
  for (uint32_t block = 0; block < tile_blocks; ++block) {
    uint16_t left = 0;
    for (uint32_t i = 0; i < block_pixels; ++i) {
      const uint32_t pixel = block * block_pixels + i;
      if (column_in_tile(pixel) % step == step / 2 && row_in_tile(pixel) % step == step / 2) left |= static_cast<uint16_t>(1u << i);
    }
    tile_->drawn[block] &= left;
  }
  return *tile_;
}

}  // namespace sideray::rt
