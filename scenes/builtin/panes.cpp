#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/builtin_scenes.h"
#include "scenes/content/shapes.h"

namespace sideray::scenes {
namespace {

constexpr float fov_deg = 45.0f;
// Half width and half height of every pane at distance 1: about half of a 16:9 picture.
constexpr float pane_width = 0.75f * 16.0f / 9.0f * 0.41421356f, pane_height = 0.67f * 0.41421356f;

// Finds the corners, in the pane's frustum, of the plane at `distance` turned by `angle`: all have the same silhouette.
struct Turned {
  double cosine, sine, half_width;
  explicit Turned(double angle)
      : cosine(elementary::cos(angle)),
        sine(elementary::sin(angle)),
        // Rays at the frustum's sides must still hit the turned plane in front of the camera.
        half_width(std::min(double{pane_width}, 0.8 * cosine / std::max(std::abs(sine), 1e-9))) {}
  double depth(double distance, double x) const { return distance * cosine / (cosine - x * sine); }
  glm::vec3 corner(double distance, double x, double y) const {
    const double t = depth(distance, x);
    return glm::vec3(x * t, y * t, -t);
  }
  double deepest(double distance) const { return std::max(depth(distance, half_width), depth(distance, -half_width)); }
};

Shape pane(const Turned& turned, double distance) {
  const double w = turned.half_width, h = double{pane_height};
  return Shape().quad(turned.corner(distance, -w, -h), turned.corner(distance, w, -h), turned.corner(distance, w, h),
                      turned.corner(distance, -w, h));
}

sideray_material_desc pane_material(int i) {
  const glm::vec3 tints[] = {{0.9f, 0.95f, 1.0f}, {1.0f, 0.85f, 0.8f}, {0.8f, 1.0f, 0.85f}, {1.0f, 0.95f, 0.75f}};
  sideray_material_desc d = opaque_material(tints[i % 4], 0.05f);
  d.base_color[3] = 0.25f;
  d.alpha_mode = SIDERAY_BLEND;
  d.double_sided = 1;
  return d;
}

}  // namespace

Content make_panes(const Numbers& numbers) {
  const int count = numbers.whole_in_range("count", 1, 64);
  const double gap = numbers.in_range("gap", 0, 10), distance = numbers.in_range("distance", 0.01, 1e5);
  const Turned turned(glm::radians(numbers.in_range("angle", -89, 89)));
  ContentBuilder b("panes");
  const auto scale = static_cast<float>(std::max(1.0, distance / 3));
  const auto wall_z = static_cast<float>(-turned.deepest(distance + count * gap) - distance / 3);
  const float reach = 3.0f * std::abs(wall_z);

  sideray_material_desc wall = opaque_material(glm::vec3(1), 0.9f);
  wall.base_color_texture.texture = b.checker("wall pattern", {214, 198, 170}, {86, 104, 132}, 8);
  const uint32_t wall_material = b.material("wall", wall);
  b.object("wall",
           b.mesh(Shape().quad({-reach, -reach, wall_z}, {reach, -reach, wall_z}, {reach, reach, wall_z},
                               {-reach, reach, wall_z}, glm::vec2(3)),
                  "wall"),
           wall_material);
  // The pattern behind the camera is what the panes reflect.
  sideray_material_desc back = opaque_material(glm::vec3(1), 0.8f);
  back.base_color_texture.texture = b.checker("back pattern", {200, 60, 40}, {240, 220, 90}, 6);
  const float back_z = 2.0f * scale, back_reach = 4.0f * scale;
  b.object("back",
           b.mesh(Shape().quad({back_reach, -back_reach, back_z}, {-back_reach, -back_reach, back_z},
                               {-back_reach, back_reach, back_z}, {back_reach, back_reach, back_z}, glm::vec2(2)),
                  "back"),
           b.material("back", back));
  for (int i = 0; i < count; ++i)
    b.object(fmt::format("pane{}", i), b.mesh(pane(turned, distance + i * gap), fmt::format("pane{}", i)),
             b.material(fmt::format("glass{}", i), pane_material(i), RayTraced::yes));
  b.light("sun", sun_light({-0.4f, -0.8f, -0.45f}, glm::vec3(3.0f)));
  const double eye[3] = {0, 0, 0}, target[3] = {0, 0, -1};
  b.camera("front", look_at(eye, target, fov_deg));
  Content content = b.take();
  content.cameras[0].camera.z_near = static_cast<float>(std::min(0.1, distance / 10));
  return content;
}

Content make_empty(const Numbers& numbers) {
  const auto film = static_cast<float>(numbers.in_range("film", 0, 10000));
  const auto anisotropy = static_cast<float>(numbers.in_range("anisotropy", 0, 1));
  const auto filmed = [film, anisotropy](sideray_material_desc d) {
    d.anisotropy = anisotropy;
    if (film > 0.0f) d.iridescence = 1.0f, d.iridescence_ior = 2.0f, d.iridescence_thickness_max = film;
    return d;
  };
  ContentBuilder b("empty");
  sideray_material_desc floor = opaque_material(glm::vec3(1), 0.7f);
  floor.base_color_texture.texture = b.checker("floor pattern", {180, 180, 176}, {90, 92, 96}, 8);
  b.object("floor", b.mesh(Shape().quad({-6, 0, 6}, {6, 0, 6}, {6, 0, -6}, {-6, 0, -6}, glm::vec2(2)), "floor"),
           b.material("floor", floor));
  sideray_material_desc metal = opaque_material({0.95f, 0.75f, 0.4f}, 0.25f);
  metal.metallic = 1.0f;
  b.object("ball", b.mesh(Shape().sphere({0, 0.8f, 0}, 0.8f, 64), "ball"), b.material("brass", filmed(metal)));
  b.object("box", b.mesh(Shape().box({-0.6f, 0, -0.6f}, {0.6f, 1.2f, 0.6f}), "box"),
           b.material("red", filmed(opaque_material({0.6f, 0.08f, 0.05f}, 0.5f))), {-2.1, 0, -0.4}, 28);
  b.object("column", b.mesh(Shape().cylinder({0, 0, 0}, 0.45f, 1.7f, 48), "column"),
           b.material("blue", filmed(opaque_material({0.06f, 0.16f, 0.5f}, 0.35f))), {1.9, 0, -0.8});
  b.light("sun", sun_light({-0.4f, -0.8f, -0.45f}, glm::vec3(3.0f)));
  const double eye[3] = {2.2, 2.4, 5.2}, target[3] = {0, 0.6, -0.2};
  b.camera("view", look_at(eye, target, fov_deg));
  return b.take();
}

}  // namespace sideray::scenes
