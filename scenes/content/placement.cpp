#include "scenes/content/placement.h"

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"

namespace sideray::scenes {
namespace {

constexpr double radians_of_degree = 0.017453292519943295;

// Calls visit(world position) for every corner of every triangle.
template <typename Visit>
void for_each_corner(const Content& content, const Object& object, Visit&& visit) {
  const Mesh& mesh = content.meshes.at(object.mesh);
  const double* m = object.world_from_object;
  const glm::dmat4x3 world_from_object(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11]);
  for (const uint32_t index : mesh.indices) {
    const float* p = &mesh.positions[size_t{3} * index];
    visit(world_from_object * glm::dvec4(double{p[0]}, double{p[1]}, double{p[2]}, 1.0));
  }
}

}  // namespace

Bounds bounds_of(const Content& content, const Object& object) {
  Bounds bounds;
  for_each_corner(content, object, [&](glm::dvec3 p) {
    bounds.minimum = glm::min(bounds.minimum, p);
    bounds.maximum = glm::max(bounds.maximum, p);
  });
  return bounds;
}

Bounds bounds_of(const Content& content) {
  Bounds all;
  for (const Object& object : content.objects) {
    const Bounds bounds = bounds_of(content, object);
    if (bounds.empty()) continue;
    all.minimum = glm::min(all.minimum, bounds.minimum);
    all.maximum = glm::max(all.maximum, bounds.maximum);
  }
  return all;
}

sideray_camera framing_camera(const Content& content, float aspect) {
  const Bounds all = bounds_of(content);
  const glm::dvec3 center = all.empty() ? glm::dvec3(0.0) : 0.5 * (all.minimum + all.maximum);
  double radius = 0.0;
  for (const Object& object : content.objects) {
    for_each_corner(content, object, [&](glm::dvec3 p) { radius = std::max(radius, glm::distance(p, center)); });
  }
  if (!(radius > 0.0)) radius = 1.0;
  constexpr double fov_deg = 45.0, margin = 1.05;
  const double half_vertical = 0.5 * fov_deg * radians_of_degree;
  const double half_horizontal = elementary::atan(elementary::tan(half_vertical) * double{aspect});
  const double distance = margin * radius / elementary::sin(std::min(half_vertical, half_horizontal));
  const glm::dvec3 eye = center + distance * glm::normalize(glm::dvec3(1.0, 0.6, 1.4));
  sideray_camera camera = look_at(&eye[0], &center[0], static_cast<float>(fov_deg));
  camera.z_near = static_cast<float>(0.5 * (distance - radius));
  return camera;
}

sideray_camera look_at(const double eye[3], const double target[3], float fov_deg) {
  const glm::dvec3 from(eye[0], eye[1], eye[2]), to(target[0], target[1], target[2]);
  const double distance = glm::distance(from, to);
  const glm::dvec3 back = distance > 0.0 ? (from - to) / distance : glm::dvec3(0, 0, 1);
  // If the view is straight up or down, north is -Z, as on a map.
  const glm::dvec3 above = std::abs(back.y) > 0.999999 ? glm::dvec3(0, 0, back.y > 0 ? -1 : 1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 right = glm::normalize(glm::cross(above, back)), up = glm::cross(back, right);
  sideray_camera camera{};
  camera.size = sizeof(camera);
  const glm::dvec3 columns[4] = {right, up, back, from};
  for (int i = 0; i < 12; ++i) camera.world_from_camera[i] = columns[i / 3][i % 3];
  camera.yfov = static_cast<float>(double{fov_deg} * radians_of_degree);
  camera.z_near = static_cast<float>(std::min(0.1, distance > 0.0 ? 0.01 * distance : 0.1));
  return camera;
}

}  // namespace sideray::scenes
