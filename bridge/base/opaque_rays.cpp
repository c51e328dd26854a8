#include "bridge/base/opaque_rays.h"

#include <algorithm>
#include <glm/gtc/constants.hpp>

namespace sideray::bridge {
namespace {

// Where the sky sends less, what hides it is lit by the sun, and throws back more than it hides: with ambient occlusion
// pictures are farther from light that bounces (docs/adr/0034-opaque-rays.md).
constexpr float least_share = 0.5f;

float mean(glm::vec3 v) {
  return (v.x + v.y + v.z) / 3.0f;
}

// Returns which share of the light the environment sends: its irradiance beside that of directional lights, each the mean
// over all ways in which a surface may be turned. Lamps light a part of a scene only, and which one changes as things move.
float environment_share(const model::Snapshot& snapshot) {
  constexpr float facing = 0.25f;  // the mean of cosines that are positive
  const float around = glm::pi<float>() * snapshot.environment->mean;
  float sum = around;
  for (const model::Light& light : snapshot.lights)
    if (light.type == SIDERAY_LIGHT_DIRECTIONAL) sum += facing * mean(light.intensity);
  return sum > 0.0f ? around / sum : 0.0f;
}

bool has_mirror(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.instances.begin(), snapshot.instances.end(),
                     [&](const model::Instance& i) { return snapshot.materials[i.material].mirrors; });
}

}  // namespace

OpaqueRays opaque_rays_of(const model::Snapshot& snapshot) {
  OpaqueRays chosen{};
  if (!(snapshot.environment->mean > 0.0f))
    chosen.why_no_ao = "no ambient occlusion: no light comes from the surroundings";
  else if (environment_share(snapshot) < least_share)
    chosen.why_no_ao = "no ambient occlusion: little of the light comes from the surroundings";
  if (!has_mirror(snapshot)) chosen.why_no_reflections = "no opaque surface is smooth enough to mirror what rays hit";
  return chosen;
}

}  // namespace sideray::bridge
