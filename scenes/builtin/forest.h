// Declares the parts of the built-in forest, which forest.cpp assembles. Metres; y up; plants stand on their origin.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scenes/content/shapes.h"

namespace sideray::scenes::forest {

struct Textures {
  uint32_t oak, birch, needles, bush, fern, grass, flowers, bark, birch_bark;  // texture indices + 1
};
Textures paint_textures(ContentBuilder& b);

struct Part {
  std::string name;
  uint32_t mesh, material;
  bool has_leaves;
};

enum class Kind { tree, bush, grass };

struct Species {
  Kind kind;
  float share;  // of the plants of its kind
  std::vector<Part> parts;
  sideray_wind_desc wind;  // for wind along +x
};
std::vector<Species> make_species(ContentBuilder& b, const Textures& textures, uint32_t seed);

}  // namespace sideray::scenes::forest
