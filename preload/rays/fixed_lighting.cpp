#include "preload/rays/fixed_lighting.h"

#include <cmath>

#include "shaders/shading/shading_cpp.h"

namespace sideray::run {
namespace {

using shading::real3;

real3 vector(const float v[3]) {
  return {v[0], v[1], v[2]};
}

shading::SrFixedLight light_of(const FixedLight& from, const Lighting& lighting) {
  constexpr float radians = 0.017453292520f;
  shading::SrFixedLight light{};
  const bool is_distant = from.position[3] == 0.0f;
  light.distant = is_distant ? 1.0f : 0.0f;
  light.place = is_distant ? glm::normalize(vector(from.position)) : vector(from.position) / from.position[3];
  light.ambient = vector(from.ambient), light.diffuse = vector(from.diffuse), light.specular = vector(from.specular);
  light.axis = glm::normalize(vector(from.spot_direction));
  light.exponent = from.spot_exponent;
  light.cos_cutoff = from.spot_cutoff >= 180.0f || is_distant ? -2.0f : std::cos(from.spot_cutoff * radians);
  light.attenuation = vector(from.attenuation);
  light.viewer = {0, 0, 1};
  light.local_viewer = lighting.local_viewer ? 1.0f : 0.0f;
  return light;
}

// Returns a surface that is lit on the side that the ray hits. Its colour is clamped before the texture modulates it.
shading::SrSurface surface_of(const DrawMaterial& material, const sideray_shading_point& point) {
  shading::SrSurface surface{};
  surface.normal = vector(point.normal);
  surface.metallic = 1;
  surface.along = vector(material.ambient);
  surface.diffuse = vector(material.diffuse);
  surface.sheen = vector(material.specular);
  surface.coat_roughness = material.shininess;
  return surface;
}

}  // namespace

void light_point(const Lighting& lighting, const DrawMaterial& material, const sideray_shading_point& point, float color[3]) {
  const shading::SrSurface surface = surface_of(material, point);
  const real3 position(point.position[0], point.position[1], point.position[2]), to_eye = vector(point.to_eye);
  real3 lit = vector(material.emission) + vector(lighting.scene_ambient) * surface.along;
  for (int i = 0; i < lighting.lights; ++i) {
    const shading::SrFixedLight light = light_of(lighting.light[i], lighting);
    const shading::SrFixedIncidence incidence = shading::sr_fixed_incidence(light, position);
    const shading::SrFixedGain gain = shading::sr_fixed_gain(surface, light, incidence, to_eye);
    lit += gain.lit + gain.shine + shading::sr_fixed_ambient(surface, light, incidence);
  }
  for (int c = 0; c < 3; ++c) color[c] = glm::clamp(glm::clamp(lit[c], 0.0f, 1.0f) * point.base_color[c], 0.0f, 1.0f);
}

}  // namespace sideray::run
