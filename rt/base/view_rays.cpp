#include "rt/base/view_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "model/failure.h"
#include "rt/base/vectors.h"

namespace sideray::rt {
namespace {

constexpr double farthest_point = 1e30;  // rays must be finite

bool finite(const glm::dmat4& m) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(m[c][r])) return false;
  return true;
}

// Returns twice the largest difference between the stored depth and the one that the rasterizer computed.
double depth_step(double depth, DepthFormat format, bool zero_to_one) {
  if (format == DepthFormat::d16) return 1.0 / 65535.0;
  if (format == DepthFormat::d24 || format == DepthFormat::d24s8) return 1.0 / 16777215.0;
  const float f = std::max(0.0f, static_cast<float>(depth));
  const double ulp =
      static_cast<double>(std::bit_cast<float>(std::bit_cast<uint32_t>(f) + 1u)) - static_cast<double>(f);
  // If depth runs from -1 to 1, the value is near +-1 as a float before it is halved.
  return zero_to_one ? ulp : std::max(ulp, 0x1p-24);
}

}  // namespace

glm::vec3 way_to_viewer(const TraceView& view) {
  // In perspective, w grows with the distance from the eye; in parallel projection depth does.
  const glm::dmat4 rows = glm::transpose(view.clip_from_local);
  const glm::dvec3 along_w(rows[3]), along_z(rows[2]);
  if (glm::length(along_w) > 1e-12 * glm::length(along_z)) return glm::vec3(glm::normalize(-along_w));
  return glm::vec3(glm::normalize(view.reversed_depth ? along_z : -along_z));
}

ViewRays::ViewRays(const TraceView& view, uint32_t width, uint32_t height)
    : local_from_clip_(view.local_from_clip),
      reversed_(view.reversed_depth),
      zero_to_one_(view.zero_to_one_depth),
      pixel_(2.0 / width, 2.0 / height),
      near_depth_(reversed_ ? 1.0 : 0.0),
      far_depth_(1.0 - near_depth_) {
  if (!finite(view.clip_from_local) || !finite(view.local_from_clip))
    fail(SIDERAY_INVALID_ARGUMENT, "view: a matrix is not finite; give a camera's matrix and its inverse");
  const glm::dmat4& m = local_from_clip_;
  const glm::dvec4 w_row(view.clip_from_local[0].w, view.clip_from_local[1].w, view.clip_from_local[2].w,
                         view.clip_from_local[3].w);
  perspective_ = glm::length(glm::dvec3(w_row)) > 1e-12 * std::abs(w_row.w);
  if (perspective_ && std::abs(m[2].w) > 0.0) {
    eye_ = glm::dvec3(m[2]) / m[2].w;
    sign_ = m[2].w * ndc_depth(near_depth_) + m[3].w < 0.0 ? -1.0 : 1.0;
    along_x_ = sign_ * (glm::dvec3(m[0]) - eye_ * m[0].w);
    along_y_ = sign_ * (glm::dvec3(m[1]) - eye_ * m[1].w);
    center_ = sign_ * (glm::dvec3(m[3]) - eye_ * m[3].w);
    spread_ = pixel_.y * glm::length(along_y_);
  } else if (!perspective_) {
    direction_ = point({0, 0}, ndc_depth(far_depth_)) - point({0, 0}, ndc_depth(near_depth_));
    direction_ /= glm::length(direction_);
  }
  const double near = ndc_depth(near_depth_);
  right_ = glm::vec3(glm::normalize(perspective_ ? along_x_ : point({1, 0}, near) - point({0, 0}, near)));
  up_ = glm::vec3(glm::normalize(perspective_ ? along_y_ : point({0, 1}, near) - point({0, 0}, near)));
  const glm::dvec3 middle = perspective_ ? center_ : direction_;
  if (!(glm::length(middle) > 0.0) || !std::isfinite(glm::length(middle)))
    fail(SIDERAY_INVALID_ARGUMENT, "view: the matrices are no camera; give a camera's matrix and its inverse");
  // Steps in perspective are those of one unit of depth.
  const glm::dvec3 step_x = perspective_ ? along_x_ : point({1, 0}, near) - point({0, 0}, near);
  const glm::dvec3 step_y = perspective_ ? along_y_ : point({0, 1}, near) - point({0, 0}, near);
  const double tall = pixel_.y * glm::length(step_y);
  const glm::dvec3 axis = glm::normalize(glm::cross(step_x, step_y));
  const Cone cone = perspective_ ? Cone{0.0f, static_cast<float>(tall / std::abs(glm::dot(middle, axis)))}
                                 : Cone{static_cast<float>(tall), 0.0f};
  alpha_cone_ = {cone, axis, {step_x * (pixel_.x / tall), step_y * (pixel_.y / tall)}};
}

