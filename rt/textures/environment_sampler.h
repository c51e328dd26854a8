// Draws directions in proportion to the radiance that an environment sends from them. Immutable once made; any thread
// may use it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

class EnvironmentSampler {
 public:
  // Keeps the environment. It is sampled as environment_specular() at roughness 0 shows it: scale and rotation
  // included.
  explicit EnvironmentSampler(std::shared_ptr<const model::Environment> environment);

  struct Sample {
    glm::vec3 direction;
    float density;  // per steradian
  };
  // `u` is a point of the unit square. A black environment has no samples: do not call it there.
  Sample sample(glm::vec2 u) const;
  // Returns a density that is positive wherever radiance comes from; `direction` is unit.
  float density(glm::vec3 direction) const;
  glm::vec3 radiance(glm::vec3 direction) const;
  float mean_radiance() const { return mean_radiance_; }  // over the sphere and the channels
  bool black() const { return rows_.empty(); }
  const std::shared_ptr<const model::Environment>& environment() const { return environment_; }

 private:
  std::shared_ptr<const model::Environment> environment_;
  // A cell is a texel; cumulative shares have one entry more than there are cells. A row of columns_ is width_ + 1
  // long.
  uint32_t width_ = 0;
  std::vector<float> rows_, columns_;
  std::vector<double> edges_;         // edges of the rows, as cosines to +Y
  std::vector<float> row_densities_;  // a row's share per solid angle of one of its cells
  float mean_radiance_ = 0;
};

}  // namespace sideray::rt
