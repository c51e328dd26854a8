#include "rt/reference/reference_shader.h"

#include <algorithm>
#include <cmath>

#include "rt/base/sampling.h"
#include "rt/base/largest.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr uint32_t layers_in_reflection = 64;  // as many as one traversal holds
// Rays stop before the light by this share of the distance, so that rounding does not carry them past it.
constexpr float short_of_light = 1e-5f;
// A reflected ray with at least this share of an average ray's contribution is always traced; others by Russian
// roulette.
constexpr float worth_a_ray = 0.1f;

// The purposes of random numbers at a point; lights count from the last one on.
enum Purpose : uint32_t { for_lobes, for_environment, for_reflection, for_lot, for_lights };

glm::vec3 start_of_ray(const SurfacePoint& p, glm::vec3 direction) {
  const float side = glm::dot(p.geometric_normal, direction) < 0.0f ? -p.offset : p.offset;
  return p.position + p.geometric_normal * side;
}

glm::vec2 random_point(const SurfacePoint& p, uint32_t purpose, uint32_t half, uint32_t j) {
  return PointSet(random_key({p.key, purpose, half}))[j];
}

}  // namespace

void ReferenceShader::begin(const ReferenceScene& scene, uint32_t samples, bool shadows) {
  scene_ = scene;
  samples_ = samples;
  shadows_ = shadows;
  straight_.begin(*scene.scene, *scene.intersector);
  rays_reflection = rays_shadow = 0;
}

glm::vec3 ReferenceShader::mean(const glm::vec3* radiance) const {
  const float share = static_cast<float>((samples_ + 1) / 2) / static_cast<float>(samples_);
  return samples_ == 1 ? radiance[0] : glm::mix(radiance[1], radiance[0], share);
}

void ReferenceShader::shade(std::span<const SurfacePoint> points, bool traced, glm::vec3* radiance) {
  prepare(points, first_);
  for (size_t i = 0; i < points.size(); ++i) first_.sums[i] = shading::sr_emitted(points[i].surface);
  add_points_of_light(points, shadows_, first_);
  for (size_t i = 0; i < points.size(); ++i) radiance[2 * i] = radiance[2 * i + 1] = first_.sums[i];
  for (uint32_t half = 0; half < 2; ++half) {
    const uint32_t samples = (samples_ + 1 - half) / 2;
    std::fill(first_.sums.begin(), first_.sums.end(), glm::vec3(0.0f));
    if (samples > 0) add_samples(points, {samples, half, shadows_, traced}, first_);
    for (size_t i = 0; i < points.size(); ++i) {
      radiance[2 * i + half] += first_.sums[i];
      if (samples_ == 1) radiance[2 * i + 1] = radiance[2 * i];
    }
    if (samples_ == 1) break;
  }
}

void ReferenceShader::prepare(std::span<const SurfacePoint> points, Bounce& b) const {
  b.lobes.clear();
  b.cones.clear();
  b.sums.assign(points.size(), glm::vec3(0.0f));
  b.lobes.reserve(points.size());
  for (const SurfacePoint& p : points) b.lobes.emplace_back(p);
  for (const ReferenceLight& light : *scene_.lights)
    for (const SurfacePoint& p : points) b.cones.push_back(light.sized() ? light_cone(light, p.position) : LightCone{});
}

// Adds lights without a size, for which one ray is exact.
void ReferenceShader::add_points_of_light(std::span<const SurfacePoint> points, bool shadows, Bounce& b) {
  for (const ReferenceLight& light : *scene_.lights) {
    if (light.sized()) continue;
    for (size_t i = 0; i < points.size(); ++i) {
      const SurfacePoint& p = points[i];
      const shading::SrIncidence in = shading::sr_incidence(light.light, p.position);
      if (!(largest(in.irradiance) > 0.0f)) continue;
      const glm::vec3 gain = shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance;
      add_direct_light(p, i, {in.to_light, in.distance, gain}, shadows, b);
    }
    end_shadow_rays(b);
  }
}

void ReferenceShader::add_samples(std::span<const SurfacePoint> points, const Lighting& lighting, Bounce& b) {
  for (uint32_t j = 0; j < lighting.samples; ++j) {
    rays_.clear();
    reflections_.clear();
    sample_lights(points, lighting, j, b);
    sample_lobes(points, lighting, j, b);
    if (!scene_.environment->black()) sample_environment(points, lighting, j, b);
    end_shadow_rays(b);
    if (lighting.traced) end_reflections(points, b);
  }
}

void ReferenceShader::sample_lights(std::span<const SurfacePoint> points, const Lighting& lighting, uint32_t j,
                                    Bounce& b) {
  const auto n = static_cast<float>(lighting.samples);
  for (size_t light = 0; light < scene_.lights->size(); ++light) {
    if (!(*scene_.lights)[light].sized()) continue;
    for (size_t i = 0; i < points.size(); ++i) {
      const LightCone& cone = b.cones[light * points.size() + i];
      if (!(largest(cone.radiance) > 0.0f)) continue;
      const SurfacePoint& p = points[i];
      const glm::vec2 u = random_point(p, for_lights + static_cast<uint32_t>(light), lighting.half, j);
      const glm::vec3 direction = glm::normalize(model::Frame(cone.axis).world(sample_cone(u, cone.aperture)));
      const float weight = balance(n, 1.0f / cone_solid_angle(cone.aperture), n, b.lobes[i].density(direction));
      const glm::vec3 gain = shading::sr_reflect_light(p.surface, p.to_eye, direction) * cone.radiance * weight;
      add_direct_light(p, i, {direction, distance_to_light(cone, u.x * cone.aperture), gain}, lighting.shadows, b);
    }
    end_shadow_rays(b);
  }
}

