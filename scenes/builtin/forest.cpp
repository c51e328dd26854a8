#include "scenes/builtin/forest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/builtin_scenes.h"
#include "scenes/builtin/paint.h"
#include "scenes/content/rotation.h"

namespace sideray::scenes {
namespace {

using namespace forest;
using glm::vec2;
using glm::vec3;

constexpr float pond_radius = 4.2f, water_y = -0.2f;
constexpr vec2 wall_low(1.5f, -8.3f), wall_high(9.5f, -8.0f);  // x and z
constexpr float wall_height = 2.6f;
constexpr vec2 viewpoint(-2.4f, 12.5f);
constexpr uint32_t yaws = 4;  // rotations of plants; each needs its own wind in object space

// Returns the distance from the middle of the pond, 1 at its shore.
float shore(vec2 p) {
  const float turn = elementary::atan2(p.y, p.x);
  return glm::length(p * vec2(0.8f, 1.1f)) / (pond_radius * (1.0f + 0.08f * elementary::sin(3.0f * turn + 0.7f)));
}

float ground(vec2 p) {
  const float hills = 1.5f * (fractal_noise(p / 1600.0f + 0.5f, 64, 3, 5) - 0.5f);
  const float far = glm::smoothstep(6.0f, 18.0f, glm::length(p));
  const float basin = 1.0f - glm::smoothstep(0.55f, 1.25f, shore(p));
  return far * hills - 0.75f * basin;
}

bool is_by_wall(vec2 p, float margin) {
  return p.x > wall_low.x - margin && p.x < wall_high.x + margin && p.y > wall_low.y - margin &&
         p.y < wall_high.y + margin;
}

float distance_to_segment(vec2 p, vec2 a, vec2 b) {
  const float t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0f, 1.0f);
  return glm::length(p - glm::mix(a, b, t));
}

bool grows(Kind kind, vec2 p) {
  if (kind == Kind::grass) return shore(p) > 1.08f && !is_by_wall(p, 0.3f);
  if (is_by_wall(p, kind == Kind::tree ? 2.6f : 0.8f)) return false;
  const float view = std::min(distance_to_segment(p, viewpoint, {0, 0}), distance_to_segment(p, {0.5f, 1}, {5, -8}));
  if (kind == Kind::bush) return shore(p) > 1.25f && view > 1.3f && glm::length(p - viewpoint) > 2.0f;
  return shore(p) > 1.9f && view > 3.4f && glm::length(p - viewpoint) > 4.0f;
}

struct Plant {
  Kind kind;
  vec2 at;
  uint32_t key;  // of its random numbers
};

vec2 cell_of(uint32_t morton) {
  const auto even = [](uint32_t v) {
    v &= 0x55555555u;
    v = (v | v >> 1) & 0x33333333u;
    v = (v | v >> 2) & 0x0f0f0f0fu;
    v = (v | v >> 4) & 0x00ff00ffu;
    return (v | v >> 8) & 0x0000ffffu;
  };
  return {static_cast<float>(even(morton)), static_cast<float>(even(morton >> 1))};
}

// Returns `count` plants at jittered places in the cells of a square. Cells are in the order of a curve that keeps
// neighbours together, so that a picture sees few runs of a species' instances. Places where nothing grows are skipped,
// and the rest is thinned evenly.
std::vector<Plant> place_plants(uint32_t count, uint32_t seed) {
  const float side = std::max(26.0f, 0.8f * std::sqrt(static_cast<float>(count)));
  for (uint32_t bits = 2;; ++bits) {
    const uint32_t cells = 1u << (2 * bits);
    if (cells < count) continue;
    const float size = side / static_cast<float>(1u << bits);
    std::vector<Plant> plants;
    for (uint32_t i = 0; i < cells; ++i) {
      const vec2 at = (cell_of(i) + vec2(hash01(i, seed, 1), hash01(i, seed, 2))) * size - 0.5f * side + vec2(0, -1.5f);
      const float pick = hash01(i, seed, 3);
      Kind kind = pick < 0.06f ? Kind::tree : pick < 0.17f ? Kind::bush : Kind::grass;
      if (!grows(kind, at)) kind = Kind::grass;
      if (grows(kind, at)) plants.push_back({kind, at, i});
    }
    if (plants.size() < count) continue;
    std::vector<Plant> kept;
    for (uint64_t i = 0; i < count; ++i) kept.push_back(plants[i * plants.size() / count]);
    return kept;
  }
}

// Returns the plants whose shadows fall on the wall, and those that frame the picture.
std::vector<Plant> chosen_plants() {
  std::vector<Plant> plants;
  for (const vec2 at : {vec2(7.6f, -5.2f), vec2(11.2f, -5.4f), vec2(-7.2f, 2.5f), vec2(8.6f, 3.4f)})
    plants.push_back({Kind::tree, at, 0x40000000u + static_cast<uint32_t>(plants.size())});
  for (const vec2 at : {vec2(3.4f, 5.4f), vec2(-4.9f, 5.6f), vec2(2.2f, -7.2f), vec2(5.9f, 1.6f)})
    plants.push_back({Kind::bush, at, 0x40000000u + static_cast<uint32_t>(plants.size())});
  return plants;
}

class Planting {
 public:
  Planting(ContentBuilder& b, std::vector<Species> species, uint32_t seed)
      : b_(b), species_(std::move(species)), seed_(seed) {
    const float blows = 0.6f;  // radians from +x toward +z
    for (const Species& s : species_)
      for (const bool has_leaves : {false, true})
        for (uint32_t yaw = 0; yaw < yaws; ++yaw) {
          sideray_wind_desc wind = s.wind;
          if (!has_leaves) wind.leaf_amplitude = 0;
          // In the space of a plant turned about +y by the yaw, the wind is turned the other way.
          const float angle = blows + turn(yaw);
          wind.direction[0] = elementary::cos(angle), wind.direction[1] = 0, wind.direction[2] = elementary::sin(angle);
          winds_.push_back(b_.wind(wind));
        }
  }

