#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"
#include "scenes/builtin/bistro/bistro.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec2;
using glm::vec3;
using Curve = std::vector<vec2>;  // (radius, height)

// Describes a vessel: its outer wall from the middle of the foot to the rim, the wall's thickness, the height of the
// inner bottom, and the height of a usual filling.
struct Vessel {
  const char* name;
  Curve outer;
  float wall, floor, fill;
  uint32_t segments, steps;
};

const Vessel& vessel(Glass glass) {
  static const std::array<Vessel, 9> list = {{
      {"red wine glass",
       {{0, 0},
        {0.037f, 0},
        {0.037f, 0},
        {0.0365f, 0.0025f},
        {0.014f, 0.006f},
        {0.0055f, 0.013f},
        {0.0045f, 0.04f},
        {0.0045f, 0.088f},
        {0.008f, 0.098f},
        {0.027f, 0.109f},
        {0.042f, 0.133f},
        {0.0455f, 0.158f},
        {0.042f, 0.190f},
        {0.034f, 0.225f}},
       0.0015f,
       0.1015f,
       0.153f,
       48,
       3},
      {"white wine glass",
       {{0, 0},
        {0.034f, 0},
        {0.034f, 0},
        {0.0335f, 0.0025f},
        {0.013f, 0.006f},
        {0.005f, 0.013f},
        {0.0042f, 0.04f},
        {0.0042f, 0.090f},
        {0.008f, 0.099f},
        {0.024f, 0.112f},
        {0.034f, 0.138f},
        {0.0355f, 0.160f},
        {0.032f, 0.185f},
        {0.0275f, 0.208f}},
       0.0014f,
       0.1025f,
       0.150f,
       40,
       3},
      {"flute",
       {{0, 0},
        {0.031f, 0},
        {0.031f, 0},
        {0.0305f, 0.0025f},
        {0.012f, 0.006f},
        {0.0048f, 0.013f},
        {0.0042f, 0.045f},
        {0.005f, 0.075f},
        {0.012f, 0.096f},
        {0.021f, 0.130f},
        {0.0255f, 0.175f},
        {0.024f, 0.228f}},
       0.0014f,
       0.088f,
       0.195f,
       36,
       3},
      {"coupe",
       {{0, 0},
        {0.034f, 0},
        {0.034f, 0},
        {0.0335f, 0.0025f},
        {0.013f, 0.006f},
        {0.005f, 0.013f},
        {0.0042f, 0.04f},
        {0.0045f, 0.085f},
        {0.016f, 0.093f},
        {0.037f, 0.107f},
        {0.046f, 0.126f},
        {0.0475f, 0.142f}},
       0.0014f,
       0.0945f,
       0.128f,
       44,
       3},
      {"tumbler",
       {{0, 0}, {0.033f, 0}, {0.0355f, 0.003f}, {0.0365f, 0.02f}, {0.0395f, 0.085f}},
       0.0022f,
       0.0095f,
       0.045f,
       40,
       3},
      {"tall glass",
       {{0, 0}, {0.026f, 0}, {0.0285f, 0.003f}, {0.029f, 0.02f}, {0.0335f, 0.145f}},
       0.0018f,
       0.010f,
       0.112f,
       36,
       3},
      {"snifter",
       {{0, 0},
        {0.034f, 0},
        {0.034f, 0},
        {0.0335f, 0.0025f},
        {0.013f, 0.006f},
        {0.006f, 0.013f},
        {0.0055f, 0.035f},
        {0.010f, 0.043f},
        {0.035f, 0.056f},
        {0.050f, 0.082f},
        {0.0505f, 0.104f},
        {0.042f, 0.134f},
        {0.034f, 0.150f}},
       0.0015f,
       0.047f,
       0.078f,
       48,
       3},
      {"carafe",
       {{0, 0},
        {0.046f, 0},
        {0.051f, 0.005f},
        {0.055f, 0.040f},
        {0.050f, 0.100f},
        {0.026f, 0.165f},
        {0.021f, 0.195f},
        {0.028f, 0.235f},
        {0.035f, 0.252f}},
       0.0022f,
       0.008f,
       0.130f,
       48,
       3},
      {"decanter",
       {{0, 0},
        {0.068f, 0},
        {0.078f, 0.006f},
        {0.082f, 0.030f},
        {0.066f, 0.070f},
        {0.030f, 0.115f},
        {0.019f, 0.150f},
        {0.018f, 0.200f},
        {0.023f, 0.222f},
        {0.029f, 0.228f}},
       0.0025f,
       0.009f,
       0.062f,
       48,
       3},
  }};
  return list[static_cast<size_t>(glass)];
}

