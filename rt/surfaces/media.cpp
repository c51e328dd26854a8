#include "rt/surfaces/media.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "elementary/functions.h"
#include "model/material.h"
#include "model/material_slots.h"

namespace sideray::rt {
namespace {

// Returns whether some texture varies the transmittance of a surface; emission and occlusion textures do not.
bool varies(const std::vector<TextureRead>& reads) {
  return std::any_of(reads.begin(), reads.end(), [](const TextureRead& read) {
    const auto slot = model::material_slots[read.slot].slot;
    return slot != &sideray_material_desc::occlusion_texture && slot != &sideray_material_desc::emissive_texture;
  });
}

// Lobes up to this roughness are mirrors.
constexpr float smooth = 0.04f;

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

RefractionScene::RefractionScene(std::shared_ptr<const model::Snapshot> committed) : surfaces(std::move(committed)) {
  for (size_t i = 0; i < surfaces.materials.size(); ++i) {
    shading::SrMaterial& m = surfaces.materials[i];
    const bool volume = model::has_volume(surfaces.snapshot->materials[i].desc);
    materials.push_back({volume, m.ior, volume ? model::index_spread(surfaces.snapshot->materials[i].desc) : 0.0f,
                         volume ? m.absorption : glm::vec3(0.0f)});
    bends.push_back(model::bends_light(surfaces.snapshot->materials[i].desc));
    m.thickness = 0.0f;
  }
  for (const model::Instance& instance : surfaces.snapshot->instances) {
    if (!model::tints_light(surfaces.snapshot->materials[instance.material], instance)) continue;
    tinting.add(instance.bounds.minimum);
    tinting.add(instance.bounds.maximum);
  }
  surfaces.records = make_records(*surfaces.snapshot, surfaces.materials, surfaces.fixed_materials, surfaces.textures);
}

std::unique_ptr<ShadingScene> lit_scene(const std::shared_ptr<const model::Snapshot>& snapshot) {
  auto scene = std::make_unique<ShadingScene>(snapshot);
  const bool tinted = std::any_of(snapshot->instances.begin(), snapshot->instances.end(), [&](const model::Instance& i) {
    return model::tints_light(snapshot->materials[i.material], i);
  });
  if (!tinted) return scene;
  auto glass = std::make_shared<RefractionScene>(snapshot);
  glass->find_plain(*scene);
  scene->glass = std::move(glass);
  return scene;
}

void RefractionScene::find_plain(const ShadingScene& scene) {
  plain_solid.resize(materials.size());
  plain_other.resize(materials.size());
  const model::Snapshot& snapshot = *scene.snapshot;
  for (const model::Instance& instance : snapshot.instances) {
    const uint32_t m = instance.material;
    if (!model::tints_light(snapshot.materials[m], instance)) continue;
    const bool solid = instance.solid && materials[m].volume;
    PlainGlass& plain = (solid ? plain_solid : plain_other)[m];
    if (!plain.through.empty() || varies(scene.textures[m]) || scene.materials[m].anisotropy > 0.0f) continue;
    for (uint32_t i = 0; i <= PlainGlass::steps; ++i) {
      const float cosine = static_cast<float>(i) / static_cast<float>(PlainGlass::steps);
      const shading::SrSurface s = plain_surface(scene, m, cosine, !solid);
      const glm::vec3 to_eye(std::sqrt(std::max(1.0f - cosine * cosine, 0.0f)), 0.0f, cosine);
      plain.through.push_back(shading::sr_blend(s, to_eye, static_cast<int>(snapshot.materials[m].desc.blend_mode)).through);
    }
    const shading::SrSurface s = plain_surface(scene, m, 1.0f, !solid);
    plain.inner = inner_of(s);
    plain.edge = edge_of(s);
    plain.scattered = scattered_by(s);
    plain.cover = snapshot.materials[m].desc.blend_mode == SIDERAY_BLEND_MULTIPLY ? 0.0f : s.alpha;
  }
}

glm::vec3 inner_of(const shading::SrSurface& s) {
  return s.tint * (s.below_sheen * (1.0f - s.coat_share));
}

glm::vec3 scattered_by(const shading::SrSurface& s) {
  glm::vec3 reflected = s.diffuse * shading::sr_diffuse_share(s, 1.0f);
  if (s.roughness > smooth) reflected += shading::sr_specular_albedo(s);
  return glm::clamp(s.alpha * reflected, 0.0f, 1.0f);
}

// As in set_reflectance(): a rough lobe reflects its albedo, and a smooth one its Fresnel term.
glm::vec3 edge_of(const shading::SrSurface& s) {
  const float kept = s.albedo_terms.x + s.albedo_terms.y;
  return s.roughness > smooth ? s.f90 : s.f90 / std::clamp(kept, 0.05f, 1.0f);
}

glm::vec3 RefractionScene::transmittance(const MediumStack& media, float distance) const {
  if (media.empty()) return glm::vec3(1.0f);
  const glm::vec3 absorption = medium(media.top()).absorption;
  glm::vec3 through(1.0f);
  for (int c = 0; c < 3; ++c)
    if (absorption[c] > 0.0f) through[c] = elementary::exp(-absorption[c] * distance);
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
  // The reflectance in total, whatever the roughness.
  const float kept = surface.albedo_terms.x + surface.albedo_terms.y;
  surface.f0 = surface.f90 = glm::min(reflected, glm::vec3(1.0f)) / std::clamp(kept, 0.05f, 1.0f);
}

}  // namespace sideray::rt
