#include "rt/refraction/refraction.h"

#include <algorithm>
#include <cmath>

#include "model/hemisphere.h"
#include "model/material.h"
#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

constexpr float smooth_roughness = 0.04f;
constexpr uint32_t facet_purpose = 67;
constexpr uint32_t tries = 8;  // of facets, before the shading normal stands for one

// Samples the facets of a rough surface that its viewer sees (Heitz 2018).
class VisibleFacets {
 public:
  explicit VisibleFacets(const SurfacePoint& point)
      : frame_(facing_normal(point)), alpha_(point.surface.roughness * point.surface.roughness) {
    to_eye_ = {glm::dot(frame_.x, point.to_eye), glm::dot(frame_.y, point.to_eye), glm::dot(frame_.z, point.to_eye)};
  }
  glm::vec3 sample(uint32_t key) const {
    const uint32_t x = hash_bits(key), y = hash_bits(x);
    return frame_.world(model::sample_visible_normal(to_eye_, alpha_, {unit_float(x), unit_float(y)}));
  }

 private:
  model::Frame frame_;
  glm::vec3 to_eye_;
  float alpha_;
};

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
  const VisibleFacets facets(point);
  for (uint32_t k = 0; k < tries; ++k) {
    const glm::vec3 facet = facets.sample(key + k);
    if (glm::dot(facet, point.to_eye) <= 0.0f) continue;
    const Bend b = through_facet(point, facet, crossing);
    if (!b.total && glm::dot(b.direction, point.geometric_normal) < 0.0f) return b.direction;
  }
  return through_facet(point, facing_normal(point), crossing).direction;
}

RoughTurn turned_by_facet(const SurfacePoint& point, const Crossing& crossing, uint32_t key) {
  const VisibleFacets facets(point);
  for (uint32_t k = 0; k < tries; ++k) {
    const glm::vec3 facet = facets.sample(key + k);
    const float cosine = glm::dot(facet, point.to_eye);
    if (cosine <= 0.0f) continue;
    const Bend b = bend(point.to_eye, facet, crossing.ior_from, crossing.ior_to);
    const float reflects = b.total ? 1.0f : dielectric_reflectance(b.cosine, crossing.ior_from, crossing.ior_to);
    const bool transmitted = unit_float(random_key({key, facet_purpose, k})) >= reflects;
    const glm::vec3 direction = transmitted ? b.direction : glm::normalize(facet * (2.0f * cosine) - point.to_eye);
    if ((glm::dot(direction, point.geometric_normal) < 0.0f) == transmitted) return {direction, transmitted};
  }
  return {bend(point.to_eye, facing_normal(point), crossing.ior_from, crossing.ior_to).direction, false};
}

}  // namespace sideray::rt
