#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/bistro/bistro.h"
#include "scenes/content/rotation.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec3;

// Returns a blade that starts at the origin, bends over along +z and ends with its tip down.
Shape blade(float length, float width) {
  return Shape().sheet(6, 12, [=](float u, float v) {
    const float across = u - 0.5f, taper = elementary::pow(elementary::sin(glm::pi<float>() * (0.06f + 0.92f * v)), 0.75f);
    const float bend = 1.15f * v;
    const float z = length * elementary::sin(bend) / 1.15f, y = length * (0.35f * v - 0.55f * (1.0f - elementary::cos(bend)));
    return vec3(-width * taper * across, y + 0.25f * width * taper * 4.0f * across * across, z);
  });
}

}  // namespace

void add_plant(Kit& kit, const std::string& suffix, vec3 at, float height, uint32_t leaves) {
  const glm::dvec3 place(at);
  const uint32_t pot = kit.mesh("pot", [] {
    return Shape().lathe({},
                         {{0, 0},
                          {0.11f, 0},
                          {0.115f, 0.01f},
                          {0.155f, 0.24f},
                          {0.168f, 0.24f},
                          {0.170f, 0.29f},
                          {0.152f, 0.29f},
                          {0.145f, 0.255f},
                          {0, 0.255f}},
                         40);
  });
  const uint32_t soil = kit.mesh("soil", [] { return Shape().lathe({}, {{0.147f, 0.262f}, {0, 0.275f}}, 24); });
  kit.b.object("pot" + suffix, pot, kit.m.terracotta, place);
  kit.b.object("soil" + suffix, soil, kit.m.soil, place);
  Shape stems, crown;
  const Shape leaf = blade(0.42f, 0.10f);
  const uint32_t salt = static_cast<uint32_t>(std::lround(height * 1000.0f));
  for (uint32_t i = 0; i < leaves; ++i) {
    const float turn = 2.39996f * static_cast<float>(i) + kit.random(salt, i);
    const float share = (static_cast<float>(i) + 0.5f) / static_cast<float>(leaves);
    const float y = 0.27f + (height - 0.27f) * (0.25f + 0.75f * share) * (0.85f + 0.15f * kit.random(salt, 100 + i));
    const float lean = 0.16f * (1.0f - 0.6f * share);
    const vec3 tip(lean * elementary::sin(turn), y, lean * elementary::cos(turn));
    stems.tube({{0.01f * elementary::sin(turn), 0.26f, 0.01f * elementary::cos(turn)},
                vec3(0.4f * tip.x, 0.5f * (y + 0.26f), 0.4f * tip.z),
                tip},
               0.005f, 6, 3);
    const float size = 0.75f + 0.5f * kit.random(salt, 200 + i);
    glm::mat4 to_tip = glm::translate(glm::mat4(1.0f), tip);
    to_tip = rotated(to_tip, turn, vec3(0, 1, 0));
    to_tip = rotated(to_tip, -0.5f - 0.9f * share + 0.3f * kit.random(salt, 300 + i), vec3(1, 0, 0));
    crown.append(leaf, glm::scale(to_tip, vec3(size)));
  }
  kit.b.object("stems" + suffix, kit.b.mesh(stems, "stems" + suffix), kit.m.stem, place);
  kit.b.object("leaves" + suffix, kit.b.mesh(crown, "leaves" + suffix), kit.m.leaf, place);
}

}  // namespace sideray::scenes::bistro
