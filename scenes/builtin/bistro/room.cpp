#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/bistro/bistro.h"
#include "scenes/content/rotation.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float dado_y = 0.98f, sill_y = 0.55f, transom_y = 2.28f, head_y = 2.80f;
constexpr int bays = 5;
constexpr float bay = (right_x - left_x) / bays;

// Returns wall panelling of the given length along +x at z = 0, facing +z.
Shape wainscot(float length) {
  Shape s;
  s.quad({0, 0, 0.006f}, {length, 0, 0.006f}, {length, dado_y, 0.006f}, {0, dado_y, 0.006f}, {length, 1});
  s.bevelled_box({0, 0, 0}, {length, 0.14f, 0.030f}, 0.008f);
  s.bevelled_box({0, dado_y - 0.05f, 0}, {length, dado_y, 0.045f}, 0.012f);
  s.bevelled_box({0, dado_y - 0.16f, 0}, {length, dado_y - 0.06f, 0.022f}, 0.006f);
  const int panels = std::max(1, static_cast<int>(std::lround(length / 0.72f)));
  const float step = length / static_cast<float>(panels);
  for (int i = 0; i < panels; ++i) {
    const float x = step * static_cast<float>(i);
    s.bevelled_box({x, 0.13f, 0}, {x + 0.10f, dado_y - 0.15f, 0.022f}, 0.006f);
    s.bevelled_box({x + 0.15f, 0.20f, 0}, {x + step - 0.05f, dado_y - 0.22f, 0.020f}, 0.014f);
  }
  return s;
}

// Returns the placement at `at`, turned about the vertical, of an object made along +x and facing +z.
glm::dmat4 facing(vec3 at, float turn_deg) {
  return rotated(glm::translate(glm::dmat4(1.0), glm::dvec3(at)), glm::radians(double{turn_deg}),
                     glm::dvec3(0, 1, 0));
}

Shape wall(float length) {
  return Shape().quad({0, 0, 0}, {length, 0, 0}, {length, ceiling_y, 0}, {0, ceiling_y, 0},
                      vec2(length, ceiling_y) * 0.45f);
}

void add_walls(Kit& kit) {
  struct Side {
    const char* name;
    vec3 at;
    float turn_deg, length;
  };
  constexpr float depth = back_z - window_z, width = right_x - left_x;
  static constexpr Side sides[] = {{"left", {left_x, 0, back_z}, 90.0f, depth},
                                   {"right", {right_x, 0, window_z}, -90.0f, depth},
                                   {"back", {right_x, 0, back_z}, 180.0f, width}};
  for (const Side& side : sides) {
    const std::string name = side.name;
    kit.b.object("wall " + name, kit.b.mesh(wall(side.length), "wall " + name), kit.m.plaster,
                 facing(side.at, side.turn_deg));
    kit.b.object("wainscot " + name, kit.b.mesh(wainscot(side.length), "wainscot " + name), kit.m.panel,
                 facing(side.at, side.turn_deg));
    const Shape cornice = Shape().bevelled_box({0, ceiling_y - 0.12f, 0}, {side.length, ceiling_y, 0.10f}, 0.04f);
    kit.b.object("cornice " + name, kit.b.mesh(cornice, "cornice " + name), kit.m.ceiling,
                 facing(side.at, side.turn_deg));
  }
}

void add_floor_and_ceiling(Kit& kit) {
  constexpr float width = right_x - left_x, depth = back_z - window_z;
  const Shape floor = Shape().quad({left_x, 0, back_z}, {right_x, 0, back_z}, {right_x, 0, window_z},
                                   {left_x, 0, window_z}, vec2(width, depth) / 0.56f);
  kit.b.object("floor", kit.b.mesh(floor, "floor"), kit.m.floor);
  const Shape ceiling = Shape().quad({left_x, ceiling_y, window_z}, {right_x, ceiling_y, window_z},
                                     {right_x, ceiling_y, back_z}, {left_x, ceiling_y, back_z});
  kit.b.object("ceiling", kit.b.mesh(ceiling, "ceiling"), kit.m.ceiling);
  Shape beams;
  for (int i = 0; i < 4; ++i) {
    const float x = left_x + width * (static_cast<float>(i) + 0.5f) / 4.0f;
    beams.bevelled_box({x - 0.09f, ceiling_y - 0.2f, window_z}, {x + 0.09f, ceiling_y + 0.02f, back_z}, 0.015f, 0.8f);
  }
  kit.b.object("beams", kit.b.mesh(beams, "beams"), kit.m.walnut);
}