const Vessel& vessel(Bottle bottle) {
  static const std::array<Vessel, 4> list = {{
      {"bordeaux bottle",
       {{0, 0},
        {0.034f, 0},
        {0.0375f, 0.004f},
        {0.038f, 0.012f},
        {0.038f, 0.012f},
        {0.038f, 0.190f},
        {0.0365f, 0.205f},
        {0.027f, 0.224f},
        {0.0165f, 0.240f},
        {0.0142f, 0.258f},
        {0.0138f, 0.297f},
        {0.0138f, 0.297f},
        {0.0155f, 0.299f},
        {0.0155f, 0.312f},
        {0.0145f, 0.314f}},
       0.0028f,
       0.012f,
       0.215f,
       40,
       2},
      {"burgundy bottle",
       {{0, 0},
        {0.036f, 0},
        {0.0408f, 0.005f},
        {0.0412f, 0.014f},
        {0.0412f, 0.014f},
        {0.0412f, 0.145f},
        {0.0385f, 0.172f},
        {0.027f, 0.208f},
        {0.0175f, 0.240f},
        {0.0145f, 0.272f},
        {0.0142f, 0.292f},
        {0.0142f, 0.292f},
        {0.016f, 0.294f},
        {0.016f, 0.302f},
        {0.0145f, 0.304f}},
       0.0028f,
       0.012f,
       0.185f,
       40,
       2},
      {"spirit bottle",
       {{0, 0},
        {0.040f, 0},
        {0.044f, 0.004f},
        {0.0445f, 0.012f},
        {0.0445f, 0.012f},
        {0.0445f, 0.150f},
        {0.042f, 0.166f},
        {0.024f, 0.184f},
        {0.0155f, 0.196f},
        {0.0142f, 0.210f},
        {0.0142f, 0.246f},
        {0.0142f, 0.246f},
        {0.0175f, 0.248f},
        {0.0175f, 0.258f}},
       0.003f,
       0.014f,
       0.150f,
       40,
       2},
      {"flask",
       {{0, 0},
        {0.044f, 0},
        {0.050f, 0.006f},
        {0.054f, 0.045f},
        {0.046f, 0.098f},
        {0.026f, 0.130f},
        {0.0155f, 0.150f},
        {0.0142f, 0.175f},
        {0.0145f, 0.215f},
        {0.0145f, 0.215f},
        {0.0185f, 0.217f},
        {0.0185f, 0.226f}},
       0.0028f,
       0.012f,
       0.105f,
       40,
       2},
  }};
  return list[static_cast<size_t>(bottle)];
}

Vessel for_distance(const Kit& kit, Vessel v) {
  v.segments >>= kit.coarseness;
  v.steps = std::max(v.steps, kit.coarseness + 1) - kit.coarseness;
  return v;
}

std::string mesh_name(const Kit& kit, const Vessel& v, const std::string& part = "") {
  static constexpr const char* suffixes[] = {"", " coarse", " far"};
  return fmt::format("{}{}{}", v.name, part, suffixes[kit.coarseness]);
}

Curve outer_wall(const Vessel& v) {
  Curve curve = smooth_curve(v.outer, v.steps);
  for (size_t i = 1; i < curve.size(); ++i) curve[i].x = std::max(curve[i].x, 1e-3f);
  curve.front() = vec2(0);
  return curve;
}

