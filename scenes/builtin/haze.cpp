#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "scenes/builtin/builtin_scenes.h"
#include "scenes/builtin/paint.h"
#include "scenes/content/shapes.h"

namespace sideray::scenes {
namespace {

using glm::vec2, glm::vec3;

// Paints the normal map of a surface whose slopes across and down the image are slope(uv).
uint32_t paint_normals(ContentBuilder& b, const std::string& name, uint32_t size,
                       const std::function<vec2(vec2 uv)>& slope) {
  Texture texture;
  texture.name = name;
  texture.width = texture.height = size;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const vec2 s = slope((vec2(x, y) + 0.5f) / static_cast<float>(size));
      // Green points up the image.
      const vec3 n = glm::normalize(vec3(-s.x, s.y, 1.0f));
      for (int c = 0; c < 3; ++c) texture.rgba.push_back(static_cast<uint8_t>(std::lround(127.5f * (n[c] + 1.0f))));
      texture.rgba.push_back(255);
    }
  return b.texture(std::move(texture));
}

// Returns the slope of rising air: wisps that are longer than wide, none at the image's borders.
vec2 haze_slope(vec2 uv) {
  constexpr float step = 1.0f / 256.0f;
  const auto height = [](vec2 p) {
    const vec2 window(elementary::sin(glm::pi<float>() * p.x), elementary::sin(glm::pi<float>() * p.y));
    return window.x * window.x * window.y * window.y * fractal_noise(glm::fract(vec2(p.x, 0.4f * p.y)), 8, 2, 77);
  };
  const float across = height(uv + vec2(step, 0)) - height(uv - vec2(step, 0));
  const float down = height(uv + vec2(0, step)) - height(uv - vec2(0, step));
  return vec2(across, down) / (2.0f * step) * 0.12f;
}

// Returns the slope of rings about two drops, which fade with the distance.
vec2 ripple_slope(vec2 uv) {
  vec2 sum(0);
  for (const vec2 drop : {vec2(0.35f, 0.4f), vec2(0.7f, 0.65f)}) {
    const vec2 away = uv - drop;
    const float r = std::max(glm::length(away), 1e-3f);
    sum += away / r * (0.25f * elementary::exp(-3.0f * r) * elementary::cos(45.0f * r));
  }
  return sum;
}

vec2 wave_slope(vec2 uv) {
  const float turn = glm::two_pi<float>();
  return {0.30f * elementary::cos(3.0f * turn * uv.x + 1.5f * elementary::sin(turn * uv.y)), 0.18f * elementary::cos(4.0f * turn * uv.y)};
}

void add_room(ContentBuilder& b) {
  sideray_material_desc wall = opaque_material(vec3(1), 0.9f);
  wall.base_color_texture.texture = b.checker("wall pattern", {222, 206, 178}, {52, 84, 108}, 8);
  b.object("wall",
           b.mesh(Shape().quad({-3, 0, -1.1f}, {3, 0, -1.1f}, {3, 2.4f, -1.1f}, {-3, 2.4f, -1.1f}, {4, 1.6f}), "wall"),
           b.material("wall", wall));
  sideray_material_desc table = opaque_material(vec3(1), 0.6f);
  table.base_color_texture.texture = b.checker("table pattern", {146, 96, 58}, {120, 74, 44}, 8);
  b.object("table",
           b.mesh(Shape().quad({-3, 0, 1.5f}, {3, 0, 1.5f}, {3, 0, -1.1f}, {-3, 0, -1.1f}, {3, 1.3f}), "table"),
           b.material("table", table));
}

// Adds a flame behind the air that it heats, and a post in front of it: the haze must not show what is in front of it.
void add_candle(ContentBuilder& b, float strength, const sideray_camera& camera) {
  b.object("candle", b.mesh(Shape().cylinder({0, 0, 0}, 0.06f, 0.42f, 32), "candle"),
           b.material("wax", opaque_material({0.86f, 0.82f, 0.70f}, 0.5f)), {-0.95, 0, 0});
  sideray_material_desc flame = opaque_material(vec3(0), 1.0f);
  flame.unlit = 1;
  const vec3 glow(5.0f, 2.6f, 0.8f);
  for (int c = 0; c < 3; ++c) flame.base_color[c] = 1.0f, flame.emissive[c] = glow[c];
  b.object("flame",
           b.mesh(Shape().lathe({}, {{0, 0}, {0.018f, 0.015f}, {0.022f, 0.04f}, {0.012f, 0.08f}, {0, 0.12f}}, 24, 80),
                  "flame"),
           b.material("flame", flame), {-0.95, 0.43, 0});
  b.light("flame", point_light({-0.95f, 0.52f, 0.05f}, vec3(0.9f, 0.55f, 0.22f), 4.0f));
  // The haze adds no light and hides nothing: it is visible only where it distorts the picture.
  sideray_material_desc haze = opaque_material(vec3(0), 1.0f);
  haze.alpha_mode = SIDERAY_BLEND;
  haze.blend_mode = SIDERAY_BLEND_ADDITIVE;
  haze.unlit = haze.double_sided = 1;
  haze.normal_texture.texture = paint_normals(b, "haze normals", 256, haze_slope);
  haze.normal_texture.wrap_u = haze.normal_texture.wrap_v = SIDERAY_CLAMP;
  haze.distortion = 0.05f * strength;
  // The haze faces the viewer, as sprites do, so that only its wisps distort the picture.
  glm::dmat4 facing(1.0);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) facing[c][r] = camera.world_from_camera[3 * c + r];
  facing[3] = glm::dvec4(-0.95, 0.95, 0.1, 1);
  b.object("haze", b.mesh(Shape().quad({-0.3f, -0.6f, 0}, {0.3f, -0.6f, 0}, {0.3f, 0.6f, 0}, {-0.3f, 0.6f, 0}), "haze"),
           b.material("hot air", haze, RayTraced::no), facing);
  b.object("post", b.mesh(Shape().cylinder({0, 0, 0}, 0.02f, 1.2f, 24), "post"),
           b.material("brass", opaque_material({0.75f, 0.52f, 0.2f}, 0.4f)), {-0.86, 0, 0.3});
}

