#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/bistro/bistro.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float table_radius = 0.42f;

Shape table_top() {
  return Shape()
      .lathe({},
             {{0, table_y - 0.030f},
              {table_radius - 0.012f, table_y - 0.030f},
              {table_radius - 0.003f, table_y - 0.024f},
              {table_radius, table_y - 0.015f},
              {table_radius - 0.003f, table_y - 0.006f},
              {table_radius - 0.012f, table_y},
              {0, table_y}},
             72)
      .uv_from_above(1.1f);
}

Shape table_rim() {
  return Shape().lathe({},
                       {{table_radius - 0.004f, table_y - 0.022f},
                        {table_radius + 0.0015f, table_y - 0.020f},
                        {table_radius + 0.0015f, table_y - 0.010f},
                        {table_radius - 0.004f, table_y - 0.008f}},
                       72);
}

Shape table_leg() {
  Shape leg;
  leg.lathe({},
            smooth_curve({{0, 0.10f},
                          {0.055f, 0.10f},
                          {0.055f, 0.10f},
                          {0.058f, 0.13f},
                          {0.030f, 0.17f},
                          {0.024f, 0.26f},
                          {0.034f, 0.36f},
                          {0.034f, 0.36f},
                          {0.025f, 0.38f},
                          {0.022f, 0.60f},
                          {0.040f, 0.68f},
                          {0.10f, 0.715f},
                          {0.10f, table_y - 0.029f},
                          {0.10f, table_y - 0.029f},
                          {0, table_y - 0.029f}},
                         3),
            24);
  for (int i = 0; i < 4; ++i) {
    const float a = glm::half_pi<float>() * static_cast<float>(i) + 0.78f;
    const auto at = [&](float r, float y) { return vec3(r * elementary::cos(a), y, r * elementary::sin(a)); };
    leg.tube({at(0.03f, 0.15f), at(0.10f, 0.14f), at(0.20f, 0.06f), at(0.28f, 0.018f), at(0.31f, 0.018f)}, 0.017f, 10,
             4);
  }
  return leg;
}

// Returns a bentwood chair: four splayed legs, a ring that ties them, a hoop for the back and a smaller one in it.
Shape chair_frame() {
  Shape chair;
  chair.lathe({}, {{0.165f, 0.440f}, {0.200f, 0.438f}, {0.206f, 0.450f}, {0.200f, 0.464f}, {0.168f, 0.462f}}, 28);
  for (const float x : {-1.0f, 1.0f}) {
    chair.tube({{0.14f * x, 0.445f, -0.13f}, {0.155f * x, 0.2f, -0.15f}, {0.185f * x, 0.0f, -0.185f}}, 0.0135f, 7, 3);
    chair.tube({{0.165f * x, 0.0f, 0.235f},
                {0.150f * x, 0.22f, 0.180f},
                {0.160f * x, 0.45f, 0.160f},
                {0.178f * x, 0.66f, 0.200f},
                {0.150f * x, 0.82f, 0.232f},
                {0.080f * x, 0.885f, 0.245f},
                {0, 0.90f, 0.248f}},
               0.0135f, 10, 5);
    chair.tube({{0.085f * x, 0.455f, 0.172f},
                {0.095f * x, 0.62f, 0.195f},
                {0.082f * x, 0.75f, 0.220f},
                {0.045f * x, 0.805f, 0.234f},
                {0, 0.818f, 0.236f}},
               0.0095f, 7, 3);
  }
  std::vector<vec3> ring;
  for (int i = 0; i <= 12; ++i) {
    const float a = glm::two_pi<float>() * static_cast<float>(i) / 12.0f;
    ring.emplace_back(0.150f * elementary::cos(a), 0.23f, 0.012f + 0.155f * elementary::sin(a));
  }
  return chair.tube(ring, 0.008f, 6, 3);
}

Shape chair_seat() {
  return Shape()
      .lathe({}, {{0, 0.444f}, {0.17f, 0.444f}, {0.17f, 0.460f}, {0.10f, 0.455f}, {0, 0.453f}}, 40)
      .uv_from_above(2.6f);
}

Shape plate() {
  return Shape().lathe({},
                       {{0, 0},
                        {0.062f, 0},
                        {0.066f, 0.004f},
                        {0.098f, 0.014f},
                        {0.115f, 0.019f},
                        {0.116f, 0.021f},
                        {0.096f, 0.0175f},
                        {0.064f, 0.0075f},
                        {0, 0.006f}},
                       56);
}

