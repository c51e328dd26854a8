#include "rt/surfaces/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "elementary/functions.h"
#include "model/material.h"
#include "rt/surfaces/sprite_surface.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

using shading::SrMaterial;
using shading::SrSurface;

// Sixteen roundings, relative to the triangle's largest coordinate: the distance between a point interpolated here and
// the plane that Embree intersects after it has transformed the ray into object space.
constexpr float rounding = 0x1p-20f;

glm::vec3 to_vec3(const float* v) {
  return {v[0], v[1], v[2]};
}

SrMaterial shading_material(const sideray_material_desc& d) {
  SrMaterial m{};
  m.base_color = glm::vec4(d.base_color[0], d.base_color[1], d.base_color[2], d.base_color[3]);
  m.emissive = to_vec3(d.emissive);
  m.specular_color = to_vec3(d.specular_color);
  m.absorption = model::absorption(d);
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
  m.iridescence = d.iridescence;
  m.iridescence_ior = d.iridescence_ior;
  m.iridescence_thickness_min = d.iridescence_thickness_min;
  m.iridescence_thickness_max = d.iridescence_thickness_max;
  m.anisotropy = d.anisotropy;
  m.anisotropy_cosine = elementary::cos(d.anisotropy_rotation);
  m.anisotropy_sine = elementary::sin(d.anisotropy_rotation);
  m.alpha_mode = static_cast<int>(d.alpha_mode);
  m.unlit = d.unlit != 0;
  return m;
}

shading::SrLight shading_light(const model::Light& l) {
  return {l.position, l.direction, l.intensity, l.range, l.cos_inner, l.cos_outer, static_cast<int>(l.type)};
}

// Sets how the texture environment combines texel and primary colour.
void set_environment(shading::SrFixedMaterial& m, sideray_texture_environment environment, bool textured) {
  const bool decal = environment == SIDERAY_ENVIRONMENT_DECAL, replaces = environment == SIDERAY_ENVIRONMENT_REPLACE;
  m.of_none = decal || environment == SIDERAY_ENVIRONMENT_ADD || !textured ? 1.0f : 0.0f;
  m.modulates_alpha = textured && !decal ? 1.0f : 0.0f;
  if (!textured) return;
  m.of_texel = environment == SIDERAY_ENVIRONMENT_MODULATE ? 1.0f : 0.0f;
  m.of_alpha = decal ? -1.0f : 0.0f;
  m.adds = replaces || environment == SIDERAY_ENVIRONMENT_ADD ? 1.0f : 0.0f;
  m.adds_alpha = decal ? 1.0f : 0.0f;
  m.replaces_alpha = replaces ? 1.0f : 0.0f;
}

shading::SrFixedMaterial fixed_material(const model::Material& material) {
  const sideray_material_desc& d = material.desc;
  const sideray_fixed_material& f = material.fixed;
  const auto follows = [&](uint32_t bit) { return (f.follows_color & bit) != 0 ? 1.0f : 0.0f; };
  shading::SrFixedMaterial m{};
  m.color = glm::vec4(d.base_color[0], d.base_color[1], d.base_color[2], d.base_color[3]);
  m.ambient = to_vec3(f.ambient);
  m.diffuse = to_vec3(f.diffuse);
  m.specular = to_vec3(f.specular);
  m.emission = to_vec3(f.emission);
  m.reflectance = to_vec3(f.reflectance);
  m.fresnel = f.fresnel != 0 ? 1.0f : 0.0f;
  m.shininess = f.shininess;
  m.lit = d.unlit != 0 ? 0.0f : 1.0f;
  m.ambient_follows = follows(SIDERAY_FOLLOW_AMBIENT);
  m.diffuse_follows = follows(SIDERAY_FOLLOW_DIFFUSE);
  m.specular_follows = follows(SIDERAY_FOLLOW_SPECULAR);
  m.emission_follows = follows(SIDERAY_FOLLOW_EMISSION);
  set_environment(m, f.environment, d.base_color_texture.texture != 0);
  m.bends = d.transmission > 0.0f ? 1.0f : 0.0f;
  return m;
}

FixedLightTerms fixed_light(const model::FixedLight& l, const model::FixedFunction& f) {
  FixedLightTerms t{};
  const auto put = [](float (&to)[3], glm::vec3 from) { to[0] = from.x, to[1] = from.y, to[2] = from.z; };
  put(t.place, l.place), put(t.ambient, l.ambient), put(t.diffuse, l.diffuse), put(t.specular, l.specular);
  put(t.axis, l.axis), put(t.attenuation, l.attenuation);
  t.distant = l.distant ? 1.0f : 0.0f;
  t.exponent = l.exponent;
  t.cos_cutoff = l.cos_cutoff;
  t.viewer[2] = 1.0f;
  t.local_viewer = f.local_viewer ? 1.0f : 0.0f;
  t.separate = f.separate_specular;
  t.casts_shadows = l.casts_shadows;
  return t;
}

