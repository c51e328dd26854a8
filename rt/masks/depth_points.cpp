#include "rt/masks/depth_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sideray::rt {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
// This share covers coordinates that go through an instance's transform and back in floats.
constexpr double rounding = 0x1p-21;
// This is a factor on a slope: neighbours tell the mean slope of the triangles between them.
constexpr double slope_margin = 2.0;
// A step of at most this distance over breadth is believed from two pixels alone.
constexpr double steep = 4.0;
// Rays skip this share of a pixel's breadth where it is not known how the surface is tilted.
constexpr double pixel_share = 0.5;

void move_off(DepthPoint& p, float bias) {
  p.front += p.normal * bias;
  p.back -= p.normal * bias;
}

bool marked(const MaskRequest& r, uint32_t stencil) {
  return r.inexact != SIDERAY_EXACT && (stencil & r.inexact_bits) != 0;
}

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

void DepthPoints::see(const MaskRequest& r, const ViewRays& view, uint32_t x0, uint32_t y0) {
  // Where depth runs from -1 to 1 it was rounded once before, to half of the step that it is stored by.
  const double roundings = r.view.zero_to_one_depth ? 1.0 : 1.5;
  for (uint32_t j = 0; j < side; ++j)
    for (uint32_t i = 0; i < side; ++i) {
      Seen& s = seen_[size_t{j} * side + i];
      s.distance = nothing;
      const uint32_t x = x0 + i - border, y = y0 + j - border;  // wraps below 0, beyond every size
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
      if (inner(i) && inner(j))
        s.off = roundings * (s.distance - double{view.end_of_ray(pixel, texel.depth, s.distance, r.depth.format)});
    }
}

double DepthPoints::slope(size_t index, size_t stride, bool perspective, bool goes_on_after) const {
  const Seen& here = seen_[index];
  // In perspective the distance changes from ray to ray where the depth does not; w is linear on a plane.
  const auto depth = [&](size_t i) {
    const Seen& s = seen_[i];
    return perspective ? (1.0 - s.w / here.w) * here.distance : s.distance - here.distance;
  };
  const auto ends = [&](size_t i) { return !(seen_[i].distance < nothing) || seen_[i].resting != here.resting; };
  const size_t after = index + stride, before = index - stride;
  const double best = slope_margin * std::abs(depth(goes_on_after ? after : before));
  const size_t other = goes_on_after ? before : after;
  // Before empty space a surface may curve away; at a fold the steeper side counts; where one surface hides another,
  // neither applies.
  if (ends(other)) return 2.0 * best;
  const size_t beyond = goes_on_after ? index - 2 * stride : index + 2 * stride;
  const double change = depth(other);
  const bool folds =
      !ends(beyond) && std::abs(depth(beyond) - 2.0 * change) <= 0.125 * std::abs(change) + 8.0 * here.off;
  return folds ? std::max(best, slope_margin * std::abs(change)) : best;
}

DepthPoints::Step DepthPoints::step(size_t index, size_t stride, bool perspective) const {
  const Seen &here = seen_[index], &before = seen_[index - stride], &after = seen_[index + stride];
  const auto cost = [&](const Seen& other) {
    return other.distance < nothing && other.resting == here.resting ? std::abs(other.distance - here.distance)
                                                                     : nothing;
  };
  const double back = cost(before), forth = cost(after), slope = std::min(back, forth);
  if (slope == nothing) return {glm::dvec3(0.0), 0.0, 0.0, false};
  const bool goes_on_after = forth <= back;
  const Seen& next = goes_on_after ? after : before;
  const glm::dvec3 along = goes_on_after ? after.position - here.position : here.position - before.position;
  const glm::dvec3 drawn = next.drawn - here.drawn;
  const double steepest = DepthPoints::slope(index, stride, perspective, goes_on_after);
  const double breadth = std::sqrt(std::max(glm::dot(drawn, drawn) - slope * slope, 0.0));
  if (slope <= steep * breadth) return {along, steepest, breadth, true};
  // On a plane the inverse distance is linear: a third pixel on either side tells a grazing surface from another one
  // behind a thin leaf.
  const auto straight = [&](const Seen& other, double steps) {
    const double first = 1.0 / next.distance - 1.0 / here.distance, third = 1.0 / other.distance - 1.0 / here.distance;
    return cost(other) < nothing && std::abs(third - steps * first) <= 0.1 * std::abs(first);
  };
  const Seen& beyond = seen_[goes_on_after ? index + 2 * stride : index - 2 * stride];
  if (straight(beyond, 2.0) || straight(goes_on_after ? before : after, -1.0)) return {along, steepest, breadth, true};
  return {glm::dvec3(0.0), steep * breadth, breadth, false};
}

