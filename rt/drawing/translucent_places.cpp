#include "rt/drawing/translucent_places.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sideray::rt {
namespace {

// Is a rectangle in normalized device coordinates.
struct Rectangle {
  glm::dvec2 low{INFINITY}, high{-INFINITY};

  void add(const glm::dvec4& clip) {
    const glm::dvec2 ndc = glm::dvec2(clip) / clip.w;
    low = glm::min(low, ndc);
    high = glm::max(high, ndc);
  }
};

// Is above 0 for clip-space points beyond the near plane. The plane is moved slightly toward the eye, because rays
// begin there in single precision.
double past_near(const glm::dvec4& clip, const TraceView& view) {
  constexpr double nearer = 1e-5;
  if (view.reversed_depth) return (1.0 + nearer) * clip.w - clip.z;
  return clip.z + (view.zero_to_one_depth ? nearer : 1.0 + nearer) * clip.w;
}

// Returns the bounding rectangle of the part of the bounds beyond the near plane.
Rectangle outline(const model::Bounds& bounds, const TraceView& view) {
  std::array<glm::dvec4, 8> corners;
  std::array<double, 8> past;
  Rectangle r;
  for (size_t i = 0; i < corners.size(); ++i) {
    const glm::vec3 p(i & 1 ? bounds.maximum.x : bounds.minimum.x, i & 2 ? bounds.maximum.y : bounds.minimum.y,
                      i & 4 ? bounds.maximum.z : bounds.minimum.z);
    corners[i] = view.clip_from_local * glm::dvec4(p, 1.0);
    past[i] = past_near(corners[i], view);
    if (past[i] > 0.0) r.add(corners[i]);
  }
  for (size_t i = 0; i < corners.size(); ++i)
    for (const size_t axis : {1u, 2u, 4u}) {
      const size_t j = i | axis;
      if (j != i && (past[i] > 0.0) != (past[j] > 0.0))
        r.add(glm::mix(corners[i], corners[j], past[i] / (past[i] - past[j])));
    }
  return r;
}

// Return the range of pixels between two coordinates, one wider on each side, because rounding may move an edge into
// the next pixel.
uint32_t first_pixel(double ndc, uint32_t size) {
  return static_cast<uint32_t>(std::clamp(std::floor((0.5 * ndc + 0.5) * size) - 1.0, 0.0, static_cast<double>(size)));
}
uint32_t end_pixel(double ndc, uint32_t size) {
  return static_cast<uint32_t>(std::clamp(std::floor((0.5 * ndc + 0.5) * size) + 2.0, 0.0, static_cast<double>(size)));
}

}  // namespace

std::vector<uint8_t> translucent_places(const model::Snapshot& snapshot, const TraceView& view, uint32_t width,
                                        uint32_t height) {
  if (!snapshot.particles.empty()) return {};
  std::vector<uint8_t> places(size_t{width} * height, 0);
  for (const model::Instance& instance : snapshot.instances) {
    if (!snapshot.materials[instance.material].translucent || instance.bounds.empty()) continue;
    if (instance.wind != 0 || instance.sprites != 0) return {};
    const Rectangle r = outline(instance.bounds, view);
    if (r.low.x > r.high.x) continue;
    const uint32_t x0 = first_pixel(r.low.x, width), x1 = end_pixel(r.high.x, width);
    const uint32_t y0 = first_pixel(r.low.y, height), y1 = end_pixel(r.high.y, height);
    for (uint32_t y = y0; x0 < x1 && y < y1; ++y)
      std::fill_n(places.begin() + static_cast<ptrdiff_t>(size_t{y} * width + x0), x1 - x0, uint8_t{255});
  }
  return places;
}

}  // namespace sideray::rt
