#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/forest.h"
#include "scenes/builtin/paint.h"

namespace sideray::scenes::forest {
namespace {

using glm::vec2;
using glm::vec3;

vec3 around(float turn) {
  return {elementary::cos(turn), 0, elementary::sin(turn)};
}

// Adds a branch that thins out along a curved axis from `a` to `b`.
void add_limb(Shape& shape, vec3 a, vec3 b, float radius_a, float radius_b, vec3 bend, uint32_t sides, uint32_t rows,
              vec2 uv_scale) {
  const vec3 along = glm::normalize(b - a);
  const vec3 side = glm::normalize(glm::cross(along, std::abs(along.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0)));
  const vec3 other = glm::cross(side, along);
  shape.sheet(
      sides, rows,
      [=](float u, float v) {
        const float turn = -glm::two_pi<float>() * u, flare = 1.0f + 0.8f * elementary::exp(-9.0f * v) * (radius_a > 0.1f);
        const vec3 axis = glm::mix(a, b, v) + bend * (4.0f * v * (1.0f - v));
        return axis + (side * elementary::cos(turn) + other * elementary::sin(turn)) * (glm::mix(radius_a, radius_b, v) * flare);
      },
      uv_scale);
}

// Builds a mesh of leaf cards with the normals of the whole crown, so that it is lit as one body.
class Crown {
 public:
  // Adds a card from `root` along `up`; `across` is its half width.
  void card(vec3 root, vec3 up, vec3 across, vec3 normal) {
    vec3 corners[4] = {root - across, root + across, root + across + up, root - across + up};
    vec2 uvs[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    if (glm::dot(glm::cross(across, up), normal) < 0.0f) {
      std::swap(corners[0], corners[1]), std::swap(corners[2], corners[3]);
      std::swap(uvs[0], uvs[1]), std::swap(uvs[2], uvs[3]);
    }
    const auto first = static_cast<uint32_t>(mesh_.positions.size() / 3);
    for (int i = 0; i < 4; ++i) {
      for (int c = 0; c < 3; ++c) mesh_.positions.push_back(corners[i][c]), mesh_.normals.push_back(normal[c]);
      mesh_.uv0.push_back(uvs[i].x), mesh_.uv0.push_back(uvs[i].y);
    }
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh_.indices.push_back(first + i);
  }
  Mesh take(std::string name) {
    mesh_.name = std::move(name);
    return std::move(mesh_);
  }

 private:
  Mesh mesh_;
};

// Draws random numbers in sequence. Two of them must not be arguments of one call: the compiler chooses their order.
struct Numbers {
  uint32_t seed, next = 0;
  float in(float low, float high) { return low + (high - low) * hash01(seed, next++, 40); }
  vec3 direction() {
    const float y = in(-1, 1), turn = in(0, glm::two_pi<float>()), r = std::sqrt(1 - y * y);
    return {r * elementary::cos(turn), y, r * elementary::sin(turn)};
  }
  // Returns a point at height `y`, up to `most` off the axis in x and z.
  vec3 off_axis(float most, float y) {
    const float z = in(-most, most), x = in(-most, most);
    return {x, y, z};
  }
};

// Adds cards in an ellipsoid, most of them near its surface.
void add_ball(Crown& crown, Numbers& n, vec3 center, vec3 radii, uint32_t cards, float size, vec3 body) {
  for (uint32_t i = 0; i < cards; ++i) {
    const vec3 d = n.direction();
    const vec3 at = center + radii * d * elementary::cbrt(n.in(0.25f, 1.0f));
    const vec3 normal = glm::normalize(0.75f * glm::normalize(at - body) + 0.35f * d + vec3(0, 0.3f, 0));
    const vec3 up = glm::normalize(0.8f * d + 0.8f * n.direction() + vec3(0, 0.15f, 0));
    const vec3 across = glm::normalize(glm::cross(up, n.direction() + vec3(0.01f, 0.02f, 0.03f)));
    const float s = size * n.in(0.75f, 1.25f);
    crown.card(at - 0.4f * s * up, s * up, 0.5f * s * across, normal);
  }
}

struct TreeShape {
  float height, trunk_radius, crown_from, crown_radius;
  uint32_t limbs, cards_a_limb;
  float card_size, rise;  // of limbs, as a share of their length
};

void grow_broadleaf(const TreeShape& t, uint32_t seed, Shape& trunk, Crown& crown) {
  Numbers n{seed};
  const vec3 top = n.off_axis(0.3f, 0.86f * t.height);
  const vec3 bend = n.off_axis(0.15f, 0);
  add_limb(trunk, {0, -0.3f, 0}, top, t.trunk_radius, 0.12f * t.trunk_radius, bend, 10, 10, {2, 0.5f * t.height});
  const vec3 body(0, 0.5f * (t.crown_from + 1.0f) * t.height, 0);
  for (uint32_t i = 0; i < t.limbs; ++i) {
    const float share = (static_cast<float>(i) + 0.5f) / static_cast<float>(t.limbs);
    const float v = t.crown_from + (0.97f - t.crown_from) * share;
    const float reach =
        t.crown_radius * std::sqrt(std::max(elementary::sin(glm::pi<float>() * (0.22f + 0.74f * share)), 0.1f));
    const vec3 out = around(2.39996f * static_cast<float>(i) + n.in(-0.3f, 0.3f));
    const vec3 from = glm::mix(vec3(0, -0.3f, 0), top, v * 0.92f) + bend * (4 * v * (1 - v));
    const vec3 to = from + 0.72f * reach * (out + vec3(0, t.rise, 0));
    add_limb(trunk, from, to, 0.32f * t.trunk_radius * (1.2f - share), 0.012f, {0, 0.06f * reach, 0}, 5, 4, {1, 1.5f});
    const float ball = 0.46f * t.crown_radius * n.in(0.8f, 1.15f);
    add_ball(crown, n, to, vec3(ball, 0.72f * ball, ball), t.cards_a_limb, t.card_size, body);
  }
  add_ball(crown, n, top, vec3(0.4f * t.crown_radius), t.cards_a_limb, t.card_size, body);
}

void grow_conifer(float height, uint32_t seed, Shape& trunk, Crown& crown) {
  Numbers n{seed};
  add_limb(trunk, {0, -0.3f, 0}, {0, height, 0}, 0.17f, 0.015f, vec3(0), 9, 8, {2, 0.5f * height});
  constexpr uint32_t tiers = 17;
  for (uint32_t tier = 0; tier < tiers; ++tier) {
    const float share = static_cast<float>(tier) / tiers, y = height * (0.14f + 0.86f * share);
    const float reach = 1.75f * elementary::pow(1.0f - share, 0.85f) + 0.15f;
    const uint32_t boughs = 6 + static_cast<uint32_t>(7.0f * (1.0f - share));
    for (uint32_t i = 0; i < boughs; ++i) {
      const vec3 out =
          around(glm::two_pi<float>() * (static_cast<float>(i) + n.in(0, 0.7f)) / static_cast<float>(boughs));
      const vec3 along = glm::normalize(out + vec3(0, 0.35f * share - 0.32f + n.in(-0.08f, 0.08f), 0));
      const vec3 side(-out.z, 0, out.x), normal = glm::normalize(out + vec3(0, 0.9f, 0));
      const float length = reach * n.in(0.85f, 1.15f);
      const vec3 lifted = glm::normalize(side + vec3(0, n.in(-0.35f, 0.35f), 0));
      crown.card({0, y, 0}, length * along, 0.36f * length * lifted, normal);
      crown.card(vec3(0, y, 0) + 0.25f * length * along, 0.8f * length * along,
                 0.2f * length * glm::normalize(vec3(0, 1, 0) + 0.4f * side), normal);
    }
  }
}

Mesh grow_bush(uint32_t seed) {
  Numbers n{seed};
  Crown crown;
  for (int i = 0; i < 5; ++i) {
    const float z = n.in(-0.45f, 0.45f), y = n.in(0.3f, 0.55f), x = n.in(-0.45f, 0.45f);
    add_ball(crown, n, {x, y, z}, vec3(0.42f, 0.36f, 0.42f), 30, 0.34f, {0, 0.1f, 0});
  }
  return crown.take("bush");
}

// Returns fronds that rise and bend over; for grass, cards that lean.
Mesh grow_tuft(const std::string& name, uint32_t seed, uint32_t count, float radius, float length, float half_width,
               float bend) {
  Numbers n{seed};
  Crown crown;
  for (uint32_t i = 0; i < count; ++i) {
    const float turn = 2.39996f * static_cast<float>(i) + n.in(-0.4f, 0.4f);
    const vec3 out = around(turn), side(-out.z, 0, out.x);
    const float r = radius * std::sqrt((static_cast<float>(i) + 0.5f) / static_cast<float>(count));
    const vec3 at = r * around(turn + 2.0f * bend * n.in(-1, 1)) - vec3(0, 0.03f, 0);
    const float s = length * n.in(0.75f, 1.2f), lean = bend * n.in(0.6f, 1.2f);
    const vec3 up = s * glm::normalize(out * lean + vec3(0, 1, 0));
    const vec3 normal = glm::normalize(vec3(0, 1, 0) + 0.35f * out);
    crown.card(at, up, half_width * side, normal);
  }
  return crown.take(name);
}

sideray_material_desc leaf_material(uint32_t texture, vec3 behind, float share) {
  sideray_material_desc d = opaque_material(vec3(1), 0.62f);
  d.base_color_texture.texture = texture;
  d.base_color_texture.wrap_u = d.base_color_texture.wrap_v = SIDERAY_CLAMP;
  d.alpha_mode = SIDERAY_MASK;
  d.alpha_cutoff = 0.35f;
  d.double_sided = 1;
  d.specular = 0.5f;
  d.diffuse_transmission = share;
  for (int c = 0; c < 3; ++c) d.diffuse_transmission_color[c] = behind[c];
  return d;
}

sideray_wind_desc breeze(float height, float sway, float branches, float leaves, float hertz) {
  sideray_wind_desc d = sideray_wind_defaults();
  d.height = height;
  d.amplitude = sway, d.frequency = hertz;
  d.branch_amplitude = branches, d.branch_frequency = 2.3f * hertz;
  d.leaf_amplitude = leaves, d.leaf_frequency = 1.9f;
  d.wavelength = 0.6f * height;
  return d;
}

struct SpeciesMaker {
  ContentBuilder& b;
  uint32_t seed;
  std::vector<Species> made = {};