  void add(const Plant& plant) {
    const uint32_t chosen = choose(plant.kind, random(plant, 4));
    const auto yaw = std::min(static_cast<uint32_t>(random(plant, 5) * yaws), yaws - 1);
    const float size = 0.75f + 0.5f * random(plant, 6);
    glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(plant.at.x, ground(plant.at), plant.at.y));
    m = rotated(m, double{turn(yaw)}, glm::dvec3(0, 1, 0));
    m = glm::scale(m, glm::dvec3(double{size}));
    for (const Part& part : species_[chosen].parts)
      b_.object(part.name, part.mesh, part.material, m, winds_[(chosen * 2 + (part.has_leaves ? 1 : 0)) * yaws + yaw],
                random(plant, 7));
  }

 private:
  static float turn(uint32_t yaw) { return glm::two_pi<float>() * (static_cast<float>(yaw) + 0.15f) / yaws; }
  float random(const Plant& plant, uint32_t salt) const { return hash01(plant.key, seed_, salt); }
  uint32_t choose(Kind kind, float random) const {
    uint32_t last = 0;
    for (uint32_t i = 0; i < species_.size(); ++i) {
      if (species_[i].kind != kind) continue;
      last = i;
      random -= species_[i].share;
      if (random < 0.0f) break;
    }
    return last;
  }

  ContentBuilder& b_;
  std::vector<Species> species_;
  uint32_t seed_;
  std::vector<uint32_t> winds_;  // for each species: those of trunk and leaves in each rotation
};

Texel ground_texel(vec2 uv) {
  const float large = fractal_noise(uv, 4, 5, 71), fine = fractal_noise(uv, 32, 3, 72);
  Texel t;
  t.color = glm::mix(vec3(0.43f, 0.36f, 0.25f), vec3(0.40f, 0.47f, 0.21f), glm::smoothstep(0.35f, 0.6f, large)) *
            (0.7f + 0.6f * fine);
  return t;
}