std::vector<FixedLightTerms> fixed_lights_of(const model::FixedFunction& f) {
  std::vector<FixedLightTerms> lights;
  for (const bool with_shadows : {true, false})
    for (const model::FixedLight& l : f.lights)
      if (l.casts_shadows == with_shadows) lights.push_back(fixed_light(l, f));
  return lights;
}

template <typename T>
T interpolate(const std::vector<T>& values, glm::uvec3 t, glm::vec3 weights) {
  return values[t.x] * weights.x + values[t.y] * weights.y + values[t.z] * weights.z;
}

glm::vec3 unit_or(glm::vec3 v, glm::vec3 otherwise) {
  const float squared = glm::dot(v, v);
  return squared > 1e-24f && std::isfinite(squared) ? v * (1.0f / std::sqrt(squared)) : otherwise;
}

// Holds one hit triangle in local space.
struct Patch {
  const model::Instance& instance;
  const model::Mesh& mesh;
  glm::uvec3 triangle;
  glm::vec3 weights;
  glm::vec3 front;  // unit geometric normal of the front face
  glm::vec3 edge1, edge2;
  float largest;  // the largest coordinate in the transform of its corners
};

Patch make_patch(const model::Snapshot& snapshot, const Hit& hit) {
  const model::Instance& instance = snapshot.instances[hit.instance];
  const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
  Patch p{instance, mesh, mesh.triangles[hit.primitive], {1.0f - hit.u - hit.v, hit.u, hit.v}, {}, {}, {}, 0.0f};
  const glm::vec3 p0 = mesh.positions[p.triangle.x], p1 = mesh.positions[p.triangle.y],
                  p2 = mesh.positions[p.triangle.z];
  const glm::mat3 linear(instance.local_from_object);
  p.edge1 = linear * (p1 - p0);
  p.edge2 = linear * (p2 - p0);
  const glm::vec3 normal = glm::cross(p.edge1, p.edge2);
  p.front = unit_or(instance.mirrored ? -normal : normal, glm::vec3(0, 1, 0));
  const glm::vec3 extent = glm::max(glm::abs(p0), glm::max(glm::abs(p1), glm::abs(p2)));
  const glm::vec3 sum = glm::abs(linear[0]) * extent.x + glm::abs(linear[1]) * extent.y +
                        glm::abs(linear[2]) * extent.z + glm::abs(instance.local_from_object[3]);
  p.largest = std::max({sum.x, sum.y, sum.z});
  return p;
}

// Returns the front face's shading normal.
glm::vec3 smooth_normal(const Patch& p) {
  return unit_or(p.instance.normal_from_object * interpolate(p.mesh.normals, p.triangle, p.weights), p.front);
}

// Returns the front face's tangent in local space; w = 0 if there is none.
glm::vec4 tangent_of(const Patch& p) {
  if (!p.mesh.has_tangents) return glm::vec4(0.0f);
  const glm::vec4 tangent = interpolate(p.mesh.tangents, p.triangle, p.weights);
  const glm::vec3 along = glm::mat3(p.instance.local_from_object) * glm::vec3(tangent);
  const float squared = glm::dot(along, along);
  if (!(squared > 1e-24f)) return glm::vec4(0.0f);
  return {along * (1.0f / std::sqrt(squared)), p.instance.mirrored ? -tangent.w : tangent.w};
}

// Returns whether the material needs a tangent frame.
bool needs_frame(const sideray_material_desc& d, bool textured) {
  return d.anisotropy > 0.0f ||
         (textured && (d.normal_texture.texture != 0 || d.clearcoat_normal_texture.texture != 0));
}

// Returns the sheen's albedo (z of the albedo table), or 0 without sheen.
float sheen_albedo(const SrSurface& s, float n_v) {
  if (std::max({s.sheen.x, s.sheen.y, s.sheen.z}) <= 0.0f) return 0.0f;
  return albedo_and_sheen(model::albedo_table(), n_v, s.sheen_roughness).z;
}

