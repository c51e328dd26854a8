#include "rt/refraction/refraction.h"

#include <algorithm>
#include <cmath>

#include "model/hemisphere.h"
#include "model/material.h"
#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

constexpr float smooth_roughness = 0.04f;

// Returns the direction in which a facet transmits light. A thin wall refracts twice; its transmission lobe is its
// reflection lobe on the other side (KHR_materials_transmission).
Bend through_facet(const SurfacePoint& point, glm::vec3 facet, const Crossing& crossing) {
  if (crossing.ior_from != crossing.ior_to) return bend(point.to_eye, facet, crossing.ior_from, crossing.ior_to);
  const glm::vec3 mirrored = facet * (2.0f * glm::dot(facet, point.to_eye)) - point.to_eye;
  const glm::vec3 normal = facing_normal(point);
  return {mirrored - normal * (2.0f * glm::dot(normal, mirrored)), 1.0f, false};
}

}  // namespace

bool bends_light(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.materials.begin(), snapshot.materials.end(),
                     [](const model::Material& m) { return model::bends_light(m.desc); });
}

Bend bend(glm::vec3 to_eye, glm::vec3 normal, float ior_from, float ior_to) {
  const float ratio = ior_from / ior_to, cosine = std::min(glm::dot(normal, to_eye), 1.0f);
  if (ratio == 1.0f) return {-to_eye, cosine, false};
  const float square = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
  if (square < 0.0f) return {glm::normalize(normal * (2.0f * cosine) - to_eye), 0.0f, true};
  const float behind = std::sqrt(square);
  return {glm::normalize(normal * (ratio * cosine - behind) - to_eye * ratio), ratio > 1.0f ? behind : cosine, false};
}

glm::vec3 facing_normal(const SurfacePoint& p) {
  return glm::dot(p.surface.normal, p.to_eye) > 0.0f ? p.surface.normal : p.geometric_normal;
}

bool is_scattered(const SurfacePoint& point) {
  return point.surface.roughness > smooth_roughness && point.surface.tint != glm::vec3(0.0f);
}

glm::vec3 scattered_direction(const SurfacePoint& point, const Crossing& crossing, uint32_t key) {
  constexpr uint32_t tries = 8;
  const glm::vec3 normal = facing_normal(point);
  const model::Frame frame(normal);
  const glm::vec3 to_eye(glm::dot(frame.x, point.to_eye), glm::dot(frame.y, point.to_eye),
                         glm::dot(frame.z, point.to_eye));
  const float alpha = point.surface.roughness * point.surface.roughness;
  for (uint32_t k = 0; k < tries; ++k) {
    const uint32_t x = hash_bits(key + k), y = hash_bits(x);
    const glm::vec3 facet = frame.world(model::sample_visible_normal(to_eye, alpha, {unit_float(x), unit_float(y)}));
    if (glm::dot(facet, point.to_eye) <= 0.0f) continue;
    const Bend b = through_facet(point, facet, crossing);
    if (!b.total && glm::dot(b.direction, point.geometric_normal) < 0.0f) return b.direction;
  }
  return through_facet(point, normal, crossing).direction;
}

}  // namespace sideray::rt