  uint32_t bark(const std::string& name, uint32_t texture) const {
    sideray_material_desc d = opaque_material(vec3(1), 0.9f);
    d.base_color_texture.texture = texture;
    return b.material(name, d);
  }
  void broadleaf(const std::string& name, float share, const TreeShape& shape, uint32_t wood, uint32_t leaves) {
    Shape trunk;
    Crown crown;
    grow_broadleaf(shape, seed + static_cast<uint32_t>(made.size()), trunk, crown);
    tree(name, share, trunk, crown, shape.height, wood, leaves);
  }
  void tree(const std::string& name, float share, const Shape& trunk, Crown& crown, float height, uint32_t wood,
            uint32_t leaves) {
    const uint32_t trunk_mesh = b.mesh(trunk, name + " trunk"), crown_mesh = b.mesh(crown.take(name + " leaves"));
    made.push_back({Kind::tree,
                    share,
                    {{name, trunk_mesh, wood, false}, {name + "+", crown_mesh, leaves, true}},
                    breeze(height, 0.035f * height, 0.05f, 0.02f, 0.22f)});
  }
  void plant(Kind kind, const std::string& name, float share, Mesh mesh, uint32_t material,
             const sideray_wind_desc& wind) {
    made.push_back({kind, share, {{name, b.mesh(std::move(mesh)), material, true}}, wind});
  }
};

}  // namespace

std::vector<Species> make_species(ContentBuilder& b, const Textures& t, uint32_t seed) {
  SpeciesMaker maker{b, seed};
  const uint32_t bark = maker.bark("bark", t.bark), birch_bark = maker.bark("birch bark", t.birch_bark);
  const vec3 sunny(0.62f, 0.74f, 0.22f);
  const auto leaves = [&](const char* name, uint32_t texture, float share) {
    return b.material(name, leaf_material(texture, sunny, share));
  };
  const uint32_t oak_leaves = leaves("oak leaves", t.oak, 0.3f), birch_leaves = leaves("birch leaves", t.birch, 0.4f);
  maker.broadleaf("oak", 0.30f, {7.0f, 0.26f, 0.36f, 2.5f, 15, 34, 0.52f, 0.45f}, bark, oak_leaves);
  maker.broadleaf("beech", 0.20f, {8.5f, 0.22f, 0.40f, 2.1f, 15, 32, 0.50f, 0.65f}, bark, oak_leaves);
  maker.broadleaf("birch", 0.27f, {7.6f, 0.11f, 0.34f, 1.45f, 16, 26, 0.38f, 0.75f}, birch_bark, birch_leaves);
  Shape trunk;
  Crown crown;
  grow_conifer(8.2f, seed + 9, trunk, crown);
  maker.tree("spruce", 0.23f, trunk, crown, 8.2f, bark, leaves("needles", t.needles, 0.1f));
  const sideray_wind_desc low = breeze(0.9f, 0.03f, 0.025f, 0.010f, 0.5f);
  maker.plant(Kind::bush, "bush", 0.55f, grow_bush(seed + 20), leaves("bush leaves", t.bush, 0.3f), low);
  maker.plant(Kind::bush, "fern", 0.45f, grow_tuft("fern", seed + 21, 13, 0.06f, 0.95f, 0.24f, 1.1f),
              leaves("fern", t.fern, 0.4f), low);
  const uint32_t grass = leaves("grass", t.grass, 0.35f);
  const sideray_wind_desc blades = breeze(0.5f, 0.06f, 0.0f, 0.006f, 0.7f);
  maker.plant(Kind::grass, "grass", 0.55f, grow_tuft("grass", seed + 30, 14, 0.48f, 0.42f, 0.34f, 0.35f), grass,
              blades);
  maker.plant(Kind::grass, "tall grass", 0.33f, grow_tuft("tall grass", seed + 31, 11, 0.36f, 0.66f, 0.30f, 0.25f),
              grass, blades);
  maker.plant(Kind::grass, "flowers", 0.12f, grow_tuft("flowers", seed + 32, 8, 0.34f, 0.52f, 0.30f, 0.25f),
              leaves("flowers", t.flowers, 0.3f), blades);
  return std::move(maker.made);
}

}  // namespace sideray::scenes::forest
