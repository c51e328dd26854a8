// The rays of a view at any place of the picture, in double: where a point of a layer is seen from another view. Immutable;
// any thread may call it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "rt/base/view.h"

namespace sideray::rt {

// Describes a surface about a point of a view ray: the distance from where rays start, and a unit normal, either side.
struct LensPlane {
  double distance;
  glm::dvec3 normal;
};

class Lens {
 public:
  Lens() = default;
  // The matrices are those of a view (ViewRays).
  Lens(const TraceView& view, uint32_t width, uint32_t height);

  // Returns where the ray at a place of the picture hits a plane that the ray of `pixel` hits at a distance. Pixel centres
  // lie at whole numbers. None where it is seen from its edge.
  std::optional<glm::dvec3> point(glm::dvec2 pixel, const LensPlane& plane, glm::dvec2 place) const;
  // Returns at which distance the ray of a pixel hits the plane through a point; none where it is seen from its edge, or lies
  // behind the ray's start.
  std::optional<double> distance(glm::dvec2 pixel, glm::dvec3 point, glm::dvec3 normal) const;
  // Returns where a point is in the picture; none behind the eye.
  std::optional<glm::dvec2> place(glm::dvec3 point) const;
  // Returns the unit direction of a place's ray.
  glm::dvec3 direction(glm::dvec2 place) const;
  // Returns whether everything is seen where the other view shows it, to within a 4096th of a pixel.
  bool sees_as(const Lens& other) const;
  // The width of a pixel at a distance, about the middle of the picture.
  double breadth(double distance) const { return perspective_ ? spread_ * distance : spread_; }

 private:
  glm::dvec2 ndc(glm::dvec2 place) const { return (place + 0.5) * pixel_ - 1.0; }
  glm::dvec3 origin(glm::dvec2 place) const;
  glm::dvec3 along(glm::dvec2 place) const;  // of any length

  glm::dmat4 clip_from_local_{1.0};
  bool perspective_ = true;
  glm::dvec2 size_{1.0}, pixel_{1.0};
  glm::dvec3 eye_{0.0}, center_{0.0}, along_x_{0.0}, along_y_{0.0}, direction_{0.0};
  double spread_ = 0.0;
};

}  // namespace sideray::rt
