#include "scenes/builtin/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace sideray::scenes {
namespace {

uint32_t wrapped(float cell, uint32_t period) {
  const auto p = static_cast<int64_t>(period);
  const auto inside = static_cast<int64_t>(cell);
  if (inside >= 0 && inside < p) return static_cast<uint32_t>(inside);  // the usual case, without a division
  return static_cast<uint32_t>(((inside % p) + p) % p);
}

// Rounds as std::lround does, which is a call of libm.
uint8_t code(float value) {
  const float scaled = std::clamp(value, 0.0f, 1.0f) * 255.0f;
  const auto whole = static_cast<int>(scaled);
  return static_cast<uint8_t>(scaled - static_cast<float>(whole) >= 0.5f ? whole + 1 : whole);
}

Texture blank(const std::string& name, uint32_t width, uint32_t height, bool srgb) {
  Texture texture;
  texture.name = name;
  texture.width = width;
  texture.height = height;
  texture.srgb = srgb;
  texture.rgba.resize(size_t{4} * width * height, 255);
  return texture;
}

std::vector<Texel> painted(uint32_t width, uint32_t height, const Paint& paint) {
  std::vector<Texel> texels;
  texels.reserve(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      texels.push_back(paint(glm::vec2((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                       (static_cast<float>(y) + 0.5f) / static_cast<float>(height))));
  return texels;
}

void set_colors(Texture& texture, const std::vector<Texel>& texels) {
  for (size_t i = 0; i < texels.size(); ++i) {
    for (int c = 0; c < 3; ++c) texture.rgba[4 * i + static_cast<size_t>(c)] = code(texels[i].color[c]);
    texture.rgba[4 * i + 3] = code(texels[i].alpha);
  }
}

// The glyphs of 0 to 9, then A to Z. The grid is x 0..4, y 0..6; a stroke is a chain of points, two digits each; a
// blank starts a new stroke.
constexpr std::array<std::string_view, 36> glyphs = {"103041453616050110",
                                                     "152620",
                                                     "05163645440040",
                                                     "051636454433 334241301001",
                                                     "3630 360242",
                                                     "460603334241301001",
                                                     "36160501103041423303",
                                                     "064620",
                                                     "163645443313040516 133342413010010213",
                                                     "1030414536160504133344",
                                                     "002640 1232",
                                                     "000636454433 033342413000",
                                                     "4536160501103041",
                                                     "00062645412000",
                                                     "46060040 0333",
                                                     "460600 0333",
                                                     "45361605011030414323",
                                                     "0006 4046 0343",
                                                     "2026 1030 1636",
                                                     "4641301001",
                                                     "0006 4603 1340",
                                                     "060040",
                                                     "0006234640",
                                                     "00064046",
                                                     "103041453616050110",
                                                     "00063645443303",
                                                     "103041453616050110 2240",
                                                     "00063645443303 2340",
                                                     "453616050413334241301001",
                                                     "0646 2620",
                                                     "060110304146",
                                                     "062046",
                                                     "0610233046",
                                                     "0046 0640",
                                                     "062346 2320",
                                                     "06460040"};

}  // namespace

float value_noise(glm::vec2 p, glm::uvec2 period, uint32_t seed) {
  const glm::vec2 cell = glm::floor(p), f = p - cell, t = f * f * (3.0f - 2.0f * f);
  const uint32_t x0 = wrapped(cell.x, period.x), y0 = wrapped(cell.y, period.y);
  const uint32_t x1 = x0 + 1 == period.x ? 0 : x0 + 1, y1 = y0 + 1 == period.y ? 0 : y0 + 1;
  const float top = glm::mix(hash01(x0, y0, seed), hash01(x1, y0, seed), t.x);
  const float bottom = glm::mix(hash01(x0, y1, seed), hash01(x1, y1, seed), t.x);
  return glm::mix(top, bottom, t.y);
}

float fractal_noise(glm::vec2 uv, uint32_t period, uint32_t octaves, uint32_t seed) {
  float sum = 0, weight = 0, share = 1;
  for (uint32_t i = 0; i < octaves; ++i, period *= 2, share *= 0.5f) {
    sum += share * value_noise(uv * static_cast<float>(period), glm::uvec2(period), seed + i);
    weight += share;
  }
  return sum / weight;
}

Cell cell_noise(glm::vec2 uv, uint32_t period, uint32_t seed) {
  const glm::vec2 p = uv * static_cast<float>(period), home = glm::floor(p);
  float nearest = 9, second = 9, random = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const glm::vec2 cell = home + glm::vec2(dx, dy);
      const uint32_t x = wrapped(cell.x, period), y = wrapped(cell.y, period);
      const glm::vec2 site = cell + 0.5f + 0.7f * (glm::vec2(hash01(x, y, seed), hash01(x, y, seed + 1)) - 0.5f);
      const float d = glm::length(p - site);
      if (d < nearest)
        second = nearest, nearest = d, random = hash01(x, y, seed + 2);
      else
        second = std::min(second, d);
    }
  return {0.5f * (second - nearest), random};
}

Maps paint_maps(ContentBuilder& b, const std::string& name, uint32_t size, float relief, const Paint& paint) {
  const std::vector<Texel> texels = painted(size, size, paint);
  Texture color = blank(name, size, size, true), surface = blank(name + " surface", size, size, false),
          normal = blank(name + " normals", size, size, false);
  set_colors(color, texels);
  const auto height = [&](uint32_t x, uint32_t y) { return texels[size_t{y % size} * size + x % size].height; };
  const float slope = 0.5f * relief * static_cast<float>(size);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const size_t i = size_t{y} * size + x;
      surface.rgba[4 * i] = code(texels[i].cavity);
      surface.rgba[4 * i + 1] = code(texels[i].roughness);
      surface.rgba[4 * i + 2] = code(texels[i].metallic);
      // Green points up in the image, against v.
      const float dx = height(x + 1, y) - height(x + size - 1, y), dy = height(x, y + 1) - height(x, y + size - 1);
      const glm::vec3 n = glm::normalize(glm::vec3(-dx * slope, dy * slope, 1.0f));
      for (int c = 0; c < 3; ++c) normal.rgba[4 * i + static_cast<size_t>(c)] = code(n[c] * 0.5f + 0.5f);
    }
  Maps maps;
  maps.color = b.texture(std::move(color));
  maps.surface = b.texture(std::move(surface));
  maps.normal = b.texture(std::move(normal));
  return maps;
}

