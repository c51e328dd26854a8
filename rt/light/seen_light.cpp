#include "rt/light/seen_light.h"

#include <cmath>

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr float least_elevation_of_eye = 0.05f;  // the sine, above the surface
// The largest distances, in widths of a pixel, between a point and the place that its pixel shows: off the surface, and
// along it where the surface faces the eye.
constexpr float most_off = 0.25f, most_along = 2.0f;

}  // namespace

SeenLight::SeenLight(const TraceView& view, uint32_t width, uint32_t height, const DepthImage& depth, const PixelLight& light)
    : rays_(view, width, height),
      clip_from_local_(view.clip_from_local),
      width_(width),
      height_(height),
      depth_(depth),
      light_(light) {}

std::optional<ArrivingLight> SeenLight::at(const PointAround& point) const {
  const glm::dvec4 clip = clip_from_local_ * glm::dvec4(glm::dvec3(point.origin), 1.0);
  const double x = (clip.x / clip.w * 0.5 + 0.5) * width_, y = (clip.y / clip.w * 0.5 + 0.5) * height_;
  if (!(clip.w > 0.0 && x >= 0.0 && y >= 0.0 && x < width_ && y < height_)) return std::nullopt;
  const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
  const size_t texel = size_t{row} * width_ + column;
  if (!light_.answers.empty() && (light_.answers[texel] & light_.answer_of_open) == 0) return std::nullopt;
  const uint16_t* thrown = &light_.thrown[4 * texel];
  if (thrown[3] == 0 || !shows(column, row, point)) return std::nullopt;
  constexpr float whole = 255.0f;
  return ArrivingLight{{imath_half_to_float(thrown[0]), imath_half_to_float(thrown[1]), imath_half_to_float(thrown[2])},
                       glm::vec3(static_cast<float>(light_.open[texel]) / whole)};
}

// The normal is on the side from which the point was met: a wall whose back a mirror shows does not count.
bool SeenLight::shows(uint32_t x, uint32_t y, const PointAround& point) const {
  const double depth = read_depth(depth_, x, y).depth;
  const ViewRays::Pixel pixel = rays_.pixel(x, y);
  const double exact = rays_.distance(pixel, depth);
  const auto distance = static_cast<float>(exact);
  const float error = distance - rays_.end_of_ray(pixel, depth, exact, depth_.format);
  const float facing = -glm::dot(pixel.direction, point.normal);
  if (!(facing > least_elevation_of_eye)) return false;
  const Cone cone = rays_.cone(pixel);
  const float width = cone.width + cone.spread * distance;
  const glm::vec3 apart = pixel.origin + pixel.direction * distance - point.origin;
  const float along = most_along * width / facing;
  return std::abs(glm::dot(apart, point.normal)) <= most_off * width + error && glm::dot(apart, apart) <= along * along;
}

}  // namespace sideray::rt
