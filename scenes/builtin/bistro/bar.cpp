#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/bistro/bistro.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float front_x = 3.10f, inner_x = 3.62f, near_z = 2.7f, far_z = -2.3f, top_y = 1.06f;
constexpr float shelf_x = right_x - 0.30f;
constexpr std::array<float, 3> shelf_y = {1.14f, 1.52f, 1.90f};

void add_counter(Kit& kit) {
  Shape front;
  front.bevelled_box({front_x + 0.06f, 0, far_z + 0.06f}, {inner_x, top_y - 0.04f, near_z - 0.06f}, 0.01f);
  const int panels = 7;
  const float step = (near_z - far_z - 0.12f) / panels;
  for (int i = 0; i < panels; ++i) {
    const float z = far_z + 0.06f + step * static_cast<float>(i);
    front.bevelled_box({front_x + 0.035f, 0.22f, z + 0.07f}, {front_x + 0.07f, top_y - 0.16f, z + step - 0.07f},
                       0.016f);
    front.bevelled_box({front_x + 0.02f, 0.10f, z - 0.035f}, {front_x + 0.07f, top_y - 0.06f, z + 0.035f}, 0.008f);
  }
  front.bevelled_box({front_x + 0.015f, 0, far_z + 0.03f}, {inner_x, 0.12f, near_z - 0.03f}, 0.01f);
  kit.b.object("bar front", kit.b.mesh(front, "bar front"), kit.m.panel);
  const Shape top = Shape().bevelled_box({front_x - 0.06f, top_y - 0.05f, far_z - 0.03f},
                                         {inner_x + 0.04f, top_y, near_z + 0.03f}, 0.014f, 0.9f);
  kit.b.object("bar top", kit.b.mesh(top, "bar top"), kit.m.bar_top);
  Shape rail;
  const float x = front_x - 0.09f;
  rail.tube({{x, 0.19f, far_z + 0.1f}, {x, 0.19f, near_z - 0.1f}}, 0.022f, 16, 1);
  for (int i = 0; i < 5; ++i) {
    const float z = far_z + 0.35f + 1.08f * static_cast<float>(i);
    rail.tube({{x, 0.19f, z}, {front_x + 0.03f, 0.19f, z}}, 0.011f, 8, 1);
  }
  kit.b.object("foot rail", kit.b.mesh(rail, "foot rail"), kit.m.brass);
}

void add_stools(Kit& kit) {
  const uint32_t seat = kit.mesh("stool seat", [] {
    return Shape()
        .lathe({},
               smooth_curve(
                   {{0, 0.70f}, {0.17f, 0.70f}, {0.17f, 0.70f}, {0.185f, 0.735f}, {0.165f, 0.765f}, {0, 0.775f}}, 3),
               36)
        .uv_from_above(3.0f);
  });
  const uint32_t leg = kit.mesh("stool leg", [] {
    Shape s;
    s.lathe({},
            smooth_curve({{0, 0},
                          {0.20f, 0},
                          {0.20f, 0},
                          {0.20f, 0.012f},
                          {0.06f, 0.03f},
                          {0.026f, 0.06f},
                          {0.026f, 0.68f},
                          {0.09f, 0.70f},
                          {0.09f, 0.70f},
                          {0, 0.702f}},
                         2),
            28);
    std::vector<vec3> ring;
    for (int i = 0; i <= 12; ++i) {
      const float a = glm::two_pi<float>() * static_cast<float>(i) / 12.0f;
      ring.emplace_back(0.15f * elementary::cos(a), 0.28f, 0.15f * elementary::sin(a));
    }
    return s.tube(ring, 0.009f, 8, 3);
  });
  for (int i = 0; i < 5; ++i) {
    const glm::dvec3 at(double{front_x} - 0.42, 0.0, double{far_z} + 0.45 + 0.98 * i);
    kit.b.object(fmt::format("stool seat{}", i), seat, kit.m.leather, at, 31.0 * i);
    kit.b.object(fmt::format("stool leg{}", i), leg, kit.m.brass, at);
  }
}

void add_back_bar(Kit& kit) {
  Shape wood;
  wood.bevelled_box({shelf_x - 0.12f, 0, far_z}, {right_x, 0.92f, near_z}, 0.01f, 0.8f);
  for (const float y : shelf_y)
    wood.bevelled_box({shelf_x, y - 0.03f, far_z}, {right_x - 0.02f, y, near_z}, 0.006f, 0.8f);
  for (int i = 0; i <= 3; ++i) {
    const float z = glm::mix(far_z, near_z, static_cast<float>(i) / 3.0f);
    wood.bevelled_box({shelf_x - 0.02f, 0.9f, z - 0.04f}, {right_x, 2.45f, z + 0.04f}, 0.012f, 0.8f);
  }
  wood.bevelled_box({shelf_x - 0.06f, 2.40f, far_z - 0.08f}, {right_x, 2.56f, near_z + 0.08f}, 0.03f, 0.8f);
  kit.b.object("back bar", kit.b.mesh(wood, "back bar"), kit.m.walnut);
  constexpr float x = right_x - 0.015f;
  for (int i = 0; i < 3; ++i) {
    const float z0 = glm::mix(far_z, near_z, static_cast<float>(i) / 3.0f) + 0.04f;
    const float z1 = glm::mix(far_z, near_z, static_cast<float>(i + 1) / 3.0f) - 0.04f;
    const Shape mirror = Shape().quad({x, 0.93f, z0}, {x, 0.93f, z1}, {x, 2.41f, z1}, {x, 2.41f, z0});
    const std::string name = fmt::format("mirror{}", i);
    kit.b.object(name, kit.b.mesh(mirror, name), kit.m.mirror);
  }
}

