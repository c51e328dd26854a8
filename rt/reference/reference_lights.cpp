#include "rt/reference/reference_lights.h"

#include <cmath>

#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

// Largest radius as a share of the distance: a sphere around the point shrinks to it.
constexpr float nearest_to_center = 0.999f;

}  // namespace

std::vector<ReferenceLight> reference_lights(const model::Snapshot& snapshot) {
  std::vector<ReferenceLight> lights;
  for (const model::Light& l : snapshot.lights) {
    if (l.intensity == glm::vec3(0.0f)) continue;
    const bool directional = l.type == SIDERAY_LIGHT_DIRECTIONAL;
    lights.push_back(
        {{l.position, l.direction, l.intensity, l.range, l.cos_inner, l.cos_outer, static_cast<int>(l.type)},
         directional ? 0.0f : l.radius,
         directional ? std::min(l.angular_radius, glm::half_pi<float>()) : 0.0f});
  }
  return lights;
}

LightCone light_cone(const ReferenceLight& l, glm::vec3 position) {
  const shading::SrIncidence in = shading::sr_incidence(l.light, position);
  LightCone cone{in.to_light, glm::vec3(0.0f), 0.0f, in.distance, 0.0f};
  float sine2 = 0.0f;
  if (l.angular_radius > 0.0f) {
    cone.aperture = cone_aperture(l.angular_radius);
    sine2 = cone.aperture * (2.0f - cone.aperture);
    cone.distance = farthest;
  } else {
    cone.radius = std::min(l.radius, nearest_to_center * in.distance);
    cone.aperture = sphere_aperture(cone.radius, in.distance);
    const float sine = cone.radius / in.distance;
    sine2 = sine * sine;
  }
  cone.radiance = in.irradiance * (1.0f / (glm::pi<float>() * sine2));
  return cone;
}

float below_axis(const LightCone& cone, glm::vec3 direction) {
  const float cosine = glm::dot(cone.axis, direction);
  const glm::vec3 across = glm::cross(cone.axis, direction);
  return cosine > 0.0f ? glm::dot(across, across) / (1.0f + cosine) : 1.0f - cosine;
}

float distance_to_light(const LightCone& cone, float below) {
  return cone.radius > 0.0f ? distance_to_sphere(cone.radius, cone.distance, below) : cone.distance;
}

}  // namespace sideray::rt
