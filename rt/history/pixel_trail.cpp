#include "rt/history/pixel_trail.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sideray::rt {
namespace {

// Depth tolerance for the same surface, as a share of the depth: less than the step at an edge.
constexpr float same_depth = 1.0f / 128.0f;

}  // namespace

void PixelTrail::begin(const TraceView& view, const DepthImage& depth, glm::uvec2 size, glm::dvec3 origin, bool follows,
                       Executor& executor, uint64_t frame, std::span<const float> depths) {
  if (frame != 0 && frame == frame_) return;
  FrameCamera camera(view, size.x, size.y);
  before_ = follows && size == glm::uvec2(width_, height_) ? camera_ : std::nullopt;
  if (before_) before_->shift(origin_ - origin);
  frame_ = frame;
  ++step_;
  number_ = before_ ? number_ + 1 : 1;
  origin_ = origin;
  camera_ = camera;
  width_ = size.x, height_ = size.y;
  std::swap(depth_, depth_before_);
  if (depths.empty()) fill_depths(executor, depth, *camera_, depth_);
  else depth_.assign(depths.begin(), depths.end());
  same_view_ = before_ && camera_->sees_as(*before_);
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
  glm::ivec2 least(INT32_MAX), most(-1);
  for (uint32_t row = y; row < std::min(y + frame_tile_size, height_); ++row) look_back(x, row, across, least, most);
  tiles_from_[tile] = {glm::uvec2(1), glm::uvec2(0)};
  if (most.x >= 0) tiles_from_[tile] = {glm::uvec2(least) / frame_tile_size, glm::uvec2(most) / frame_tile_size};
}

// Finds where pixels of a tile's row were, and extends `least` and `most` by these places.
void PixelTrail::look_back(uint32_t x, uint32_t y, uint32_t count, glm::ivec2& least, glm::ivec2& most) {
  const size_t first = size_t{y} * width_ + x;
  const float* depth = &depth_[first];
  uint32_t* from = &from_[first];
  if (same_view_) {
    const float* then = &depth_before_[first];
    for (uint32_t i = 0; i < count; ++i)
      from[i] = ((std::abs(then[i] - depth[i]) <= same_depth * depth[i]) & (depth[i] > 0.0f))
                    ? static_cast<uint32_t>(first) + i
                    : nowhere;
    least = glm::min(least, glm::ivec2(x, y)), most = glm::max(most, glm::ivec2(x + count - 1, y));
    return;
  }
  // This loop has no branches, so that it becomes vector code; the next one reads the pixels that it finds.
  const auto row = static_cast<float>(y);
  const glm::vec4 origin = was_.origin + row * was_.origin_y, ray = was_.ray + row * was_.ray_y;
  std::array<float, frame_tile_size> at_x, at_y, expected;
  for (uint32_t i = 0; i < count; ++i) {
    const auto column = static_cast<float>(x + i);
    const float d = depth[i];
    const float over = 1.0f / (origin.z + column * was_.origin_x.z + d * (ray.z + column * was_.ray_x.z));
    at_x[i] = (origin.x + column * was_.origin_x.x + d * (ray.x + column * was_.ray_x.x)) * over;
    at_y[i] = (origin.y + column * was_.origin_x.y + d * (ray.y + column * was_.ray_x.y)) * over;
    const float then = origin.w + column * was_.origin_x.w + d * (ray.w + column * was_.ray_x.w);
    expected[i] = over > 0.0f && d > 0.0f ? then : 0.0f;
  }
  const auto right = static_cast<float>(width_ - 1), top = static_cast<float>(height_ - 1);
  for (uint32_t i = 0; i < count; ++i) {
    from[i] = nowhere;
    if (!(expected[i] > 0.0f && at_x[i] >= 0.0f && at_y[i] >= 0.0f && at_x[i] <= right && at_y[i] <= top)) continue;
    glm::ivec2 chosen(std::min(at_x[i] + rounding_.x, right), std::min(at_y[i] + rounding_.y, top));
    if (!was_there(chosen, expected[i])) chosen = search({at_x[i], at_y[i]}, expected[i]);
    if (chosen.x < 0) continue;
    from[i] = index(chosen);
    least = glm::min(least, chosen), most = glm::max(most, chosen);
  }
}

}  // namespace sideray::rt
