#include "rt/drawing/translucent_places.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace sideray::rt {
namespace {

// In normalized device coordinates.
struct Rectangle {
  glm::dvec2 low{INFINITY}, high{-INFINITY};
};

// Returns nothing where the bounds have no outline in the picture's plane.
std::optional<Rectangle> outline(const model::Bounds& bounds, const glm::dmat4& clip_from_local) {
  Rectangle r;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 p(corner & 1 ? bounds.maximum.x : bounds.minimum.x, corner & 2 ? bounds.maximum.y : bounds.minimum.y,
                      corner & 4 ? bounds.maximum.z : bounds.minimum.z);
    const glm::dvec4 clip = clip_from_local * glm::dvec4(p, 1.0);
    if (!(clip.w > 1e-9 * glm::length(glm::dvec3(clip)))) return std::nullopt;
    const glm::dvec2 ndc = glm::dvec2(clip) / clip.w;
    r.low = glm::min(r.low, ndc);
    r.high = glm::max(r.high, ndc);
  }
  return r;
}

// The pixel in which a coordinate lies, and one more: rounding may put an edge into the pixel beside it.
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
    const std::optional<Rectangle> r = outline(instance.bounds, view.clip_from_local);
    if (!r) return {};
    const uint32_t x0 = first_pixel(r->low.x, width), x1 = end_pixel(r->high.x, width);
    const uint32_t y0 = first_pixel(r->low.y, height), y1 = end_pixel(r->high.y, height);
    for (uint32_t y = y0; x0 < x1 && y < y1; ++y)
      std::fill_n(places.begin() + static_cast<ptrdiff_t>(size_t{y} * width + x0), x1 - x0, uint8_t{255});
  }
  return places;
}

}  // namespace sideray::rt
