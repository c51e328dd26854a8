#include "rt/history/pixel_trail.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/vectors.h"

namespace sideray::rt {
namespace {

// Depth tolerance for the same surface, as a share of the depth: less than the step at an edge.
constexpr float same_depth = 1.0f / 128.0f;

// Holds where the pixels of a tile's row were in the previous frame.
struct RowThen {
  std::array<float, frame_tile_size> x, y, depth;     // depth: 0 = behind the camera, or no surface now
  std::array<uint32_t, frame_tile_size> shows_other;  // 1: the nearest pixel showed another surface
  bool any_shows_other;
  glm::uvec2 least, most;                             // bounds of the pixels that showed the surface
};

struct PictureThen {
  const std::vector<float>& depths;
  uint32_t width, height;
  glm::vec2 rounding;
};

// The loops of these two have no branches, and do one thing each, so that they become vector code.
SIDERAY_VECTORS void project(const TrailTerms& was, const float* depth, uint32_t first, uint32_t y, uint32_t count,
                             RowThen& row) {
  const auto down = static_cast<float>(y);
  const glm::vec4 origin = was.origin + down * was.origin_y, ray = was.ray + down * was.ray_y;
  const glm::vec4 origin_x = was.origin_x, ray_x = was.ray_x;
  for (uint32_t i = 0; i < count; ++i) {
    const auto column = static_cast<float>(first + i);
    const float d = depth[i];
    const float over = 1.0f / (origin.z + column * origin_x.z + d * (ray.z + column * ray_x.z));
    row.x[i] = (origin.x + column * origin_x.x + d * (ray.x + column * ray_x.x)) * over;
    row.y[i] = (origin.y + column * origin_x.y + d * (ray.y + column * ray_x.y)) * over;
    const float then = origin.w + column * origin_x.w + d * (ray.w + column * ray_x.w);
    row.depth[i] = over > 0.0f && d > 0.0f ? then : 0.0f;
  }
}

SIDERAY_VECTORS void find(RowThen& row, uint32_t count, const PictureThen& then, uint32_t* from) {
  const auto right = static_cast<float>(then.width - 1), top = static_cast<float>(then.height - 1);
  const float rounding_x = then.rounding.x, rounding_y = then.rounding.y;
  const float* depths = then.depths.data();
  const auto width = static_cast<int32_t>(then.width);
  std::array<int32_t, frame_tile_size> u, v, at, inside, shows;
  std::array<float, frame_tile_size> there;
  for (uint32_t i = 0; i < count; ++i) {
    const float x = row.x[i], y = row.y[i];
    inside[i] = (row.depth[i] > 0.0f) & (x >= 0.0f) & (y >= 0.0f) & (x <= right) & (y <= top);
    u[i] = static_cast<int32_t>(inside[i] ? std::min(x + rounding_x, right) : 0.0f);
    v[i] = static_cast<int32_t>(inside[i] ? std::min(y + rounding_y, top) : 0.0f);
    at[i] = v[i] * width + u[i];
  }
  for (uint32_t i = 0; i < count; ++i) there[i] = depths[at[i]];
  for (uint32_t i = 0; i < count; ++i)
    shows[i] = inside[i] & (std::abs(there[i] - row.depth[i]) <= same_depth * row.depth[i]);
  for (uint32_t i = 0; i < count; ++i) {
    row.shows_other[i] = static_cast<uint32_t>(inside[i] & ~shows[i]);
    from[i] = shows[i] ? static_cast<uint32_t>(at[i]) : PixelTrail::nowhere;
  }
  int32_t least_x = INT32_MAX, least_y = INT32_MAX, most_x = 0, most_y = 0, others = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const int32_t no = shows[i] - 1;  // all bits where another surface was shown
    least_x = std::min(least_x, u[i] | (no & INT32_MAX)), most_x = std::max(most_x, u[i] & ~no);
    least_y = std::min(least_y, v[i] | (no & INT32_MAX)), most_y = std::max(most_y, v[i] & ~no);
    others |= inside[i] & no;
  }
  row.least = {least_x, least_y}, row.most = {most_x, most_y};
  row.any_shows_other = others != 0;
}

}  // namespace

void PixelTrail::begin(const TrailFrame& frame, Executor& executor) {
  if (frame.number != 0 && frame.number == frame_) return;
  FrameCamera camera(frame.view, frame.size.x, frame.size.y);
  before_ = frame.follows && frame.size == glm::uvec2(width_, height_) ? camera_ : std::nullopt;
  if (before_) before_->shift(origin_ - frame.origin);
  frame_ = frame.number;
  ++step_;
  number_ = before_ ? number_ + 1 : 1;
  origin_ = frame.origin;
  camera_ = camera;
  width_ = frame.size.x, height_ = frame.size.y;
  std::swap(depth_, depth_before_);
  if (frame.depths.empty()) fill_depths(executor, frame.depth, *camera_, depth_);
  else depth_.assign(frame.depths.begin(), frame.depths.end());
  same_view_ = before_ && camera_->sees_as(*before_);
  same_lines_ = before_ && camera_->shares_lines(*before_);
  if (same_view_) camera_ = before_;  // slow movement is compared with the place where it began, until it counts
  from_.resize(size_t{width_} * height_);
  tiles_from_.resize(size_t{tile_count(width_)} * tile_count(height_));
  if (!before_) return;
  if (!same_view_) find_way();
  executor.run(tiles_from_.size(), [&](size_t tile, uint32_t) { look_back(tile); });
}