// Returns the normal on the eye's side, also of the rest pose, which is not seen itself: columns go right and rows up.
glm::dvec3 DepthPoints::normal(const Step& across, const Step& up, const glm::dvec3& toward) {
  glm::dvec3 n = -toward;
  if (across.known && up.known)
    n = glm::cross(across.along, up.along);
  else if (const glm::dvec3 along = across.known ? across.along : up.along; glm::dot(along, along) > 0.0)
    n = along * (glm::dot(along, toward) / glm::dot(along, along)) - toward;
  const double length = glm::length(n);
  return length > 0.0 && std::isfinite(length) ? n / length : -toward;
}

DepthPoint DepthPoints::point(const MaskRequest& r, const ViewRays& view, uint32_t x, uint32_t y, size_t index) const {
  const Seen& here = seen_[index];
  const glm::dvec3 toward(here.direction);
  const Step across = step(index, 1, view.perspective()), up = step(index, side, view.perspective());
  // The margin is half a step of the format with rounding, and what the rasterizer's grid of sub-pixels moves a slope
  // by. The slope is known but for what lies between neighbours, and for a step.
  const double off = here.off + (across.slope + up.slope + 4.0 * here.off) * double{r.subpixel};
  glm::dvec3 normal = DepthPoints::normal(across, up, toward);
  if (!here.resting && glm::dot(normal, toward) > 0.0) normal = -normal;
  const double least = rounding * largest(here.position);
  DepthPoint p{};
  p.x = static_cast<uint16_t>(x);
  p.y = static_cast<uint16_t>(y);
  p.normal = glm::vec3(normal);
  const auto doubt = [&](const Step& s) { return s.known ? 2.0 * here.off / glm::length(s.along) : 0.0; };
  p.doubt = static_cast<float>(std::min(doubt(across) + doubt(up), 2.0));
  // In the rest pose the surface is tilted otherwise: an error along the view ray or across it counts in full.
  const double any_way = off + (across.breadth + up.breadth) * double{r.subpixel};
  const glm::dvec3 moved = here.resting ? normal * (any_way + least) : -toward * off + normal * least;
  p.front = glm::vec3(here.position + moved);
  p.back = glm::vec3(here.position - moved);
  p.inexact = here.marked;
  p.bias = r.inexact_bias;
  if (r.inexact == SIDERAY_INEXACT_BOUNDED && !r.rest_offsets.empty())
    p.bias = std::max(r.rest_offsets[size_t{y} * r.width + x].w, 0.0f);
  if (!r.points.empty() && !here.resting) {
    const OpaquePoint& met = r.points[size_t{y} * r.width + x];
    if (std::abs(met.distance - here.distance) <= off + least) return exact(p, here, met, least);
  }
  if (!across.known || !up.known) {
    const ViewRays::Pixel pixel = view.pixel(x, y), beside = view.pixel(x + 1, y);
    const glm::dvec3 turn(beside.direction - pixel.direction), move(beside.origin - pixel.origin);
    p.skip = static_cast<float>(pixel_share * glm::length(turn * here.distance + move));
  }
  return p;
}

DepthPoint DepthPoints::exact(DepthPoint p, const Seen& here, const OpaquePoint& met, double least) {
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

const std::vector<DepthPoint>& DepthPoints::gather(const MaskRequest& r, const ViewRays& view, uint32_t x0,
                                                   uint32_t y0) {
  constexpr uint32_t block = 4;
  see(r, view, x0, y0);
  points_.clear();
  for (uint32_t by = 0; by < tile_size; by += block)
    for (uint32_t bx = 0; bx < tile_size; bx += block)
      for (uint32_t j = by; j < by + block; ++j)
        for (uint32_t i = bx; i < bx + block; ++i) {
          const size_t index = size_t{j + border} * side + i + border;
          if (seen_[index].distance == nothing) continue;
          points_.push_back(point(r, view, x0 + i, y0 + j, index));
          if (r.shadow_bias > 0.0f) move_off(points_.back(), r.shadow_bias);
        }
  return points_;
}

}  // namespace sideray::rt