// `front_normal` and `tangent` are of the front face; only anisotropic materials use them.
SrSurface seen_surface(const SrMaterial& material, const shading::SrTexels& texels, const SrSurface& away,
                       glm::vec3 to_eye, glm::vec3 front_normal, glm::vec4 tangent) {
  SrSurface s = shading::sr_facing(away, to_eye);
  if (material.anisotropy > 0.0f) s = shading::sr_brushed(s, material, texels, front_normal, tangent);
  if (material.iridescence > 0.0f) s = shading::sr_filmed(s, material, texels, to_eye);
  const float n_v = std::abs(glm::dot(s.normal, to_eye));
  const model::AlbedoTable& table = model::albedo_table();
  glm::vec2 terms = albedo_terms(table, n_v, shading::sr_round_roughness(s));
  if (s.anisotropy > 0.0f) {
    const float cosine = shading::sr_round_cosine(s, to_eye);
    terms = shading::sr_brushed_terms(s, terms, albedo_terms(table, cosine, shading::sr_round_roughness(s)));
  }
  return shading::sr_seen(s, to_eye, terms, sheen_albedo(s, n_v));
}

shading::SrFixedModel fixed_model(const ShadingScene& scene) {
  const FixedModelTerms& m = scene.records.model;
  return {glm::vec3(m.ambient[0], m.ambient[1], m.ambient[2]), m.two_sided, m.separate};
}

// Holds what vertices and textures give a patch; normals are those of its front.
struct TexturedPatch {
  TextureValues textures;
  glm::vec3 smooth, normal, coat_normal;
  glm::vec4 tangent, vertex_color;
};

// `direction`, `width` and `steps`: of the ray's cone there.
TexturedPatch textured(const ShadingScene& scene, const Patch& patch, glm::vec3 direction, float width,
                       const PixelSteps* steps) {
  const sideray_material_desc& desc = scene.snapshot->materials[patch.instance.material].desc;
  const std::vector<TextureRead>& reads = scene.textures[patch.instance.material];
  const glm::vec3 smooth = smooth_normal(patch);
  TexturedPatch t{no_textures, smooth, smooth, smooth, glm::vec4(0.0f), glm::vec4(1.0f)};
  if (needs_frame(desc, !reads.empty())) t.tangent = tangent_of(patch);
  if (!reads.empty()) {
    const TextureFootprint footprint = texture_footprint(patch.edge1, patch.edge2, direction, width, steps);
    t.textures = read_textures(reads, {patch.mesh, patch.triangle, patch.weights, footprint}, desc.occlusion_strength);
    if (desc.normal_texture.texture || desc.clearcoat_normal_texture.texture) {
      t.normal = shading::sr_perturb(smooth, t.tangent, t.textures.normal, desc.normal_scale);
      t.coat_normal = shading::sr_perturb(smooth, t.tangent, t.textures.coat_normal, desc.clearcoat_normal_scale);
    }
  }
  if (patch.mesh.has_colors) t.vertex_color = interpolate(patch.mesh.colors, patch.triangle, patch.weights);
  return t;
}

SrSurface seen_surface(const ShadingScene& scene, const Patch& patch, const TexturedPatch& t, glm::vec3 to_eye,
                       bool front) {
  const uint32_t material = patch.instance.material;
  const SrMaterial& factors = scene.materials[material];
  shading::SrTexels texels = t.textures.texels;
  // In the fixed function, vertex colour follows other rules.
  if (patch.mesh.has_colors && !scene.snapshot->fixed) texels.base_color *= t.vertex_color;
  // A solid's thickness absorbs only where light enters it.
  if (patch.instance.solid && !front) texels.thickness = 0.0f;
  const SrSurface away =
      shading::sr_surface(factors, texels, front ? t.normal : -t.normal, front ? t.coat_normal : -t.coat_normal);
  const SrSurface seen = seen_surface(factors, texels, away, to_eye, t.smooth, t.tangent);
  if (!scene.snapshot->fixed) return seen;
  return shading::sr_fixed_surface(seen, scene.fixed_materials[material], fixed_model(scene), texels.base_color,
                                   t.vertex_color, front, factors.alpha_mode == SIDERAY_BLEND, to_eye);
}

}  // namespace

ShadingScene::ShadingScene(std::shared_ptr<const model::Snapshot> committed) : snapshot(std::move(committed)) {
  materials.reserve(snapshot->materials.size());
  for (const model::Material& m : snapshot->materials) {
    materials.push_back(shading_material(m.desc));
    textures.push_back(texture_reads(*snapshot, m.desc));
  }
  for (size_t i = 0; i < snapshot->lights.size(); ++i) {
    const model::Light& l = snapshot->lights[i];
    if (l.intensity == glm::vec3(0.0f)) continue;
    lights.push_back(shading_light(l));
    light_numbers.push_back(static_cast<uint32_t>(i));
  }
  if (snapshot->fixed) {
    for (const model::Material& m : snapshot->materials) fixed_materials.push_back(fixed_material(m));
    fixed_lights = fixed_lights_of(*snapshot->fixed);
  }
  records = make_records(*snapshot, materials, fixed_materials, textures);
}

