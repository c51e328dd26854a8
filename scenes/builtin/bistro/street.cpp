#include <fmt/format.h>

#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/bistro/bistro.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float ground_y = -0.12f, far_kerb_z = -13.0f, street_z = -15.0f;

struct House {
  float from, to, height;  // along x
  int facade, floors, columns;
  float front_z;
};

// The gap at x -4..0 is a side street that lets the dusk in.
constexpr House houses[] = {{-34, -24, 9.5f, 0, 3, 5, street_z},   {-24, -14, 7.5f, 1, 2, 5, street_z},
                            {-14, -4.2f, 8.6f, 2, 3, 5, street_z}, {0.4f, 7.6f, 7.4f, 1, 2, 4, street_z},
                            {7.6f, 16, 9.4f, 0, 3, 4, street_z},   {16, 27, 8.0f, 2, 2, 6, street_z},
                            {27, 38, 10.0f, 0, 3, 5, street_z},    {-16, -6.5f, 5.6f, 0, 1, 5, -38.0f},
                            {-6.5f, -1.0f, 4.4f, 1, 1, 3, -36.0f}, {-1.0f, 6.0f, 5.2f, 2, 1, 4, -40.0f}};
void add_house(Kit& kit, int index, const House& h) {
  const float width = h.to - h.from, depth = 10.0f, front_z = h.front_z;
  Shape walls, lit, dark, trim, shop, awning;
  const auto face = [&](vec3 a, vec3 b, float top) {
    const float length = glm::length(b - a);
    walls.quad(a, b, vec3(b.x, top, b.z), vec3(a.x, top, a.z), vec2(length / 4.0f, (top - ground_y) / 4.0f));
  };
  face({h.from, ground_y, front_z}, {h.to, ground_y, front_z}, h.height);
  face({h.from, ground_y, front_z - depth}, {h.from, ground_y, front_z}, h.height);
  face({h.to, ground_y, front_z}, {h.to, ground_y, front_z - depth}, h.height);
  trim.bevelled_box({h.from - 0.1f, h.height - 0.3f, front_z - depth}, {h.to + 0.1f, h.height, front_z + 0.25f}, 0.08f,
                    0.3f);
  trim.bevelled_box({h.from, 2.95f, front_z - 0.1f}, {h.to, 3.15f, front_z + 0.12f}, 0.03f, 0.3f);
  const float pitch = width / static_cast<float>(h.columns), rise = (h.height - 3.3f) / static_cast<float>(h.floors);
  for (int f = 0; f < h.floors; ++f)
    for (int c = 0; c < h.columns; ++c) {
      const float x = h.from + pitch * (static_cast<float>(c) + 0.5f), y = 3.45f + rise * static_cast<float>(f);
      const float w = 0.48f, tall = std::min(1.55f, rise - 0.5f);
      const bool is_lit = kit.random(400 + static_cast<uint32_t>(index), static_cast<uint32_t>(10 * f + c)) < 0.45f;
      (is_lit ? lit : dark)
          .quad({x - w, y, front_z + 0.02f}, {x + w, y, front_z + 0.02f}, {x + w, y + tall, front_z + 0.02f},
                {x - w, y + tall, front_z + 0.02f});
      trim.bevelled_box({x - w - 0.12f, y - 0.1f, front_z}, {x + w + 0.12f, y, front_z + 0.14f}, 0.02f, 0.3f);
      trim.bevelled_box({x - w - 0.1f, y + tall, front_z}, {x + w + 0.1f, y + tall + 0.12f, front_z + 0.08f}, 0.02f,
                        0.3f);
      for (const float side : {-1.0f, 1.0f})
        trim.bevelled_box({x + side * (w + 0.05f) - 0.05f, y, front_z},
                          {x + side * (w + 0.05f) + 0.05f, y + tall, front_z + 0.06f}, 0.015f, 0.3f);
    }
  // The ground floor has a shop window and a door under an awning, or a closed shutter.
  for (int c = 0; c + 1 < h.columns; c += 2) {
    const float x0 = h.from + pitch * (static_cast<float>(c) + 0.25f), x1 = x0 + 1.4f * pitch;
    const bool open = kit.random(420 + static_cast<uint32_t>(index), static_cast<uint32_t>(c)) < 0.7f;
    shop.bevelled_box({x0, ground_y, front_z - 0.1f}, {x1, 2.75f, front_z + 0.10f}, 0.03f);
    (open ? lit : dark)
        .quad({x0 + 0.15f, 0.55f, front_z + 0.11f}, {x1 - 1.0f, 0.55f, front_z + 0.11f},
              {x1 - 1.0f, 2.25f, front_z + 0.11f}, {x0 + 0.15f, 2.25f, front_z + 0.11f});
    dark.quad({x1 - 0.85f, 0, front_z + 0.11f}, {x1 - 0.15f, 0, front_z + 0.11f}, {x1 - 0.15f, 2.25f, front_z + 0.11f},
              {x1 - 0.85f, 2.25f, front_z + 0.11f});
    if (open)
      awning.sheet(1, 2, [=](float u, float v) {
        const float out = 1.2f * (1.0f - v);
        return vec3(glm::mix(x0, x1, u), 2.30f + 0.5f * v, front_z + 0.12f + out);
      });
  }
  const auto add = [&](const char* part, const Shape& shape, uint32_t material) {
    const std::string name = fmt::format("house{} {}", index, part);
    if (!shape.empty()) kit.b.object(name, kit.b.mesh(shape, name), material);
  };
  const uint32_t stone = kit.m.facades[static_cast<size_t>(h.facade)];
  add("walls", walls, stone);
  add("trim", trim, stone);
  add("lit windows", lit, kit.m.lit_window);
  add("dark windows", dark, kit.m.dark_window);
  add("shopfront", shop, kit.m.shopfront);
  add("awning", awning, kit.m.awning);
}

