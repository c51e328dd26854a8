#include "rt/hit_shader.h"

#include <algorithm>
#include <cmath>

#include "rt/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr float farthest = 1e30f;
constexpr float least_share = 1e-4f;  // of reflected light in what is seen: below it no ray is worth its cost
constexpr float least_transmittance = 1e-4f;
constexpr uint32_t layers_in_reflection = 8;
// Sine of the least elevation of a reflected ray over the geometric surface, where the shading normal would send it in.
constexpr float least_elevation = 1e-3f;
// Share of the way to a light that is not tested, so that rounding does not carry the ray past it.
constexpr float short_of_light = 1e-5f;

float largest(glm::vec3 v) {
  return std::max({v.x, v.y, v.z});
}

glm::vec3 start_of_ray(const SurfacePoint& p, glm::vec3 direction) {
  const float side = glm::dot(p.geometric_normal, direction) < 0.0f ? -p.offset : p.offset;
  return p.position + p.geometric_normal * side;
}

glm::vec3 mirror_direction(const SurfacePoint& p, glm::vec3 n) {
  glm::vec3 r = n * (2.0f * glm::dot(n, p.to_eye)) - p.to_eye;
  const float elevation = glm::dot(r, p.geometric_normal);
  if (elevation < least_elevation) r += p.geometric_normal * (least_elevation - elevation);
  return glm::normalize(r);
}

glm::vec2 terms_of(const SurfacePoint& p) {
  return albedo_terms(model::albedo_table(), std::abs(glm::dot(p.surface.normal, p.to_eye)), p.surface.roughness);
}

// Of light from the mirror direction in what the eye sees: through base and coat.
glm::vec2 reflected_shares(const SurfacePoint& p, glm::vec2 albedo_terms) {
  const shading::SrSurface& s = p.surface;
  const float base = largest(shading::sr_specular_albedo(s, albedo_terms)) * s.below_sheen * (1.0f - s.coat_share);
  return glm::vec2(base, s.coat_share) * s.occlusion;
}

// Whether base and coat show the same.
bool reflects_alike(const shading::SrSurface& s) {
  return s.coat_normal == s.normal && s.coat_roughness == s.roughness;
}

shading::SrSurroundings prefiltered(const model::Environment& environment, const shading::SrSurface& s) {
  const bool behind = largest(s.behind) > 0.0f;
  return {environment_irradiance(environment, s.normal),
          behind ? environment_irradiance(environment, -s.normal) : glm::vec3(0.0f), glm::vec3(0.0f), glm::vec3(0.0f)};
}

// Packets gain from the coherent traversal only where their rays go the same way; elsewhere it costs half the speed.
bool directions_agree(std::span<const Ray> rays) {
  constexpr float same_way = 0.95f;
  size_t agreeing = 0;
  for (size_t i = 1; i < rays.size(); ++i) agreeing += glm::dot(rays[i - 1].direction, rays[i].direction) > same_way;
  return agreeing * 10 >= rays.size() * 9;
}

}  // namespace

void HitShader::begin(const ShadingScene& scene, const Intersector& intersector, bool shadows) {
  scene_ = &scene;
  intersector_ = &intersector;
  shadows_ = shadows;
  rays_reflection = rays_shadow = 0;
}

void HitShader::shade(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  const model::Environment& environment = *scene_->snapshot->environment;
  for (size_t i = 0; i < points.size(); ++i) radiance[i] = shading::sr_emitted(points[i].surface);
  add_direct(points, radiance);
  trace_reflections(points);
  for (size_t i = 0; i < points.size(); ++i) {
    const shading::SrSurface& s = points[i].surface;
    shading::SrSurroundings light = prefiltered(environment, s);
    light.specular = reflected_[i];
    light.coat = reflected_[reflects_alike(s) ? i : points.size() + i];
    radiance[i] += shading::sr_environment(s, albedo_terms_[i], light);
  }
}

void HitShader::add_direct(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  for (const shading::SrLight& light : scene_->lights) {
    shadow_rays_.clear(), shadow_gains_.clear(), shadow_points_.clear();
    for (size_t i = 0; i < points.size(); ++i) {
      const SurfacePoint& p = points[i];
      const shading::SrIncidence in = shading::sr_incidence(light, p.position);
      if (!shading::sr_faces(p.surface, in.to_light) || largest(in.irradiance) <= 0.0f) continue;
      const glm::vec3 gain = shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance;
      if (!(largest(gain) > 0.0f)) continue;
      if (!shadows_) {
        radiance[i] += gain;
        continue;
      }
      shadow_rays_.push_back({start_of_ray(p, in.to_light), 0.0f, in.to_light, in.distance * (1.0f - short_of_light)});
      shadow_gains_.push_back(gain);
      shadow_points_.push_back(static_cast<uint32_t>(i));
    }
    blocked_.resize(shadow_rays_.size());
    rays_shadow += shadow_rays_.size();
    if (!shadow_rays_.empty()) intersector_->occluded(shadow_rays_, true, blocked_.data());
    for (size_t r = 0; r < shadow_rays_.size(); ++r)
      if (!blocked_[r]) radiance[shadow_points_[r]] += shadow_gains_[r];
  }
}