SurfacePoint surface_point(const ShadingScene& scene, const Hit& hit, const Ray& ray, Cone cone,
                           const PixelSteps* steps) {
  if (scene.snapshot->instances[hit.instance].sprites != 0) return sprite_point(*scene.snapshot, hit, ray, cone);
  const Patch patch = make_patch(*scene.snapshot, hit);
  const float width = cone.width + cone.spread * static_cast<float>(hit.distance);
  const sideray_material_desc& desc = scene.snapshot->materials[patch.instance.material].desc;
  SurfacePoint point{};
  point.to_eye = -ray.direction;
  point.surface = seen_surface(scene, patch, textured(scene, patch, ray.direction, width, steps), point.to_eye,
                               hit.front);
  point.position = patch.instance.local_from_object *
                   glm::vec4(interpolate(patch.mesh.positions, patch.triangle, patch.weights), 1.0f);
  point.geometric_normal = hit.front ? patch.front : -patch.front;
  point.offset = rounding * patch.largest;
  point.cone = {width, cone.spread};
  point.distortion = desc.distortion;
  point.blend = static_cast<int>(desc.blend_mode);
  point.hit = hit;
  point.blended = shading::sr_blend(point.surface, point.to_eye, point.blend);
  return point;
}

shading::SrSurface plain_surface(const ShadingScene& scene, uint32_t material, float cosine, bool thick) {
  shading::SrTexels texels = no_textures.texels;
  if (!thick) texels.thickness = 0.0f;
  const glm::vec3 normal(0, 0, 1), to_eye(std::sqrt(std::max(1.0f - cosine * cosine, 0.0f)), 0.0f, cosine);
  const SrMaterial& factors = scene.materials[material];
  return seen_surface(factors, texels, shading::sr_surface(factors, texels, normal, normal), to_eye, normal,
                      glm::vec4(0.0f));
}

shading::SrBlend blend_of(const SurfacePoint& point) {
  return point.answer ? point.answer->blend : point.blended;
}

SurfaceAttributes surface_attributes(const model::Snapshot& snapshot, const SurfacePoint& point) {
  const Patch patch = make_patch(snapshot, point.hit);
  const model::Mesh& mesh = patch.mesh;
  const TextureFootprint steps = texture_footprint(patch.edge1, patch.edge2, -point.to_eye, point.cone.width);
  SurfaceAttributes a{};
  const std::vector<glm::vec2>* const sets[] = {&mesh.uv0, &mesh.uv1};
  for (size_t set = 0; set < 2; ++set) {
    const std::vector<glm::vec2>& uv = *sets[set];
    a.uv[set] = interpolate(uv, patch.triangle, patch.weights);
    const glm::vec2 edge1 = uv[patch.triangle.y] - uv[patch.triangle.x],
                    edge2 = uv[patch.triangle.z] - uv[patch.triangle.x];
    a.footprint[set][0] = edge1 * steps.along.x + edge2 * steps.along.y;
    a.footprint[set][1] = edge1 * steps.across.x + edge2 * steps.across.y;
  }
  a.color = interpolate(mesh.colors, patch.triangle, patch.weights);
  a.tangent = tangent_of(patch);
  const uint32_t primitive = point.hit.primitive;
  a.primitive = mesh.source_primitive.empty() ? primitive : mesh.source_primitive[primitive];
  return a;
}

float thickness_texel(const ShadingScene& scene, const SurfacePoint& point) {
  const uint32_t material = scene.snapshot->instances[point.hit.instance].material;
  const auto reads_thickness = [](const TextureRead& read) {
    return model::material_slots[read.slot].slot == &sideray_material_desc::thickness_texture;
  };
  const std::vector<TextureRead>& reads = scene.textures[material];
  const auto found = std::ranges::find_if(reads, reads_thickness);
  if (found == reads.end()) return 1.0f;
  TextureRead alone = *found;
  alone.same_as = 0;
  const Patch patch = make_patch(*scene.snapshot, point.hit);
  const TextureFootprint footprint = texture_footprint(patch.edge1, patch.edge2, -point.to_eye, point.cone.width);
  return read_textures({&alone, 1}, {patch.mesh, patch.triangle, patch.weights, footprint}, 1.0f).texels.thickness;
}

glm::vec3 geometric_normal(const model::Snapshot& snapshot, const Hit& hit) {
  return make_patch(snapshot, hit).front;
}

}  // namespace sideray::rt