Shape loaf() {
  Shape bread;
  return bread.sheet(24, 12, [](float u, float v) {
    const float a = glm::two_pi<float>() * u, b = 0.97f * glm::pi<float>() * (v - 0.5f);
    const float ripple = 1.0f + 0.06f * elementary::sin(5.0f * a) * elementary::cos(b);
    return vec3(0.075f * elementary::sin(b), 0.022f + 0.026f * ripple * elementary::cos(b) * elementary::cos(a),
                0.030f * ripple * elementary::cos(b) * elementary::sin(a));
  });
}

struct Setting {
  Kit& kit;
  std::string table;
  vec3 top;  // of the table's middle
  int count = 0;

  std::string next() { return fmt::format("{}.{}", table, count++); }
  vec3 at(vec2 p) const { return top + vec3(p.x, 0, p.y); }
};

void add_bread(Setting& s, vec2 p, float turn) {
  const std::string suffix = s.next();
  const auto place = [&](const char* name, uint32_t mesh, uint32_t material, float up) {
    s.kit.b.object(name + suffix, mesh, material, glm::dvec3(s.at(p) + vec3(0, up, 0)), double{turn});
  };
  place("plate", s.kit.mesh("plate", plate), s.kit.m.china, 0);
  place("bread", s.kit.mesh("loaf", loaf), s.kit.m.bread, 0.008f);
}

// Lays the table next to the camera by hand; positions are to the right of and away from the eye at (-1.6, 2.9).
void lay_first_table(Setting& s, int bottles) {
  const vec2 away = glm::normalize(vec2(0.44f, -0.90f)), right(-away.y, away.x);
  const auto spot = [&](float r, float a) { return s.at(r * right + a * away); };
  struct Laid {
    Glass glass;
    float right, away;
    int drink;
    float fill;
  };
  static constexpr Laid laid[] = {
      {Glass::red_wine, -0.085f, -0.03f, 0, 1.0f},    {Glass::red_wine, 0.075f, 0.135f, 0, 0.6f},
      {Glass::white_wine, -0.235f, -0.120f, 1, 1.0f}, {Glass::snifter, 0.255f, -0.115f, 2, 1.0f},
      {Glass::coupe, -0.015f, 0.295f, -1, 1.0f},      {Glass::flute, -0.150f, 0.220f, 1, 0.9f},
      {Glass::decanter, 0.195f, 0.075f, 0, 1.0f},     {Glass::tumbler, 0.120f, -0.235f, -1, 1.0f},
      {Glass::tall, -0.305f, 0.060f, -1, 1.0f},       {Glass::white_wine, 0.300f, 0.110f, -1, 1.0f},
      {Glass::flute, 0.235f, 0.190f, 1, 1.0f},        {Glass::red_wine, -0.275f, 0.215f, 0, 0.8f},
      {Glass::tumbler, -0.330f, -0.060f, -1, 0.8f},   {Glass::coupe, 0.335f, -0.010f, 1, 1.0f},
  };
  for (const Laid& l : laid) add_glass(s.kit, l.glass, s.next(), spot(l.right, l.away), l.drink, l.fill);
  struct Stood {
    Bottle bottle;
    float right, away;
    int tint, label;
    float fill, turn;
  };
  static constexpr Stood stood[] = {
      {Bottle::bordeaux, -0.205f, 0.095f, 0, 0, 0.7f, 10.0f},
      {Bottle::spirit, 0.165f, 0.270f, 1, 3, 0.6f, 0.0f},
      {Bottle::flask, 0.060f, 0.270f + 0.085f, 2, -1, 0.0f, 0.0f},
      {Bottle::burgundy, -0.150f, 0.340f, 3, 2, 0.8f, 30.0f},
  };
  for (int i = 0; i < std::min(bottles, 4); ++i) {
    const Stood& b = stood[i];
    add_bottle(s.kit, b.bottle, s.next(), spot(b.right, b.away), b.tint, b.label, b.fill, b.turn);
  }
  add_candle(s.kit, s.next(), spot(0.015f, -0.140f));
}

// Finds random places on the other tables, one after another, each free of the objects placed before.
class Scatter {
 public:
  Scatter(Setting& setting, uint32_t salt) : s_(setting), salt_(salt) {}

  bool place(float radius, vec2& found) {
    for (uint32_t attempt = 0; attempt < 60; ++attempt) {
      const uint32_t draw = 2 * (60 * things_ + attempt);
      const float r = (table_radius - 0.02f - radius) * std::sqrt(s_.kit.random(salt_, draw));
      const float angle = glm::two_pi<float>() * s_.kit.random(salt_, draw + 1);
      found = r * vec2(elementary::cos(angle), elementary::sin(angle));
      if (!free_at(found, radius)) continue;
      taken_.emplace_back(found.x, found.y, radius);
      ++things_;
      return true;
    }
    ++things_;
    return false;
  }