void hang_picture(Kit& kit, const std::string& name, vec3 middle, float turn_deg, vec2 half, float border,
                  uint32_t picture, uint32_t frame) {
  Shape mould;
  const float w = half.x + border, h = half.y + border;
  mould.bevelled_box({-w, -h, 0}, {w, -half.y, 0.035f}, 0.01f).bevelled_box({-w, half.y, 0}, {w, h, 0.035f}, 0.01f);
  mould.bevelled_box({-w, -half.y, 0}, {-half.x, half.y, 0.035f}, 0.01f);
  mould.bevelled_box({half.x, -half.y, 0}, {w, half.y, 0.035f}, 0.01f);
  kit.b.object("frame " + name, kit.b.mesh(mould, "frame " + name), frame, facing(middle, turn_deg));
  const Shape canvas = Shape().quad({-half.x, -half.y, 0.012f}, {half.x, -half.y, 0.012f}, {half.x, half.y, 0.012f},
                                    {-half.x, half.y, 0.012f});
  kit.b.object(name, kit.b.mesh(canvas, name), picture, facing(middle, turn_deg));
}

// Returns a curtain that a band gathers: wide above and below, narrow at the band.
Shape curtain(float width, float top, float bottom) {
  return Shape().sheet(84, 12,
                       [=](float u, float v) {
                         const float y = glm::mix(bottom, top, v), x = u - 0.5f;
                         const float gather = 1.0f - 0.55f * elementary::exp(-18.0f * (v - 0.38f) * (v - 0.38f));
                         const float deep = 0.034f * gather, phase = 7.0f * glm::two_pi<float>() * u;
                         return vec3(width * gather * x + 0.005f * gather * elementary::cos(phase + 3.0f * v), y,
                                     deep * elementary::sin(phase) + 0.012f * gather * elementary::sin(0.43f * phase + 2.0f * v));
                       },
                       {1.6f, 5.0f});
}

Shape window_frame() {
  Shape s;
  const float z0 = window_z - 0.07f, z1 = window_z + 0.05f;
  s.bevelled_box({left_x, transom_y, z0}, {right_x, transom_y + 0.07f, z1}, 0.012f, 0.8f);
  s.bevelled_box({left_x, head_y, z0}, {right_x, head_y + 0.10f, z1 + 0.03f}, 0.015f, 0.8f);
  s.bevelled_box({left_x, sill_y - 0.045f, z0 - 0.05f}, {right_x, sill_y, z1 + 0.22f}, 0.012f, 0.8f);
  for (int i = 0; i <= bays; ++i) {
    const float x = left_x + bay * static_cast<float>(i);
    s.bevelled_box({x - 0.055f, sill_y, z0}, {x + 0.055f, head_y, z1 + 0.01f}, 0.014f, 0.8f);
    if (i == bays) continue;
    for (int k = 1; k < 4; ++k) {
      const float bar = x + 0.25f * bay * static_cast<float>(k);
      s.bevelled_box({bar - 0.014f, transom_y + 0.06f, z0 + 0.02f}, {bar + 0.014f, head_y + 0.01f, z1 - 0.02f}, 0.006f);
    }
    s.bevelled_box({x + 0.5f * bay - 0.02f, sill_y - 0.01f, z0 + 0.02f},
                   {x + 0.5f * bay + 0.02f, transom_y + 0.01f, z1 - 0.02f}, 0.008f, 0.8f);
  }
  return s;
}

Shape pane(vec2 low, vec2 high) {
  constexpr float z = window_z - 0.01f;
  return Shape().quad({low.x, low.y, z}, {high.x, low.y, z}, {high.x, high.y, z}, {low.x, high.y, z});
}

