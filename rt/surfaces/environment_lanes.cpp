#include "rt/surfaces/environment_lanes.h"

#include <algorithm>

#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {
namespace {

void add(const model::Environment::Image& image, EnvironmentLevels& levels) {
  levels.texels[levels.count] = &image.texels[0].x;
  levels.width[levels.count] = static_cast<float>(image.width);
  levels.height[levels.count++] = static_cast<float>(image.height);
}

}  // namespace

EnvironmentLevels levels_of(const model::Environment& environment) {
  EnvironmentLevels levels{};
  if (environment.black) return levels;
  for (const model::Environment::Image& image : environment.specular) add(image, levels);
  levels.uniform = environment.uniform;
  return levels;
}

EnvironmentLanes::EnvironmentLanes(const model::Environment& environment, const ShadeKernels& kernels)
    : kernels_(&kernels), specular_(levels_of(environment)) {
  if (environment.black) return;
  add(environment.irradiance, irradiance_);
  irradiance_.uniform = environment.uniform;
}

void EnvironmentLanes::look_up(const EnvironmentLevels& levels, std::span<const glm::vec3> directions, float roughness,
                               glm::vec3* found) const {
  if (levels.count == 0) return void(std::fill_n(found, directions.size(), glm::vec3(0.0f)));
  alignas(64) BlockRow direction[3], mirror_like{}, rough, uv[2], result[3];
  std::fill_n(rough, block_size, roughness);
  for (size_t first = 0; first < directions.size(); first += block_size) {
    const size_t count = std::min<size_t>(block_size, directions.size() - first);
    for (size_t i = 0; i < block_size; ++i) set_vector(direction, i, directions[first + std::min(i, count - 1)]);
    if (!levels.uniform) kernels_->places(direction, direction, mirror_like, uv);
    kernels_->specular(levels, uv, rough, result);
    for (size_t i = 0; i < count; ++i) found[first + i] = vector_at(result, i);
  }
}

void EnvironmentLanes::specular(std::span<const glm::vec3> directions, float roughness, glm::vec3* radiance) const {
  look_up(specular_, directions, roughness, radiance);
}

void EnvironmentLanes::irradiance(std::span<const glm::vec3> directions, glm::vec3* light) const {
  look_up(irradiance_, directions, 0.0f, light);
}

}  // namespace sideray::rt
