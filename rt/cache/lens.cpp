#include "rt/cache/lens.h"

#include <cmath>

#include "rt/base/view_rays.h"

namespace sideray::rt {
namespace {

// Seen at less than this sine, a plane says nothing of the pixel beside.
constexpr double least_sine = 0.02;
constexpr double same_pixel = 1.0 / 4096;
// Of an eye that stands still, beside what rounding makes of its coordinates.
constexpr double same_eye = 1e-8;

}  // namespace

Lens::Lens(const TraceView& view, uint32_t width, uint32_t height)
    : clip_from_local_(view.clip_from_local), size_(width, height), pixel_(2.0 / glm::dvec2(width, height)) {
  const ViewRays rays(view, width, height);
  perspective_ = rays.perspective();
  if (perspective_) {
    const ViewRays::Perspective terms = rays.terms();
    eye_ = terms.eye, center_ = terms.center, along_x_ = terms.along_x, along_y_ = terms.along_y;
    spread_ = pixel_.y * glm::length(along_y_) / glm::length(center_);
    return;
  }
  const double near = view.reversed_depth ? 1.0 : 0.0, far = 1.0 - near;
  const auto at = [&](double x, double y, double depth) {
    const glm::dvec4 h = view.local_from_clip * glm::dvec4(x, y, view.zero_to_one_depth ? depth : 2.0 * depth - 1.0, 1.0);
    return glm::dvec3(h) / h.w;
  };
  center_ = at(0, 0, near);
  along_x_ = at(1, 0, near) - center_;
  along_y_ = at(0, 1, near) - center_;
  direction_ = glm::normalize(at(0, 0, far) - center_);
  spread_ = pixel_.y * glm::length(along_y_);
}

glm::dvec3 Lens::origin(glm::dvec2 place) const {
  if (perspective_) return eye_;
  const glm::dvec2 p = ndc(place);
  return center_ + p.x * along_x_ + p.y * along_y_;
}

glm::dvec3 Lens::along(glm::dvec2 place) const {
  if (!perspective_) return direction_;
  const glm::dvec2 p = ndc(place);
  return center_ + p.x * along_x_ + p.y * along_y_;
}

glm::dvec3 Lens::direction(glm::dvec2 place) const {
  return glm::normalize(along(place));
}

std::optional<glm::dvec3> Lens::point(glm::dvec2 pixel, const LensPlane& plane, glm::dvec2 place) const {
  const glm::dvec3 there = origin(pixel) + direction(pixel) * plane.distance;
  if (place == pixel) return there;
  const std::optional<double> t = distance(place, there, plane.normal);
  if (!t) return std::nullopt;
  return origin(place) + direction(place) * *t;
}

std::optional<double> Lens::distance(glm::dvec2 pixel, glm::dvec3 point, glm::dvec3 normal) const {
  const glm::dvec3 toward = direction(pixel);
  const double sine = glm::dot(normal, toward);
  if (std::abs(sine) < least_sine) return std::nullopt;
  const double t = glm::dot(normal, point - origin(pixel)) / sine;
  return t > 0.0 ? std::optional(t) : std::nullopt;
}

std::optional<glm::dvec2> Lens::place(glm::dvec3 point) const {
  const glm::dvec4 clip = clip_from_local_ * glm::dvec4(point, 1.0);
  if (!(clip.w > 0.0)) return std::nullopt;
  return (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size_ - 0.5;
}

bool Lens::sees_as(const Lens& other) const {
  if (perspective_ != other.perspective_ || size_ != other.size_) return false;
  for (int i = 0; i < 5; ++i) {
    const glm::dvec2 place = i == 4 ? 0.5 * size_ : size_ * glm::dvec2(i & 1, i >> 1);
    const double moved = glm::length(direction(place) - other.direction(place));
    const double away = glm::length(origin(place) - other.origin(place));
    const double allowed = perspective_ ? same_eye * (1.0 + glm::length(eye_)) : same_pixel * spread_;
    if (!(moved <= (perspective_ ? same_pixel * spread_ : same_eye)) || !(away <= allowed)) return false;
  }
  return true;
}

}  // namespace sideray::rt