glm::dvec2 ViewRays::ndc(uint32_t x, uint32_t y) const {
  return (glm::dvec2(x, y) + 0.5) * pixel_ - 1.0;
}

double ViewRays::ndc_depth(double depth) const {
  return zero_to_one_ ? depth : 2.0 * depth - 1.0;
}

glm::dvec3 ViewRays::point(glm::dvec2 p, double z) const {
  const glm::dvec4 h = local_from_clip_ * glm::dvec4(p, z, 1.0);
  return glm::dvec3(h) / h.w;
}

ViewRays::Perspective ViewRays::terms() const {
  const glm::dmat4& m = local_from_clip_;
  return {pixel_, center_, along_x_, along_y_, eye_, sign_, {m[0].w, m[1].w, m[2].w, m[3].w}, reversed_, zero_to_one_};
}

ViewRays::Pixel ViewRays::pixel(uint32_t x, uint32_t y) const {
  Pixel p{ndc(x, y), {}, {}};
  if (!perspective_) {
    p.origin = glm::vec3(point(p.ndc, ndc_depth(near_depth_)));
    p.direction = glm::vec3(direction_);
    return p;
  }
  const glm::dvec3 direction = center_ + p.ndc.x * along_x_ + p.ndc.y * along_y_;
  p.length = glm::length(direction);
  p.w = local_from_clip_[0].w * p.ndc.x + local_from_clip_[1].w * p.ndc.y;
  p.origin = glm::vec3(eye_);
  p.direction = glm::vec3(direction * (1.0 / p.length));
  return p;
}

double ViewRays::distance(const Pixel& p, double depth) const {
  const double z = ndc_depth(depth);
  if (!perspective_) return glm::dot(point(p.ndc, z) - point(p.ndc, ndc_depth(near_depth_)), direction_);
  // A point is eye + direction / w, with w linear in the depth.
  const double w = sign_ * (p.w + local_from_clip_[2].w * z + local_from_clip_[3].w);
  return w * farthest_point > p.length ? p.length / w : std::numeric_limits<double>::infinity();
}

double ViewRays::window_depth(const Pixel& p, double distance_along) const {
  double z = ndc_depth(near_depth_);
  if (perspective_)
    z = (sign_ * p.length / distance_along - p.w - local_from_clip_[3].w) / local_from_clip_[2].w;
  else
    z += distance_along / glm::dot(glm::dvec3(local_from_clip_[2]), direction_);
  return zero_to_one_ ? z : 0.5 * z + 0.5;
}

double ViewRays::distance(uint32_t x, uint32_t y, double depth) const {
  return distance(pixel(x, y), depth);
}

Ray ViewRays::ray(uint32_t x, uint32_t y) const {
  return ray(pixel(x, y));
}

Ray ViewRays::ray(const Pixel& p) const {
  Ray r{};
  r.origin = p.origin;
  r.direction = p.direction;
  r.t_near = perspective_ ? static_cast<float>(distance(p, near_depth_)) : 0.0f;
  r.t_far = static_cast<float>(std::min(distance(p, far_depth_), farthest_point));
  return r;
}

