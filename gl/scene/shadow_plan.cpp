#include "gl/scene/shadow_plan.h"

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"
#include "model/material.h"

namespace sideray::gl {
namespace {

constexpr uint32_t directional_size = 2048, local_size = 1024, smallest_size = 128;
constexpr uint64_t largest_bytes = 256u << 20;  // for all maps together, 4 bytes a texel
constexpr uint32_t border_texels = 4;           // margin around what must be covered, for the filter
constexpr float near_share = 1e-4f;             // near plane, as a share of the distance to the farthest caster
// A cone wider than this (half angle 60 degrees and rounding) would waste most of a single frustum.
constexpr float cos_widest_frustum = 0.4999f;

using Bounds = model::Bounds;

glm::vec3 corner_of(const Bounds& b, int corner) {
  return {(corner & 1) ? b.maximum.x : b.minimum.x, (corner & 2) ? b.maximum.y : b.minimum.y,
          (corner & 4) ? b.maximum.z : b.minimum.z};
}

glm::mat4 texture_from_clip(bool zero_to_one_depth) {
  glm::mat4 m(1.0f);
  m[0][0] = m[1][1] = 0.5f;
  m[3][0] = m[3][1] = 0.5f;
  if (!zero_to_one_depth) m[2][2] = m[3][2] = 0.5f;
  return m;
}

// Returns two unit vectors that make a right-handed frame with `axis`.
void complete_frame(glm::dvec3 axis, glm::dvec3& right, glm::dvec3& up) {
  const glm::dvec3 hint = std::abs(axis.y) < 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  right = glm::normalize(glm::cross(axis, hint));
  up = glm::cross(right, axis);
}

// Returns a matrix of rows right, up, forward, and a translation: maps local space to (x, y, distance along the axis).
glm::dmat4 frame_matrix(glm::dvec3 right, glm::dvec3 up, glm::dvec3 forward, glm::dvec3 origin) {
  const glm::dmat3 turn = glm::transpose(glm::dmat3(right, up, forward));
  glm::dmat4 m(turn);
  m[3] = glm::dvec4(-(turn * origin), 1.0);
  return m;
}

void fit_directional(const model::Light& light, const std::vector<Bounds>& casters, uint32_t size, bool reversed,
                     LightShadow& shadow) {
  const glm::dvec3 forward(light.direction);
  glm::dvec3 right, up;
  complete_frame(forward, right, up);
  const glm::dmat4 frame = frame_matrix(right, up, forward, glm::dvec3(0));
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (const Bounds& b : casters)
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p(frame * glm::dvec4(corner_of(b, corner), 1.0));
      low = glm::min(low, p), high = glm::max(high, p);
    }
  const glm::dvec3 middle = 0.5 * (low + high);
  const double least = 1e-6 * std::max(glm::length(high - low), 1e-6);
  glm::dvec3 half = glm::max(0.5 * (high - low), glm::dvec3(least));
  half.x *= double(size) / (size - 2 * border_texels);
  half.y *= double(size) / (size - 2 * border_texels);
  half.z *= 1.01;
  // Depth falls from 1 to 0 along the light where reversed, and rises from -1 to 1 otherwise.
  glm::dmat4 clip_from_frame(1.0);
  clip_from_frame[0][0] = 1.0 / half.x;
  clip_from_frame[1][1] = 1.0 / half.y;
  clip_from_frame[2][2] = (reversed ? -0.5 : 1.0) / half.z;
  clip_from_frame[3] = glm::dvec4(-middle.x / half.x, -middle.y / half.y,
                                  reversed ? 0.5 + 0.5 * middle.z / half.z : -middle.z / half.z, 1.0);
  shadow.clip_from_local = {glm::mat4(clip_from_frame * frame)};
  shadow.shadow_from_local = texture_from_clip(reversed) * shadow.clip_from_local[0];
  shadow.texel = static_cast<float>(2.0 * std::max(half.x, half.y) / size);
}

// Returns the infinite projection of a frame whose z is the distance: depth near / z where reversed, otherwise 1 - near
// / z.
glm::dmat4 perspective(double tan_half, double near, bool reversed) {
  glm::dmat4 m(0.0);
  m[0][0] = m[1][1] = 1.0 / tan_half;
  m[2][2] = reversed ? 0.0 : 1.0;
  m[3][2] = reversed ? near : -2.0 * near;
  m[2][3] = 1.0;
  return m;
}

void fit_frustum(const model::Light& light, double near, uint32_t size, bool reversed, LightShadow& shadow) {
  const double half_angle = elementary::acos(double{light.cos_outer});
  const double tan_half = elementary::tan(half_angle) * double(size) / (size - 2 * border_texels) + 1e-3;
  const glm::dvec3 forward(light.direction);
  glm::dvec3 right, up;
  complete_frame(forward, right, up);
  const glm::dmat4 frame = frame_matrix(right, up, forward, glm::dvec3(light.position));
  shadow.clip_from_local = {glm::mat4(perspective(tan_half, near, reversed) * frame)};
  shadow.shadow_from_local = texture_from_clip(reversed) * shadow.clip_from_local[0];
  shadow.texel = static_cast<float>(2.0 * tan_half / size);
}

// Fits six squares around the light. Right and up are the next two axes, whatever the sign: some faces are mirrored,
// which is harmless, since both sides cast shadows.
void fit_faces(const model::Light& light, double near, uint32_t size, bool reversed, LightShadow& shadow) {
  const double tan_half = double(size) / (size - 2 * border_texels);
  const glm::dmat4 projection = perspective(tan_half, near, reversed);
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    glm::dvec3 forward(0), right(0), up(0);
    forward[axis] = face % 2 == 0 ? 1 : -1;
    right[(axis + 1) % 3] = 1;
    up[(axis + 2) % 3] = 1;
    shadow.clip_from_local.emplace_back(projection * frame_matrix(right, up, forward, glm::dvec3(light.position)));
  }
  shadow.shadow_from_local[0] =
      reversed ? glm::vec4(0, near, 1.0 / tan_half, 0) : glm::vec4(1, -near, 1.0 / tan_half, 0);
  shadow.texel = static_cast<float>(2.0 * tan_half / size);
}

