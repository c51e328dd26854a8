// Makes textures by code for the built-in scenes: tileable noise, and maps painted by a function. Any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scenes/content/hash.h"
#include "scenes/content/shapes.h"

namespace sideray::scenes {

// Return smooth noise in 0..1 that repeats every `period` units of p, and a sum of its octaves over uv in 0..1.
float value_noise(glm::vec2 p, glm::uvec2 period, uint32_t seed);
float fractal_noise(glm::vec2 uv, uint32_t period, uint32_t octaves, uint32_t seed);

// Describes the nearest of jittered points, one in each cell of a period x period grid over uv in 0..1.
struct Cell {
  float edge;  // distance to the border of the cell, in cells
  float random;
};
Cell cell_noise(glm::vec2 uv, uint32_t period, uint32_t seed);

struct Texel {
  glm::vec3 color = glm::vec3(1);  // as sRGB codes, 0..1
  float height = 0.0f;             // 0..1
  float roughness = 1.0f, metallic = 0.0f;
  float cavity = 1.0f;  // share of ambient light that reaches it
  float alpha = 1.0f;
};
using Paint = std::function<Texel(glm::vec2 uv)>;  // uv 0..1 from the top left

struct Maps {
  uint32_t color = 0, surface = 0, normal = 0;  // as slots want them; surface: occlusion, roughness, metallic
};
// Paints the maps of a material; `relief` is the height of its relief in widths of the image.
Maps paint_maps(ContentBuilder& b, const std::string& name, uint32_t size, float relief, const Paint& paint);
uint32_t paint_image(ContentBuilder& b, const std::string& name, uint32_t width, uint32_t height, const Paint& paint);

// Writes capitals and digits as strokes on a 4 x 6 grid, as with chalk.
struct Lettering {
  struct Stroke {
    glm::vec2 a, b;
  };
  struct Letter {
    glm::vec2 least, most;  // bounds of its strokes
    std::vector<Stroke> strokes;
  };
  std::vector<Letter> letters;
  // Writes `text` from the lower left corner `at`, y up; `height` is that of a capital. Returns x at the end of the
  // text.
  float write(const std::string& text, glm::vec2 at, float height);
  // Returns the distance to the nearest stroke, at most `farthest`.
  float distance(glm::vec2 p, float farthest) const;
};

}  // namespace sideray::scenes