Cone ViewRays::cone(uint32_t x, uint32_t y) const {
  return cone(pixel(x, y));
}

Cone ViewRays::cone(const Pixel& p) const {
  if (perspective_) return {0.0f, static_cast<float>(spread_ / p.length)};
  const double z = ndc_depth(near_depth_);
  return {static_cast<float>(glm::length(point(p.ndc + glm::dvec2(0, pixel_.y), z) - point(p.ndc, z))), 0.0f};
}

float ViewRays::depth(uint32_t x, uint32_t y, double distance) const {
  if (!perspective_) return static_cast<float>(distance);
  const glm::dvec2 p = ndc(x, y);
  return static_cast<float>(distance / glm::length(center_ + p.x * along_x_ + p.y * along_y_));
}

float ViewRays::end_of_ray(const Pixel& p, double depth, double distance_of_depth, DepthFormat format,
                           double half_steps) const {
  if (cleared(depth)) return static_cast<float>(std::min(distance(p, far_depth_), farthest_point));
  const double off = half_steps * (0.5 * depth_step(depth, format, zero_to_one_));
  const double nearer = std::clamp(depth + (reversed_ ? off : -off), 0.0, 1.0);
  const double end = distance(p, nearer) - 0x1p-21 * distance_of_depth;
  return static_cast<float>(std::clamp(end, 0.0, farthest_point));
}

float ViewRays::end_of_ray(uint32_t x, uint32_t y, double depth, DepthFormat format) const {
  const Pixel p = pixel(x, y);
  return end_of_ray(p, depth, distance(p, depth), format);
}

void ViewRays::fill(const Block& block, DepthFormat format, Ray* rays, Cone* cones) const {
  if (!perspective_) {
    for (uint32_t i = 0; i < Block::size; ++i) {
      const auto x = static_cast<uint32_t>(block.x[i]), y = static_cast<uint32_t>(block.y[i]);
      const Pixel p = pixel(x, y);
      rays[i] = ray(p);
      rays[i].t_far = end_of_ray(p, block.depth[i], distance(p, block.depth[i]), format);
      cones[i] = cone(p);
    }
    return;
  }
  Rows rows;
  for (uint32_t i = 0; i < Block::size; ++i) rows.step[i] = depth_step(block.depth[i], format, zero_to_one_);
  fill_rows(block, rows);
  const glm::vec3 eye(eye_);
  for (uint32_t i = 0; i < Block::size; ++i) {
    const glm::vec3 direction(rows.direction[0][i], rows.direction[1][i], rows.direction[2][i]);
    rays[i] = {eye, rows.t_near[i], direction, rows.t_far[i]};
    cones[i] = {0.0f, rows.spread[i]};
  }
}