void add_ground(Kit& kit) {
  const auto plane = [&](const char* name, float y, float near, float far, uint32_t material, float scale) {
    const Shape s =
        Shape().quad({-40, y, near}, {40, y, near}, {40, y, far}, {-40, y, far}, vec2(80, near - far) / scale);
    kit.b.object(name, kit.b.mesh(s, name), material);
  };
  plane("near pavement", 0.0f - 0.02f, window_z - 0.05f, -6.2f, kit.m.pavement, 2.0f);
  plane("cobbles", ground_y, -6.2f, far_kerb_z, kit.m.cobbles, 1.6f);
  plane("far pavement", 0.0f, far_kerb_z, street_z, kit.m.pavement, 2.0f);
  plane("side street", ground_y + 0.1f, street_z, -60.0f, kit.m.cobbles, 1.6f);
  Shape kerb;
  kerb.bevelled_box({-40, ground_y - 0.1f, -6.35f}, {40, -0.01f, -6.15f}, 0.02f);
  kerb.bevelled_box({-40, ground_y - 0.1f, far_kerb_z - 0.1f}, {40, 0.01f, far_kerb_z + 0.1f}, 0.02f);
  kit.b.object("kerbs", kit.b.mesh(kerb, "kerbs"), kit.m.pavement);
}

Shape street_lamp_post() {
  Shape s;
  s.lathe({},
          smooth_curve({{0, 0},
                        {0.16f, 0},
                        {0.16f, 0},
                        {0.15f, 0.25f},
                        {0.09f, 0.42f},
                        {0.055f, 0.6f},
                        {0.045f, 1.6f},
                        {0.04f, 2.95f},
                        {0.07f, 3.0f},
                        {0.07f, 3.0f},
                        {0.06f, 3.06f},
                        {0, 3.06f}},
                       2),
          20);
  s.tube({{-0.35f, 2.72f, 0}, {0, 2.80f, 0}, {0.35f, 2.72f, 0}}, 0.02f, 8, 4);
  s.lathe({}, {{0.185f, 3.42f}, {0.17f, 3.46f}, {0.05f, 3.60f}, {0, 3.68f}}, 20);
  for (int i = 0; i < 6; ++i) {
    const float a = glm::two_pi<float>() * static_cast<float>(i) / 6.0f;
    s.tube({{0.075f * elementary::cos(a), 3.03f, 0.075f * elementary::sin(a)}, {0.165f * elementary::cos(a), 3.43f, 0.165f * elementary::sin(a)}},
           0.009f, 6, 1);
  }
  return s;
}

}  // namespace

void add_street(Kit& kit) {
  add_ground(kit);
  for (int i = 0; i < static_cast<int>(std::size(houses)); ++i) add_house(kit, i, houses[i]);
  const uint32_t post = kit.mesh("street lamp", street_lamp_post);
  const uint32_t globe = kit.mesh("street globe", [] { return Shape().sphere({0, 3.24f, 0}, 0.12f, 20); });
  constexpr vec2 posts[] = {{-7.5f, -6.7f}, {-1.9f, -12.6f}, {4.6f, -6.7f},
                            {8.0f, -12.6f}, {-2.6f, -24.0f}, {-6.0f, -33.0f}};
  for (size_t i = 0; i < std::size(posts); ++i) {
    const glm::dvec3 at{double{posts[i].x}, double{ground_y}, double{posts[i].y}};
    kit.b.object(fmt::format("street lamp{}", i), post, kit.m.iron, at);
    kit.b.object(fmt::format("street globe{}", i), globe, kit.m.street_globe, at);
  }
  sideray_light lantern =
      spot_light({-1.9f, 3.1f, -12.6f}, {0.1f, -1, 0.55f}, vec3(0.62f, 0.80f, 1.0f) * 240.0f, 30.0f, 60.0f);
  lantern.radius = 0.12f;
  kit.b.light("street", lantern);
  // A dome around everything, seen from inside, shows the dusk.
  constexpr float radius = 70.0f;
  const Shape dome = Shape().sheet(48, 24, [](float u, float v) {
    const float azimuth = -glm::two_pi<float>() * u, elevation = glm::pi<float>() * (0.985f * v - 0.4925f);
    return radius *
           vec3(elementary::cos(elevation) * elementary::sin(azimuth), elementary::sin(elevation), elementary::cos(elevation) * elementary::cos(azimuth));
  });
  kit.b.object("dusk", kit.b.mesh(dome, "dusk"), kit.m.sky);
}

}  // namespace sideray::scenes::bistro
