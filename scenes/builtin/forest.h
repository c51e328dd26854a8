// The parts of the built-in forest, which forest.cpp puts together. Metres; y up; plants stand on their origin.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scenes/content/shapes.h"

namespace sideray::scenes::forest {

struct Textures {
  uint32_t oak, birch, needles, bush, fern, grass, flowers, bark, birch_bark;  // as slots want them
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
  sideray_wind_desc wind;  // as if it blew along +x
};
std::vector<Species> make_species(ContentBuilder& b, const Textures& textures, uint32_t seed);

}  // namespace sideray::scenes::forest
