#include "rt/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/texture_sample.h"

namespace sideray::rt {
namespace {

using shading::SrMaterial;
using shading::SrSurface;
using shading::SrTexels;

// Sixteen roundings, of coordinates up to the largest of the triangle: what separates a point interpolated in here from
// the plane that Embree intersects after it has moved the ray into object space.
constexpr float rounding = 0x1p-20f;

glm::vec3 to_vec3(const float* v) {
  return {v[0], v[1], v[2]};
}

// Beer and Lambert: white light keeps attenuation_color after attenuation_distance.
glm::vec3 absorption(const sideray_material_desc& d) {
  if (std::isinf(d.attenuation_distance)) return glm::vec3(0.0f);
  return -glm::log(glm::max(to_vec3(d.attenuation_color), glm::vec3(1e-6f))) / d.attenuation_distance;
}

SrMaterial shading_material(const sideray_material_desc& d) {
  SrMaterial m{};
  m.base_color = glm::vec4(d.base_color[0], d.base_color[1], d.base_color[2], d.base_color[3]);
  m.emissive = to_vec3(d.emissive);
  m.specular_color = to_vec3(d.specular_color);
  m.absorption = absorption(d);
  m.metallic = d.metallic;
  m.roughness = d.roughness;
  m.transmission = d.transmission;
  m.ior = d.ior;
  m.thickness = d.thickness;
  m.specular = d.specular;
  m.clearcoat = d.clearcoat;
  m.clearcoat_roughness = d.clearcoat_roughness;
  m.sheen_color = to_vec3(d.sheen_color);
  m.sheen_roughness = d.sheen_roughness;
  m.diffuse_transmission = d.diffuse_transmission;
  m.diffuse_transmission_color = to_vec3(d.diffuse_transmission_color);
  m.alpha_mode = static_cast<int>(d.alpha_mode);
  m.unlit = d.unlit != 0;
  return m;
}

bool has_texture(const sideray_material_desc& d) {
  return d.base_color_texture.texture || d.metallic_roughness_texture.texture || d.normal_texture.texture ||
         d.occlusion_texture.texture || d.emissive_texture.texture || d.transmission_texture.texture ||
         d.thickness_texture.texture;
}

shading::SrLight shading_light(const model::Light& l) {
  return {l.position, l.direction, l.intensity, l.range, l.cos_inner, l.cos_outer, static_cast<int>(l.type)};
}

template <typename T>
T interpolate(const std::vector<T>& values, glm::uvec3 t, glm::vec3 weights) {
  return values[t.x] * weights.x + values[t.y] * weights.y + values[t.z] * weights.z;
}

glm::vec3 unit_or(glm::vec3 v, glm::vec3 otherwise) {
  const float squared = glm::dot(v, v);
  return squared > 1e-24f && std::isfinite(squared) ? v * (1.0f / std::sqrt(squared)) : otherwise;
}

// One hit triangle in local space.
struct Patch {
  const model::Instance& instance;
  const model::Mesh& mesh;
  glm::uvec3 triangle;
  glm::vec3 weights;
  glm::vec3 front;  // unit geometric normal of the front face
  float double_area;
  float largest;  // coordinate that takes part in placing it
};

Patch make_patch(const model::Snapshot& snapshot, const Hit& hit) {
  const model::Instance& instance = snapshot.instances[hit.instance];
  const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
  Patch p{instance, mesh, mesh.triangles[hit.primitive], {1.0f - hit.u - hit.v, hit.u, hit.v}, {}, 0.0f, 0.0f};
  const glm::vec3 p0 = mesh.positions[p.triangle.x], p1 = mesh.positions[p.triangle.y],
                  p2 = mesh.positions[p.triangle.z];
  const glm::mat3 linear(instance.local_from_object);
  const glm::vec3 normal = glm::cross(linear * (p1 - p0), linear * (p2 - p0));
  p.double_area = glm::length(normal);
  p.front = unit_or(instance.mirrored ? -normal : normal, glm::vec3(0, 1, 0));
  const glm::vec3 extent = glm::max(glm::abs(p0), glm::max(glm::abs(p1), glm::abs(p2)));
  const glm::vec3 sum = glm::abs(linear[0]) * extent.x + glm::abs(linear[1]) * extent.y +
                        glm::abs(linear[2]) * extent.z + glm::abs(instance.local_from_object[3]);
  p.largest = std::max({sum.x, sum.y, sum.z});
  return p;
}

// Texture look-ups of one point: the level of detail by ray cones (Akenine-Moeller et al., Ray Tracing Gems, ch. 20).
class Lookup {
 public:
  Lookup(const model::Snapshot& snapshot, const Patch& patch, float footprint)
      : snapshot_(snapshot), patch_(patch), footprint_(footprint) {}

  glm::vec4 operator()(const sideray_texture_slot& slot) const {
    if (slot.texture == 0) return glm::vec4(1.0f);
    const model::Texture& texture = *snapshot_.textures[slot.texture - 1];
    const std::vector<glm::vec2>& uv = slot.uv_set == 0 ? patch_.mesh.uv0 : patch_.mesh.uv1;
    return sample(texture, slot, interpolate(uv, patch_.triangle, patch_.weights), level(texture, slot, uv));
  }