void add_pane(ContentBuilder& b, float strength) {
  sideray_material_desc glass = glass_material({0.93f, 1.0f, 0.97f}, 0.05f);
  glass.normal_texture.texture = paint_normals(b, "pane normals", 256, wave_slope);
  glass.distortion = 0.06f * strength;
  b.object("pane",
           b.mesh(Shape().quad({-0.42f, 0.02f, 0}, {0.42f, 0.02f, 0}, {0.42f, 1.05f, 0}, {-0.42f, 1.05f, 0}), "pane"),
           b.material("wavy glass", glass, RayTraced::yes), {0.02, 0, 0.15}, 8);
}

void add_basin(ContentBuilder& b, float strength) {
  Shape basin;
  basin.box({-0.5f, 0, -0.4f}, {-0.46f, 0.22f, 0.4f}).box({0.46f, 0, -0.4f}, {0.5f, 0.22f, 0.4f});
  basin.box({-0.5f, 0, -0.4f}, {0.5f, 0.22f, -0.36f}).box({-0.5f, 0, 0.36f}, {0.5f, 0.22f, 0.4f});
  b.object("basin", b.mesh(basin, "basin"), b.material("stone", opaque_material(vec3(0.55f), 0.8f)), {1.05, 0, 0.25});
  sideray_material_desc tiles = opaque_material(vec3(1), 0.5f);
  tiles.base_color_texture.texture = b.checker("tiles", {236, 232, 220}, {40, 120, 128}, 8);
  b.object("tiles",
           b.mesh(Shape().quad({-0.46f, 0.01f, 0.36f}, {0.46f, 0.01f, 0.36f}, {0.46f, 0.01f, -0.36f},
                               {-0.46f, 0.01f, -0.36f}),
                  "tiles"),
           b.material("tiles", tiles), {1.05, 0, 0.25});
  sideray_material_desc water = glass_material({0.85f, 0.97f, 1.0f}, 0.0f);
  water.ior = 1.33f;
  water.normal_texture.texture = paint_normals(b, "water normals", 256, ripple_slope);
  water.distortion = 0.05f * strength;
  b.object("water",
           b.mesh(Shape().quad({-0.46f, 0.17f, 0.36f}, {0.46f, 0.17f, 0.36f}, {0.46f, 0.17f, -0.36f},
                               {-0.46f, 0.17f, -0.36f}),
                  "water"),
           b.material("water", water, RayTraced::yes), {1.05, 0, 0.25});
}

}  // namespace

Content make_haze(const Numbers& numbers) {
  const auto strength = static_cast<float>(numbers.in_range("strength", 0, 10));
  ContentBuilder b("haze");
  const double eye[3] = {0.05, 1.75, 2.6}, target[3] = {0.05, 0.55, 0};
  const sideray_camera camera = look_at(eye, target, 40);
  add_room(b);
  add_candle(b, strength, camera);
  add_pane(b, strength);
  add_basin(b, strength);
  b.light("sun", sun_light({0.35f, -0.8f, -0.5f}, vec3(2.4f)));
  b.camera("front", camera);
  return b.take();
}

}  // namespace sideray::scenes
