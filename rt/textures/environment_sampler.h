// Samples directions in proportion to an environment's radiance. Immutable once made; any thread may use it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

class EnvironmentSampler {
 public:
  // Keeps the environment alive. The sampled radiance is environment_specular() at roughness 0, with scale and
  // rotation.
  explicit EnvironmentSampler(std::shared_ptr<const model::Environment> environment);

  struct Sample {
    glm::vec3 direction;
    float density;  // per steradian
  };
  // `u` is a point of the unit square. Must not be called for a black environment.
  Sample sample(glm::vec2 u) const;
  // Returns the sampling density per steradian, which is positive wherever there is radiance; `direction` is unit.
  float density(glm::vec3 direction) const;
  glm::vec3 radiance(glm::vec3 direction) const;
  float mean_radiance() const { return mean_radiance_; }  // over the sphere and the channels
  bool black() const { return rows_.empty(); }
  const std::shared_ptr<const model::Environment>& environment() const { return environment_; }

 private:
  std::shared_ptr<const model::Environment> environment_;
  // A cell is a texel. Arrays of cumulative shares have one entry more than cells, so a row of columns_ is width_ + 1
  // long.
  uint32_t width_ = 0;
  std::vector<float> rows_, columns_;
  std::vector<double> edges_;         // edges of the rows, as cosines to +Y
  std::vector<float> row_densities_;  // each row's share per solid angle of one of its cells
  float mean_radiance_ = 0;
};

}  // namespace sideray::rt
