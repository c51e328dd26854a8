#include "model/placement.h"

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"
#include "model/failure.h"
#include "model/material.h"
#include "model/wind.h"

namespace sideray::model {
namespace {

// Limits factors and intensities, so that their products stay in the range of floats.
constexpr float largest_factor = 1e15f;
constexpr double origin_step = 1024.0;
constexpr float shines_all_around = -2.0f;  // below every cosine

glm::dmat4x3 affine(const double* columns) {
  glm::dmat4x3 m;
  for (int c = 0; c < 4; ++c) m[c] = glm::dvec3(columns[3 * c], columns[3 * c + 1], columns[3 * c + 2]);
  return m;
}

Bounds transformed(const Bounds& bounds, const glm::mat4x3& m) {
  Bounds result;
  if (bounds.empty()) return result;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 p((corner & 1) ? bounds.maximum.x : bounds.minimum.x,
                      (corner & 2) ? bounds.maximum.y : bounds.minimum.y,
                      (corner & 4) ? bounds.maximum.z : bounds.minimum.z);
    result.add(m * glm::vec4(p, 1.0f));
  }
  return result;
}

// Returns the inverse transpose of a linear map, for directions that are normalized later. It is scaled by a power of
// two, which changes no direction, so that its largest entry is near 1: in thin shapes entries may exceed the range of
// floats, and infinity times 0 is NaN in every normal.
glm::mat3 normal_map(const glm::dmat3& linear) {
  const glm::dmat3 map = glm::transpose(glm::inverse(linear));
  double largest = 0.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(map[c][r]));
  return glm::mat3(map * std::ldexp(1.0, -std::ilogb(largest)));
}

glm::vec3 vector(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

bool has_place(const sideray_fixed_light& l) {
  return l.position[3] != 0.0;
}

bool is_spot(const sideray_fixed_light& l) {
  return has_place(l) && l.spot_cutoff_deg < 180.0f;
}

void check_place(const sideray_fixed_light& l, size_t index) {
  const glm::dvec3 xyz(l.position[0], l.position[1], l.position[2]);
  const double most = has_place(l) ? 1e15 * std::abs(l.position[3]) : 1e15;
  for (const double p : l.position)
    if (!std::isfinite(p) || !(std::abs(p) <= std::max(most, 1e15)))
      fail(SIDERAY_INVALID_ARGUMENT, "fixed light {}: position must be finite and xyz / w at most 1e15", index);
  if (!has_place(l) && !(glm::length(xyz) > 1e-12))
    fail(SIDERAY_INVALID_ARGUMENT, "fixed light {}: position w is 0 and xyz no direction; give the way to the light", index);
}

void check_fixed_light(const sideray_fixed_light& l, size_t index) {
  check_fixed_color(l.ambient, "fixed light ambient");
  check_fixed_color(l.diffuse, "fixed light diffuse");
  check_fixed_color(l.specular, "fixed light specular");
  check_place(l, index);
  check_fixed_exponent(l.spot_exponent, "fixed light spot_exponent");
  if (!(l.spot_cutoff_deg == 180.0f || (l.spot_cutoff_deg >= 0.0f && l.spot_cutoff_deg <= 90.0f)))
    fail(SIDERAY_INVALID_ARGUMENT, "fixed light {}: spot_cutoff_deg is {}; give 0 to 90, or 180", index, l.spot_cutoff_deg);
  const float axis = glm::length(vector(l.spot_direction));
  if (is_spot(l) && !(axis > 1e-12f && std::isfinite(axis)))
    fail(SIDERAY_INVALID_ARGUMENT, "fixed light {}: spot_direction must be finite and not zero", index);
  float sum = 0.0f;
  for (const float a : {l.constant_attenuation, l.linear_attenuation, l.quadratic_attenuation}) {
    if (!(a >= 0.0f && a <= largest_factor))
      fail(SIDERAY_INVALID_ARGUMENT, "fixed light {}: an attenuation is {}; give 0 to 1e15", index, a);
    sum += a;
  }
  if (!(sum > 0.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "fixed light {}: all its attenuations are 0; OpenGL's constant one is 1", index);
}

FixedLight local_fixed_light(const sideray_fixed_light& l, glm::dvec3 origin) {
  FixedLight light{};
  const glm::dvec3 xyz(l.position[0], l.position[1], l.position[2]);
  light.distant = !has_place(l);
  light.place = glm::vec3(light.distant ? glm::normalize(xyz) : xyz / l.position[3] - origin);
  light.ambient = vector(l.ambient), light.diffuse = vector(l.diffuse), light.specular = vector(l.specular);
  light.axis = is_spot(l) ? glm::normalize(vector(l.spot_direction)) : glm::vec3(0, 0, -1);
  light.exponent = is_spot(l) ? l.spot_exponent : 0.0f;
  light.cos_cutoff = is_spot(l) ? elementary::cos(glm::radians(l.spot_cutoff_deg)) : shines_all_around;
  light.attenuation = light.distant ? glm::vec3(1, 0, 0)
                                    : glm::vec3(l.constant_attenuation, l.linear_attenuation, l.quadratic_attenuation);
  light.casts_shadows = l.casts_shadows != 0;
  return light;
}

}  // namespace

void check_transform(const double* m, size_t index) {
  for (int i = 0; i < 12; ++i)
    if (!std::isfinite(m[i]) || std::abs(m[i]) > 1e15)
      fail(SIDERAY_INVALID_ARGUMENT, "instance {}: world_from_object[{}] is {}; give finite numbers up to 1e15", index,
           i, m[i]);
  const glm::dmat4x3 a = affine(m);
  const double determinant = glm::determinant(glm::dmat3(a[0], a[1], a[2]));
  if (!(std::abs(determinant) > 1e-30))
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: world_from_object cannot be inverted (determinant {}); leave it out",
         index, determinant);
}

