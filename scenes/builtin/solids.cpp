#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/builtin_scenes.h"
#include "scenes/content/shapes.h"

namespace sideray::scenes {
namespace {

// The glass of every solid in the scene.
struct Glass {
  float ior, roughness, dispersion, film;
  sideray_material_desc solid(glm::vec3 tint, float distance, float thickness) const {
    sideray_material_desc d = glass_material(glm::vec3(1.0f), roughness);
    d.ior = ior;
    d.dispersion = dispersion;
    if (film > 0.0f) d.iridescence = 1.0f, d.iridescence_ior = 2.0f, d.iridescence_thickness_max = film;
    d.thickness = thickness;
    d.attenuation_distance = distance;
    for (int c = 0; c < 3; ++c) d.attenuation_color[c] = tint[c];
    return d;
  }
};

// Returns a lens: two caps of spheres of `radius` that meet in a circle about +Y.
Shape lens(float radius, float aperture, uint32_t segments) {
  constexpr int rings = 24;
  const float edge = elementary::asin(aperture / radius), middle = radius * elementary::cos(edge);
  std::vector<glm::vec2> profile;
  for (int side : {-1, 1})
    for (int i = side < 0 ? 0 : 1; i <= rings; ++i) {
      const int k = side < 0 ? i : rings - i;
      const float a = edge * static_cast<float>(k) / rings;
      const float height = radius * elementary::cos(a) - middle;
      profile.emplace_back(k == 0 ? 0.0f : radius * elementary::sin(a), static_cast<float>(side) * height);
    }
  return Shape().lathe(glm::vec3(0), profile, segments, 10.0f);
}

struct Tumbler {
  float radius = 0.34f, height = 0.95f, wall = 0.03f, base = 0.08f;
  Shape glass(uint32_t segments) const {
    const float inner = radius - wall;
    return Shape().lathe(glm::vec3(0),
                         {{0, 0}, {radius, 0}, {radius, height}, {inner, height}, {inner, base}, {0, base}}, segments);
  }
  // Returns the liquid, which reaches `overlap` into wall and bottom.
  Shape liquid(float fill, float overlap, uint32_t segments) const {
    const float r = radius - wall + overlap, low = base - overlap, top = base + fill * (height - base);
    return Shape().lathe(glm::vec3(0), {{0, low}, {r, low}, {r, top}, {0, top}}, segments);
  }
};

void add_room(ContentBuilder& b) {
  sideray_material_desc floor = opaque_material(glm::vec3(1), 0.8f), wall = floor;
  floor.base_color_texture.texture = b.checker("floor pattern", {206, 200, 188}, {92, 98, 108}, 8);
  wall.base_color_texture.texture = b.checker("wall pattern", {214, 190, 150}, {64, 100, 140}, 8);
  b.object("floor", b.mesh(Shape().quad({-5, 0, 4}, {5, 0, 4}, {5, 0, -3}, {-5, 0, -3}, glm::vec2(3, 2)), "floor"),
           b.material("floor", floor));
  b.object("wall", b.mesh(Shape().quad({-5, 0, -3}, {5, 0, -3}, {5, 3, -3}, {-5, 3, -3}, glm::vec2(3, 1)), "wall"),
           b.material("wall", wall));
}

}  // namespace

Content make_solids(const Numbers& numbers) {
  const auto segments = static_cast<uint32_t>(numbers.whole_in_range("segments", 8, 4096));
  const auto fill = static_cast<float>(numbers.in_range("fill", 0, 1));
  const auto overlap = static_cast<float>(numbers.in_range("overlap", -0.02, 0.02));
  const Glass glass{static_cast<float>(numbers.in_range("ior", 1, 3)),
                    static_cast<float>(numbers.in_range("roughness", 0, 1)),
                    static_cast<float>(numbers.in_range("dispersion", 0, 10)),
                    static_cast<float>(numbers.in_range("film", 0, 10000))};
  const Glass water{static_cast<float>(numbers.in_range("liquid_ior", 1, 3)), 0.0f, 0.0f, 0.0f};
  ContentBuilder b("solids");
  add_room(b);
  const uint32_t clear = b.material("clear glass", glass.solid({0.86f, 0.96f, 0.92f}, 1.0f, 0.5f), RayTraced::yes);
  const uint32_t green = b.material("green glass", glass.solid({0.35f, 0.85f, 0.5f}, 0.8f, 0.4f), RayTraced::yes);
  const uint32_t thin = b.material("tumbler glass", glass.solid({0.9f, 0.97f, 0.95f}, 0.3f, 0.03f), RayTraced::yes);
  const uint32_t drink = b.material("liquid", water.solid({0.9f, 0.45f, 0.12f}, 0.4f, 0.5f), RayTraced::yes);
  const uint32_t block = b.material("single quad", glass.solid(glm::vec3(1), INFINITY, 0.1f), RayTraced::yes);

  b.object("ball", b.mesh(Shape().sphere(glm::vec3(0), 0.5f, segments), "ball"), clear, {-1.75, 0.501, 0.1});
  b.object("cube", b.mesh(Shape().box({-0.35f, 0, -0.35f}, {0.35f, 0.7f, 0.35f}), "cube"), green, {-0.6, 0.001, -0.2},
           32);
  const Tumbler tumbler;
  b.object("tumbler", b.mesh(tumbler.glass(segments), "tumbler"), thin, {0.4, 0.001, 0.3});
  if (fill > 0.0f)
    b.object("liquid", b.mesh(tumbler.liquid(fill, overlap, segments), "liquid"), drink, {0.4, 0.001, 0.3});
  const glm::dmat4 upright(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 1.3, 0.55, -0.2, 1);
  b.object("lens", b.mesh(lens(1.1f, 0.5f, segments), "lens"), clear, upright);
  b.object("single quad", b.mesh(Shape().quad({-0.4f, 0, 0}, {0.4f, 0, 0}, {0.4f, 1, 0}, {-0.4f, 1, 0}), "single quad"),
           block, {2.3, 0.001, 0.0}, -30);
  b.light("sun", sun_light({-0.4f, -0.8f, -0.45f}, glm::vec3(3.0f)));
  const double eye[3] = {0.2, 1.3, 4.6}, target[3] = {0.15, 0.5, 0};
  b.camera("view", look_at(eye, target, 36.0f));
  return b.take();
}

}  // namespace sideray::scenes
