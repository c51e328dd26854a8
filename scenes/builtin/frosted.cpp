#include <fmt/format.h>

#include <array>

#include "scenes/builtin/builtin_scenes.h"
#include "scenes/content/shapes.h"

// Frosted panes and bottles in a dark room with bright windows, whose reflections show noise. Blocks touch the glass,
// and show where a filter reaches too far.
namespace sideray::scenes {
namespace {

constexpr int panes = 6;
constexpr float pane_half_width = 0.36f, pane_height = 1.5f;
constexpr float window_z = 7.0f;  // behind the camera

sideray_material_desc frosted(glm::vec3 tint, float roughness) {
  sideray_material_desc d = opaque_material(tint, roughness);
  d.transmission = 1.0f;
  d.ior = 2.0f;
  d.double_sided = 1;
  return d;
}

sideray_material_desc glowing(glm::vec3 radiance) {
  sideray_material_desc d = opaque_material(glm::vec3(0), 1);
  for (int i = 0; i < 3; ++i) d.emissive[i] = radiance[i];
  return d;
}

void add_room(ContentBuilder& b) {
  sideray_material_desc floor = opaque_material(glm::vec3(1), 0.8f);
  floor.base_color_texture.texture = b.checker("floor pattern", {190, 186, 180}, {60, 62, 66}, 8);
  b.object("floor", b.mesh(Shape().quad({-6, 0, 7}, {6, 0, 7}, {6, 0, -2}, {-6, 0, -2}, glm::vec2(2)), "floor"),
           b.material("floor", floor));
  sideray_material_desc wall = opaque_material(glm::vec3(1), 0.9f);
  wall.base_color_texture.texture = b.checker("wall pattern", {120, 104, 86}, {70, 66, 72}, 8);
  b.object("wall", b.mesh(Shape().quad({-6, 0, -2}, {6, 0, -2}, {6, 4, -2}, {-6, 4, -2}, glm::vec2(2, 1)), "wall"),
           b.material("wall", wall));
  const uint32_t dark = b.material("dark", opaque_material(glm::vec3(0.02f), 0.9f));
  b.object("back",
           b.mesh(Shape().box({-6.2f, 0, window_z}, {6.2f, 4, window_z + 0.1f}).box({-6, 4, -2}, {6, 4.1f, 7}), "back"),
           dark);
  b.object("sides", b.mesh(Shape().box({-6.2f, 0, -2}, {-6, 4, 7}).box({6, 0, -2}, {6.2f, 4, 7}), "sides"), dark);
}

void add_windows(ContentBuilder& b) {
  const std::array<glm::vec3, 4> colors{{{9, 8, 6}, {2, 5, 9}, {9, 3, 1}, {5, 8, 3}}};
  std::array<uint32_t, 4> glows{};
  for (size_t i = 0; i < 4; ++i) glows[i] = b.material(fmt::format("glow{}", i), glowing(colors[i]));
  const uint32_t strip =
      b.mesh(Shape().box({-0.25f, 0.5f, window_z - 0.05f}, {0.25f, 3.2f, window_z - 0.01f}), "window");
  for (size_t i = 0; i < 9; ++i)
    b.object(fmt::format("window{}", i), strip, glows[i % 4], {1.3 * (static_cast<double>(i) - 4), 0, 0});
}

}  // namespace

Content make_frosted(const Numbers& numbers) {
  const double given = numbers.in_range("roughness", 0, 1);
  const auto roughness = [&](double share) { return static_cast<float>(given > 0 ? given : 0.1 + 0.5 * share); };
  ContentBuilder b("frosted");
  add_room(b);
  add_windows(b);
  const uint32_t pane = b.mesh(Shape().quad({-pane_half_width, 0, 0}, {pane_half_width, 0, 0},
                                            {pane_half_width, pane_height, 0}, {-pane_half_width, pane_height, 0}),
                               "pane");
  const uint32_t block = b.mesh(Shape().box({-0.1f, 0, 0.002f}, {0.1f, 0.3f, 0.2f}), "block");
  const uint32_t red = b.material("block", opaque_material({0.7f, 0.06f, 0.04f}, 0.6f));
  const uint32_t bottle = b.mesh(
      Shape().lathe(
          {0, 0, 0},
          {{0, 0.01f}, {0.15f, 0.01f}, {0.16f, 0.05f}, {0.16f, 0.4f}, {0.06f, 0.56f}, {0.055f, 0.7f}, {0, 0.7f}}, 48),
      "bottle");
  for (int i = 0; i < panes; ++i) {
    const double x = 0.9 * (i - 0.5 * (panes - 1)), yaw = i % 2 == 0 ? 8 : -8;
    const float rough = roughness(i / (panes - 1.0));
    b.object(fmt::format("pane{}", i), pane,
             b.material(fmt::format("pane{}", i), frosted({0.85f, 0.92f, 0.95f}, rough), RayTraced::yes), {x, 0, 0},
             yaw);
    b.object(fmt::format("block{}", i), block, red, {x, 0, 0}, yaw);
    if (i % 2 == 0) continue;
    b.object(fmt::format("bottle{}", i), bottle,
             b.material(fmt::format("bottle{}", i), frosted({0.7f, 0.9f, 0.75f}, rough), RayTraced::yes),
             {x - 0.45, 0, 0.9});
  }
  b.light("lamp", point_light({0.5f, 3.2f, 2.5f}, glm::vec3(9.0f), 0.0f));
  const double eye[3] = {0.3, 1.1, 3.6}, target[3] = {0, 0.62, 0};
  b.camera("view", look_at(eye, target, 45.0f));
  return b.take();
}

}  // namespace sideray::scenes