void add_panes(Kit& kit) {
  for (int i = 0; i < bays; ++i) {
    const float x = left_x + bay * static_cast<float>(i);
    for (int half = 0; half < 2; ++half) {
      const float from = x + 0.5f * bay * static_cast<float>(half);
      const std::string name = fmt::format("window{}.{}", i, half);
      kit.b.object(
          name, kit.b.mesh(pane({from + 0.01f, sill_y - 0.01f}, {from + 0.5f * bay - 0.01f, transom_y + 0.01f}), name),
          kit.m.window);
    }
    for (int k = 0; k < 4; ++k) {
      const float from = x + 0.25f * bay * static_cast<float>(k);
      const std::string name = fmt::format("transom{}.{}", i, k);
      kit.b.object(
          name,
          kit.b.mesh(pane({from + 0.005f, transom_y + 0.06f}, {from + 0.25f * bay - 0.005f, head_y + 0.01f}), name),
          kit.m.stained[static_cast<size_t>((i + k * 2) % 3)]);
    }
  }
}

}  // namespace

void add_room(Kit& kit) {
  add_floor_and_ceiling(kit);
  add_walls(kit);
  hang_picture(kit, "chalkboard", {right_x, 1.72f, -3.05f}, -90.0f, {0.40f, 0.46f}, 0.045f, kit.m.chalkboard,
               kit.m.walnut);
  for (int i = 0; i < 3; ++i)
    hang_picture(kit, fmt::format("painting{}", i), {left_x, 1.75f, 2.6f - 2.3f * static_cast<float>(i)}, 90.0f,
                 {0.30f, 0.36f}, 0.05f, kit.m.paintings[static_cast<size_t>(i)], kit.m.frame);
}

void add_windows(Kit& kit) {
  kit.b.object("window frame", kit.b.mesh(window_frame(), "window frame"), kit.m.walnut);
  const Shape above = Shape().quad({left_x, head_y, window_z}, {right_x, head_y, window_z},
                                   {right_x, ceiling_y, window_z}, {left_x, ceiling_y, window_z}, {3.9f, 0.22f});
  kit.b.object("wall above windows", kit.b.mesh(above, "wall above windows"), kit.m.plaster);
  Shape below;
  below.quad({left_x, 0, window_z + 0.02f}, {right_x, 0, window_z + 0.02f}, {right_x, sill_y, window_z + 0.02f},
             {left_x, sill_y, window_z + 0.02f});
  below.bevelled_box({left_x, 0, window_z}, {right_x, 0.12f, window_z + 0.05f}, 0.01f);
  for (int i = 0; i < 2 * bays; ++i) {
    const float x = left_x + 0.5f * bay * static_cast<float>(i);
    below.bevelled_box({x + 0.10f, 0.17f, window_z}, {x + 0.5f * bay - 0.10f, sill_y - 0.09f, window_z + 0.04f},
                       0.014f);
  }
  kit.b.object("wainscot windows", kit.b.mesh(below, "wainscot windows"), kit.m.panel);
  add_panes(kit);
  const uint32_t cloth = kit.b.mesh(curtain(0.42f, transom_y - 0.02f, sill_y + 0.02f), "curtain");
  for (int i = 0; i <= bays; ++i) {
    const double x = double{left_x + bay * static_cast<float>(i)} + (i == 0 ? 0.17 : i == bays ? -0.17 : 0.0);
    kit.b.object(fmt::format("curtain{}", i), cloth, kit.m.velvet, {x, 0.0, double{window_z} + 0.14});
  }
  const float rod_z = window_z + 0.14f;
  const Shape rod =
      Shape().tube({{left_x + 0.02f, transom_y, rod_z}, {right_x - 0.02f, transom_y, rod_z}}, 0.012f, 12, 1);
  kit.b.object("curtain rod", kit.b.mesh(rod, "curtain rod"), kit.m.brass);
  // The gold letters are to be read from the street, so they are mirrored inside.
  constexpr float sign_z = window_z - 0.012f;
  const float x = left_x + 2.0f * bay, y = 1.86f;
  const Shape sign = Shape().quad({x + bay - 0.08f, y, sign_z}, {x + 0.08f, y, sign_z}, {x + 0.08f, y + 0.39f, sign_z},
                                  {x + bay - 0.08f, y + 0.39f, sign_z});
  kit.b.object("sign", kit.b.mesh(sign, "sign"), kit.m.gilt);
}

}  // namespace sideray::scenes::bistro
