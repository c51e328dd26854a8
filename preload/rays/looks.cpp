#include "preload/rays/looks.h"

#include <algorithm>
#include <cstring>

namespace sideray::run {

void Looks::clear() {
  looks_.clear();
  lightings_.clear();
}

const Lighting* Looks::lighting_now() {
  const Lighting now = run::read_lighting();
  if (lightings_.empty() || std::memcmp(&lightings_.back(), &now, sizeof(now)) != 0) lightings_.push_back(now);
  return &lightings_.back();
}

Looks::Look Looks::look_of(const DrawState& state, const float tint[4]) {
  Look look;
  std::copy_n(tint, 3, look.tint);
  look.second_texture = state.texture[1] != 0;
  if (!state.lighting) return look;
  look.lighting = lighting_now();
  look.material = state.material;
  // With GL_COLOR_MATERIAL the colours of the vertices are the material's.
  for (int c = 0; c < 3 && state.color_material; ++c) look.material.ambient[c] = look.material.diffuse[c] = 1.0f;
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
    light_point(*look.lighting, look.material, point, result.radiance);
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
