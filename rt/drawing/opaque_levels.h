// Holds an opaque picture and its mip levels, for surfaces that bend or blur the light behind them, as
// gl/targets/opaque_levels.cpp does. One thread fills it; then any thread may read. Row 0 of pixels is the bottom row.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"

namespace sideray::rt {

class OpaqueLevels {
 public:
  void fill(uint32_t width, uint32_t height, const std::vector<glm::vec4>& picture, Executor& executor);

  // Returns the colour of a texel of the finest level.
  glm::vec3 at(uint32_t x, uint32_t y) const { return levels_[0].texels[size_t{y} * levels_[0].width + x]; }
  // Returns the colour at a position, 0..1 in the picture, filtered trilinearly.
  glm::vec3 at(glm::vec2 place, float level) const;
  // Returns the centre of a pixel, 0..1 in the picture.
  glm::vec2 middle(glm::uvec2 pixel) const {
    return (glm::vec2(pixel) + 0.5f) / glm::vec2(levels_[0].width, levels_[0].height);
  }
  // Returns the level that is one texel high.
  float coarsest() const { return coarsest_; }

 private:
  struct Level {
    uint32_t width = 0, height = 0;
    std::vector<glm::vec3> texels;
  };
  static glm::vec3 sample(const Level& level, glm::vec2 place);
  static Level half_of(const Level& fine, Executor& executor);

  std::vector<Level> levels_;
  float coarsest_ = 0.0f;
};

}  // namespace sideray::rt