void ReferenceShader::sample_lobes(std::span<const SurfacePoint> points, const Lighting& lighting, uint32_t j,
                                   Bounce& b) {
  const auto n = static_cast<float>(lighting.samples);
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    if (!b.lobes[i].reflects()) continue;
    const glm::vec3 direction = b.lobes[i].sample(random_point(p, for_lobes, lighting.half, j));
    if (direction == glm::vec3(0.0f)) continue;
    const float density = b.lobes[i].density(direction);
    add_environment(p, i,
                    {direction, density, scene_.environment->density(direction),
                     random_key({p.key, for_reflection, lighting.half, j})},
                    lighting, b);
    for (size_t light = 0; light < scene_.lights->size(); ++light) {
      const LightCone& cone = b.cones[light * points.size() + i];
      const float below = cone.aperture > 0.0f ? below_axis(cone, direction) : 1.0f;
      if (below >= cone.aperture || !(largest(cone.radiance) > 0.0f)) continue;
      const glm::vec3 gain = shading::sr_reflect_light(p.surface, p.to_eye, direction) * cone.radiance *
                             balance(n, density, n, 1.0f / cone_solid_angle(cone.aperture));
      add_direct_light(p, i, {direction, distance_to_light(cone, below), gain}, lighting.shadows, b);
    }
  }
}

void ReferenceShader::sample_environment(std::span<const SurfacePoint> points, const Lighting& lighting, uint32_t j,
                                         Bounce& b) {
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    if (!b.lobes[i].reflects()) continue;
    const EnvironmentSampler::Sample s = scene_.environment->sample(random_point(p, for_environment, lighting.half, j));
    add_environment(p, i,
                    {s.direction, b.lobes[i].density(s.direction), s.density,
                     random_key({p.key, for_reflection, lighting.half, j, 1u})},
                    lighting, b);
  }
}

// Adds the environment in a direction that one of the two strategies chose: at once for an unoccluded lobe, or by a ray
// if the scene may occlude it.
void ReferenceShader::add_environment(const SurfacePoint& p, size_t i, const EnvironmentDirection& chosen,
                                      const Lighting& lighting, Bounce& b) {
  const glm::vec3 direction = chosen.direction;
  const auto n = static_cast<float>(lighting.samples);
  const shading::SrReflection r = shading::sr_reflection(p.surface, p.to_eye, direction);
  const float weight = balance(n, chosen.lobe_density, n, chosen.environment_density) * p.surface.occlusion;
  const glm::vec3 radiance = scene_.environment->black() ? glm::vec3(0.0f) : scene_.environment->radiance(direction);
  b.sums[i] += r.wide * radiance * weight;
  if (!lighting.traced) {
    b.sums[i] += r.glossy * radiance * weight;
    return;
  }
  const glm::vec3 glossy = r.glossy * weight;
  if (!(largest(glossy) > 0.0f)) return;
  // Rays with little to contribute are traced by Russian roulette; the traced ones get the weight of the others.
  const float average = b.lobes[i].glossy_albedo() / n;
  const float mean = scene_.environment->black() ? 1.0f : std::max(scene_.environment->mean_radiance(), 1e-20f);
  const float chance = largest(glossy) * std::max(largest(radiance) / mean, 1.0f) / (worth_a_ray * average);
  if (chance < 1.0f && unit_float(random_key({chosen.key, for_lot})) >= chance) return;
  const glm::vec3 ray = shading::sr_lifted(direction, p.geometric_normal);
  rays_.push_back({start_of_ray(p, ray), 0.0f, ray, farthest});
  reflections_.push_back({static_cast<uint32_t>(i), chosen.key, glossy / std::min(chance, 1.0f)});
}

// Adds the light by a shadow ray, or at once if it casts no shadows.
void ReferenceShader::add_direct_light(const SurfacePoint& p, size_t i, const DirectLight& light, bool shadows, Bounce& b) {
  if (!(largest(light.gain) > 0.0f)) return;
  if (!shadows) {
    b.sums[i] += light.gain;
    return;
  }
  b.shadow_rays.push_back(
      {start_of_ray(p, light.to_light), 0.0f, light.to_light, light.distance * (1.0f - short_of_light)});
  b.shadow_gains.push_back(light.gain);
  b.shadow_points.push_back(static_cast<uint32_t>(i));
}

