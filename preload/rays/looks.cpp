#include "preload/rays/looks.h"

#include <algorithm>
#include <cmath>

namespace sideray::run {
namespace {

// Returns the fixed function's fog coordinate of a hit in a plane mirror: the depth of the mirror image before the eye.
float mirrored_depth(const sideray_shading_point& point) {
  float mirror[3], length = 0;
  for (int c = 0; c < 3; ++c) {
    mirror[c] = static_cast<float>(point.position[c]) + point.to_eye[c] * point.distance;
    length += mirror[c] * mirror[c];
  }
  length = std::sqrt(length);
  return length > 0 ? std::abs(mirror[2]) * (1 + point.distance / length) : point.distance;
}

// Returns 1 for the surface that the eye sees first, whose reflection is weighted when it is drawn. Behind refracting
// glass, returns Schlick's share.
float reflected_share(float reflectance, const sideray_shading_point& point) {
  double square = 0;
  for (const double p : point.position) square += p * p;
  if (std::abs(static_cast<double>(point.distance) - std::sqrt(square)) <= 1e-3 * std::sqrt(square)) return 1;
  float cosine = 0;
  for (int c = 0; c < 3; ++c) cosine += point.normal[c] * point.to_eye[c];
  return reflectance + (1 - reflectance) * std::pow(1 - std::clamp(cosine, 0.0f, 1.0f), 5.0f);
}

// The OpenGL Graphics System, version 2.1, section 3.10.
float share_in_fog(const Fog& fog, float depth) {
  float share = 0;
  if (fog.mode == GL_LINEAR)
    share = fog.end != fog.start ? (fog.end - depth) / (fog.end - fog.start) : 1;
  else
    share = std::exp(-(fog.mode == GL_EXP2 ? fog.density * depth * fog.density * depth : fog.density * depth));
  return std::clamp(share, 0.0f, 1.0f);
}

}  // namespace

Looks::Look Looks::look_of(const DrawState& state, const float tint[4]) {
  Look look;
  std::copy_n(tint, 3, look.tint);
  look.second_texture = state.texture(1) != 0;
  look.fog = state.fog;
  if (!state.lighting || state.shows_texture_alone()) return look;
  look.lighting = state.lights;
  look.material = state.material;
  // With GL_COLOR_MATERIAL the colours of the vertices are the material's.
  for (int c = 0; c < 3 && state.color_material; ++c) look.material.ambient[c] = look.material.diffuse[c] = 1.0f;
  return look;
}

uint64_t Looks::add(const DrawState& state, const float tint[4]) {
  looks_.push_back(look_of(state, tint));
  return looks_.size() - 1;
}

uint64_t Looks::add_mirror(const DrawState& state, const float tint[4], float reflectance) {
  looks_.push_back(look_of(state, tint));
  looks_.back().mirrors = true;
  looks_.back().reflectance = reflectance;
  return looks_.size() - 1;
}

uint64_t Looks::add_clear() {
  looks_.emplace_back().clear = true;
  return looks_.size() - 1;
}

void Looks::shade(const Look& look, const sideray_shading_point& point, sideray_shading_result& result) {
  // Rays from the eye, straight or refracted, find no radiance on it; mirrors show it as a lit surface.
  const bool is_translucent = (look.mirrors || look.clear) && point.bounce == 0;
  for (float& reflectance : result.reflectance) reflectance = look.mirrors && is_translucent ? reflected_share(look.reflectance, point) : 0.0f;
  if (is_translucent) {
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
  if (!look.fog.on) return;
  const float share = share_in_fog(look.fog, mirrored_depth(point));
  for (int c = 0; c < 3; ++c) result.radiance[c] = share * result.radiance[c] + (1 - share) * look.fog.color[c];
}

void Looks::shade(void* user, const sideray_shading_point* points, size_t count, sideray_shading_result* results) {
  const Looks& looks = *static_cast<const Looks*>(user);
  for (size_t i = 0; i < count; ++i)
    if (points[i].user < looks.looks_.size()) shade(looks.looks_[points[i].user], points[i], results[i]);
}

}  // namespace sideray::run
