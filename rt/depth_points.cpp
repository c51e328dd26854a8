#include "rt/depth_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sideray::rt {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
// Of coordinates that go through an instance's transform and back in floats.
constexpr double rounding = 0x1p-21;

bool marked(const MaskRequest& r, uint32_t stencil) {
  return r.inexact != SIDERAY_EXACT && (stencil & r.inexact_bits) != 0;
}

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

void DepthPoints::see(const MaskRequest& r, const ViewRays& view, uint32_t x0, uint32_t y0) {
  for (uint32_t j = 0; j < side; ++j)
    for (uint32_t i = 0; i < side; ++i) {
      Seen& s = seen_[size_t{j} * side + i];
      s.distance = nothing;
      const uint32_t x = x0 + i - 1, y = y0 + j - 1;  // wraps below 0, beyond every size
      if (x >= r.width || y >= r.height) continue;
      const DepthTexel texel = read_depth(r.depth, x, y);
      if (r.view.reversed_depth ? texel.depth <= 0.0 : texel.depth >= 1.0) continue;
      const ViewRays::Pixel pixel = view.pixel(x, y);
      s.distance = view.distance(pixel, texel.depth);
      s.position = glm::dvec3(pixel.origin) + glm::dvec3(pixel.direction) * s.distance;
      s.direction = pixel.direction;
      s.marked = marked(r, texel.stencil);
      s.resting = s.marked && r.inexact == SIDERAY_INEXACT_RESTPOSE && !r.rest_offsets.empty();
      if (s.resting) s.position += glm::dvec3(glm::vec3(r.rest_offsets[size_t{y} * r.width + x]));
      const bool border = i == 0 || j == 0 || i + 1 == side || j + 1 == side;
      if (!border) s.off = s.distance - double{view.end_of_ray(pixel, texel.depth, s.distance, r.depth.format)};
    }
}

DepthPoints::Step DepthPoints::step(const Seen& here, const Seen& before, const Seen& after) const {
  const auto cost = [&](const Seen& other) {
    return other.distance < nothing && other.resting == here.resting ? std::abs(other.distance - here.distance)
                                                                     : nothing;
  };
  const double back = cost(before), forth = cost(after);
  if (std::min(back, forth) == nothing) return {glm::dvec3(0.0), -1.0};
  return forth <= back ? Step{after.position - here.position, forth} : Step{here.position - before.position, back};
}

DepthPoint DepthPoints::point(const MaskRequest& r, uint32_t x, uint32_t y, uint32_t i, uint32_t j) const {
  const Seen& here = at(i, j);
  const glm::dvec3 toward(here.direction);
  const Step across = step(here, at(i - 1, j), at(i + 1, j)), up = step(here, at(i, j - 1), at(i, j + 1));
  // Half a step of the format and rounding, and what the rasterizer's grid of sub-pixels moves a slope by.
  const double slope = std::max(across.slope, 0.0) + std::max(up.slope, 0.0);
  const double off = here.off + slope * double{r.subpixel};
  glm::dvec3 normal = -toward;
  if (across.slope >= 0.0 && up.slope >= 0.0) {
    // Columns go right and rows up, so that this side is the eye's; of the rest pose too, which is not seen itself.
    const glm::dvec3 n = glm::cross(across.along, up.along);
    const double length = glm::length(n);
    if (length > 0.0 && std::isfinite(length)) normal = n / length;
  }
  if (!here.resting && glm::dot(normal, toward) > 0.0) normal = -normal;
  const double least = rounding * largest(here.position);
  DepthPoint p{};
  p.x = static_cast<uint16_t>(x), p.y = static_cast<uint16_t>(y);
  p.normal = glm::vec3(normal);
  // In the rest pose the surface stands at another angle: an error along the view ray counts in full.
  const glm::dvec3 moved = here.resting ? normal * (off + least) : -toward * off + normal * least;
  p.front = glm::vec3(here.position + moved);
  p.back = glm::vec3(here.position - moved);
  p.inexact = here.marked;
  p.bias = r.inexact_bias;
  if (r.inexact == SIDERAY_INEXACT_BOUNDED && !r.rest_offsets.empty())
    p.bias = std::max(r.rest_offsets[size_t{y} * r.width + x].w, 0.0f);
  return p;
}

const std::vector<DepthPoint>& DepthPoints::gather(const MaskRequest& r, const ViewRays& view, uint32_t x0,
                                                   uint32_t y0) {
  constexpr uint32_t block = 4;
  see(r, view, x0, y0);
  points_.clear();
  for (uint32_t by = 0; by < tile_size; by += block)
    for (uint32_t bx = 0; bx < tile_size; bx += block)
      for (uint32_t j = by; j < by + block; ++j)
        for (uint32_t i = bx; i < bx + block; ++i) {
          if (at(i + 1, j + 1).distance == nothing) continue;
          points_.push_back(point(r, x0 + i, y0 + j, i + 1, j + 1));
        }
  return points_;
}

}  // namespace sideray::rt
