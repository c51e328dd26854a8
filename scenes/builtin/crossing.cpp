#include <fmt/format.h>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/builtin_scenes.h"
#include "scenes/content/rotation.h"
#include "scenes/content/shapes.h"

namespace sideray::scenes {
namespace {

constexpr int kind_count = 5;

// Returns the kinds of translucency in turn: alpha, transmission, additive, premultiplied, multiplied.
sideray_material_desc kind_of_glass(int i) {
  const glm::vec3 tints[] = {{0.9f, 0.25f, 0.2f}, {0.3f, 0.8f, 0.35f}, {0.25f, 0.4f, 0.95f}, {0.95f, 0.8f, 0.3f}};
  const glm::vec3 tint = tints[(i / kind_count + i) % 4];
  if (i % kind_count == 1) {
    sideray_material_desc d = glass_material(tint, 0.05f);
    d.double_sided = 1;
    return d;
  }
  sideray_material_desc d = opaque_material(tint, 0.1f);
  const sideray_blend_mode modes[kind_count] = {SIDERAY_BLEND_ALPHA, SIDERAY_BLEND_ALPHA, SIDERAY_BLEND_ADDITIVE,
                                                SIDERAY_BLEND_PREMULTIPLIED, SIDERAY_BLEND_MULTIPLY};
  d.blend_mode = modes[i % kind_count];
  d.base_color[3] = d.blend_mode == SIDERAY_BLEND_PREMULTIPLIED ? 0.2f : 0.55f;
  d.alpha_mode = SIDERAY_BLEND;
  d.double_sided = 1;
  return d;
}

Shape sheet(float half_width, float half_height) {
  const float w = half_width, h = half_height;
  return Shape().quad({-w, -h, 0}, {w, -h, 0}, {w, h, 0}, {-w, h, 0});
}

}  // namespace

Content make_crossing(const Numbers& numbers) {
  const int panes = numbers.whole_in_range("panes", 0, 64), strips = numbers.whole_in_range("strips", 3, 64);
  const int layers = numbers.whole_in_range("layers", 0, 256);
  ContentBuilder b("crossing");
  sideray_material_desc wall = opaque_material(glm::vec3(1), 0.9f);
  wall.base_color_texture.texture = b.checker("wall pattern", {214, 198, 170}, {86, 104, 132}, 8);
  b.object("wall", b.mesh(Shape().quad({-8, -8, -3}, {8, -8, -3}, {8, 8, -3}, {-8, 8, -3}, glm::vec2(3)), "wall"),
           b.material("wall", wall));
  int glasses = 0;
  const auto add = [&](const std::string& name, uint32_t mesh, const glm::dmat4& world_from_object) {
    const sideray_material_desc d = kind_of_glass(glasses);
    b.object(name, mesh, b.material(fmt::format("glass{}", glasses), d, RayTraced::yes), world_from_object);
    ++glasses;
  };
  const auto placed = [](glm::dvec3 at, double yaw, double roll, double tilt) {
    glm::dmat4 m = glm::translate(glm::dmat4(1), at);
    m = rotated(m, roll, glm::dvec3(0, 0, 1));
    m = rotated(m, yaw, glm::dvec3(0, 1, 0));
    return rotated(m, tilt, glm::dvec3(1, 0, 0));
  };

  // Panes cross in a star about the vertical, each tilted a little, so that no two intersect in the same line.
  const uint32_t pane = b.mesh(sheet(0.62f, 0.8f), "pane");
  for (int i = 0; i < panes; ++i)
    add(fmt::format("pane{}", i), pane,
        placed({-1.45, 0, 0}, glm::pi<double>() * (i + 0.3) / panes, 0.1 * i, 0.12 * i));

  // Strips overlap around a ring, each over the next, so that no order of whole strips is right.
  const uint32_t strip = b.mesh(sheet(0.75f, 0.16f), "strip");
  for (int i = 0; i < strips; ++i) {
    const double turn = 2 * glm::pi<double>() * i / strips;
    add(fmt::format("strip{}", i), strip,
        placed({0.5 * elementary::cos(turn + 0.5 * glm::pi<double>()), 0.5 * elementary::sin(turn + 0.5 * glm::pi<double>()), 0}, 0.3,
               turn, 0));
  }

  // Many layers are behind one another, each tilted differently so that it crosses its neighbours.
  const uint32_t layer = b.mesh(sheet(0.55f, 0.75f), "layer");
  for (int i = 0; i < layers; ++i)
    add(fmt::format("layer{}", i), layer,
        placed({1.45, 0, 0.6 - 1.2 * (i + 0.5) / layers}, 0.25 * elementary::sin(2.4 * i), 0, 0.2 * elementary::cos(2.4 * i)));

  b.light("sun", sun_light({-0.4f, -0.8f, -0.45f}, glm::vec3(3.0f)));
  const double eye[3] = {0, 0.15, 4.4}, target[3] = {0, 0, 0};
  b.camera("front", look_at(eye, target, 32.0f));
  return b.take();
}

}  // namespace sideray::scenes
