// Samples directions above a surface in proportion to an environment's light on it, for rays of ambient occlusion.
// Immutable once made; any thread may use it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

class SkyDirections {
 public:
  // Keeps the environment alive, and integrates it over the cells of a cube, on the calling thread and in time
  // proportional to its texels.
  explicit SkyDirections(std::shared_ptr<const model::Environment> environment);

  struct Draw {
    glm::vec3 direction;  // unit
    // Light from there, times the cosine, over the density: mean(weight * visible) / mean(weight) is the visible share
    // of the environment's light. 0 below the surface and in a black environment.
    float weight;
  };
  // Returns the index of the table from which draw() samples for a surface with this unit normal.
  static uint32_t facing(glm::vec3 normal);
  // `u` is a point of the unit square.
  Draw draw(uint32_t facing, glm::vec3 normal, glm::vec2 u) const;
  // If the environment is black, draw() must not be called.
  bool black() const { return cells_.empty(); }
  const std::shared_ptr<const model::Environment>& environment() const { return environment_; }

 private:
  struct Cell {
    glm::vec3 corner;  // on the cube's face: the one with the smallest coordinates
    float power;       // solid angle times mean radiance, over channels too
  };

  std::vector<float> sum_cells();
  void sum_facings(const std::vector<float>& solid_angles);

  std::shared_ptr<const model::Environment> environment_;
  std::vector<Cell> cells_;
  // One table a cell of a coarser cube, which is selected by the surface's normal; all concatenated.
  std::vector<float> shares_;     // cumulative, by cell
  std::vector<uint16_t> guides_;  // for equal intervals of random numbers: the first cell that a number in it may
                                  // select
};

}  // namespace sideray::rt
