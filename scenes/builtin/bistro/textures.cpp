#include "scenes/builtin/bistro/textures.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"

namespace sideray::scenes::bistro {
namespace {

glm::vec3 rgb(uint32_t hex) {
  return glm::vec3(hex >> 16 & 255u, hex >> 8 & 255u, hex & 255u) / 255.0f;
}

// Returns 1 for |x| < width, fading over `soft`.
float band(float x, float width, float soft) {
  return 1.0f - glm::smoothstep(width - soft, width + soft, std::abs(x));
}

// Returns wood with grain along u: stretched growth rings, with pores.
Texel wood(glm::vec2 uv, glm::vec3 dark, glm::vec3 light, float ambient) {
  const float bend = fractal_noise({uv.x, uv.y}, 3, 3, 11);
  const float rings = 0.5f + 0.5f * elementary::sin(glm::two_pi<float>() * (9.0f * uv.y + 1.7f * bend));
  const float fibre = value_noise({uv.x * 12.0f, uv.y * 192.0f}, {12, 192}, 12);
  const float pores = glm::smoothstep(0.72f, 0.95f, value_noise({uv.x * 24.0f, uv.y * 256.0f}, {24, 256}, 13));
  Texel t;
  const float shade = 0.55f * rings + 0.45f * fibre;
  t.color = glm::mix(dark, light, shade) * (1.0f - 0.35f * pores);
  t.height = 0.6f + 0.25f * fibre - 0.35f * pores;
  t.roughness = 0.55f + 0.2f * pores - 0.1f * shade;
  t.cavity = ambient;
  return t;
}

// Returns cement tiles, two by two in the image: a star in a ring, and quarter rings at the corners.
Texel cement_tile(glm::vec2 uv, float ambient) {
  const glm::vec2 tile = glm::fract(uv * 2.0f) - 0.5f;
  const glm::vec2 corner = 0.5f - glm::abs(tile);
  const float r = glm::length(tile), angle = elementary::atan2(tile.y, tile.x), at_corner = glm::length(corner);
  const float petals = 0.20f + 0.07f * elementary::cos(8.0f * angle);
  glm::vec3 color = rgb(0xb9a888);
  const auto lay = [&](glm::vec3 ink, float amount) { color = glm::mix(color, ink, amount); };
  lay(rgb(0x2f3f3a), band(at_corner - 0.30f, 0.035f, 0.008f));
  lay(rgb(0x7a2f26), 1.0f - glm::smoothstep(0.19f, 0.21f, at_corner));
  lay(rgb(0xb9a888), 1.0f - glm::smoothstep(0.07f, 0.085f, at_corner));
  lay(rgb(0x2f3f3a), 1.0f - glm::smoothstep(petals, petals + 0.015f, r));
  lay(rgb(0xc4b492), 1.0f - glm::smoothstep(0.6f * petals, 0.6f * petals + 0.015f, r));
  lay(rgb(0x7a2f26), 1.0f - glm::smoothstep(0.04f, 0.055f, r));
  const float grout = glm::smoothstep(0.006f, 0.014f, std::min(corner.x, corner.y));
  const float wear = fractal_noise(uv, 4, 5, 21), speck = value_noise(uv * 128.0f, glm::uvec2(128), 24);
  const glm::vec2 which = glm::floor(uv * 2.0f);
  const float own = hash01(static_cast<uint32_t>(which.x), static_cast<uint32_t>(which.y), 22);
  Texel t;
  t.color = glm::mix(rgb(0x3a332b), color * (0.80f + 0.22f * wear + 0.08f * own), grout) * (0.92f + 0.1f * speck);
  t.height = 0.75f * grout + 0.12f * wear;
  t.roughness = glm::mix(0.9f, 0.22f + 0.34f * wear, grout);
  t.cavity = ambient * (0.5f + 0.5f * grout);
  return t;
}

Texel plaster(glm::vec2 uv, float ambient) {
  const float broad = fractal_noise(uv, 3, 5, 31), trowel = fractal_noise(uv, 12, 4, 32);
  Texel t;
  t.color = glm::mix(rgb(0xb08a52), rgb(0xd6b27a), broad) * (0.94f + 0.08f * trowel);
  t.height = trowel;
  t.roughness = 0.82f;
  t.cavity = ambient;
  return t;
}

// Returns paving stones of two sizes, wet in the hollows.
Texel cobbles(glm::vec2 uv, float ambient) {
  const float row = std::floor(uv.y * 12.0f);
  const float shift = hash01(static_cast<uint32_t>(row), 41);
  const glm::vec2 stone(glm::fract(uv.x * 8.0f + shift), glm::fract(uv.y * 12.0f));
  const auto column = static_cast<uint32_t>(std::floor(glm::fract(uv.x + shift / 8.0f) * 8.0f));
  const float own = hash01(column, static_cast<uint32_t>(row), 42);
  const glm::vec2 inward = 0.5f - glm::abs(stone - 0.5f);
  const float top = glm::smoothstep(0.0f, 0.22f, std::min(inward.x, inward.y * 0.8f));
  const float grain = fractal_noise(uv, 32, 3, 43), puddle = glm::smoothstep(0.45f, 0.62f, fractal_noise(uv, 2, 3, 44));
  Texel t;
  t.color = glm::mix(rgb(0x17181a), rgb(0x4a4c52) * (0.7f + 0.5f * own), top) * (0.85f + 0.3f * grain);
  t.height = glm::mix(top * (0.8f + 0.2f * own) + 0.05f * grain, 0.45f, puddle * (1.0f - 0.5f * top));
  t.roughness = glm::mix(0.24f + 0.25f * grain, 0.08f, puddle);
  t.cavity = ambient * (0.4f + 0.6f * top);
  return t;
}

// Returns the ashlar of a street front: courses of dressed stone.
Texel ashlar(glm::vec2 uv, float ambient) {
  const float row = std::floor(uv.y * 8.0f);
  const float shift = 0.5f * std::fmod(row, 2.0f);
  const glm::vec2 stone(glm::fract(uv.x * 4.0f + shift), glm::fract(uv.y * 8.0f));
  const auto column = static_cast<uint32_t>(std::floor(glm::fract(uv.x + shift / 4.0f) * 4.0f));
  const glm::vec2 inward = 0.5f - glm::abs(stone - 0.5f);
  const float face = glm::smoothstep(0.01f, 0.05f, std::min(inward.x * 2.0f, inward.y));
  const float stain = fractal_noise(uv, 2, 5, 51), own = hash01(column, static_cast<uint32_t>(row), 52);
  Texel t;
  t.color = glm::mix(rgb(0x4a4642), rgb(0xb0a48e), face) * (0.62f + 0.3f * stain + 0.16f * own);
  t.height = face;
  t.roughness = 0.8f;
  t.cavity = ambient * (0.5f + 0.5f * face);
  return t;
}

Texel weave(glm::vec2 uv, float ambient) {
  constexpr float threads = 32.0f;
  const glm::vec2 at = uv * threads, f = glm::fract(at);
  const bool over = (static_cast<int>(at.x) + static_cast<int>(at.y)) % 2 == 0;
  const float warp = elementary::sin(glm::pi<float>() * f.x), weft = elementary::sin(glm::pi<float>() * f.y);
  const float slub = fractal_noise(uv, 8, 3, 61);
  Texel t;
  t.height = over ? warp : weft;
  t.color = glm::vec3(0.80f + 0.14f * t.height) * (0.88f + 0.16f * slub);
  t.roughness = 0.9f;
  t.cavity = ambient * (0.7f + 0.3f * t.height);
  return t;
}

Texel leather(glm::vec2 uv, float ambient) {
  const Cell cell = cell_noise(uv, 24, 71);
  Texel t;
  t.height = glm::smoothstep(0.0f, 0.22f, cell.edge);
  const float wear = fractal_noise(uv, 3, 3, 74);
  t.color = glm::mix(rgb(0x2c0d0a), rgb(0x6a211a), 0.35f + 0.4f * t.height * wear + 0.2f * cell.random);
  t.roughness = 0.62f - 0.22f * t.height;
  t.cavity = ambient;
  return t;
}

// Returns a leaf with its tip toward -v: midrib and side veins.
Texel leaf(glm::vec2 uv, float ambient) {
  const float side = std::abs(uv.x - 0.5f), vein = std::abs(glm::fract((uv.y - 0.6f * side) * 9.0f) - 0.5f);
  const float rib = std::max(band(side, 0.02f, 0.012f), 0.55f * band(vein, 0.07f, 0.05f));
  Texel t;
  t.color = glm::mix(rgb(0x2d4a22), rgb(0x8aa35a), rib) * (0.8f + 0.35f * fractal_noise(uv, 4, 3, 81));
  t.height = 1.0f - rib;
  t.roughness = 0.45f;
  t.cavity = ambient;
  return t;
}

// Returns a lattice of cane, as light and dark.
Texel cane(glm::vec2 uv, float ambient) {
  const glm::vec2 f = glm::abs(glm::fract(uv * 16.0f) - 0.5f);
  const float strand = std::max(band(f.x, 0.3f, 0.08f), band(f.y, 0.3f, 0.08f));
  Texel t;
  t.color =
      glm::mix(rgb(0x2a1a0c), rgb(0xb08a4c), strand) * (0.85f + 0.2f * value_noise(uv * 64.0f, glm::uvec2(64), 91));
  t.height = strand;
  t.roughness = 0.6f;
  t.cavity = ambient * (0.4f + 0.6f * strand);
  return t;
}

}  // namespace

Maps paint_floor(ContentBuilder& b) {
  return paint_maps(b, "cement tiles", 512, 0.008f, [](glm::vec2 uv) { return cement_tile(uv, room_ambient); });
}
Maps paint_wood(ContentBuilder& b) {
  return paint_maps(b, "walnut", 512, 0.0016f,
                    [](glm::vec2 uv) { return wood(uv, rgb(0x4a2a17), rgb(0x96643a), room_ambient); });
}
Maps paint_plaster(ContentBuilder& b) {
  return paint_maps(b, "plaster", 256, 0.012f, [](glm::vec2 uv) { return plaster(uv, room_ambient); });
}
Maps paint_cobbles(ContentBuilder& b) {
  return paint_maps(b, "cobbles", 512, 0.016f, [](glm::vec2 uv) { return cobbles(uv, street_ambient); });
}
Maps paint_ashlar(ContentBuilder& b) {
  return paint_maps(b, "ashlar", 256, 0.012f, [](glm::vec2 uv) { return ashlar(uv, street_ambient); });
}
Maps paint_weave(ContentBuilder& b) {
  return paint_maps(b, "weave", 256, 0.012f, [](glm::vec2 uv) { return weave(uv, room_ambient); });
}
Maps paint_leather(ContentBuilder& b) {
  return paint_maps(b, "leather", 256, 0.006f, [](glm::vec2 uv) { return leather(uv, room_ambient); });
}
Maps paint_leaf(ContentBuilder& b) {
  return paint_maps(b, "leaf", 128, 0.012f, [](glm::vec2 uv) { return leaf(uv, room_ambient); });
}
Maps paint_cane(ContentBuilder& b) {
  return paint_maps(b, "cane", 256, 0.008f, [](glm::vec2 uv) { return cane(uv, room_ambient); });
}

// Paints a label: paper with a frame, a crest, a name and lines too small to read.
uint32_t paint_label(ContentBuilder& b, int which) {
  static constexpr uint32_t papers[] = {0xe9dfc4, 0x1d2a24, 0xd8c9a0, 0x6b1d1a};
  static constexpr uint32_t inks[] = {0x5a1418, 0xc9a24a, 0x22314a, 0xe6d3a0};
  static const char* const names[] = {"MARGELLE", "ABSINTHE", "SAUVIGNY", "COGNAC"};
  const glm::vec3 paper = rgb(papers[which]), ink = rgb(inks[which]);
  Lettering text;
  text.write(names[which], {0.06f, 0.50f}, 0.12f);
  const auto seed = static_cast<uint32_t>(which);
  return paint_image(b, std::string("label ") + names[which], 256, 256, [&](glm::vec2 uv) {
    const glm::vec2 p(uv.x, 1.0f - uv.y), border = 0.5f - glm::abs(uv - 0.5f);
    float amount = band(std::min(border.x, border.y) - 0.035f, 0.008f, 0.004f);
    amount = std::max(amount, 1.0f - glm::smoothstep(0.010f, 0.016f, text.distance(p, 0.02f)));
    const glm::vec2 crest = p - glm::vec2(0.5f, 0.79f);
    const float r = glm::length(crest), points = 0.085f + 0.02f * elementary::cos(6.0f * elementary::atan2(crest.y, crest.x));
    amount = std::max(amount, band(r - points, 0.012f, 0.006f));
    amount = std::max(amount, 1.0f - glm::smoothstep(0.028f, 0.036f, r));
    const float line = std::floor(p.y * 20.0f), end = 0.28f + 0.12f * hash01(static_cast<uint32_t>(line), seed, 5);
    if (p.y > 0.1f && p.y < 0.4f && std::abs(p.x - 0.5f) < end)
      amount = std::max(amount, 0.7f * band(glm::fract(p.y * 20.0f) - 0.5f, 0.14f, 0.08f));
    Texel t;
    t.color = glm::mix(paper * (0.9f + 0.1f * fractal_noise(uv, 8, 2, 95)), ink, amount);
    return t;
  });
}

uint32_t paint_chalkboard(ContentBuilder& b) {
  Lettering title, lines;
  title.write("MENU DU SOIR", {0.13f, 0.86f}, 0.070f);
  static const char* const menu[] = {"SOUPE DU JOUR  6", "TARTE AU CITRON 7", "ASSIETTE      9",
                                     "VIN ROUGE     5",  "PASTIS        4",   "CAFE          2"};
  for (int i = 0; i < 6; ++i) lines.write(menu[i], {0.10f, 0.70f - 0.115f * static_cast<float>(i)}, 0.052f);
  return paint_image(b, "chalkboard", 512, 512, [&](glm::vec2 uv) {
    const glm::vec2 p(uv.x, 1.0f - uv.y);
    const float dust = fractal_noise(uv, 4, 4, 96), grit = value_noise(uv * 256.0f, glm::uvec2(256), 97);
    float chalk = 0.9f * (1.0f - glm::smoothstep(0.004f, 0.009f, title.distance(p, 0.02f)));
    chalk = std::max(chalk, 0.8f * (1.0f - glm::smoothstep(0.003f, 0.007f, lines.distance(p, 0.02f))));
    chalk = std::max(chalk, 0.6f * band(p.y - 0.815f, 0.003f, 0.002f) * band(p.x - 0.5f, 0.34f, 0.01f));
    Texel t;
    t.color = glm::mix(rgb(0x20251f) + 0.10f * dust, rgb(0xe8e4d8), chalk * (0.55f + 0.6f * grit));
    return t;
  });
}

// Paints the name in gold on the pane, mirrored by its quad because it is seen from inside. Alpha is coverage.
uint32_t paint_sign(ContentBuilder& b) {
  Lettering text;
  text.write("BISTRO SIDERAY", {0.035f, 0.09f}, 0.072f);
  return paint_image(b, "gilt letters", 512, 128, [&](glm::vec2 uv) {
    const glm::vec2 p(uv.x, 0.25f * (1.0f - uv.y));
    const float lines = band(std::abs(p.y - 0.125f) - 0.085f, 0.004f, 0.001f) * band(p.x - 0.5f, 0.47f, 0.002f);
    Texel t;
    t.color = rgb(0xe0b65a);
    t.alpha = std::max(1.0f - glm::smoothstep(0.007f, 0.012f, text.distance(p, 0.02f)), lines);
    return t;
  });
}

// Paints the dusk sky from the zenith (top row) to below the horizon, with streaks of cloud. Unlit: codes of radiance.
uint32_t paint_sky(ContentBuilder& b) {
  return paint_image(b, "dusk", 256, 128, [](glm::vec2 uv) {
    const float up = 1.0f - 2.0f * uv.y;  // 1 at the zenith, 0 at the horizon
    const float glow = elementary::exp(-std::max(up, 0.0f) * 7.0f), cloud = fractal_noise({uv.x, uv.y}, 6, 4, 99);
    Texel t;
    t.color = glm::mix(rgb(0x22345c), rgb(0x5a6a94), elementary::exp(-std::max(up, 0.0f) * 2.5f));
    t.color = glm::mix(t.color, rgb(0xe0a080), 0.75f * glow);
    t.color = glm::mix(t.color, rgb(0x6a5a78), 0.5f * glm::smoothstep(0.5f, 0.75f, cloud) * glow);
    if (up < 0.0f) t.color = rgb(0x24262c);
    return t;
  });
}

// Paints a room behind a window at night: a lamp's glow between curtains.
uint32_t paint_lit_window(ContentBuilder& b) {
  return paint_image(b, "lit window", 128, 128, [](glm::vec2 uv) {
    const float folds = 0.5f + 0.5f * elementary::sin(uv.x * 70.0f),
                curtain = glm::smoothstep(0.24f, 0.34f, std::abs(uv.x - 0.5f));
    const float lamp = elementary::exp(-6.0f * glm::length(glm::vec2(uv.x - 0.42f, (uv.y - 0.4f) * 0.8f)));
    const float bars = std::max(band(uv.x - 0.5f, 0.02f, 0.004f), band(uv.y - 0.38f, 0.015f, 0.004f));
    Texel t;
    t.color = glm::mix(rgb(0x9a6a34) + lamp * rgb(0x8a6a40), rgb(0x8a4a2a) * (0.6f + 0.4f * folds), curtain);
    t.color *= 1.0f - 0.9f * bars;
    return t;
  });
}

// Paints still lifes for the walls, from discs and bands.
uint32_t paint_painting(ContentBuilder& b, int which) {
  static constexpr uint32_t grounds[] = {0x3a4a52, 0x7a5a32, 0x5a2a2a}, shapes[] = {0xd8a24a, 0x2a4a4a, 0xe0c8a0};
  const auto seed = 200u + 16u * static_cast<uint32_t>(which);
  return paint_image(b, "painting " + std::to_string(which), 128, 128, [&](glm::vec2 uv) {
    const float brush = fractal_noise({uv.x, uv.y}, 6, 4, seed);
    Texel t;
    t.color =
        glm::mix(rgb(grounds[which]), 0.6f * rgb(grounds[which]), glm::smoothstep(0.55f, 0.62f, uv.y + 0.1f * brush));
    for (uint32_t i = 0; i < 7; ++i) {
      const glm::vec2 at(0.15f + 0.7f * hash01(i, 1, seed), 0.45f + 0.3f * hash01(i, 2, seed));
      const float r = 0.05f + 0.09f * hash01(i, 3, seed),
                  d = glm::length((uv - at) * glm::vec2(1.0f, 0.8f)) + 0.02f * brush;
      const glm::vec3 ink = glm::mix(rgb(shapes[which]), rgb(0x7a3a2a), hash01(i, 4, seed));
      t.color = glm::mix(t.color, ink * (1.15f - 0.6f * glm::smoothstep(0.0f, r, d)),
                         1.0f - glm::smoothstep(r, r + 0.02f, d));
    }
    t.color *= 0.8f + 0.4f * brush;
    return t;
  });
}

}  // namespace sideray::scenes::bistro