// Returns the outer wall above the height `floor`, moved inward by `depth`.
Curve inside(const Curve& outer, float depth, float floor) {
  Curve curve;
  for (size_t i = 1; i < outer.size(); ++i) {
    const vec2 before = outer[i] - outer[i - 1], after = i + 1 < outer.size() ? outer[i + 1] - outer[i] : before;
    const vec2 along = glm::normalize(glm::normalize(before) + glm::normalize(after));
    const vec2 p = outer[i] - depth * vec2(along.y, -along.x);
    if (p.y <= floor + 1e-4f || p.x < 1.5e-3f) continue;
    if (!curve.empty() && p.y <= curve.back().y + 1e-5f) continue;
    curve.push_back(p);
  }
  return curve;
}

Shape vessel_shape(const Vessel& v) {
  Curve profile = outer_wall(v);
  Curve inner = inside(profile, v.wall, v.floor);
  inner.back().y = profile.back().y;  // a flat rim
  profile.insert(profile.end(), inner.rbegin(), inner.rend());
  profile.emplace_back(0.0f, v.floor);
  return Shape().lathe({}, profile, v.segments, 50.0f);
}

// Returns the liquid, which reaches half way into the wall: so rays hit its surface and the glass's inner surface in
// one order, and no gap of air is between them.
Shape liquid_shape(const Vessel& v, float height) {
  const Curve wall = inside(outer_wall(v), 0.5f * v.wall, v.floor - 0.5f * v.wall);
  Curve profile = {{0, v.floor - 0.5f * v.wall}};
  for (size_t i = 0; i < wall.size(); ++i) {
    if (wall[i].y < height - 5e-4f) {
      profile.push_back(wall[i]);
      continue;
    }
    const vec2 below = profile.back();
    const float t = (height - below.y) / (wall[i].y - below.y);
    profile.push_back(glm::mix(below, wall[i], t));
    break;
  }
  profile.emplace_back(0.0f, height);
  return Shape().lathe({}, profile, v.segments, 50.0f);
}

float fill_height(const Vessel& v, float fill) {
  return v.floor + (v.fill - v.floor) * fill;
}

void add_liquid(Kit& kit, const Vessel& v, const std::string& suffix, vec3 at, uint32_t material, float fill) {
  const int percent = std::clamp(static_cast<int>(std::lround(fill * 10.0f)) * 10, 10, 100);
  const uint32_t mesh = kit.mesh(mesh_name(kit, v, fmt::format(" contents {}", percent)),
                                 [&] { return liquid_shape(v, fill_height(v, 0.01f * static_cast<float>(percent))); });
  kit.b.object("drink" + suffix, mesh, material, glm::dvec3(at));
}

// Returns a label around a third of the bottle, just off the glass.
Shape label_shape(float radius, float low, float high) {
  return Shape().sheet(14, 1, [=](float u, float v) {
    const float angle = glm::radians(-75.0f + 150.0f * u);
    return vec3((radius + 3e-4f) * elementary::sin(angle), glm::mix(low, high, v), (radius + 3e-4f) * elementary::cos(angle));
  });
}

Shape capsule_shape(const Vessel& v, bool cork) {
  const float top = v.outer.back().y, r = v.outer.back().x;
  if (cork)
    return Shape().lathe({},
                         {{0, top - 0.018f},
                          {r - v.wall - 4e-4f, top - 0.018f},
                          {r - v.wall - 4e-4f, top + 0.004f},
                          {r + 0.002f, top + 0.004f},
                          {r + 0.002f, top + 0.016f},
                          {0, top + 0.017f}},
                         20);
  return Shape().lathe({},
                       {{r + 0.0004f, top - 0.062f},
                        {r + 0.001f, top - 0.018f},
                        {r + 0.002f, top - 0.016f},
                        {r + 0.002f, top + 0.0008f},
                        {0, top + 0.001f}},
                       20);
}

}  // namespace

