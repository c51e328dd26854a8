#include "scenes/builtin/smoke.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/builtin_scenes.h"
#include "scenes/builtin/paint.h"

namespace sideray::scenes {
namespace {

using glm::vec2;
using glm::vec3;

constexpr uint32_t cell_side = 64;

// Holds a place on a flip-book: the cell, and the point in it, -1..1 from its middle, y up.
struct InCell {
  uint32_t cell;
  vec2 p;
  explicit InCell(vec2 uv) {
    const vec2 at = uv * vec2(flip_book_columns, flip_book_rows), home = glm::floor(at);
    cell = static_cast<uint32_t>(home.y) * flip_book_columns + static_cast<uint32_t>(home.x);
    p = (at - home) * vec2(2, -2) + vec2(-1, 1);
  }
};

// Returns a texel of the puffs: each picture shows another puff, later ones torn more.
Texel smoke_texel(vec2 uv) {
  const InCell at(uv);
  const float age = static_cast<float>(at.cell) / (flip_book_columns * flip_book_rows - 1);
  const vec2 in_cell = 0.5f + 0.5f * at.p;
  const vec2 bend(fractal_noise(in_cell, 3, 3, 900 + at.cell) - 0.5f,
                  fractal_noise(in_cell, 3, 3, 950 + at.cell) - 0.5f);
  const float r = glm::length(at.p + 0.7f * bend);
  const float billows = fractal_noise(in_cell, 4, 4, 800 + at.cell);
  const float torn = glm::smoothstep(0.25f * age, 0.25f * age + 0.5f, billows);
  // Smoke fades out before the border of the cell.
  const float rim = 1.0f - glm::smoothstep(0.80f, 0.98f, glm::length(at.p));
  Texel t;
  t.alpha = rim * (1.0f - glm::smoothstep(0.15f, 0.9f, r)) * glm::mix(1.0f, torn, 0.4f + 0.5f * age);
  t.color = vec3(0.86f + 0.14f * billows);
  return t;
}

// Returns a texel of the flame, a drop that narrows upward and sways. Its two waves have whole periods in a loop, so
// that the end continues at the start.
Texel flame_texel(vec2 uv) {
  const InCell at(uv);
  const float turn = glm::two_pi<float>() * static_cast<float>(at.cell) / (flip_book_columns * flip_book_rows);
  const float height = 0.5f + 0.5f * at.p.y;  // 0..1
  const float sway =
      0.10f * height * height * (elementary::sin(turn + 3.0f * height) + 0.5f * elementary::sin(2.0f * turn + 5.0f * height));
  const float tip = 0.90f + 0.05f * elementary::sin(turn + 1.0f);
  const float y = std::clamp(height / tip, 0.0f, 1.0f);
  const float width =
      0.42f * std::sqrt(std::max(glm::smoothstep(0.0f, 0.25f, y) * (1.0f - y), 0.0f)) * (1.1f - 0.4f * y);
  const float across = std::abs(at.p.x - sway) / std::max(width, 1e-3f);
  const float body = height < tip && width > 0.01f ? 1.0f - glm::smoothstep(0.35f, 1.0f, across) : 0.0f;
  const float core = body * (1.0f - glm::smoothstep(0.0f, 0.6f, across)) * glm::smoothstep(0.08f, 0.3f, y);
  Texel t;
  const float blue = 1.0f - glm::smoothstep(0.0f, 0.22f, y);
  t.color = glm::mix(glm::mix(vec3(1.0f, 0.45f, 0.08f), vec3(1.0f, 0.86f, 0.52f), core), vec3(0.25f, 0.35f, 0.9f),
                     0.7f * blue);
  t.alpha = body * (0.35f + 0.65f * glm::smoothstep(0.05f, 0.3f, y)) * (1.0f - 0.5f * glm::smoothstep(0.6f, 1.0f, y));
  return t;
}

sideray_material_desc pane_material(vec3 tint) {
  sideray_material_desc d = opaque_material(tint, 0.05f);
  d.base_color[3] = 0.2f;
  d.alpha_mode = SIDERAY_BLEND;
  d.double_sided = 1;
  return d;
}

}  // namespace

uint32_t paint_smoke(ContentBuilder& b) {
  return paint_image(b, "smoke", flip_book_columns * cell_side, flip_book_rows * cell_side, smoke_texel);
}

uint32_t paint_flame(ContentBuilder& b) {
  return paint_image(b, "flame", flip_book_columns * cell_side, flip_book_rows * cell_side, flame_texel);
}

// Makes a column of smoke with glass in front of it, in it and behind it.
Content make_smoke(const Numbers& numbers) {
  const int count = numbers.whole_in_range("count", 1, 50000);
  ContentBuilder b("smoke");
  sideray_material_desc wall = opaque_material(vec3(1), 0.9f);
  wall.base_color_texture.texture = b.checker("wall pattern", {120, 90, 60}, {30, 40, 60}, 8);
  b.object("wall",
           b.mesh(Shape().quad({-4, -0.5f, -2.5f}, {4, -0.5f, -2.5f}, {4, 4, -2.5f}, {-4, 4, -2.5f}, vec2(2)), "wall"),
           b.material("wall", wall));
  sideray_material_desc floor = opaque_material(vec3(1), 0.8f);
  floor.base_color_texture.texture = b.checker("floor pattern", {150, 150, 146}, {70, 72, 76}, 8);
  b.object("floor", b.mesh(Shape().quad({-4, 0, 4}, {4, 0, 4}, {4, 0, -2.5f}, {-4, 0, -2.5f}, vec2(2)), "floor"),
           b.material("floor", floor));
  b.object("post", b.mesh(Shape().cylinder({0, 0, 0}, 0.12f, 1.1f, 32), "post"),
           b.material("post", opaque_material({0.5f, 0.08f, 0.05f}, 0.5f)), {0.35, 0, 0.1});
  const vec3 tints[] = {{0.9f, 0.95f, 1.0f}, {1.0f, 0.8f, 0.7f}, {0.75f, 1.0f, 0.8f}};
  const float depths[] = {1.2f, 0.0f, -1.2f}, lefts[] = {-1.1f, -0.5f, -0.3f};
  for (int i = 0; i < 3; ++i) {
    const float x = lefts[i], z = depths[i];
    const std::string name = fmt::format("pane{}", i);
    b.object(name, b.mesh(Shape().quad({x, 0.3f, z}, {x + 1.6f, 0.3f, z}, {x + 1.6f, 1.9f, z}, {x, 1.9f, z}), name),
             b.material(name, pane_material(tints[i]), RayTraced::yes));
  }
  b.particles("smoke", {0, 0.1, 0},
              fmt::format(R"({{"count": {}, "lifetime": [3, 4], "start": "cone", "radius": 0.25, "cone_deg": 12,
                "velocity": [0, 0.9, 0], "spread": 0.12, "acceleration": [0.02, 0.08, 0], "drag": 0.35,
                "turbulence": 0.25, "turbulence_hz": 0.4, "size": [0.12, 0.4, 0.7], "size_variation": 0.4,
                "color": [[0.5, 0.48, 0.45], [0.8, 0.8, 0.82]], "alpha": [0, 0.35, 0.2, 0],
                "rotation_deg": [0, 360], "spin_deg": [-30, 30], "columns": 4, "rows": 4,
                "soft_distance": 0.2, "lit": true}})",
                          count),
              paint_smoke(b));
  b.light("sun", sun_light({-0.4f, -0.8f, -0.45f}, vec3(3.0f)));
  const double eye[3] = {0, 1.2, 4.6}, target[3] = {0, 1.15, 0};
  b.camera("front", look_at(eye, target, 42.0f));
  return b.take();
}

}  // namespace sideray::scenes