void ReferenceShader::end_shadow_rays(Bounce& b) {
  if (b.shadow_rays.empty()) return;
  b.blocked.resize(b.shadow_rays.size());
  rays_shadow += b.shadow_rays.size();
  scene_.intersector->occluded(b.shadow_rays, directions_agree(b.shadow_rays), b.blocked.data());
  if (straight_.is_tinted()) pass_glass(b);
  for (size_t r = 0; r < b.shadow_rays.size(); ++r)
    if (!b.blocked[r]) b.sums[b.shadow_points[r]] += b.shadow_gains[r];
  b.shadow_rays.clear();
  b.shadow_gains.clear();
  b.shadow_points.clear();
}

// Attenuates shadow rays by translucent surfaces on their way.
void ReferenceShader::pass_glass(Bounce& b) {
  free_.clear();
  of_free_.clear();
  for (size_t r = 0; r < b.shadow_rays.size(); ++r) {
    if (b.blocked[r]) continue;
    free_.push_back(b.shadow_rays[r]);
    of_free_.push_back(static_cast<uint32_t>(r));
  }
  straight_.follow(free_);
  for (size_t i = 0; i < free_.size(); ++i) b.shadow_gains[of_free_[i]] *= straight_.through(i);
}

void ReferenceShader::end_reflections(std::span<const SurfacePoint> points, Bounce& b) {
  if (rays_.empty()) return;
  reflected_.assign(rays_.size(), glm::vec3(0.0f));
  const bool coherent = directions_agree(rays_);
  trace_opaque(points, coherent);
  if (scene_.intersector->has_translucent(LayerSet::all_translucent)) composite_in_front(points, coherent);
  for (size_t r = 0; r < rays_.size(); ++r) b.sums[reflections_[r].point] += reflected_[r] * reflections_[r].weight;
}

// Adds the light of second_points_ to second_.sums: direct light and the unoccluded environment, without further
// bounces.
void ReferenceShader::light_reflected(std::span<const SurfacePoint> points, bool shadows) {
  prepare(points, second_);
  for (size_t i = 0; i < points.size(); ++i) second_.sums[i] = shading::sr_emitted(points[i].surface);
  add_points_of_light(points, shadows, second_);
  const Lighting once{1, 0, shadows, false};
  sample_lights(points, once, 0, second_);
  sample_lobes(points, once, 0, second_);
  if (!scene_.environment->black()) sample_environment(points, once, 0, second_);
  end_shadow_rays(second_);
}

void ReferenceShader::trace_opaque(std::span<const SurfacePoint> points, bool coherent) {
  hits_.resize(rays_.size());
  scene_.intersector->nearest_opaque(rays_, {.coherent = coherent}, hits_.data());
  rays_reflection += rays_.size();
  second_points_.clear();
  second_rays_.clear();
  for (size_t r = 0; r < rays_.size(); ++r) {
    if (hits_[r].instance == no_instance) {
      if (!scene_.environment->black()) reflected_[r] = scene_.environment->radiance(rays_[r].direction);
      continue;
    }
    second_points_.push_back(surface_point(*scene_.scene, hits_[r], rays_[r], points[reflections_[r].point].cone));
    second_points_.back().key = reflections_[r].key;
    second_rays_.push_back(static_cast<uint32_t>(r));
    rays_[r].t_far = static_cast<float>(hits_[r].distance);
  }
  light_reflected(second_points_, shadows_);
  for (size_t i = 0; i < second_points_.size(); ++i) reflected_[second_rays_[i]] = second_.sums[i];
}

// Composites translucent surfaces between a reflecting point and its reflection, without shadows on them.
void ReferenceShader::composite_in_front(std::span<const SurfacePoint> points, bool coherent) {
  layer_hits_.resize(rays_.size() * layers_in_reflection);
  layer_counts_.resize(rays_.size());
  scene_.intersector->nearest_layers(LayerSet::all_translucent, rays_,
                                     {.layers = layers_in_reflection, .coherent = coherent}, layer_hits_.data(),
                                     layer_counts_.data());
  rays_reflection += rays_.size();
  second_points_.clear();
  fronts_.clear();
  for (size_t r = 0; r < rays_.size(); ++r)
    for (uint32_t k = 0; k < layer_counts_[r]; ++k) {
      const Hit& hit = layer_hits_[r * layers_in_reflection + k];
      if (!(scene_.scene->snapshot->instances[hit.instance].visibility & SIDERAY_VISIBLE_REFLECTION)) continue;
      SurfacePoint p = surface_point(*scene_.scene, hit, rays_[r], points[reflections_[r].point].cone);
      p.key = random_key({reflections_[r].key, k});
      fronts_.push_back({static_cast<uint32_t>(r), shading::sr_blend(p.surface, p.to_eye, p.blend)});
      second_points_.push_back(p);
    }
  light_reflected(second_points_, false);
  // The surfaces are composited back to front.
  for (size_t i = fronts_.size(); i-- > 0;) {
    glm::vec3& behind = reflected_[fronts_[i].ray];
    behind = second_.sums[i] * fronts_[i].blend.cover + behind * fronts_[i].blend.through;
  }
}

glm::vec3 ReferenceShader::surroundings(glm::vec3 direction, float roughness) const {
  return environment_specular(*scene_.scene->snapshot->environment, direction, roughness);
}

}  // namespace sideray::rt
