#include "rt/refraction/refraction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/hemisphere.h"
#include "model/material.h"
#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

constexpr float smooth_roughness = 0.04f;

// Returns the direction in which a facet lets light through. The BTDF of a thin wall, which refracts twice, is its lobe
// of reflection on the other side (KHR_materials_transmission).
Bend through_facet(const SurfacePoint& point, glm::vec3 facet, const Crossing& crossing) {
  if (crossing.ior_from != crossing.ior_to) return bend(point.to_eye, facet, crossing.ior_from, crossing.ior_to);
  const glm::vec3 mirrored = facet * (2.0f * glm::dot(facet, point.to_eye)) - point.to_eye;
  const glm::vec3 normal = facing_normal(point);
  return {mirrored - normal * (2.0f * glm::dot(normal, mirrored)), 1.0f, false};
}

}  // namespace

bool MediumStack::contains(uint32_t instance) const {
  return std::find(instances_.begin(), instances_.begin() + count_, instance) != instances_.begin() + count_;
}

bool MediumStack::push(uint32_t instance) {
  if (count_ == capacity) return false;
  instances_[count_++] = instance;
  return true;
}

void MediumStack::remove(uint32_t instance) {
  for (uint32_t i = count_; i-- > 0;) {
    if (instances_[i] != instance) continue;
    std::copy(instances_.begin() + i + 1, instances_.begin() + count_, instances_.begin() + i);
    --count_;
    return;
  }
}

bool bends_light(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.materials.begin(), snapshot.materials.end(),
                     [](const model::Material& m) { return model::bends_light(m.desc); });
}

RefractionScene::RefractionScene(std::shared_ptr<const model::Snapshot> committed) : surfaces(std::move(committed)) {
  for (size_t i = 0; i < surfaces.materials.size(); ++i) {
    shading::SrMaterial& m = surfaces.materials[i];
    const bool volume = model::has_volume(surfaces.snapshot->materials[i].desc);
    materials.push_back({volume, m.ior, volume ? model::index_spread(surfaces.snapshot->materials[i].desc) : 0.0f,
                         volume ? m.absorption : glm::vec3(0.0f)});
    bends.push_back(model::bends_light(surfaces.snapshot->materials[i].desc));
    m.thickness = 0.0f;
  }
  surfaces.records = make_records(*surfaces.snapshot, surfaces.materials, surfaces.textures);
}

glm::vec3 RefractionScene::transmittance(const MediumStack& media, float distance) const {
  if (media.empty()) return glm::vec3(1.0f);
  const glm::vec3 absorption = medium(media.top()).absorption;
  glm::vec3 through(1.0f);
  for (int c = 0; c < 3; ++c)
    if (absorption[c] > 0.0f) through[c] = std::exp(-absorption[c] * distance);
  return through;
}

Crossing cross(const RefractionScene& scene, const Hit& hit, bool from_eye, MediumStack& media, Light light) {
  const uint32_t before = media.top();
  const float ior_before = scene.ior(media, light), own = RefractionScene::ior_of(scene.medium(hit.instance), light);
  const bool inside = media.contains(hit.instance), solid = scene.surfaces.snapshot->instances[hit.instance].solid;
  const bool enters = solid ? hit.front : !inside, dispersed = scene.disperses(media);
  Crossing crossing{false, ior_before, ior_before, no_instance, false};
  if (enters) {
    if (!media.push(hit.instance)) return crossing;
  } else if (inside) {
    media.remove(hit.instance);
  } else {
    if (!from_eye || !media.empty()) return crossing;
    return {true, own, 1.0f, hit.instance, light == Light::all && scene.medium(hit.instance).spread > 0.0f};
  }
  crossing.interface = media.top() != before;
  crossing.ior_to = scene.ior(media, light);
  crossing.disperses = light == Light::all && (dispersed || scene.disperses(media));
  return crossing;
}

Bend bend(glm::vec3 to_eye, glm::vec3 normal, float ior_from, float ior_to) {
  const float ratio = ior_from / ior_to, cosine = std::min(glm::dot(normal, to_eye), 1.0f);
  if (ratio == 1.0f) return {-to_eye, cosine, false};
  const float square = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
  if (square < 0.0f) return {glm::normalize(normal * (2.0f * cosine) - to_eye), 0.0f, true};
  const float behind = std::sqrt(square);
  return {glm::normalize(normal * (ratio * cosine - behind) - to_eye * ratio), ratio > 1.0f ? behind : cosine, false};
}

float dielectric_reflectance(float cosine, float ior_from, float ior_to) {
  const float low = std::min(ior_from, ior_to), high = std::max(ior_from, ior_to), ratio = low / high;
  const float other = std::sqrt(1.0f - ratio * ratio * (1.0f - cosine * cosine));
  const float s = (low * cosine - high * other) / (low * cosine + high * other);
  const float p = (high * cosine - low * other) / (high * cosine + low * other);
  return 0.5f * (s * s + p * p);
}

void set_reflectance(const Crossing& crossing, float cosine, shading::SrSurface& surface) {
  if (crossing.ior_from == 1.0f) return;
  const glm::vec3 reflected = crossing.ior_to == 1.0f
                                  ? shading::sr_fresnel(surface.f0, surface.f90, cosine)
                                  : surface.f90 * dielectric_reflectance(cosine, crossing.ior_from, crossing.ior_to);
  // So much leaves it in all, however rough it is.
  const float kept = surface.albedo_terms.x + surface.albedo_terms.y;
  surface.f0 = surface.f90 = glm::min(reflected, glm::vec3(1.0f)) / std::clamp(kept, 0.05f, 1.0f);
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