void check_light(const sideray_light& l, size_t index) {
  const bool directional = l.type == SIDERAY_LIGHT_DIRECTIONAL;
  if (l.type < SIDERAY_LIGHT_DIRECTIONAL || l.type > SIDERAY_LIGHT_SPOT)
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: type {} is not a sideray_light_type", index, static_cast<int>(l.type));
  for (const float i : l.intensity)
    if (!(i >= 0.0f && i <= largest_factor))
      fail(SIDERAY_INVALID_ARGUMENT, "light {}: intensity holds {}; give 0 to 1e15", index, i);
  const float length = elementary::hypot(l.direction[0], l.direction[1], l.direction[2]);
  if (l.type != SIDERAY_LIGHT_POINT && !(length > 1e-12f && std::isfinite(length)))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: direction must be finite and not zero", index);
  for (const double p : l.position)
    if (!directional && !(std::abs(p) <= 1e15))
      fail(SIDERAY_INVALID_ARGUMENT, "light {}: position must be finite and at most 1e15", index);
  if (!(l.range >= 0.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: range {} is negative; 0 = unlimited", index, l.range);
  if (!(l.radius >= 0.0f && std::isfinite(l.radius)))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: radius {} must be finite and not negative", index, l.radius);
  if (!(l.angular_diameter_deg >= 0.0f && l.angular_diameter_deg < 180.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: angular_diameter_deg {} must be 0 or more and below 180", index,
         l.angular_diameter_deg);
  if (l.type == SIDERAY_LIGHT_SPOT && !(l.inner_cone >= 0.0f && l.inner_cone < l.outer_cone && l.outer_cone <= 1.5708f))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: cones {} and {} break 0 <= inner < outer <= pi/2", index, l.inner_cone,
         l.outer_cone);
}

void OriginChoice::add(const double* m) {
  const glm::dvec3 p(m[9], m[10], m[11]);
  low_ = glm::min(low_, p);
  high_ = glm::max(high_, p);
}

glm::dvec3 OriginChoice::origin() const {
  if (low_.x > high_.x) return glm::dvec3(0);
  return glm::round(0.5 * (low_ + high_) / origin_step) * origin_step;
}

Instance local_instance(const sideray_instance_desc& d, glm::dvec3 origin, const Mesh& mesh, const Wind* wind) {
  Instance instance{};
  glm::dmat4x3 m = affine(d.world_from_object);
  m[3] -= origin;
  instance.local_from_object = glm::mat4x3(m);
  const glm::dmat3 linear(m[0], m[1], m[2]);
  instance.normal_from_object = normal_map(linear);
  instance.mirrored = glm::determinant(linear) < 0;
  instance.surface_id = d.surface_id;
  instance.visibility = d.visibility;
  instance.wind = d.wind;
  instance.wind_phase = d.wind_phase;
  instance.user = d.user;
  instance.bounds = transformed(wind ? reached_in_wind(mesh.bounds, *wind) : mesh.bounds, instance.local_from_object);
  return instance;
}

Light local_light(const sideray_light& l, glm::dvec3 origin) {
  Light light{};
  light.type = l.type;
  light.position = glm::vec3(glm::dvec3(l.position[0], l.position[1], l.position[2]) - origin);
  const glm::vec3 direction(l.direction[0], l.direction[1], l.direction[2]);
  light.direction = l.type == SIDERAY_LIGHT_POINT ? glm::vec3(0, -1, 0) : glm::normalize(direction);
  light.intensity = glm::vec3(l.intensity[0], l.intensity[1], l.intensity[2]);
  light.range = l.range;
  light.cos_inner = elementary::cos(l.inner_cone);
  light.cos_outer = elementary::cos(l.outer_cone);
  light.radius = l.radius;
  light.angular_radius = 0.5f * glm::radians(l.angular_diameter_deg);
  light.filter_radius = l.shadow_filter_radius == 0.0f ? 32.0f : l.shadow_filter_radius;
  light.filter_frames = l.shadow_filter_frames == 0 ? 8 : l.shadow_filter_frames;
  return light;
}

void check_fixed_function(const FixedDesc& model) {
  check_fixed_color(model.desc.ambient, "fixed function ambient");
  for (size_t i = 0; i < model.lights.size(); ++i) check_fixed_light(model.lights[i], i);
  if (const auto space = static_cast<int>(model.desc.radiance_space);
      space < SIDERAY_SPACE_LINEAR || space > SIDERAY_SPACE_GAMMA22)
    fail(SIDERAY_INVALID_ARGUMENT, "fixed function radiance_space {}: give a sideray_radiance_space", space);
}

FixedFunction local_fixed_function(const FixedDesc& model, glm::dvec3 origin) {
  FixedFunction fixed{};
  for (const sideray_fixed_light& light : model.lights) fixed.lights.push_back(local_fixed_light(light, origin));
  fixed.ambient = vector(model.desc.ambient);
  fixed.local_viewer = model.desc.local_viewer != 0;
  fixed.two_sided = model.desc.two_sided != 0;
  fixed.separate_specular = model.desc.separate_specular != 0;
  return fixed;
}

}  // namespace sideray::model
