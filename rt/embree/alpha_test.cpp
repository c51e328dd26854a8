#include "rt/embree/alpha_test.h"

#include "rt/embree/recompute.h"
#include "rt/textures/sprite_texel.h"
#include "rt/textures/texture_level.h"
#include "rt/textures/texture_sample.h"

namespace sideray::rt {
namespace {

float base_color_level(const model::Texture& texture, const TraceInstance& instance, const std::vector<glm::vec2>& uv,
                       const Ray& ray, const Hit& hit, const AlphaCone& cone) {
  const sideray_texture_slot& slot = instance.material->desc.base_color_texture;
  const float width = cone.width_at(ray, hit.distance);
  if (width <= 0.0f || slot.filter != SIDERAY_TRILINEAR || texture.levels.size() == 1) return 0.0f;
  const glm::uvec3 t = instance.triangles[hit.primitive];
  const auto corner = [&](uint32_t vertex) {
    const LocalPosition p = local_position(instance, vertex);
    return glm::vec3(p.x[0], p.x[1], p.x[2]);
  };
  const glm::vec3 p0 = corner(t.x);
  const TextureFootprint footprint =
      texture_footprint(corner(t.y) - p0, corner(t.z) - p0, glm::normalize(ray.direction), width,
                        cone.in_view() ? &cone.steps : nullptr);
  return texture_level(footprint, uv[t.y] - uv[t.x], uv[t.z] - uv[t.x], slot, texture);
}

}  // namespace

bool alpha_discards(const model::Snapshot& snapshot, const TraceInstance& instance, const Ray& ray, const Hit& hit,
                    const AlphaCone& cone) {
  if (instance.sprites != 0) return sprite_discards(snapshot, hit);
  const sideray_material_desc& desc = instance.material->desc;
  const float limit = desc.alpha_mode == SIDERAY_MASK ? desc.alpha_cutoff : 1.0f / 255.0f;
  const model::Mesh& mesh = *instance.mesh;
  const glm::uvec3 t = instance.triangles[hit.primitive];
  const float w = 1.0f - hit.u - hit.v;
  const model::Material& material = *instance.material;
  float alpha = material.without_factor_alpha ? 1.0f : desc.base_color[3];
  if (mesh.has_colors && !material.without_vertex_alpha)
    alpha *= w * mesh.colors[t.x].w + hit.u * mesh.colors[t.y].w + hit.v * mesh.colors[t.z].w;
  else
    alpha *= w + hit.u + hit.v;
  const sideray_texture_slot& slot = desc.base_color_texture;
  if (slot.texture == 0 || material.without_texel_alpha) return alpha < limit;
  const model::Texture& texture = *snapshot.textures[slot.texture - 1];
  const std::vector<glm::vec2>& uv = slot.uv_set == 0 ? mesh.uv0 : mesh.uv1;
  const glm::vec2 at = w * uv[t.x] + hit.u * uv[t.y] + hit.v * uv[t.z];
  const float level = base_color_level(texture, instance, uv, ray, hit, cone);
  if (instance.alpha && level == 0.0f) {
    const AlphaRange range = alpha_range(*instance.alpha, slot, at);
    if (alpha * range.least >= limit) return false;
    if (alpha * range.most < limit) return true;
  }
  return alpha * sample_alpha(texture, slot, at, level) < limit;
}

}  // namespace sideray::rt
