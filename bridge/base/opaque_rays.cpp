#include "bridge/base/opaque_rays.h"

#include <algorithm>

namespace sideray::bridge {
namespace {

bool shines(glm::vec3 light) {
  return light.x > 0.0f || light.y > 0.0f || light.z > 0.0f;
}

bool has_light(const model::Snapshot& snapshot) {
  if (snapshot.environment->mean > 0.0f) return true;
  if (std::ranges::any_of(snapshot.lights, [](const model::Light& l) { return shines(l.intensity); })) return true;
  return std::ranges::any_of(snapshot.instances, [&](const model::Instance& i) {
    const float* emissive = snapshot.materials[i.material].desc.emissive;
    return shines({emissive[0], emissive[1], emissive[2]});
  });
}

bool has_mirror(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.instances.begin(), snapshot.instances.end(),
                     [&](const model::Instance& i) { return snapshot.materials[i.material].mirrors; });
}

}  // namespace

OpaqueRays opaque_rays_of(const model::Snapshot& snapshot) {
  OpaqueRays chosen{};
  if (!(snapshot.environment->mean > 0.0f)) chosen.why_no_ao = "no ambient occlusion: no light comes from the surroundings";
  if (!has_light(snapshot)) chosen.why_no_bounce = "no light bounces: nothing sends any";
  if (snapshot.fixed) chosen.why_no_bounce = "no light bounces: the fixed function knows none that does";
  if (!has_mirror(snapshot)) chosen.why_no_reflections = "no opaque surface is smooth enough to mirror what rays hit";
  return chosen;
}

}  // namespace sideray::bridge