 private:
  bool free_at(vec2 p, float radius) const {
    for (const vec3 other : taken_)
      if (glm::length(vec2(other) - p) < other.z + radius + 0.006f) return false;
    return true;
  }

  Setting& s_;
  uint32_t salt_, things_ = 0;
  std::vector<vec3> taken_;
};

void lay_table(Setting& s, int index, int bottles) {
  const auto salt = static_cast<uint32_t>(1000 + index);
  const auto pick = [&](uint32_t which, int choices) {
    return static_cast<int>(s.kit.random(salt + 500, which) * static_cast<float>(choices));
  };
  Scatter scatter(s, salt);
  vec2 p;
  if (scatter.place(0.04f, p)) add_candle(s.kit, s.next(), s.at(p));
  if (index % 2 == 0 && scatter.place(0.117f, p)) add_bread(s, p, 40.0f * static_cast<float>(index));
  for (int i = 0; i < bottles; ++i) {
    const auto n = static_cast<uint32_t>(i);
    if (!scatter.place(0.055f, p)) continue;
    const auto kind = static_cast<Bottle>(pick(n, 4));
    add_bottle(s.kit, kind, s.next(), s.at(p), pick(20 + n, 4), pick(40 + n, 4),
               0.4f + 0.5f * s.kit.random(salt, 9000 + n), 360.0f * s.kit.random(salt, 9100 + n));
  }
  static constexpr Glass kinds[] = {Glass::red_wine, Glass::tumbler,   Glass::white_wine, Glass::flute,
                                    Glass::red_wine, Glass::snifter,   Glass::coupe,      Glass::carafe,
                                    Glass::tall,     Glass::white_wine};
  for (uint32_t i = 0; i < 9; ++i) {
    const Glass glass = kinds[(i + static_cast<uint32_t>(3 * index)) % 10];
    if (!scatter.place(glass == Glass::carafe ? 0.057f : 0.05f, p)) continue;
    static constexpr int drinks[] = {0, -1, 1, 1, -1, 2, 1, 0, 3, -1};
    const int drink = drinks[(i + static_cast<uint32_t>(3 * index)) % 10];
    add_glass(s.kit, glass, s.next(), s.at(p), drink, 0.6f + 0.4f * s.kit.random(salt, 9200 + i));
  }
}

void add_chair(Kit& kit, const std::string& name, vec2 at, float turn_deg) {
  const glm::dvec3 place{double{at.x}, 0.0, double{at.y}};
  kit.b.object(name, kit.mesh("chair", chair_frame), kit.m.walnut, place, double{turn_deg});
  kit.b.object(name + " seat", kit.mesh("chair seat", chair_seat), kit.m.cane, place, double{turn_deg});
}

}  // namespace

void add_table(Kit& kit, int index, const TablePlace& place, int bottles) {
  const glm::dvec3 at{double{place.at.x}, 0.0, double{place.at.y}};
  const std::string number = std::to_string(index);
  kit.b.object("table" + number, kit.mesh("table top", table_top), kit.m.table_top, at, double{place.turn_deg});
  kit.b.object("table rim" + number, kit.mesh("table rim", table_rim), kit.m.brass, at);
  kit.b.object("table leg" + number, kit.mesh("table leg", table_leg), kit.m.iron, at, double{place.turn_deg});
  for (int i = 0; i < place.chairs; ++i) {
    const float turn = place.turn_deg + 360.0f * static_cast<float>(i) / static_cast<float>(place.chairs);
    const float a = glm::radians(turn), r = 0.56f + 0.1f * kit.random(77, static_cast<uint32_t>(10 * index + i));
    add_chair(kit, fmt::format("chair{}.{}", index, i), place.at + r * vec2(elementary::sin(a), elementary::cos(a)),
              turn + 16.0f * (kit.random(78, static_cast<uint32_t>(10 * index + i)) - 0.5f));
  }
  Setting setting{kit, number, vec3(place.at.x, table_y, place.at.y)};
  kit.coarseness = index == 0 ? 0 : 1;
  if (index == 0) {
    lay_first_table(setting, bottles);
  } else {
    lay_table(setting, index, bottles);
  }
  kit.coarseness = 1;
}

}  // namespace sideray::scenes::bistro
