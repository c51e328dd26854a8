// Samples an environment in many directions at once, in lanes. Any thread may use it.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "model/snapshot.h"
#include "rt/surfaces/shade_kernels.h"

namespace sideray::rt {

EnvironmentLevels levels_of(const model::Environment& environment);

class EnvironmentLanes {
 public:
  EnvironmentLanes() = default;
  // The caller keeps both objects alive.
  EnvironmentLanes(const model::Environment& environment, const ShadeKernels& kernels);

  // Write what environment_specular() and environment_irradiance() return for unit directions, apart from rounding.
  void specular(std::span<const glm::vec3> directions, float roughness, glm::vec3* radiance) const;
  void irradiance(std::span<const glm::vec3> directions, glm::vec3* light) const;

 private:
  void look_up(const EnvironmentLevels& levels, std::span<const glm::vec3> directions, float roughness, glm::vec3* found) const;

  const ShadeKernels* kernels_ = nullptr;
  EnvironmentLevels specular_{}, irradiance_{};
};

}  // namespace sideray::rt