uint32_t paint_image(ContentBuilder& b, const std::string& name, uint32_t width, uint32_t height, const Paint& paint) {
  Texture color = blank(name, width, height, true);
  set_colors(color, painted(width, height, paint));
  return b.texture(std::move(color));
}

float Lettering::write(const std::string& text, glm::vec2 at, float height) {
  const float unit = height / 6.0f;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9', capital = c >= 'A' && c <= 'Z';
    const std::string_view glyph = digit     ? glyphs[static_cast<size_t>(c - '0')]
                                   : capital ? glyphs[static_cast<size_t>(c - 'A' + 10)]
                                             : std::string_view();
    const auto point = [&](size_t i) {
      return at + unit * glm::vec2(static_cast<float>(glyph[i] - '0'), static_cast<float>(glyph[i + 1] - '0'));
    };
    Letter letter{glm::vec2(INFINITY), glm::vec2(-INFINITY), {}};
    for (size_t i = 0; i + 3 < glyph.size(); i += 2) {
      if (glyph[i + 2] == ' ') {
        i += 1;  // skips the blank: the next pair starts a stroke
        continue;
      }
      const Stroke stroke{point(i), point(i + 2)};
      letter.strokes.push_back(stroke);
      letter.least = glm::min(letter.least, glm::min(stroke.a, stroke.b));
      letter.most = glm::max(letter.most, glm::max(stroke.a, stroke.b));
    }
    if (!letter.strokes.empty()) letters.push_back(std::move(letter));
    at.x += unit * (glyph.empty() ? 3.0f : 5.6f);
  }
  return at.x;
}

float Lettering::distance(glm::vec2 p, float farthest) const {
  float nearest = farthest * farthest;  // squared, so that one root suffices
  for (const Letter& letter : letters) {
    // Skips letters that are too far away, which is nearly all of them. The margin covers rounding of both distances.
    const glm::vec2 outside = glm::max(glm::max(letter.least - p, p - letter.most), glm::vec2(0));
    if (glm::dot(outside, outside) > 1.001f * nearest) continue;
    for (const Stroke& s : letter.strokes) {
      const glm::vec2 along = s.b - s.a, from = p - s.a;
      const float t = std::clamp(glm::dot(from, along) / std::max(glm::dot(along, along), 1e-12f), 0.0f, 1.0f);
      const glm::vec2 away = from - t * along;
      nearest = std::min(nearest, glm::dot(away, away));
    }
  }
  return std::sqrt(nearest);
}

}  // namespace sideray::scenes
