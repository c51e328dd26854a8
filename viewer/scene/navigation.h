// A camera that the user moves around a point or through the scene, or that follows a camera of the file. Any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <sideray/sideray.hpp>

namespace sideray::viewer {

class Navigation {
 public:
  // Follows the file's camera `index` until the user moves it. Empty: frames the scene.
  void follow(std::optional<size_t> index) { file_camera_ = index, is_free_ = false; }
  std::optional<size_t> file_camera() const { return is_free_ ? std::nullopt : file_camera_; }
  bool is_free() const { return is_free_; }
  void look(const glm::dvec3& eye, const glm::dvec3& target, double fov_deg);

  // Returns the current camera: `of_file` until the user moves it. Movement then starts from `of_file`, with the target
  // `distance` ahead.
  sideray_camera camera(const sideray_camera& of_file, double distance);

  // Rotate, in radians, about `pivot` or the eye. The horizon stays level, and the camera never crosses straight up.
  void orbit(const glm::dvec3& pivot, double right, double down);
  void turn(double right, double down) { orbit(eye_, right, down); }
  // Moves right, up and forward, in world units.
  void move(const glm::dvec3& by);
  // Scales the distance to a point by `factor`; the point keeps its place in the picture.
  void approach(const glm::dvec3& point, double factor);

  glm::dvec3 eye() const { return eye_; }
  glm::dvec3 target() const { return target_; }
  double fov_deg() const { return fov_deg_; }

 private:
  std::optional<size_t> file_camera_ = 0;
  bool is_free_ = false;
  glm::dvec3 eye_{0, 0, 1}, target_{0};
  double fov_deg_ = 45;
};

// Returns the direction through a place of the picture (0..1 from its top left corner), with length 1 along the view
// axis.
glm::dvec3 direction_through(const sideray_camera& camera, double x, double y, double aspect);
glm::dvec3 eye_of(const sideray_camera& camera);

}  // namespace sideray::viewer
