#include "viewer/scene/navigation.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/content/content.h"

namespace sideray::viewer {
namespace {

constexpr double steepest = 1.55;  // radians from the horizon

glm::dvec3 column(const sideray_camera& camera, size_t index) {
  return {camera.world_from_camera[3 * index], camera.world_from_camera[3 * index + 1],
          camera.world_from_camera[3 * index + 2]};
}

double elevation(const glm::dvec3& direction) {
  return std::asin(std::clamp(direction.y / glm::length(direction), -1.0, 1.0));
}

}  // namespace

glm::dvec3 eye_of(const sideray_camera& camera) {
  return column(camera, 3);
}

glm::dvec3 direction_through(const sideray_camera& camera, double x, double y, double aspect) {
  const double up = std::tan(0.5 * static_cast<double>(camera.yfov));
  const double pixel_aspect = camera.fx_per_fy > 0 ? static_cast<double>(camera.fx_per_fy) : 1.0;
  const double right = (2.0 * x - 1.0 - 2.0 * static_cast<double>(camera.shift_x)) * up * aspect / pixel_aspect;
  const double above = (1.0 - 2.0 * y + 2.0 * static_cast<double>(camera.shift_y)) * up;
  return column(camera, 0) * right + column(camera, 1) * above - column(camera, 2);
}

void Navigation::look(const glm::dvec3& eye, const glm::dvec3& target, double fov_deg) {
  eye_ = eye, target_ = target, fov_deg_ = fov_deg;
  is_free_ = true;
}

// An orthographic camera becomes a perspective camera as soon as it is moved.
sideray_camera Navigation::camera(const sideray_camera& of_file, double distance) {
  if (is_free_) return scenes::look_at(&eye_.x, &target_.x, static_cast<float>(fov_deg_));
  eye_ = eye_of(of_file);
  target_ = eye_ - column(of_file, 2) * distance;
  fov_deg_ = of_file.orthographic ? 45.0 : glm::degrees(static_cast<double>(of_file.yfov));
  return of_file;
}

void Navigation::orbit(const glm::dvec3& pivot, double right, double down) {
  const glm::dvec3 forward = target_ - eye_;
  const double now = elevation(forward), after = std::clamp(now - down, -steepest, steepest);
  const glm::dvec3 level(forward.x, 0, forward.z);
  const glm::dvec3 side = glm::length(level) > 0 ? glm::normalize(glm::cross(level, glm::dvec3(0, 1, 0))) : glm::dvec3(1, 0, 0);
  const glm::dmat4 turned = glm::rotate(glm::rotate(glm::dmat4(1), -right, glm::dvec3(0, 1, 0)), after - now, side);
  const auto about = [&](const glm::dvec3& point) { return pivot + glm::dvec3(turned * glm::dvec4(point - pivot, 0)); };
  look(about(eye_), about(target_), fov_deg_);
}

void Navigation::move(const glm::dvec3& by) {
  const glm::dvec3 forward = glm::normalize(target_ - eye_);
  const glm::dvec3 side = glm::normalize(glm::cross(forward, std::abs(forward.y) > 0.99999 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0)));
  const glm::dvec3 step = side * by.x + glm::cross(side, forward) * by.y + forward * by.z;
  look(eye_ + step, target_ + step, fov_deg_);
}

void Navigation::approach(const glm::dvec3& point, double factor) {
  const glm::dvec3 step = (point - eye_) * (1.0 - factor);
  look(eye_ + step, target_ + step, fov_deg_);
}

}  // namespace sideray::viewer