Texel wall_texel(vec2 uv) {
  const float stain = fractal_noise(uv, 4, 5, 81), fine = fractal_noise(uv, 48, 3, 82);
  Texel t;
  t.color = glm::mix(vec3(0.86f, 0.80f, 0.70f), vec3(0.72f, 0.66f, 0.57f), glm::smoothstep(0.45f, 0.75f, stain)) *
            (0.92f + 0.16f * fine);
  return t;
}

void add_ground(ContentBuilder& b, float half_side) {
  Shape land = Shape().sheet(220, 220, [=](float u, float v) {
    // The grid is finer toward the middle, where the pond is.
    const auto at = [=](float t) { return half_side * (0.35f * t + 0.65f * t * t * t); };
    const vec2 p(at(2 * u - 1), -at(2 * v - 1));
    return vec3(p.x, ground(p), p.y);
  });
  land.uv_from_above(0.22f);
  sideray_material_desc soil = opaque_material(vec3(1), 0.95f);
  soil.base_color_texture.texture = paint_image(b, "ground", 512, 512, ground_texel);
  b.object("ground", b.mesh(land, "ground"), b.material("ground", soil));
}

void add_pond_and_wall(ContentBuilder& b) {
  sideray_material_desc water = opaque_material({0.012f, 0.022f, 0.018f}, 0.04f);
  const float w = 1.5f * pond_radius;
  const Shape surface = Shape().quad({-w, water_y, w}, {w, water_y, w}, {w, water_y, -w}, {-w, water_y, -w});
  b.object("pond", b.mesh(surface, "pond"), b.material("pond", water));
  sideray_material_desc plaster = opaque_material(vec3(1), 0.85f);
  plaster.base_color_texture.texture = paint_image(b, "wall", 512, 512, wall_texel);
  const vec3 low(wall_low.x, -1.0f, wall_low.y), high(wall_high.x, wall_height, wall_high.y);
  b.object("wall", b.mesh(Shape().bevelled_box(low, high, 0.03f, 0.3f), "wall"), b.material("wall", plaster));
  const Shape top = Shape().bevelled_box({low.x - 0.1f, wall_height, low.z - 0.1f},
                                         {high.x + 0.1f, wall_height + 0.12f, high.z + 0.1f}, 0.02f);
  b.object("coping", b.mesh(top, "coping"), b.material("coping", opaque_material({0.32f, 0.30f, 0.27f}, 0.8f)));
}

void add_cameras(ContentBuilder& b) {
  struct View {
    const char* name;
    double eye[3], target[3];
    float fov_deg;
  };
  const View views[] = {{"clearing", {double{viewpoint.x}, 2.3, double{viewpoint.y}}, {1.2, 1.25, -2.0}, 50.0f},
                        {"pond", {-3.6, 1.0, 6.4}, {1.0, 0.35, -4.0}, 52.0f},
                        {"wall", {2.6, 1.7, -0.6}, {5.6, 1.35, -8.0}, 50.0f},
                        {"closeup", {2.0, 0.95, 7.4}, {3.5, 0.45, 5.2}, 40.0f}};
  for (const View& v : views) b.camera(v.name, look_at(v.eye, v.target, v.fov_deg));
}

}  // namespace

Content make_forest(const Numbers& numbers) {
  const auto count = static_cast<uint32_t>(numbers.whole_in_range("count", 0, 1000000));
  const auto seed = static_cast<uint32_t>(numbers.whole_in_range("seed", 0, 1000000));
  ContentBuilder b("forest");
  add_ground(b, 0.5f * std::max(26.0f, 0.8f * std::sqrt(static_cast<float>(count))) + 25.0f);
  add_pond_and_wall(b);
  Planting planting(b, make_species(b, paint_textures(b), seed), seed);
  const std::vector<Plant> chosen = chosen_plants();
  const auto first = static_cast<uint32_t>(std::min<size_t>(count, chosen.size()));
  for (uint32_t i = 0; i < first; ++i) planting.add(chosen[i]);
  for (const Plant& plant : place_plants(count - first, seed)) planting.add(plant);
  b.light("sun", sun_light({-0.72f, -0.58f, -0.38f}, {3.6f, 3.3f, 2.8f}));
  add_cameras(b);
  return b.take();
}

}  // namespace sideray::scenes