// Computes terms for x and y in pixels, both to be divided by the third component, and the depth along the axis as the
// fourth.
void PixelTrail::find_way() {
  const glm::dmat4& m = before_->clip_from_local;
  const glm::dvec2 half = 0.5 * before_->size;
  const auto was = [&](glm::dvec3 v, double is_point) {
    const glm::dvec4 clip = m * glm::dvec4(v, is_point);
    const double depth = glm::dot(before_->forward, v - before_->origin * is_point);
    return glm::vec4((clip.x + clip.w) * half.x - 0.5 * clip.w, (clip.y + clip.w) * half.y - 0.5 * clip.w, clip.w, depth);
  };
  was_ = {was(camera_->origin, 1.0), was(camera_->origin_x, 0.0), was(camera_->origin_y, 0.0),
          was(camera_->ray, 0.0),    was(camera_->ray_x, 0.0),    was(camera_->ray_y, 0.0)};
  const double n = number_;
  rounding_ = {n * 0.7548776662 - std::floor(n * 0.7548776662), n * 0.5698402910 - std::floor(n * 0.5698402910)};
}

bool PixelTrail::was_there(glm::ivec2 at, float depth) const {
  return std::abs(depth_before_[index(at)] - depth) <= same_depth * depth;
}

// Searches the four pixels around a position whose nearest pixel showed another surface. On a plane the inverse depth
// (in orthographic views the depth) is linear in the picture, so interpolating the four is exact if all show one plane.
glm::ivec2 PixelTrail::search(glm::vec2 at, float depth) const {
  const glm::ivec2 corner(at), last(static_cast<int>(width_) - 1, static_cast<int>(height_) - 1);
  const glm::ivec2 beyond = glm::min(corner + 1, last), chosen = glm::min(glm::ivec2(glm::floor(at + rounding_)), last);
  const glm::vec2 part = at - glm::vec2(corner);
  const bool inverse = camera_->perspective;
  const auto linear = [&](int x, int y) {
    const float d = depth_before_[index({x, y})];
    return inverse ? 1.0f / d : d;
  };
  const float below = glm::mix(linear(corner.x, corner.y), linear(beyond.x, corner.y), part.x);
  const float above = glm::mix(linear(corner.x, beyond.y), linear(beyond.x, beyond.y), part.x);
  const float mean = glm::mix(below, above, part.y), share = inverse ? mean * depth : mean / depth;
  if (std::abs(share - 1.0f) <= same_depth) return chosen;
  for (int i = 0; i < 4; ++i) {
    const glm::ivec2 p(i & 1 ? beyond.x : corner.x, i & 2 ? beyond.y : corner.y);
    if (was_there(p, depth)) return p;
  }
  return glm::ivec2(-1);
}

void PixelTrail::look_back(size_t tile) {
  const uint32_t columns = tile_count(width_);
  const auto x = static_cast<uint32_t>(tile % columns) * frame_tile_size,
             y = static_cast<uint32_t>(tile / columns) * frame_tile_size;
  const uint32_t across = std::min(frame_tile_size, width_ - x);
  Tiles& found = tiles_from_[tile];
  found = {glm::uvec2(UINT32_MAX), glm::uvec2(0)};
  for (uint32_t row = y; row < std::min(y + frame_tile_size, height_); ++row) look_back(x, row, across, found);
  found.first /= frame_tile_size, found.last /= frame_tile_size;
}

// Finds where pixels of a tile's row were, and extends the bounds in pixels by these places.
void PixelTrail::look_back(uint32_t x, uint32_t y, uint32_t count, Tiles& found) {
  const size_t first = size_t{y} * width_ + x;
  const float* depth = &depth_[first];
  uint32_t* from = &from_[first];
  const auto extend = [&](glm::uvec2 least, glm::uvec2 most) {
    found.first = glm::min(found.first, least), found.last = glm::max(found.last, most);
  };
  if (same_view_) {
    const float* then = &depth_before_[first];
    for (uint32_t i = 0; i < count; ++i)
      from[i] = ((std::abs(then[i] - depth[i]) <= same_depth * depth[i]) & (depth[i] > 0.0f))
                    ? static_cast<uint32_t>(first) + i
                    : nowhere;
    return extend({x, y}, {x + count - 1, y});
  }
  RowThen row;
  project(was_, depth, x, y, count, row);
  find(row, count, {depth_before_, width_, height_, rounding_}, from);
  for (uint32_t i = 0; i < count && row.any_shows_other; ++i) {
    if (!row.shows_other[i]) continue;
    const glm::ivec2 near = search({row.x[i], row.y[i]}, row.depth[i]);
    if (near.x < 0) continue;
    from[i] = index(near);
    extend(near, near);
  }
  extend(row.least, row.most);
}

}  // namespace sideray::rt