// Does what pixel(), ray(), end_of_ray() and cone() do in perspective, operation by operation, as a vector loop. The
// steps of depth must be set.
SIDERAY_VECTORS void ViewRays::fill_rows(const Block& block, Rows& rows) const {
  // These replace branches that would keep the loop from being vectorized: which depth is far, and the range of depth.
  const double far_depth = far_depth_, away = reversed_ ? -1.0 : 1.0;
  const double z_scale = zero_to_one_ ? 1.0 : 2.0, z_shift = zero_to_one_ ? 0.0 : 1.0;
  const double pixel_x = pixel_.x, pixel_y = pixel_.y, sign = sign_, spread = spread_;
  const double w_x = local_from_clip_[0].w, w_y = local_from_clip_[1].w, w_z = local_from_clip_[2].w,
               w_one = local_from_clip_[3].w;
  const double near_z = ndc_depth(near_depth_), far_z = ndc_depth(far_depth_);
  const glm::dvec3 center = center_, along_x = along_x_, along_y = along_y_;
  for (uint32_t i = 0; i < Block::size; ++i) {
    const double x = (block.x[i] + 0.5) * pixel_x - 1.0, y = (block.y[i] + 0.5) * pixel_y - 1.0;
    const double dx = center.x + x * along_x.x + y * along_y.x, dy = center.y + x * along_x.y + y * along_y.y,
                 dz = center.z + x * along_x.z + y * along_y.z;
    const double length = std::sqrt(dx * dx + dy * dy + dz * dz), inverse = 1.0 / length;
    const double pixel_w = w_x * x + w_y * y;
    const auto distance_at = [=](double z) {
      const double w = sign * (pixel_w + w_z * z + w_one), distance = length / w;
      return w * farthest_point > length ? distance : std::numeric_limits<double>::infinity();
    };
    const double depth = block.depth[i], moved = depth - away * (0.5 * rows.step[i]);
    const double nearer = moved < 0.0 ? 0.0 : moved > 1.0 ? 1.0 : moved;
    const double end = distance_at(z_scale * nearer - z_shift) - 0x1p-21 * distance_at(z_scale * depth - z_shift);
    const double limited = end < 0.0 ? 0.0 : end > farthest_point ? farthest_point : end;
    const double far = distance_at(far_z), reached = farthest_point < far ? farthest_point : far;
    const bool cleared = away * (depth - far_depth) >= 0.0;
    rows.direction[0][i] = static_cast<float>(dx * inverse);
    rows.direction[1][i] = static_cast<float>(dy * inverse);
    rows.direction[2][i] = static_cast<float>(dz * inverse);
    rows.t_near[i] = static_cast<float>(distance_at(near_z));
    rows.t_far[i] = static_cast<float>(cleared ? reached : limited);
    rows.spread[i] = static_cast<float>(spread / length);
  }
}

bool has_stencil(DepthFormat format) {
  return format == DepthFormat::d24s8 || format == DepthFormat::d32f_s8;
}

namespace {

template <typename T>
T read(const std::byte* row, size_t offset) {
  T value;
  std::memcpy(&value, row + offset, sizeof(T));
  return value;
}

double depth_of(uint16_t stored) {
  return stored / 65535.0;
}
double depth_of(uint32_t packed) {
  return (packed >> 8) / 16777215.0;
}
double depth_of(float stored) {
  return static_cast<double>(stored);
}

template <typename T>
void read_row(const std::byte* row, size_t texel_bytes, uint32_t count, double* depths) {
  for (uint32_t x = 0; x < count; ++x) depths[x] = depth_of(read<T>(row, x * texel_bytes));
}

}  // namespace

DepthTexel read_depth(const DepthImage& image, uint32_t x, uint32_t y) {
  const std::byte* row = image.texels + size_t{y} * image.row_bytes;
  switch (image.format) {
    case DepthFormat::d16:
      return {depth_of(read<uint16_t>(row, size_t{x} * 2)), 0};
    case DepthFormat::d24s8: {
      const auto packed = read<uint32_t>(row, size_t{x} * 4);
      return {depth_of(packed), packed & 0xffu};
    }
    case DepthFormat::d24:
    case DepthFormat::d32f:
      return {depth_of(read<float>(row, size_t{x} * 4)), 0};
    case DepthFormat::d32f_s8:
      return {depth_of(read<float>(row, size_t{x} * 8)), read<uint32_t>(row, size_t{x} * 8 + 4) & 0xffu};
  }
  return {0.0, 0};
}

void read_depths(const DepthImage& image, uint32_t y, uint32_t count, double* depths) {
  const std::byte* row = image.texels + size_t{y} * image.row_bytes;
  switch (image.format) {
    case DepthFormat::d16:
      return read_row<uint16_t>(row, 2, count, depths);
    case DepthFormat::d24s8:
      return read_row<uint32_t>(row, 4, count, depths);
    case DepthFormat::d24:
    case DepthFormat::d32f:
      return read_row<float>(row, 4, count, depths);
    case DepthFormat::d32f_s8:
      return read_row<float>(row, 8, count, depths);
  }
}

}  // namespace sideray::rt
