#include <fmt/format.h>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/builtin_scenes.h"
#include "scenes/content/rotation.h"
#include "scenes/content/shapes.h"

namespace sideray::scenes {
namespace {

using glm::vec3;

// The camera is at the origin and looks along -Z; at 1 m the picture is 0.83 m high.
constexpr float fov_deg = 45.0f;
constexpr float pixel_at_1m = 2.0f * 0.41421356f / 720.0f;  // of a picture 720 pixels high

sideray_material_desc sheet_material(vec3 tint) {
  sideray_material_desc d = opaque_material(tint, 0.05f);
  d.base_color[3] = 0.35f;
  d.alpha_mode = SIDERAY_BLEND;
  d.blend_mode = SIDERAY_BLEND_PREMULTIPLIED;
  d.double_sided = 1;
  return d;
}

Shape rectangle(float width, float height) {
  return Shape().quad({-width, -height, 0}, {width, -height, 0}, {width, height, 0}, {-width, height, 0});
}

// Adds opaque surroundings with patterns, so that reflections have edges too.
void add_room(ContentBuilder& b) {
  const auto patterned = [&](const char* name, glm::u8vec3 one, glm::u8vec3 other, uint32_t cells) {
    sideray_material_desc d = opaque_material(vec3(1), 0.8f);
    d.base_color_texture.texture = b.checker(std::string(name) + " pattern", one, other, cells);
    return b.material(name, d);
  };
  constexpr float reach = 16.0f;
  b.object("wall", b.mesh(rectangle(reach, reach), "wall"), patterned("wall", {214, 198, 170}, {86, 104, 132}, 24),
           {0, 0, -18});
  b.object("back", b.mesh(rectangle(reach, reach), "back"), patterned("back", {200, 60, 40}, {240, 220, 90}, 20),
           {0, 0, 4}, 180);
  b.object("side", b.mesh(rectangle(reach, reach), "side"), patterned("side", {60, 120, 90}, {210, 220, 210}, 28),
           {9, 0, -8}, -90);
}

// Adds sheets that overlap by less and less, so that every silhouette is in front of other layers.
void add_sheets(ContentBuilder& b) {
  const vec3 tints[] = {{0.9f, 0.95f, 1.0f}, {1.0f, 0.8f, 0.75f}, {0.75f, 1.0f, 0.8f}, {1.0f, 0.95f, 0.7f}};
  const uint32_t mesh = b.mesh(rectangle(0.34f, 0.34f), "sheet");
  for (int i = 0; i < 6; ++i) {
    const auto n = static_cast<float>(i);
    const glm::mat4 turned = rotated(glm::mat4(1.0f), glm::radians(13.0f * n), vec3(0.15f, 0.2f, 1.0f));
    const vec3 place(-1.55f + 0.13f * n, 0.55f - 0.09f * n, -3.0f - 0.12f * n);
    b.object(fmt::format("sheet{}", i), mesh, b.material(fmt::format("sheet{}", i), sheet_material(tints[i % 4])),
             glm::dmat4(glm::translate(glm::mat4(1.0f), place) * turned));
  }
}

// Adds upright panes seen at 80 to 89 degrees, in pairs 12 mm apart, and a glass floor that reaches the wall.
void add_glancing(ContentBuilder& b) {
  const uint32_t material = b.material("glancing", sheet_material({0.85f, 0.95f, 1.0f}));
  int i = 0;
  for (const double incidence_deg : {80.0, 84.0, 87.0, 89.0}) {
    const glm::dvec3 place(0.55 + 0.42 * i, 0.62, -3.4);
    // A pane whose normal is at this angle to the ray that hits its middle.
    const double ray_deg = glm::degrees(elementary::atan2(place.x, -place.z));
    const uint32_t mesh = b.mesh(rectangle(0.9f, 0.3f), fmt::format("glancing{}", i));
    for (int twin = 0; twin < 2; ++twin)
      b.object(fmt::format("glancing{}.{}", i, twin), mesh, material, place + glm::dvec3(0.012 * twin, 0, 0),
               incidence_deg - ray_deg);
    ++i;
  }
  const uint32_t floor =
      b.mesh(Shape().quad({-2.4f, 0, 6.5f}, {2.4f, 0, 6.5f}, {2.4f, 0, -6.5f}, {-2.4f, 0, -6.5f}), "glass floor");
  b.object("glass floor", floor, b.material("glass floor", sheet_material({0.8f, 0.9f, 0.85f})), {0, -0.75, -10});
}

// Adds upright glass rods from a quarter of a pixel to two pixels wide, and slanted wires, at several distances.
void add_rods(ContentBuilder& b, float thickness) {
  const uint32_t material = b.material("rod", glass_material({0.9f, 1.0f, 0.95f}, 0.02f));
  const float widths[] = {0.25f, 0.5f, 0.75f, 1.0f, 1.5f, 2.0f};  // pixels
  const float distances[] = {2.5f, 5.0f, 10.0f};
  for (int row = 0; row < 3; ++row)
    for (int i = 0; i < 6; ++i) {
      const float z = distances[row],
                  across = (-0.16f + 0.055f * static_cast<float>(i) + 0.013f * static_cast<float>(row)) * z;
      const float radius = 0.5f * widths[i] * thickness * pixel_at_1m * z;
      const float low = (-0.12f + 0.13f * static_cast<float>(row)) * z, high = low + 0.12f * z;
      const vec3 foot(across, low, -z), top(across + (row == 1 ? 0.03f * z : 0.002f * z), high, -z);
      b.object(fmt::format("rod{}.{}", row, i),
               b.mesh(Shape().tube({foot, 0.5f * (foot + top), top}, radius, 8, 2), fmt::format("rod{}.{}", row, i)),
               material);
    }
}

void add_curved(ContentBuilder& b) {
  const uint32_t material = b.material("curved", glass_material({1.0f, 0.97f, 0.9f}, 0.02f));
  b.object("sphere", b.mesh(Shape().sphere({}, 0.22f, 64), "sphere"), material, {-1.15, -0.52, -3.2});
  b.object("small sphere", b.mesh(Shape().sphere({}, 0.05f, 32), "small sphere"), material, {-0.75, -0.55, -3.0});
  b.object("cylinder", b.mesh(Shape().cylinder({}, 0.16f, 0.7f, 48), "cylinder"), material, {0.75, -0.74, -3.2});
  // The beaker has thin walls, so that a matcher may confuse the inner with the outer one.
  const std::vector<glm::vec2> beaker{{0, 0}, {0.15f, 0}, {0.17f, 0.5f}, {0.167f, 0.5f}, {0.147f, 0.003f}, {0, 0.003f}};
  b.object("beaker", b.mesh(Shape().lathe({}, beaker, 48), "beaker"), material, {1.3, -0.74, -3.3});
}

}  // namespace

Content make_edges(const Numbers& numbers) {
  const auto thickness = static_cast<float>(numbers.in_range("thickness", 0.1, 10));
  ContentBuilder b("edges");
  add_room(b);
  add_sheets(b);
  add_glancing(b);
  add_rods(b, thickness);
  add_curved(b);
  b.light("sun", sun_light({-0.4f, -0.8f, -0.45f}, vec3(3.0f)));
  const double eye[3] = {0, 0, 0}, target[3] = {0, 0, -1};
  b.camera("front", look_at(eye, target, fov_deg));
  return b.take();
}

}  // namespace sideray::scenes
