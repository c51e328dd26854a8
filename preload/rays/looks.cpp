#include "preload/rays/looks.h"

#include <algorithm>
#include <cstring>

namespace sideray::run {
namespace {

sideray_fixed_light fixed_light(const FixedLight& light) {
  sideray_fixed_light fixed = sideray_fixed_light_defaults();
  std::copy_n(light.ambient, 3, fixed.ambient);
  std::copy_n(light.diffuse, 3, fixed.diffuse);
  std::copy_n(light.specular, 3, fixed.specular);
  std::copy_n(light.position, 4, fixed.position);
  std::copy_n(light.spot_direction, 3, fixed.spot_direction);
  fixed.spot_exponent = light.spot_exponent;
  fixed.spot_cutoff_deg = light.spot_cutoff;
  fixed.constant_attenuation = light.attenuation[0];
  fixed.linear_attenuation = light.attenuation[1];
  fixed.quadratic_attenuation = light.attenuation[2];
  return fixed;
}

}  // namespace

void Looks::clear() {
  looks_.clear();
  lits_.clear();
}

const sideray_fixed_function* Looks::lighting_now() {
  const Lighting now = run::read_lighting();
  if (!lits_.empty() && std::memcmp(&lits_.back().as_read, &now, sizeof(now)) == 0) return &lits_.back().function;
  Lit& lit = lits_.emplace_back();
  lit.as_read = now;
  for (int i = 0; i < now.lights; ++i) lit.lights.push_back(fixed_light(now.light[i]));
  lit.function = sideray_fixed_function_defaults();
  lit.function.lights = lit.lights.data();
  lit.function.light_count = lit.lights.size();
  std::copy_n(now.scene_ambient, 3, lit.function.ambient);
  lit.function.local_viewer = now.local_viewer;
  lit.function.two_sided = 1;  // a mirror shows sides that the eye never sees
  return &lit.function;
}

Looks::Look Looks::look_of(const DrawState& state, const float tint[4]) {
  Look look;
  std::copy_n(tint, 3, look.tint);
  look.second_texture = state.texture[1] != 0;
  if (!state.lighting) return look;
  look.lighting = lighting_now();
  look.material = sideray_fixed_material_defaults();
  // With GL_COLOR_MATERIAL the colours of the vertices are the material's.
  for (int c = 0; c < 3; ++c) {
    look.material.ambient[c] = state.color_material ? 1.0f : state.material.ambient[c];
    look.material.diffuse[c] = state.color_material ? 1.0f : state.material.diffuse[c];
  }
  std::copy_n(state.material.specular, 3, look.material.specular);
  std::copy_n(state.material.emission, 3, look.material.emission);
  look.material.shininess = state.material.shininess;
  return look;
}

uint64_t Looks::add(const DrawState& state, const float tint[4]) {
  looks_.push_back(look_of(state, tint));
  return looks_.size() - 1;
}

uint64_t Looks::add_mirror(const DrawState& state, const float tint[4]) {
  looks_.push_back(look_of(state, tint));
  looks_.back().mirrors = true;
  return looks_.size() - 1;
}

void Looks::shade(const Look& look, const sideray_shading_point& point, sideray_shading_result& result) {
  const bool is_seen_first = point.bounce == 0;
  for (float& reflectance : result.reflectance) reflectance = look.mirrors && is_seen_first ? 1.0f : 0.0f;
  if (look.mirrors && is_seen_first) {
    for (float& radiance : result.radiance) radiance = 0;
    return;
  }
  if (look.lighting)
    sideray_fixed_color(look.lighting, &look.material, &point, result.radiance);
  else
    std::copy_n(point.base_color, 3, result.radiance);
  for (int c = 0; c < 3; ++c) {
    result.radiance[c] *= look.tint[c];
    if (look.second_texture) result.radiance[c] *= point.emissive[c];
  }
}

void Looks::shade(void* user, const sideray_shading_point* points, size_t count, sideray_shading_result* results) {
  const Looks& looks = *static_cast<const Looks*>(user);
  for (size_t i = 0; i < count; ++i)
    if (points[i].user < looks.looks_.size()) shade(looks.looks_[points[i].user], points[i], results[i]);
}

}  // namespace sideray::run
