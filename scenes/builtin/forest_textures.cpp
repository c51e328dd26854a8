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

struct Leaf {
  vec2 base, tip;  // 0..1, y up
  float width;     // relative to its length
  float shade;     // 0..1
};

// Later leaves cover earlier ones.
Texel leaves_texel(vec2 uv, const std::vector<Leaf>& leaves, vec3 dark, vec3 light) {
  const vec2 p(uv.x, 1.0f - uv.y);
  Texel t;
  t.color = glm::mix(dark, light, 0.4f);
  t.alpha = 0;
  for (const Leaf& leaf : leaves) {
    const vec2 axis = leaf.tip - leaf.base;
    const float length = glm::length(axis);
    const vec2 along = axis / length, from = p - leaf.base;
    const float v = glm::dot(from, along) / length;
    if (v <= 0.0f || v >= 1.0f) continue;
    const float u = (from.x * along.y - from.y * along.x) / length;
    if (std::abs(u) >= 0.5f * leaf.width) continue;  // wider than any leaf is: most texels, without powers
    const float half = 0.5f * leaf.width * elementary::pow(elementary::sin(glm::pi<float>() * elementary::pow(v, 0.8f)), 0.8f);
    const float inside = (half - std::abs(u)) * length * 90.0f;
    if (inside <= 0.0f) continue;
    const float rib = elementary::exp(-900.0f * u * u), vein = 0.5f + 0.5f * elementary::sin(70.0f * (v - 1.2f * std::abs(u)));
    t.alpha = std::max(t.alpha, std::min(inside, 1.0f));
    t.color = glm::mix(dark, light, std::clamp(leaf.shade + 0.12f * vein - 0.06f, 0.0f, 1.0f)) * (1.0f + 0.25f * rib);
  }
  return t;
}

// Returns leaves around a twig up the middle of the image.
std::vector<Leaf> twig(uint32_t count, float length, float width, float spread, uint32_t seed) {
  std::vector<Leaf> leaves{{{0.5f, 0.0f}, {0.5f, 0.8f}, 0.025f, 0.15f}};
  for (uint32_t i = 0; i < count; ++i) {
    const float share = (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
    const float side = i % 2 == 0 ? 1.0f : -1.0f;
    const float angle = side * spread * (1.0f - 0.7f * share) * (0.7f + 0.6f * hash01(i, seed));
    const vec2 base(0.5f + 0.02f * side, 0.06f + 0.62f * share);
    const float size = length * (0.8f + 0.4f * hash01(i, seed, 1));
    const vec2 tip = base + size * vec2(elementary::sin(angle), elementary::cos(angle));
    leaves.push_back({base, glm::clamp(tip, vec2(0.02f), vec2(0.98f)), width, hash01(i, seed, 2)});
  }
  return leaves;
}

uint32_t paint_leaves(ContentBuilder& b, const std::string& name, const std::vector<Leaf>& leaves, vec3 dark,
                      vec3 light) {
  return paint_image(b, name, 256, 256, [&](vec2 uv) { return leaves_texel(uv, leaves, dark, light); });
}

// Returns blades that rise from the lower edge and lean.
std::vector<Leaf> blades(uint32_t count, uint32_t seed) {
  std::vector<Leaf> leaves;
  for (uint32_t i = 0; i < count; ++i) {
    const float x = 0.08f + 0.84f * (static_cast<float>(i) + hash01(i, seed)) / static_cast<float>(count);
    const float lean = 0.5f * (hash01(i, seed, 1) - 0.5f);
    const vec2 tip(std::clamp(x + lean, 0.02f, 0.98f), 0.45f + 0.52f * hash01(i, seed, 2));
    leaves.push_back({{x, -0.25f}, tip, 0.045f + 0.03f * hash01(i, seed, 4), hash01(i, seed, 3)});
  }
  return leaves;
}

Texel flower_texel(vec2 uv, const std::vector<Leaf>& leaves) {
  Texel t = leaves_texel(uv, leaves, {0.20f, 0.32f, 0.10f}, {0.42f, 0.55f, 0.20f});
  for (uint32_t i = 0; i < 7; ++i) {
    const vec2 from = vec2(uv.x, 1.0f - uv.y) -
                      vec2(0.12f + 0.76f * (static_cast<float>(i) + 0.5f) / 7.0f, 0.55f + 0.36f * hash01(i, 31));
    const float r = glm::length(from), petals = 0.046f + 0.014f * elementary::cos(6.0f * elementary::atan2(from.y, from.x));
    if (r > petals) continue;
    t.alpha = 1;
    t.color = r < 0.017f ? vec3(0.9f, 0.7f, 0.1f) : i % 3 == 0 ? vec3(0.72f, 0.5f, 0.86f) : vec3(0.95f, 0.94f, 0.9f);
  }
  return t;
}

Texel bark_texel(vec2 uv) {
  const float ridges = fractal_noise(vec2(uv.x, 0.25f * uv.y), 16, 4, 51);
  const float cracks = glm::smoothstep(0.35f, 0.6f, ridges);
  Texel t;
  t.color = glm::mix(vec3(0.20f, 0.15f, 0.11f), vec3(0.46f, 0.37f, 0.29f), cracks) *
            (0.85f + 0.3f * fractal_noise(uv, 8, 4, 52));
  return t;
}

Texel birch_bark_texel(vec2 uv) {
  const float bands = fractal_noise(vec2(0.25f * uv.x, uv.y), 24, 3, 61);
  Texel t;
  t.color = glm::mix(vec3(0.16f, 0.14f, 0.13f), vec3(0.86f, 0.84f, 0.79f), glm::smoothstep(0.30f, 0.40f, bands)) *
            (0.9f + 0.2f * fractal_noise(uv, 8, 3, 62));
  return t;
}

}  // namespace

Textures paint_textures(ContentBuilder& b) {
  Textures t{};
  t.oak = paint_leaves(b, "oak leaves", twig(15, 0.36f, 0.46f, 1.5f, 11), {0.17f, 0.30f, 0.08f}, {0.44f, 0.58f, 0.19f});
  t.birch =
      paint_leaves(b, "birch leaves", twig(17, 0.27f, 0.52f, 1.6f, 12), {0.28f, 0.42f, 0.11f}, {0.60f, 0.68f, 0.25f});
  t.needles =
      paint_leaves(b, "needles", twig(56, 0.34f, 0.13f, 1.3f, 13), {0.10f, 0.20f, 0.11f}, {0.26f, 0.40f, 0.20f});
  t.bush =
      paint_leaves(b, "bush leaves", twig(19, 0.30f, 0.36f, 1.5f, 14), {0.15f, 0.29f, 0.12f}, {0.40f, 0.53f, 0.24f});
  t.fern = paint_leaves(b, "fern", twig(44, 0.44f, 0.13f, 1.75f, 15), {0.18f, 0.34f, 0.10f}, {0.42f, 0.58f, 0.20f});
  t.grass = paint_leaves(b, "grass blades", blades(26, 16), {0.24f, 0.36f, 0.10f}, {0.56f, 0.64f, 0.26f});
  const std::vector<Leaf> stems = blades(18, 17);
  t.flowers = paint_image(b, "flowers", 256, 256, [&](vec2 uv) { return flower_texel(uv, stems); });
  t.bark = paint_image(b, "bark", 256, 256, bark_texel);
  t.birch_bark = paint_image(b, "birch bark", 256, 256, birch_bark_texel);
  return t;
}

}  // namespace sideray::scenes::forest
