// A camera that people move: around a point, through the scene, or as the file has it. Any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <sideray/sideray.hpp>

namespace sideray::viewer {

class Navigation {
 public:
  // As the file's camera number `index` has it, until it is moved. Empty: framed.
  void follow(std::optional<size_t> index) { file_camera_ = index, is_free_ = false; }
  std::optional<size_t> file_camera() const { return is_free_ ? std::nullopt : file_camera_; }
  bool is_free() const { return is_free_; }
  void look(const glm::dvec3& eye, const glm::dvec3& target, double fov_deg);

  // The camera that is seen now. Until it is moved that is `of_file`, from which moving goes on; things are `distance` away.
  sideray_camera camera(const sideray_camera& of_file, double distance);

  // Angles in radians, about the point `pivot`, and about the eye. The horizon stays level, and straight up is not crossed.
  void orbit(const glm::dvec3& pivot, double right, double down);
  void turn(double right, double down) { orbit(eye_, right, down); }
  // Right, up and forward, in world units.
  void move(const glm::dvec3& by);
  // Nearer to the point, which keeps its place in the picture, by a factor on the distance.
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

// The direction through a place of the picture (0..1 from its top left corner), scaled to 1 along the view axis.
glm::dvec3 direction_through(const sideray_camera& camera, double x, double y, double aspect);
glm::dvec3 eye_of(const sideray_camera& camera);

}  // namespace sideray::viewer