void add_glass(Kit& kit, Glass glass, const std::string& suffix, vec3 at, int drink, float fill) {
  const Vessel v = for_distance(kit, vessel(glass));
  const bool cut = glass == Glass::decanter || glass == Glass::snifter || glass == Glass::coupe;
  const uint32_t mesh = kit.mesh(mesh_name(kit, v), [&] { return vessel_shape(v); });
  kit.b.object("glass" + suffix, mesh, cut ? kit.m.crystal : kit.m.clear, glm::dvec3(at));
  if (drink >= 0) add_liquid(kit, v, suffix, at, kit.m.drinks[static_cast<size_t>(drink)], fill);
  if (glass == Glass::tumbler && drink < 0) add_liquid(kit, v, suffix, at, kit.m.water, fill);
  if (glass != Glass::decanter) return;
  const uint32_t stopper = kit.mesh("stopper", [] {
    return Shape().lathe({},
                         {{0, 0.200f},
                          {0.0135f, 0.202f},
                          {0.0150f, 0.229f},
                          {0.008f, 0.234f},
                          {0.020f, 0.246f},
                          {0.024f, 0.262f},
                          {0.016f, 0.280f},
                          {0, 0.286f}},
                         12, 20.0f);
  });
  kit.b.object("stopper" + suffix, stopper, kit.m.crystal, glm::dvec3(at));
}

void add_bottle(Kit& kit, Bottle bottle, const std::string& suffix, vec3 at, int tint, int label, float fill,
                float turn_deg) {
  const Vessel v = for_distance(kit, vessel(bottle));
  const double turn = double{turn_deg};
  const uint32_t mesh = kit.mesh(mesh_name(kit, v), [&] { return vessel_shape(v); });
  kit.b.object("bottle" + suffix, mesh, kit.m.bottle_glass[static_cast<size_t>(tint)], glm::dvec3(at), turn);
  static constexpr int drink_of_tint[] = {0, 2, 1, 3};
  if (fill > 0.0f) add_liquid(kit, v, suffix, at, kit.m.drinks[static_cast<size_t>(drink_of_tint[tint])], fill);
  if (label >= 0 && bottle != Bottle::flask) {
    const uint32_t paper = kit.mesh(fmt::format("{} label", v.name), [&] {
      const bool low = bottle == Bottle::spirit;
      return label_shape(v.outer[5].x, low ? 0.035f : 0.045f, low ? 0.120f : 0.130f);
    });
    kit.b.object("label" + suffix, paper, kit.m.labels[static_cast<size_t>(label)], glm::dvec3(at), turn);
  }
  const bool cork = bottle == Bottle::spirit || bottle == Bottle::flask;
  const uint32_t cap = kit.mesh(fmt::format("{} closure", v.name), [&] { return capsule_shape(v, cork); });
  kit.b.object("closure" + suffix, cap, cork ? kit.m.cork : kit.m.foil, glm::dvec3(at), turn);
}

void add_candle(Kit& kit, const std::string& suffix, vec3 at) {
  const Vessel v = for_distance(kit, vessel(Glass::tumbler));
  const uint32_t mesh = kit.mesh(mesh_name(kit, v), [&] { return vessel_shape(v); });
  const uint32_t wax = kit.mesh(mesh_name(kit, v, " wax"), [&] { return liquid_shape(v, 0.036f); });
  const uint32_t flame = kit.mesh("flame", [] {
    return Shape().lathe(
        {}, {{0, 0.040f}, {0.0035f, 0.043f}, {0.0055f, 0.050f}, {0.0044f, 0.060f}, {0.002f, 0.069f}, {0, 0.076f}}, 12,
        180.0f);
  });
  const uint32_t wick = kit.mesh("wick", [] { return Shape().cylinder({0, 0.034f, 0}, 0.0008f, 0.010f, 6); });
  kit.b.object("votive" + suffix, mesh, kit.m.shade_glass, glm::dvec3(at));
  kit.b.object("wax" + suffix, wax, kit.m.wax, glm::dvec3(at));
  kit.b.object("wick" + suffix, wick, kit.m.iron, glm::dvec3(at));
  kit.b.object("flame" + suffix, flame, kit.m.flame, glm::dvec3(at));
  kit.candles.push_back(at);
}

}  // namespace sideray::scenes::bistro
