#include "scenes/content/animated_values.h"

#include <algorithm>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"

namespace sideray::scenes {

std::array<double, 6> texture_from_uv(const TextureTransform& t) {
  const double c = elementary::cos(t.rotation), s = elementary::sin(t.rotation);
  return {c * t.scale.x, -s * t.scale.x, s * t.scale.y, c * t.scale.y, t.offset.x, t.offset.y};
}

float inner_cone_of(double inner, float outer) {
  const auto given = static_cast<float>(inner);
  return given < outer ? given : 0.9999f * outer;
}

void set_values(const AnimatedMaterial& animated, double time_s, Content& content) {
  MaterialValues values = animated.at(time_s);
  for (int c = 0; c < 3; ++c) values.desc.emissive[c] = values.emissive_factor[c] * values.emissive_strength;
  for (size_t i = 0; i < material_slots.size(); ++i) {
    if (!values.changes_transform[i]) continue;
    const std::array<double, 6> matrix = texture_from_uv(values.transforms[i]);
    sideray_texture_slot& slot = values.desc.*material_slots[i].slot;
    std::transform(matrix.begin(), matrix.end(), slot.texture_from_uv, [](double x) { return static_cast<float>(x); });
  }
  for (const AnimatedMaterial::Shown& shown : animated.shown) {
    sideray_material_desc& desc = content.materials[shown.material].desc;
    desc = values.desc;
    desc.thickness *= shown.thickness_scale;
  }
}

void set_values(const AnimatedLight& animated, double time_s, bool is_hidden, Content& content) {
  const LightValues values = animated.at(time_s);
  sideray_light& light = content.lights[animated.light].light;
  for (int c = 0; c < 3; ++c)
    light.intensity[c] = is_hidden ? 0.0f : static_cast<float>(values.color[c] * values.intensity);
  if (light.type != SIDERAY_LIGHT_DIRECTIONAL) light.range = static_cast<float>(values.range);
  if (light.type != SIDERAY_LIGHT_SPOT) return;
  light.outer_cone = std::min(static_cast<float>(values.outer_cone), glm::half_pi<float>());
  light.inner_cone = inner_cone_of(values.inner_cone, light.outer_cone);
}

void set_values(const AnimatedCamera& animated, double time_s, Content& content) {
  const sideray_camera values = animated.at(time_s);
  sideray_camera& camera = content.cameras[animated.camera].camera;
  camera.yfov = values.yfov, camera.half_height = values.half_height;
  camera.z_near = values.z_near, camera.z_far = values.z_far;
}

}  // namespace sideray::scenes
