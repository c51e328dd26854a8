#include "rt/history/frame_camera.h"

#include <cmath>

#include "rt/base/view_rays.h"

namespace sideray::rt {
namespace {

// The smallest sine between a ray and a plane whose depth still predicts the neighbouring pixel.
constexpr double least_sine = 0.02;
constexpr double same_pixel = 1.0 / 1024;
// The largest relative motion of an eye at rest, from rounding of its coordinates.
constexpr double same_eye = 1e-8;

glm::dvec4 row(const glm::dmat4& m, int i) {
  return {m[0][i], m[1][i], m[2][i], m[3][i]};
}

}  // namespace

FrameCamera::FrameCamera(const TraceView& view, uint32_t width, uint32_t height)
    : perspective(ViewRays(view, width, height).perspective()),
      zero_to_one(view.zero_to_one_depth),
      reversed(view.reversed_depth),
      size(width, height),
      clip_from_local(view.clip_from_local) {
  if (perspective)
    set_perspective(view);
  else
    set_orthographic(view);
}

// A point is eye + ray / w, where w is linear in normalized device coordinates.
void FrameCamera::set_perspective(const TraceView& view) {
  const glm::dmat4& m = view.local_from_clip;
  origin = glm::dvec3(m[2]) / m[2].w;
  const auto along = [&](int column) { return glm::dvec3(m[column]) - origin * m[column].w; };
  glm::dvec3 x = along(0), y = along(1), center = along(3);
  depth_terms = row(m, 3);
  const double near = reversed ? 1.0 : zero_to_one ? 0.0 : -1.0;
  if (depth_terms.z * near + depth_terms.w < 0.0) {
    x = -x;
    y = -y;
    center = -center;
    depth_terms = -depth_terms;
  }
  forward = glm::normalize(glm::dvec3(row(clip_from_local, 3)));
  if (glm::dot(forward, center) < 0.0) forward = -forward;
  const double unit = glm::dot(forward, center);
  depth_terms /= unit;
  ray_x = x * (2.0 / size.x) / unit;
  ray_y = y * (2.0 / size.y) / unit;
  ray = (center - x - y) / unit + 0.5 * (ray_x + ray_y);
  right = glm::normalize(ray_x);
  up = glm::normalize(ray_y);
}

void FrameCamera::set_orthographic(const TraceView& view) {
  const auto at = [&](double x, double y, double z) {
    const glm::dvec4 h = view.local_from_clip * glm::dvec4(x, y, z, 1.0);
    return glm::dvec3(h) / h.w;
  };
  const double lowest = zero_to_one ? 0.0 : -1.0, near = reversed ? 1.0 : lowest, far = reversed ? lowest : 1.0;
  const glm::dvec3 corner = at(-1, -1, near), along = at(0, 0, far) - at(0, 0, near);
  origin_x = (at(1, -1, near) - corner) / size.x;
  origin_y = (at(-1, 1, near) - corner) / size.y;
  forward = ray = glm::normalize(along);
  right = glm::normalize(origin_x);
  up = glm::normalize(origin_y);
  const double behind = glm::length(origin_y) * size.y, per_z = glm::length(along) / (far - near);
  origin = corner + 0.5 * (origin_x + origin_y) - behind * forward;
  depth_terms = {0.0, 0.0, per_z, behind - per_z * near};
}

void FrameCamera::shift(glm::dvec3 moved) {
  origin += moved;
  clip_from_local[3] -= clip_from_local * glm::dvec4(moved, 0.0);
}

std::optional<glm::dvec2> FrameCamera::place(glm::dvec3 point) const {
  const glm::dvec4 clip = clip_from_local * glm::dvec4(point, 1.0);
  if (!(clip.w > 0.0)) return std::nullopt;
  return (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size - 0.5;
}

std::optional<double> FrameCamera::distance(glm::dvec2 pixel, glm::dvec3 point, glm::dvec3 normal) const {
  const glm::dvec3 toward = direction(pixel);
  const double sine = glm::dot(normal, toward), behind = perspective ? 0.0 : glm::length(origin_y) * size.y;
  if (std::abs(sine) < least_sine) return std::nullopt;
  const double t = glm::dot(normal, point - origin_at(pixel)) / sine - behind;
  return t > 0.0 ? std::optional(t) : std::nullopt;
}

std::optional<glm::dvec3> FrameCamera::point(glm::dvec2 pixel, const SeenPlane& plane, glm::dvec2 place) const {
  const double behind = perspective ? 0.0 : glm::length(origin_y) * size.y;
  const glm::dvec3 there = origin_at(pixel) + direction(pixel) * (plane.distance + behind);
  if (place == pixel) return there;
  const std::optional<double> t = distance(place, there, plane.normal);
  if (!t) return std::nullopt;
  return origin_at(place) + direction(place) * (*t + behind);
}

double FrameCamera::breadth(double distance) const {
  if (!perspective) return glm::length(origin_y);
  return distance * glm::length(ray_y) / glm::length(ray_at(0.5 * (size - 1.0)));
}

bool FrameCamera::sees_as(const FrameCamera& other) const {
  if (perspective != other.perspective || size != other.size) return false;
  for (int i = 0; i < 5; ++i) {
    const glm::dvec2 at = i == 4 ? 0.5 * size : size * glm::dvec2(i & 1, i >> 1);
    const double turned = glm::length(ray_at(at) - other.ray_at(at));
    const double moved = glm::length(origin_at(at) - other.origin_at(at));
    const double most_turned = perspective ? same_pixel * glm::length(ray_y) : same_eye;
    const double most_moved = perspective ? same_eye * (1.0 + glm::length(origin)) : same_pixel * glm::length(origin_y);
    if (!(turned <= most_turned) || !(moved <= most_moved)) return false;
  }
  return true;
}

bool FrameCamera::shares_lines(const FrameCamera& other) const {
  if (perspective != other.perspective) return false;
  return perspective ? glm::distance(origin, other.origin) <= same_eye * (1.0 + glm::length(origin))
                     : glm::distance(forward, other.forward) <= same_eye;
}

void fill_depths(Executor& executor, const DepthImage& image, const FrameCamera& camera, std::vector<float>& depths) {
  const auto width = static_cast<uint32_t>(camera.size.x), height = static_cast<uint32_t>(camera.size.y);
  depths.resize(size_t{width} * height);
  const glm::dvec4& terms = camera.depth_terms;
  const bool inverse = camera.perspective;
  const double scale = camera.zero_to_one ? 1.0 : 2.0, from = camera.zero_to_one ? 0.0 : 1.0;
  std::vector<std::vector<double>> stored(executor.threads(), std::vector<double>(width));
  executor.run(height, [&](size_t y, uint32_t thread) {
    double* s = stored[thread].data();
    read_depths(image, static_cast<uint32_t>(y), width, s);
    const double across = terms.x * 2.0 / width;
    const double up = terms.y * ((2.0 * static_cast<double>(y) + 1.0) / height - 1.0) + terms.w;
    float* to = &depths[y * width];
    for (uint32_t x = 0; x < width; ++x) {
      const double value = across * (x + 0.5) - terms.x + up + terms.z * (scale * s[x] - from);
      const bool nothing = camera.reversed ? s[x] <= 0.0 : s[x] >= 1.0;
      to[x] = nothing || !(value > 0.0) ? 0.0f : static_cast<float>(inverse ? 1.0 / value : value);
    }
  });
}

}  // namespace sideray::rt