 private:
  // Texels that a pixel's footprint spans along its longer axis, as a power of two.
  float level(const model::Texture& texture, const sideray_texture_slot& slot, const std::vector<glm::vec2>& uv) const {
    if (slot.filter != SIDERAY_TRILINEAR || texture.levels.size() == 1) return 0.0f;
    const glm::vec2 a = uv[patch_.triangle.y] - uv[patch_.triangle.x],
                    b = uv[patch_.triangle.z] - uv[patch_.triangle.x];
    const float* m = slot.texture_from_uv;
    const float texels = std::abs((a.x * b.y - a.y * b.x) * (m[0] * m[3] - m[1] * m[2])) *
                         static_cast<float>(texture.levels[0].width) * static_cast<float>(texture.levels[0].height);
    const float squared = footprint_ * footprint_ * texels / std::max(patch_.double_area, 1e-30f);
    return squared > 1.0f ? 0.5f * std::log2(squared) : 0.0f;
  }

  const model::Snapshot& snapshot_;
  const Patch& patch_;
  float footprint_;
};

constexpr glm::vec3 one(1.0f);
constexpr SrTexels no_texels{
    glm::vec4(1.0f), one, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, one, 1.0f, 1.0f, one, 1.0f, 1.0f, one};

SrTexels texels_of(const sideray_material_desc& d, const Lookup& look_up) {
  SrTexels t = no_texels;
  t.base_color = look_up(d.base_color_texture);
  t.emissive = glm::vec3(look_up(d.emissive_texture));
  const glm::vec4 metallic_roughness = look_up(d.metallic_roughness_texture);
  t.roughness = metallic_roughness.y;
  t.metallic = metallic_roughness.z;
  t.occlusion = 1.0f + d.occlusion_strength * (look_up(d.occlusion_texture).x - 1.0f);
  t.transmission = look_up(d.transmission_texture).x;
  t.thickness = look_up(d.thickness_texture).y;
  return t;
}

// Shading normals of the front face.
glm::vec3 smooth_normal(const Patch& p) {
  return unit_or(p.instance.normal_from_object * interpolate(p.mesh.normals, p.triangle, p.weights), p.front);
}

glm::vec3 mapped_normal(const sideray_material_desc& d, const Lookup& look_up, const Patch& p, glm::vec3 smooth) {
  if (d.normal_texture.texture == 0 || !p.mesh.has_tangents) return smooth;
  const glm::vec4 tangent = interpolate(p.mesh.tangents, p.triangle, p.weights);
  const glm::vec3 along = glm::mat3(p.instance.local_from_object) * glm::vec3(tangent);
  const float squared = glm::dot(along, along);
  if (!(squared > 1e-24f)) return smooth;
  const float sign = p.instance.mirrored ? -tangent.w : tangent.w;
  return shading::sr_perturb(smooth, glm::vec4(along * (1.0f / std::sqrt(squared)), sign),
                             glm::vec3(look_up(d.normal_texture)) * 2.0f - 1.0f, d.normal_scale);
}

}  // namespace

ShadingScene::ShadingScene(std::shared_ptr<const model::Snapshot> committed) : snapshot(std::move(committed)) {
  materials.reserve(snapshot->materials.size());
  for (const model::Material& m : snapshot->materials) {
    materials.push_back(shading_material(m.desc));
    textured.push_back(has_texture(m.desc));
  }
  for (const model::Light& l : snapshot->lights)
    if (l.intensity != glm::vec3(0.0f)) lights.push_back(shading_light(l));
}

SurfacePoint surface_point(const ShadingScene& scene, const Hit& hit, const Ray& ray, Cone cone) {
  const model::Snapshot& snapshot = *scene.snapshot;
  const Patch patch = make_patch(snapshot, hit);
  const uint32_t material = patch.instance.material;
  const sideray_material_desc& desc = snapshot.materials[material].desc;

  SurfacePoint point{};
  const float width = cone.width + cone.spread * static_cast<float>(hit.distance);
  SrTexels texels = no_texels;
  glm::vec3 normal = smooth_normal(patch);
  if (scene.textured[material]) {
    const float cosine = std::max(std::abs(glm::dot(patch.front, ray.direction)), 1e-4f);
    const Lookup look_up(snapshot, patch, width / cosine);
    texels = texels_of(desc, look_up);
    normal = mapped_normal(desc, look_up, patch, normal);
  }
  if (patch.mesh.has_colors) texels.base_color *= interpolate(patch.mesh.colors, patch.triangle, patch.weights);
  point.surface = shading::sr_surface(scene.materials[material], texels, hit.front ? normal : -normal,
                                      hit.front ? normal : -normal);
  point.position = patch.instance.local_from_object *
                   glm::vec4(interpolate(patch.mesh.positions, patch.triangle, patch.weights), 1.0f);
  point.geometric_normal = hit.front ? patch.front : -patch.front;
  point.to_eye = -ray.direction;
  point.offset = rounding * patch.largest;
  point.cone = {width, cone.spread};
  point.blend = static_cast<int>(desc.blend_mode);
  return point;
}

glm::vec3 geometric_normal(const model::Snapshot& snapshot, const Hit& hit) {
  return make_patch(snapshot, hit).front;
}

}  // namespace sideray::rt