void stock_shelves(Kit& kit) {
  uint32_t n = 0;
  for (size_t row = 0; row < shelf_y.size(); ++row)
    for (int i = 0; i < 26; ++i, ++n) {
      const float z = far_z + 0.14f + 0.187f * static_cast<float>(i) + 0.02f * kit.random(300, n);
      if (std::fmod(z - far_z + 0.09f, (near_z - far_z) / 3.0f) < 0.18f) continue;  // position of an upright
      const vec3 at(shelf_x + 0.13f + 0.05f * kit.random(301, n), shelf_y[row], z);
      const std::string suffix = fmt::format(".shelf{}.{}", row, i);
      const auto pick = [&](uint32_t salt, int choices) {
        return static_cast<int>(kit.random(salt, n) * static_cast<float>(choices));
      };
      if (kit.random(302, n) < 0.16f) {
        static constexpr Glass glasses[] = {Glass::coupe, Glass::flute, Glass::white_wine, Glass::tumbler};
        add_glass(kit, glasses[pick(303, 4)], suffix, at, -1, 0.2f);
      } else {
        const float fill = kit.random(306, n) < 0.7f ? 0.3f + 0.7f * kit.random(307, n) : 0.0f;
        add_bottle(kit, static_cast<Bottle>(pick(304, 4)), suffix, at, pick(305, 4), pick(308, 4), fill,
                   -90.0f + 30.0f * (kit.random(309, n) - 0.5f));
      }
    }
}

// Places glasses, bottles and an old vitrine on the counter.
void dress_counter(Kit& kit) {
  const float x = 0.5f * (front_x + inner_x);
  for (int i = 0; i < 9; ++i) {
    static constexpr Glass kinds[] = {Glass::flute, Glass::coupe, Glass::red_wine, Glass::tumbler};
    const auto n = static_cast<uint32_t>(i);
    const vec3 at(x - 0.14f + 0.12f * static_cast<float>(i % 3), top_y,
                  -1.95f + 0.115f * static_cast<float>(i / 3) + 0.02f * kit.random(320, n));
    add_glass(kit, kinds[i % 4], fmt::format(".bar{}", i), at, i % 4 == 2 ? 0 : i % 4 == 0 ? 1 : -1, 0.8f);
  }
  add_candle(kit, ".bar", {x - 0.16f, top_y, -0.75f});
  add_bottle(kit, Bottle::burgundy, ".counter0", {x + 0.08f, top_y, -0.55f}, 0, 0, 0.8f, -100.0f);
  add_bottle(kit, Bottle::spirit, ".counter1", {x + 0.14f, top_y, -0.38f}, 1, 3, 0.7f, -80.0f);
  add_glass(kit, Glass::snifter, ".bar9", {x - 0.1f, top_y, -0.42f}, 2, 1.0f);
  add_glass(kit, Glass::carafe, ".bar10", {x - 0.05f, top_y, -1.25f}, 0, 1.0f);
  constexpr float low = 0.35f, high = 1.15f, x0 = front_x + 0.05f, x1 = inner_x - 0.02f, y = top_y + 0.32f;
  const Shape case_panes[] = {Shape().quad({x0, top_y, low}, {x0, top_y, high}, {x0, y, high}, {x0, y, low}),
                              Shape().quad({x0, top_y, low}, {x0, y, low}, {x1, y, low}, {x1, top_y, low}),
                              Shape().quad({x0, top_y, high}, {x1, top_y, high}, {x1, y, high}, {x0, y, high}),
                              Shape().quad({x0, y, low}, {x0, y, high}, {x1, y, high}, {x1, y, low})};
  for (size_t i = 0; i < std::size(case_panes); ++i) {
    const std::string name = fmt::format("vitrine{}", i);
    kit.b.object(name, kit.b.mesh(case_panes[i], name), kit.m.vitrine);
  }
}

}  // namespace

void add_bar(Kit& kit) {
  add_counter(kit);
  add_stools(kit);
  add_back_bar(kit);
  kit.coarseness = 2;
  stock_shelves(kit);
  kit.coarseness = 1;
  dress_counter(kit);
}

}  // namespace sideray::scenes::bistro
