#include "rt/drawing/seen_aside.h"

#include <algorithm>

#include "model/material.h"

namespace sideray::rt {
namespace {

// Surfaces up to this roughness count as smooth.
constexpr float smooth = 0.04f;

}  // namespace

bool SeenAside::is_needed(const model::Snapshot& snapshot) {
  return std::ranges::any_of(snapshot.instances, [&](const model::Instance& instance) {
    const model::Material& material = snapshot.materials[instance.material];
    return material.translucent && model::bends_light(material.desc);
  });
}

SeenAside::SeenAside(const ShadingScene& scene, const TraceView& view, const OpaqueLevels& levels)
    : scene_(scene), view_(view), levels_(levels) {
  for (const model::Material& material : scene.snapshot->materials) bends_.push_back(model::bends_light(material.desc));
}

// A body with index 1 does not blur.
float SeenAside::level(const shading::SrSurface& surface, const shading::SrMaterial& material) const {
  if (!(surface.roughness > smooth)) return 0.0f;
  const float blurred = material.thickness > 0.0f ? std::clamp(2.0f * material.ior - 2.0f, 0.0f, 1.0f) : 1.0f;
  return levels_.coarsest() * surface.roughness * blurred;
}

// Returns where the refracted ray leaves the body, 0..1 in the picture.
glm::vec2 SeenAside::place(const SurfacePoint& point, glm::uvec2 pixel, float thickness, float ior) const {
  glm::vec3 way(0.0f);
  if (thickness > 0.0f) way = glm::refract(-point.to_eye, point.surface.normal, 1.0f / ior) * thickness;
  const glm::dvec4 clip = view_.clip_from_local * glm::dvec4(point.position + way, 1.0);
  if (!(clip.w > 0.0)) return levels_.middle(pixel);
  return glm::vec2(glm::dvec2(clip) / clip.w * 0.5 + 0.5);
}

// The index of red light is lower than the material's by `spread`, that of blue light higher.
glm::vec3 SeenAside::added(const SurfacePoint& point, glm::uvec2 pixel) const {
  const model::Instance& instance = scene_.snapshot->instances[point.hit.instance];
  if (instance.sprites != 0 || bends_[instance.material] == 0) return glm::vec3(0.0f);
  // A solid refracts only where light enters it.
  if (instance.solid && !point.hit.front) return glm::vec3(0.0f);
  const shading::SrMaterial& material = scene_.materials[instance.material];
  const float thickness = material.thickness > 0.0f ? material.thickness * thickness_texel(scene_, point) : 0.0f;
  const float coarse = level(point.surface, material);
  const auto seen = [&](float ior) { return levels_.at(place(point, pixel, thickness, ior), coarse); };
  glm::vec3 color = seen(material.ior);
  const float spread = model::index_spread(scene_.snapshot->materials[instance.material].desc);
  if (spread > 0.0f && thickness > 0.0f) {
    color.r = seen(std::max(material.ior - spread, 1.0f)).r;
    color.b = seen(material.ior + spread).b;
  }
  const glm::vec3 share = glm::max(point.blended.through - (1.0f - point.surface.alpha), glm::vec3(0.0f));
  return share * (color - levels_.at(pixel.x, pixel.y));
}

}  // namespace sideray::rt
