// Is the camera of a frame, for reprojection between pixels and points. Computed in double, in the snapshot's local
// space; pixel centres are at integers. Plain values; any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/view.h"

namespace sideray::rt {

// Describes the surface near a point of a view ray: the distance from the ray's start, and a unit normal on either
// side.
struct SeenPlane {
  double distance;
  glm::dvec3 normal;
};

// The point at pixel (x, y) and a depth along the camera's axis is origin + x * origin_x + y * origin_y + depth * (ray
// + x * ray_x + y * ray_y). In perspective rays differ and start at the eye. In an orthographic view they are parallel
// and start on a plane through the eye, which is put one picture height behind the near plane, so that depths compare
// as in perspective.
struct FrameCamera {
  bool perspective = true, zero_to_one = false, reversed = false;
  glm::dvec2 size{1.0};  // of the picture, in pixels
  glm::dmat4 clip_from_local{1.0};
  glm::dvec3 origin{0.0}, origin_x{0.0}, origin_y{0.0};
  glm::dvec3 ray{0.0}, ray_x{0.0}, ray_y{0.0};  // their component along `forward` is 1
  glm::dvec3 right{0.0}, up{0.0}, forward{0.0};
  // Coefficients of a linear function of normalized device coordinates: 1 / depth in perspective, otherwise the depth.
  glm::dvec4 depth_terms{0.0};

  FrameCamera() = default;
  // Throws Failure if the matrices describe no view.
  FrameCamera(const TraceView& view, uint32_t width, uint32_t height);

  // Changes the local space to another origin. `moved`: the old origin minus the new one.
  void shift(glm::dvec3 moved);
  glm::dvec3 origin_at(glm::dvec2 place) const { return origin + place.x * origin_x + place.y * origin_y; }
  glm::dvec3 ray_at(glm::dvec2 place) const { return ray + place.x * ray_x + place.y * ray_y; }
  glm::dvec3 direction(glm::dvec2 place) const { return glm::normalize(ray_at(place)); }
  // Returns the position of a point in the picture, in pixels; nothing if it is behind the eye.
  std::optional<glm::dvec2> place(glm::dvec3 point) const;
  // Returns the distance at which a pixel's ray hits the plane through a point; nothing if the plane is edge-on or
  // behind the ray's start.
  std::optional<double> distance(glm::dvec2 pixel, glm::dvec3 point, glm::dvec3 normal) const;
  // Returns where the ray at position `place` hits the plane that was seen through `pixel`; nothing as above.
  std::optional<glm::dvec3> point(glm::dvec2 pixel, const SeenPlane& plane, glm::dvec2 place) const;
  // Returns whether all points have the same position in both views, to within a 1024th of a pixel.
  bool sees_as(const FrameCamera& other) const;
  // Returns whether all points are seen along the same lines: mirrors show the same at the same points.
  bool shares_lines(const FrameCamera& other) const;
  // Returns the width of a pixel's footprint at a distance, near the middle of the picture.
  double breadth(double distance) const;

 private:
  void set_perspective(const TraceView& view);
  void set_orthographic(const TraceView& view);
};

// Fills in the depth of each pixel along the camera's axis; 0 = no surface.
void fill_depths(Executor& executor, const DepthImage& image, const FrameCamera& camera, std::vector<float>& depths);

}  // namespace sideray::rt
