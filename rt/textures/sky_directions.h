// Draws directions above a surface in proportion to what an environment sends from them to it: what the rays of ambient
// occlusion go along. Immutable once made; any thread may use it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

class SkyDirections {
 public:
  // Keeps the environment, and sums it over the cells of a cube around it. That is done by one thread, in time
  // proportional to its texels.
  explicit SkyDirections(std::shared_ptr<const model::Environment> environment);

  struct Draw {
    glm::vec3 direction;  // unit
    // What arrives from there, the cosine included, over the density: the mean of weight * visible over that of the
    // weight is the share of the environment's light that is visible. 0 below the surface and where all is black.
    float weight;
  };
  // Returns for draw() which of the tables a surface of that normal, of unit length, draws from.
  static uint32_t facing(glm::vec3 normal);
  // `u` is a point of the unit square.
  Draw draw(uint32_t facing, glm::vec3 normal, glm::vec2 u) const;
  // Nothing can be drawn from a black environment: do not call draw() there.
  bool black() const { return cells_.empty(); }
  const std::shared_ptr<const model::Environment>& environment() const { return environment_; }

 private:
  struct Cell {
    glm::vec3 corner;  // on the cube's face: the first along both sides
    float power;       // of what comes through it: solid angle times the mean of the radiance's channels
  };

  std::vector<float> sum_cells();
  void sum_facings(const std::vector<float>& solid_angles);

  std::shared_ptr<const model::Environment> environment_;
  std::vector<Cell> cells_;
  // Tables for drawing a cell, one for each cell of a coarser cube in which the surface's normal lies, concatenated:
  std::vector<float> shares_;     // cumulative, of the cells
  std::vector<uint16_t> guides_;  // the first cell that may be meant by a number in each of equal intervals
};

}  // namespace sideray::rt
