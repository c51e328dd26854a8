#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/bistro/bistro.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec3;

// Makes a glass bell that is open below: outer wall up, neck, inner wall down, centred on the lamp.
Shape bell() {
  std::vector<glm::vec2> outer = smooth_curve(
      {{0.175f, -0.10f}, {0.168f, -0.06f}, {0.135f, 0.02f}, {0.085f, 0.085f}, {0.045f, 0.12f}, {0.030f, 0.15f}}, 3);
  std::vector<glm::vec2> profile = outer;
  for (size_t i = outer.size(); i-- > 0;) {
    const glm::vec2 along = glm::normalize(outer[std::min(i + 1, outer.size() - 1)] - outer[i > 0 ? i - 1 : 0]);
    profile.push_back(outer[i] - 0.0028f * glm::vec2(along.y, -along.x));
  }
  profile.push_back(profile.front());
  return Shape().lathe({}, profile, 40);
}

void hang(Kit& kit, const std::string& name, vec3 at, bool linen) {
  const glm::dvec3 place(at);
  // The neck is long, so that the socket's shadow on the ceiling is small.
  const uint32_t bulb = kit.mesh("bulb", [] {
    return Shape().lathe({},
                         smooth_curve({{0, -0.052f},
                                       {0.018f, -0.048f},
                                       {0.030f, -0.022f},
                                       {0.028f, 0.0f},
                                       {0.016f, 0.040f},
                                       {0.012f, 0.075f},
                                       {0.012f, 0.105f},
                                       {0.012f, 0.105f},
                                       {0, 0.107f}},
                                      3),
                         20);
  });
  const uint32_t socket = kit.mesh("socket", [] {
    return Shape().lathe({},
                         {{0, 0.100f},
                          {0.016f, 0.100f},
                          {0.017f, 0.105f},
                          {0.017f, 0.140f},
                          {0.026f, 0.152f},
                          {0.026f, 0.165f},
                          {0.012f, 0.187f},
                          {0, 0.19f}},
                         20);
  });
  const float drop = ceiling_y - at.y - 0.18f;
  const uint32_t cord = kit.mesh(fmt::format("cord {:.3f}", double{drop}), [&] {
    return Shape()
        .cylinder({0, 0.18f, 0}, 0.004f, drop, 8)
        .lathe({}, {{0, drop + 0.15f}, {0.05f, drop + 0.152f}, {0.05f, drop + 0.18f}, {0, drop + 0.18f}}, 20);
  });
  kit.b.object("bulb " + name, bulb, kit.m.bulb, place);
  kit.b.object("socket " + name, socket, kit.m.brass, place);
  kit.b.object("cord " + name, cord, kit.m.brass, place);
  if (linen) {
    const uint32_t drum = kit.mesh("drum shade", [] {
      return Shape().sheet(48, 1,
                           [](float u, float v) {
                             const float a = -glm::two_pi<float>() * u, r = glm::mix(0.21f, 0.17f, v);
                             return vec3(r * elementary::cos(a), glm::mix(-0.11f, 0.13f, v), r * elementary::sin(a));
                           },
                           {6, 1});
    });
    kit.b.object("shade " + name, drum, kit.m.linen, place);
  } else {
    kit.b.object("shade " + name, kit.mesh("bell shade", bell), kit.m.shade_glass, place);
  }
}

void add_sconce(Kit& kit, int index, vec3 at, float turn_deg) {
  const uint32_t arm = kit.mesh("sconce", [] {
    return Shape()
        .lathe({0, -0.12f, 0.0f}, {{0, 0}, {0.045f, 0.01f}, {0.05f, 0.03f}, {0.02f, 0.05f}, {0.05f, 0.07f}, {0, 0.09f}},
               20)
        .tube({{0, -0.08f, 0.0f}, {0, -0.13f, 0.06f}, {0, -0.11f, 0.12f}, {0, -0.06f, 0.13f}}, 0.010f, 10, 4)
        .lathe({0, -0.075f, 0.13f}, {{0, 0}, {0.03f, 0.004f}, {0.042f, 0.022f}, {0, 0.03f}}, 20);
  });
  const uint32_t globe = kit.mesh("sconce globe", [] { return Shape().sphere({0, 0.025f, 0.13f}, 0.085f, 32); });
  kit.b.object(fmt::format("sconce{}", index), arm, kit.m.brass, glm::dvec3(at), double{turn_deg});
  kit.b.object(fmt::format("sconce globe{}", index), globe, kit.m.opal, glm::dvec3(at), double{turn_deg});
}

sideray_light lamp(vec3 at, float candela, float range, float radius) {
  sideray_light light = point_light(at, warm * candela, range);
  light.radius = radius;
  return light;
}

// Limits of a small bulb's intensity, and of the sum over all.
constexpr float brightest_bulb = 0.15f, all_bulbs = 12.0f;  // candela

uint32_t glowing_bulb(Kit& kit) {
  sideray_material_desc glow = opaque_material({0.8f, 0.7f, 0.55f}, 0.5f);
  const vec3 radiance = 8.0f * warm;
  for (int c = 0; c < 3; ++c) glow.emissive[c] = radiance[c];
  return kit.b.material("small bulb", glow);
}