// Returns the distance from a light to the farthest caster that its range reaches; 0 = none.
float farthest_caster(const model::Light& light, const std::vector<Bounds>& casters) {
  float farthest = 0;
  for (const Bounds& b : casters) {
    const float distance = glm::length(b.center() - light.position), radius = b.radius();
    if (light.range > 0.0f && distance - radius > light.range) continue;
    farthest = std::max(farthest, distance + radius);
  }
  return light.range > 0.0f ? std::min(farthest, light.range) : farthest;
}

// Returns the distance of the near plane. All that it cuts off lies inside the light's sphere, where shadow rays end.
double near_plane(const model::Light& light, ShadowMap map, const std::vector<Bounds>& casters) {
  constexpr double of_faces = 0.57;  // about the cosine of a cube's corner
  const double cosine = map == ShadowMap::faces ? of_faces : double{light.cos_outer};
  return std::max(double{near_share} * double{farthest_caster(light, casters)}, 0.98 * cosine * double{light.radius});
}

ShadowMap map_for(const model::Light& light, const std::vector<Bounds>& casters) {
  if (casters.empty() || light.intensity == glm::vec3(0)) return ShadowMap::none;
  if (light.type == SIDERAY_LIGHT_DIRECTIONAL) return ShadowMap::directional;
  if (farthest_caster(light, casters) <= 0.0f) return ShadowMap::none;
  return light.type == SIDERAY_LIGHT_SPOT && light.cos_outer >= cos_widest_frustum ? ShadowMap::frustum
                                                                                   : ShadowMap::faces;
}

uint64_t bytes_of(const ShadowPlan& plan) {
  return 4 * (uint64_t{plan.directional_size} * plan.directional_size * plan.directional_layers +
              uint64_t{plan.local_size} * plan.local_size * plan.local_layers);
}

// Assigns layers until the driver has no more, then halves the maps' sizes until they fit into the memory.
void choose_sizes(const std::vector<model::Light>& lights, const std::vector<Bounds>& casters,
                  const ShadowLimits& limits, ShadowPlan& plan) {
  for (size_t i = 0; i < lights.size(); ++i) {
    LightShadow& shadow = plan.lights[i];
    const ShadowMap map = map_for(lights[i], casters);
    uint32_t& layers = map == ShadowMap::directional ? plan.directional_layers : plan.local_layers;
    const uint32_t wanted = map == ShadowMap::none ? 0 : map == ShadowMap::faces ? 6 : 1;
    if (wanted == 0 || layers + wanted > limits.largest_layers) continue;
    shadow.map = map;
    shadow.first_layer = layers;
    layers += wanted;
  }
  plan.directional_size = std::min(directional_size, limits.largest_side);
  plan.local_size = std::min(local_size, limits.largest_side);
  while (bytes_of(plan) > largest_bytes && std::max(plan.directional_size, plan.local_size) > smallest_size) {
    plan.local_size = std::max(plan.local_size / 2, smallest_size);
    if (bytes_of(plan) > largest_bytes) plan.directional_size = std::max(plan.directional_size / 2, smallest_size);
  }
}

}  // namespace

std::vector<Bounds> shadow_casters(const model::Snapshot& snapshot) {
  std::vector<Bounds> casters;
  for (const model::Instance& instance : snapshot.instances)
    if ((instance.visibility & SIDERAY_VISIBLE_SHADOW) && !instance.bounds.empty() &&
        (!snapshot.materials[instance.material].translucent ||
         model::tints_light(snapshot.materials[instance.material], instance)))
      casters.push_back(instance.bounds);
  return casters;
}

ShadowPlan plan_shadow_maps(const std::vector<model::Light>& lights, const std::vector<Bounds>& casters,
                            const ShadowLimits& limits) {
  ShadowPlan plan;
  plan.lights.resize(lights.size());
  choose_sizes(lights, casters, limits, plan);
  for (size_t i = 0; i < lights.size(); ++i) {
    LightShadow& shadow = plan.lights[i];
    if (shadow.map == ShadowMap::none) continue;
    if (shadow.map == ShadowMap::directional) {
      fit_directional(lights[i], casters, plan.directional_size, limits.reversed_depth, shadow);
      continue;
    }
    const double near = near_plane(lights[i], shadow.map, casters);
    if (shadow.map == ShadowMap::frustum)
      fit_frustum(lights[i], near, plan.local_size, limits.reversed_depth, shadow);
    else
      fit_faces(lights[i], near, plan.local_size, limits.reversed_depth, shadow);
  }
  return plan;
}

}  // namespace sideray::gl
