#include "preload/rays/fixed_lighting.h"

#include <algorithm>
#include <cmath>

namespace sideray::run {
namespace {

float dot(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Returns the length that the vector had; the null vector stays.
float normalize(float v[3]) {
  const float length = std::sqrt(dot(v, v));
  for (int c = 0; c < 3 && length > 0.0f; ++c) v[c] /= length;
  return length;
}

// Returns which part of a spot's light arrives along -to_light.
float spot_share(const FixedLight& light, const float to_light[3]) {
  constexpr float radians = 0.017453292520f;
  if (light.spot_cutoff >= 180.0f || light.position[3] == 0.0f) return 1.0f;
  float axis[3] = {light.spot_direction[0], light.spot_direction[1], light.spot_direction[2]};
  normalize(axis);
  const float along = -dot(axis, to_light);
  return along < std::cos(light.spot_cutoff * radians) ? 0.0f : std::pow(std::max(along, 0.0f), light.spot_exponent);
}

void add_light(const FixedLight& light, const DrawMaterial& material, const sideray_shading_point& point,
               const float to_viewer[3], float color[3]) {
  const bool is_directional = light.position[3] == 0.0f;
  float to_light[3], halfway[3];
  for (int c = 0; c < 3; ++c)
    to_light[c] = is_directional ? light.position[c]
                                 : light.position[c] / light.position[3] - static_cast<float>(point.position[c]);
  const float distance = normalize(to_light);
  const float* a = light.attenuation;
  const float fade = (is_directional ? 1.0f : 1.0f / (a[0] + a[1] * distance + a[2] * distance * distance)) *
                     spot_share(light, to_light);
  const float toward = dot(point.normal, to_light);
  for (int c = 0; c < 3; ++c) halfway[c] = to_light[c] + to_viewer[c];
  normalize(halfway);
  const float gloss = std::pow(std::max(dot(point.normal, halfway), 0.0f), material.shininess);
  for (int c = 0; c < 3; ++c) {
    color[c] += fade * light.ambient[c] * material.ambient[c];
    if (toward <= 0.0f) continue;
    color[c] += fade * (toward * light.diffuse[c] * material.diffuse[c] + gloss * light.specular[c] * material.specular[c]);
  }
}

}  // namespace

void light_point(const Lighting& lighting, const DrawMaterial& material, const sideray_shading_point& point, float color[3]) {
  constexpr float toward_plane[3] = {0, 0, 1};
  const float* to_viewer = lighting.local_viewer ? point.to_eye : toward_plane;
  for (int c = 0; c < 3; ++c) color[c] = material.emission[c] + lighting.scene_ambient[c] * material.ambient[c];
  for (int i = 0; i < lighting.lights; ++i) add_light(lighting.light[i], material, point, to_viewer, color);
  for (int c = 0; c < 3; ++c) color[c] = std::clamp(std::clamp(color[c], 0.0f, 1.0f) * point.base_color[c], 0.0f, 1.0f);
}

}  // namespace sideray::run