// Hangs bulbs on thin cords under the ceiling. Each bulb's light is moved out of the bulb, so that nothing blocks it. A
// bulb's position depends only on its number, so more bulbs do not move it.
void add_small_bulbs(Kit& kit, uint32_t count) {
  constexpr float radius = 0.012f;  // of bulb and light
  const uint32_t material = glowing_bulb(kit);
  const uint32_t bulb = kit.mesh("small bulb", [] { return Shape().sphere({0, 0, 0}, radius, 6); });
  const uint32_t cord = kit.mesh("small cord", [] { return Shape().cylinder({0, 0, 0}, 0.0015f, 1.0f, 3); });
  const float candela = std::min(brightest_bulb, all_bulbs / static_cast<float>(count));
  const glm::dvec3 least(double{left_x} + 0.3, 0.0, double{window_z} + 0.3);
  const glm::dvec3 most(double{right_x} - 0.3, 0.0, double{back_z} - 0.3);
  for (uint32_t i = 0; i < count; ++i) {
    // Multiples of two irrational numbers cover the ceiling evenly, for any count.
    const double n = i + 1.0, u = std::fmod(n * 0.7548776662466927, 1.0), v = std::fmod(n * 0.5698402909980532, 1.0);
    const double drop = 0.45 + 0.5 * double{hash01(i, 7)};
    const glm::dvec3 at = glm::mix(least, most, glm::dvec3(u, 0.0, v)) + glm::dvec3(0.0, double{ceiling_y} - drop, 0.0);
    kit.b.object(fmt::format("small bulb{}", i), bulb, material, at);
    kit.b.object(fmt::format("small cord{}", i), cord, kit.m.brass,
                 glm::scale(glm::translate(glm::dmat4(1.0), at), glm::dvec3(1.0, drop, 1.0)));
    kit.b.light(fmt::format("small{}", i), lamp(vec3(at) - vec3(0, 2.5f * radius, 0), candela, 3.5f, radius));
  }
}

// Makes a spot light, which needs one shadow map; a point light needs six.
sideray_light cone(vec3 at, vec3 direction, float candela, float range, float radius) {
  sideray_light light = spot_light(at, direction, warm * candela, range, 60.0f);
  light.radius = radius;
  return light;
}

}  // namespace

void add_lamps(Kit& kit, uint32_t small_bulbs) {
  constexpr float radius = 0.02f;  // inside the bulb of hang(); a larger sphere would shine past the frosted glass
  struct Pendant {
    vec3 at;
    bool linen;
    float candela;  // 0: it glows, and a neighbour includes its light
    bool down;      // lights only downward, which costs a third
  };
  static constexpr Pendant pendants[] = {
      {{-1.15f, 1.92f, 1.45f}, false, 5.2f, false}, {{0.85f, 1.86f, -0.45f}, false, 6.4f, false},
      {{2.0f, 1.86f, -2.45f}, false, 5.8f, false},  {{-1.0f, 1.86f, -2.35f}, false, 7.0f, true},
      {{-2.9f, 1.86f, -0.6f}, false, 0.0f, false},  {{1.3f, 1.95f, 2.5f}, true, 0.0f, false}};
  for (size_t i = 0; i < std::size(pendants); ++i) {
    const Pendant& p = pendants[i];
    hang(kit, fmt::format("pendant{}", i), p.at, p.linen);
    if (p.candela <= 0.0f) continue;
    const std::string name = fmt::format("pendant{}", i);
    if (p.down) {
      kit.b.light(name, cone(p.at, {0, -1, 0}, p.candela, 4.0f, radius));
    } else {
      kit.b.light(name, lamp(p.at, p.candela, 11.0f, radius));
    }
  }
  for (int i = 0; i < 3; ++i)
    hang(kit, fmt::format("bar{}", i), {3.34f, 1.98f, -1.75f + 1.5f * static_cast<float>(i)}, true);
  kit.b.light("bar", cone({3.34f, 2.05f, -0.9f}, {0.35f, -1.0f, 0.0f}, 12.0f, 6.0f, 0.15f));
  for (int i = 0; i < 3; ++i) add_sconce(kit, i, {left_x + 0.02f, 1.85f, 3.75f - 2.3f * static_cast<float>(i)}, 90.0f);
  add_sconce(kit, 3, {right_x - 0.02f, 1.80f, -3.72f}, -90.0f);
  // Moved out of the globe, because otherwise its light on the wall would be a small spot.
  kit.b.light("sconce", cone({right_x - 0.50f, 1.90f, -3.60f}, {1, 0.1f, -0.2f}, 2.0f, 4.0f, 0.085f));
  // The flame of the first table's candle, which tables.cpp places there.
  kit.b.light("candle", lamp({-1.298f, 0.808f, 1.720f}, 0.20f, 1.6f, 0.006f));
  if (small_bulbs > 0) add_small_bulbs(kit, small_bulbs);
}

}  // namespace sideray::scenes::bistro