// Fills albedo_terms_ and reflected_.
void HitShader::trace_reflections(std::span<const SurfacePoint> points) {
  collect_mirror_rays(points);
  if (mirror_rays_.empty()) return;
  const bool coherent = directions_agree(mirror_rays_);
  opaque_hits_.resize(mirror_rays_.size());
  intersector_->nearest_opaque(mirror_rays_, coherent, opaque_hits_.data());
  rays_reflection += mirror_rays_.size();
  shade_reflection_hits();
  if (!intersector_->has_translucent(LayerSet::all_translucent)) return;
  for (size_t r = 0; r < mirror_rays_.size(); ++r)
    if (opaque_hits_[r].instance != no_instance) mirror_rays_[r].t_far = static_cast<float>(opaque_hits_[r].distance);
  layer_hits_.resize(mirror_rays_.size() * layers_in_reflection);
  layer_counts_.resize(mirror_rays_.size());
  intersector_->nearest_layers(LayerSet::all_translucent, mirror_rays_, layers_in_reflection, coherent,
                               layer_hits_.data(), layer_counts_.data());
  rays_reflection += mirror_rays_.size();
  composite_in_front();
}

void HitShader::collect_mirror_rays(std::span<const SurfacePoint> points) {
  albedo_terms_.resize(points.size());
  reflected_.assign(2 * points.size(), glm::vec3(0.0f));
  mirror_rays_.clear(), mirror_cones_.clear(), mirror_roughness_.clear(), mirror_targets_.clear();
  const auto add = [&](const SurfacePoint& p, glm::vec3 normal, float roughness, size_t target) {
    const glm::vec3 direction = mirror_direction(p, normal);
    mirror_rays_.push_back({start_of_ray(p, direction), 0.0f, direction, farthest});
    mirror_cones_.push_back(p.cone);
    mirror_roughness_.push_back(roughness);
    mirror_targets_.push_back(static_cast<uint32_t>(target));
  };
  coats_.clear();
  for (size_t i = 0; i < points.size(); ++i) {
    const shading::SrSurface& s = points[i].surface;
    albedo_terms_[i] = terms_of(points[i]);
    const glm::vec2 shares = reflected_shares(points[i], albedo_terms_[i]);
    const bool one_ray = reflects_alike(s);
    if ((one_ray ? shares.x + shares.y : shares.x) >= least_share) add(points[i], s.normal, s.roughness, i);
    if (!one_ray && shares.y >= least_share) coats_.push_back(static_cast<uint32_t>(i));
  }
  // Last, so that neighbours in a packet go the same way.
  for (const uint32_t i : coats_)
    add(points[i], points[i].surface.coat_normal, points[i].surface.coat_roughness, points.size() + i);
}

void HitShader::shade_reflection_hits() {
  second_points_.clear(), second_rays_.clear();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    const Hit& hit = opaque_hits_[r];
    if (hit.instance == no_instance) {
      reflected_[mirror_targets_[r]] =
          environment_specular(*scene_->snapshot->environment, mirror_rays_[r].direction, mirror_roughness_[r]);
      continue;
    }
    second_points_.push_back(surface_point(*scene_, hit, mirror_rays_[r], mirror_cones_[r]));
    second_rays_.push_back(static_cast<uint32_t>(r));
  }
  second_radiance_.resize(second_points_.size());
  for (size_t i = 0; i < second_points_.size(); ++i) second_radiance_[i] = ambient(second_points_[i]);
  add_direct(second_points_, second_radiance_.data());
  for (size_t i = 0; i < second_points_.size(); ++i) reflected_[mirror_targets_[second_rays_[i]]] = second_radiance_[i];
}

// Translucent surfaces between a reflecting point and what it reflects.
void HitShader::composite_in_front() {
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    glm::vec3 sum(0.0f), through(1.0f);
    for (uint32_t k = 0; k < layer_counts_[r] && largest(through) >= least_transmittance; ++k) {
      const Hit& hit = layer_hits_[r * layers_in_reflection + k];
      if (!(scene_->snapshot->instances[hit.instance].visibility & SIDERAY_VISIBLE_REFLECTION)) continue;
      const SurfacePoint p = surface_point(*scene_, hit, mirror_rays_[r], mirror_cones_[r]);
      const shading::SrBlend blend = shading::sr_blend(p.surface, p.to_eye, p.blend);
      if (blend.cover > 0.0f) sum += through * unshadowed(p) * blend.cover;
      through *= blend.through;
    }
    glm::vec3& reflected = reflected_[mirror_targets_[r]];
    reflected = sum + through * reflected;
  }
}

glm::vec3 HitShader::unshadowed(const SurfacePoint& p) const {
  glm::vec3 sum = ambient(p);
  for (const shading::SrLight& light : scene_->lights) {
    const shading::SrIncidence in = shading::sr_incidence(light, p.position);
    if (!shading::sr_faces(p.surface, in.to_light)) continue;
    sum += shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance;
  }
  return sum;
}

// Emission and the prefiltered environment, without a ray.
glm::vec3 HitShader::ambient(const SurfacePoint& p) const {
  const model::Environment& environment = *scene_->snapshot->environment;
  const shading::SrSurface& s = p.surface;
  if (environment.black) return shading::sr_emitted(s);
  shading::SrSurroundings light = prefiltered(environment, s);
  light.specular = environment_specular(environment, mirror_direction(p, s.normal), s.roughness);
  if (s.coat_share > 0.0f)
    light.coat = environment_specular(environment, mirror_direction(p, s.coat_normal), s.coat_roughness);
  return shading::sr_emitted(s) + shading::sr_environment(s, terms_of(p), light);
}

}  // namespace sideray::rt
