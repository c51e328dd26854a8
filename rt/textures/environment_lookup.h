// Samples prefiltered environments and the albedo table on the CPU as the rasterizer does. Any thread may call it.
#pragma once

#include <glm/glm.hpp>

#include "model/snapshot.h"

namespace sideray::rt {

// Returns whether all directions have the same light, so that look-ups need no direction.
inline bool is_uniform(const model::Environment& environment) {
  return environment.black || environment.uniform;
}

// Samples the irradiance as GL does: bilinear between texel centres, u repeats, v clamps. `direction` is unit.
glm::vec3 environment_irradiance(const model::Environment& environment, glm::vec3 direction);

// Samples the prefiltered radiance, linearly between the two levels nearest to the roughness.
glm::vec3 environment_specular(const model::Environment& environment, glm::vec3 direction, float roughness);

// Says where the prefiltered radiance is sampled: uv is sr_latlong of a direction.
struct EnvironmentPlace {
  glm::vec2 uv;
  float roughness;
};

// Samples the prefiltered environment at `place`. SurfaceBatch does the same for many places.
glm::vec3 environment_specular_at(const model::Environment& environment, const EnvironmentPlace& place);

// Samples the table, bilinear and clamped, at (n.v, roughness), both 0..1.
glm::vec3 albedo_and_sheen(const model::AlbedoTable& table, float n_v, float roughness);
glm::vec2 albedo_terms(const model::AlbedoTable& table, float n_v, float roughness);

}  // namespace sideray::rt
