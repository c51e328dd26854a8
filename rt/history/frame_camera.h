// The camera of a frame, for reprojection: where its pixels' points lie, and where points lie in its picture. Computed
// in double, in the snapshot's local space; pixel centres lie at whole numbers. Plain values; any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/view.h"

namespace sideray::rt {

// Describes a surface about a point of a view ray: the distance from where rays start, and a unit normal, either side.
struct SeenPlane {
  double distance;
  glm::dvec3 normal;
};

// A point at a depth along the camera's axis is origin + x * origin_x + y * origin_y + depth * (ray + x * ray_x + y *
// ray_y). In perspective rays differ and start at the eye; in an orthographic view they are parallel and start at its
// plane. The eye is put as far behind that plane as the picture is high, so that depths compare as they do in
// perspective.
struct FrameCamera {
  bool perspective = true, zero_to_one = false, reversed = false;
  glm::dvec2 size{1.0};  // of the picture, in pixels
  glm::dmat4 clip_from_local{1.0};
  glm::dvec3 origin{0.0}, origin_x{0.0}, origin_y{0.0};
  glm::dvec3 ray{0.0}, ray_x{0.0}, ray_y{0.0};  // the part along `forward` is 1
  glm::dvec3 right{0.0}, up{0.0}, forward{0.0};
  // A linear function of normalized device coordinates: the inverse of the depth in perspective, otherwise the depth.
  glm::dvec4 depth_terms{0.0};

  FrameCamera() = default;
  // Throws Failure where the matrices are no view.
  FrameCamera(const TraceView& view, uint32_t width, uint32_t height);

  // Puts it into a local space whose origin lies elsewhere. `moved`: the old origin less the new one.
  void shift(glm::dvec3 moved);
  glm::dvec3 origin_at(glm::dvec2 place) const { return origin + place.x * origin_x + place.y * origin_y; }
  glm::dvec3 ray_at(glm::dvec2 place) const { return ray + place.x * ray_x + place.y * ray_y; }
  glm::dvec3 direction(glm::dvec2 place) const { return glm::normalize(ray_at(place)); }
  // Returns where a point is in the picture; none behind the eye.
  std::optional<glm::dvec2> place(glm::dvec3 point) const;
  // Returns at which distance the ray of a pixel hits the plane through a point; none where it is seen from its edge, or lies
  // behind the ray's start.
  std::optional<double> distance(glm::dvec2 pixel, glm::dvec3 point, glm::dvec3 normal) const;
  // Returns where the ray at a place of the picture hits a plane that the ray of `pixel` hits; none as above.
  std::optional<glm::dvec3> point(glm::dvec2 pixel, const SeenPlane& plane, glm::dvec2 place) const;
  // Returns whether everything is seen where the other view shows it, to within a 1024th of a pixel.
  bool sees_as(const FrameCamera& other) const;
  // Returns the width of a pixel at a distance, about the middle of the picture.
  double breadth(double distance) const;

 private:
  void set_perspective(const TraceView& view);
  void set_orthographic(const TraceView& view);
};

// Fills the depths of a depth buffer's pixels along the camera's axis; 0 = nothing is drawn there.
void fill_depths(Executor& executor, const DepthImage& image, const FrameCamera& camera, std::vector<float>& depths);

}  // namespace sideray::rt
