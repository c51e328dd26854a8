#include "rt/shading/mirror_rays.h"

#include <algorithm>
#include <cmath>

#include "model/hemisphere.h"
#include "rt/base/sampling.h"
#include "rt/base/largest.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr float least_transmittance = 1e-4f;
constexpr uint32_t layers_in_reflection = 8, most_layers_in_reflection = 64;
constexpr uint32_t not_deep = 0xffffffffu;
// Separates the random numbers of reflections from others of the same key.
constexpr uint32_t reflection_purpose = 0x5ef1ec7u;

float mean(glm::vec3 v) {
  return (v.x + v.y + v.z) * (1.0f / 3.0f);
}

// Returns 1 / distance of a hit; the distance is at least what rounding resolves.
float nearness_of(const Hit& hit) {
  return 1.0f / std::max(static_cast<float>(hit.distance), 1e-6f);
}

// Returns the direction in which a rough lobe about `normal` reflects the eye, by one of the microfacets visible to it
// (Heitz 2018), among directions that leave the surface; `mirror` if none was found. Its radiance replaces that of the
// mirror direction in the split sum (Karis 2013, "Real Shading in Unreal Engine 4"): the lobe's albedo times the mean
// radiance over the lobe. This has little noise, since no weight varies between samples, and agrees with the
// rasterizer's prefiltered environment. Its bias, as Karis describes it, is to treat albedo and radiance as independent
// over the lobe. A direction that hits nothing uses the environment prefiltered about the lobe's dominant direction: it
// has no noise in open surroundings, and a bias where geometry hides a part of the sky.
glm::vec3 rough_direction(const SurfacePoint& p, const model::Frame& frame, glm::vec2 alpha, uint32_t key,
                          glm::vec3 mirror) {
  constexpr uint32_t tries = 8;
  const glm::vec3 to_eye(glm::dot(frame.x, p.to_eye), glm::dot(frame.y, p.to_eye), glm::dot(frame.z, p.to_eye));
  if (to_eye.z <= 0.0f) return mirror;
  for (uint32_t i = 0; i < tries; ++i) {
    // The tries are independent, because a stratified set would not stay stratified after rejections.
    const uint32_t x = random_key({key, i}), y = hash_bits(x);
    const glm::vec3 h = sample_visible_normal(to_eye, alpha, {unit_float(x), unit_float(y)});
    const glm::vec3 local = h * (2.0f * glm::dot(to_eye, h)) - to_eye, direction = frame.world(local);
    if (local.z > 0.0f && glm::dot(direction, p.geometric_normal) > 0.0f) return glm::normalize(direction);
  }
  return glm::dot(mirror, p.geometric_normal) > 0.0f ? mirror : shading::sr_lifted(mirror, p.geometric_normal);
}

}  // namespace

bool mirrors(float roughness) {
  constexpr float floor = 0.04f;
  return roughness <= floor;
}

bool mirrors(const Mirror& mirror) {
  return mirror.narrow || (!mirror.brushed && mirrors(mirror.roughness));
}

void MirrorRays::begin(const ShadingScene& scene, const Intersector& intersector, SecondaryHitShader& met) {
  scene_ = &scene;
  intersector_ = &intersector;
  met_ = &met;
  traversals = 0;
}

void MirrorRays::clear() {
  rays_.clear();
  cones_.clear();
  of_points_.clear();
  mirrors_.clear();
}

void MirrorRays::add(const SurfacePoint& p, uint32_t point, glm::vec3 origin, const Mirror& mirror) {
  if (mirrors(mirror)) {
    rays_.push_back({origin, 0.0f, mirror.direction, farthest});
    // A narrow lobe is one mirror ray with a wider cone, so that coarser mip levels blur its reflection.
    const float spread = mirror.narrow ? 2.0f * mirror.roughness * mirror.roughness : 0.0f;
    cones_.push_back({p.cone.width, p.cone.spread + spread});
  } else {
    const uint32_t key = random_key({p.key, reflection_purpose, mirror.layer});
    const model::Frame frame = mirror.brushed ? frame_of_base(p.surface) : model::Frame(mirror.normal);
    const glm::vec2 alpha = mirror.brushed ? alphas_of_base(p.surface) : glm::vec2(mirror.roughness * mirror.roughness);
    rays_.push_back({start_of_ray(p), 0.0f, rough_direction(p, frame, alpha, key, mirror.direction), farthest});
    cones_.push_back(p.cone);
  }
  of_points_.push_back(point);
  mirrors_.push_back(mirror);
}

void MirrorRays::follow() {
  if (rays_.empty()) return;
  const bool coherent = directions_agree(rays_);
  opaque_hits_.resize(rays_.size());
  intersector_->nearest_opaque(rays_, {.coherent = coherent}, opaque_hits_.data());
  traversals += rays_.size();
  shade_opaque_hits();
  if (intersector_->has_translucent(LayerSet::all_translucent)) trace_in_front(coherent);
}

void MirrorRays::reflect(std::span<const SurfacePoint> points, glm::vec3* radiance,
                         std::vector<RoughReflection>* rough) {
  clear();
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    const glm::vec3 n = p.surface.normal, mirrored = n * (2.0f * glm::dot(p.to_eye, n)) - p.to_eye;
    // A lobe samples its surroundings where the rasterizer does. Perturbed normals send a part of most lobes below the
    // surface; lifting the whole lobe would show the horizon alone.
    const bool is_lobe = !mirrors(p.surface.roughness);
    add(p, static_cast<uint32_t>(i), start_of_ray(p),
        {is_lobe ? mirrored : shading::sr_lifted(mirrored, p.geometric_normal), n, p.surface.roughness, 0});
  }
  follow();
  std::copy(radiance_.begin(), radiance_.begin() + static_cast<ptrdiff_t>(points.size()), radiance);
  if (!rough) return;
  rough->assign(points.size(), RoughReflection{});
  for (size_t i = 0; i < points.size(); ++i)
    if (!mirrors(mirrors_[i])) (*rough)[i] = {radiance_[i], glm::vec3(1.0f), mirrors_[i].roughness, nearness_[i]};
  see_past(*rough);
}

// Adds the environment to rough lobes: over the whole lobe, and in the direction of rays that hit nothing. The latter
// uses the level of half the roughness, because the filter averages neighbouring directions.
void MirrorRays::see_past(std::vector<RoughReflection>& rough) {
  constexpr float narrower = 0.5f;
  const bool uniform = is_uniform(*scene_->snapshot->environment);
  missed_.clear();
  for (size_t i = 0; i < rough.size(); ++i)
    if (rough[i].weight != glm::vec3(0.0f)) missed_.push_back(static_cast<uint32_t>(i));
  look_up_surroundings();
  places_.clear();
  for (size_t i = 0; i < missed_.size(); ++i) {
    RoughReflection& r = rough[missed_[i]];
    r.is_sampled = true;
    r.surroundings = met_radiance_[i];
    const glm::vec2 uv = uniform ? glm::vec2(0.0f) : shading::sr_latlong(rays_[missed_[i]].direction);
    places_.push_back({uv, narrower * r.roughness});
  }
  met_->surroundings(places_, met_radiance_.data());
  for (size_t i = 0; i < missed_.size(); ++i)
    if (!(rough[missed_[i]].nearness > 0.0f)) rough[missed_[i]].radiance = met_radiance_[i];
}

// Writes the radiance of the nearest opaque surfaces to radiance_, or of the surroundings where there are none.
void MirrorRays::shade_opaque_hits() {
  radiance_.resize(rays_.size());
  nearness_.assign(rays_.size(), 0.0f);
  hits_.clear();
  rays_of_points_.clear();
  missed_.clear();
  for (size_t r = 0; r < rays_.size(); ++r) {
    const Hit& hit = opaque_hits_[r];
    if (hit.instance == no_instance) {
      missed_.push_back(static_cast<uint32_t>(r));
      continue;
    }
    nearness_[r] = nearness_of(hit);
    hits_.push_back({&hit, &rays_[r], cones_[r], mirrors_[r].weight});
    rays_of_points_.push_back(static_cast<uint32_t>(r));
  }
  met_radiance_.resize(hits_.size());
  met_->shade_secondary_hits(hits_, met_radiance_.data());
  for (size_t i = 0; i < hits_.size(); ++i) radiance_[rays_of_points_[i]] = met_radiance_[i];
  see_surroundings();
}

// Writes the surroundings of missed_ to radiance_.
void MirrorRays::see_surroundings() {
  look_up_surroundings();
  for (size_t i = 0; i < missed_.size(); ++i) radiance_[missed_[i]] = met_radiance_[i];
}

// Writes the environment in the lobes of missed_ to met_radiance_.
void MirrorRays::look_up_surroundings() {
  places_.clear();
  const bool uniform = is_uniform(*scene_->snapshot->environment);
  for (const uint32_t r : missed_) {
    const Mirror& m = mirrors_[r];
    const glm::vec2 uv =
        uniform ? glm::vec2(0.0f) : shading::sr_latlong(shading::sr_dominant(m.normal, m.direction, m.roughness));
    places_.push_back({uv, m.roughness});
  }
  met_radiance_.resize(places_.size());
  met_->surroundings(places_, met_radiance_.data());
}

// Composites the translucent surfaces between a reflecting point and its reflection over radiance_.
void MirrorRays::trace_in_front(bool coherent) {
  for (size_t r = 0; r < rays_.size(); ++r)
    if (opaque_hits_[r].instance != no_instance) rays_[r].t_far = static_cast<float>(opaque_hits_[r].distance);
  layer_hits_.resize(rays_.size() * layers_in_reflection);
  layer_counts_.resize(rays_.size());
  intersector_->nearest_layers(LayerSet::all_translucent, rays_, {.layers = layers_in_reflection, .coherent = coherent},
                               layer_hits_.data(), layer_counts_.data());
  traversals += rays_.size();
  trace_deep(coherent);
  gather_in_front();
  blends_.resize(hits_.size());
  met_radiance_.resize(hits_.size());
  met_->shade_in_front(hits_, blends_.data(), met_radiance_.data());
  blend_in_front();
}

// Traces the few rays again whose surfaces filled one traversal, with room for more.
void MirrorRays::trace_deep(bool coherent) {
  deep_rays_.clear();
  deep_rank_.assign(rays_.size(), not_deep);
  for (size_t r = 0; r < rays_.size(); ++r) {
    if (layer_counts_[r] < layers_in_reflection) continue;
    deep_rank_[r] = static_cast<uint32_t>(deep_rays_.size());
    deep_rays_.push_back(rays_[r]);
  }
  if (deep_rays_.empty()) return;
  deep_hits_.resize(deep_rays_.size() * most_layers_in_reflection);
  deep_counts_.resize(deep_rays_.size());
  intersector_->nearest_layers(LayerSet::all_translucent, deep_rays_,
                               {.layers = most_layers_in_reflection, .coherent = coherent}, deep_hits_.data(),
                               deep_counts_.data());
  traversals += deep_rays_.size();
}

// Fills hits_ with the translucent hits of all rays, each ray's nearest first.
void MirrorRays::gather_in_front() {
  hits_.clear();
  rays_of_points_.clear();
  for (size_t r = 0; r < rays_.size(); ++r) {
    const uint32_t deep = deep_rank_[r];
    const Hit* hits =
        deep == not_deep ? &layer_hits_[r * layers_in_reflection] : &deep_hits_[deep * most_layers_in_reflection];
    const uint32_t count = deep == not_deep ? layer_counts_[r] : deep_counts_[deep];
    for (uint32_t k = 0; k < count; ++k) {
      if (!(scene_->snapshot->instances[hits[k].instance].visibility & SIDERAY_VISIBLE_REFLECTION)) continue;
      hits_.push_back({&hits[k], &rays_[r], cones_[r], mirrors_[r].weight});
      rays_of_points_.push_back(static_cast<uint32_t>(r));
    }
  }
}

// Attenuates radiance_ by hits_, and adds the light of the visible ones.
void MirrorRays::blend_in_front() {
  size_t i = 0;
  for (size_t r = 0; r < rays_.size() && i < hits_.size(); ++r) {
    weights_.clear();
    glm::vec3 through(1.0f);
    float near = 0.0f;  // nearness of the translucent ones
    for (; i < hits_.size() && rays_of_points_[i] == r; ++i) {
      if (largest(through) < least_transmittance) continue;
      const shading::SrBlend& blend = blends_[i];
      near += nearness_of(*hits_[i].hit) * std::max(mean(through) - mean(through * blend.through), 0.0f);
      if (blend.cover > 0.0f) weights_.push_back({through * blend.cover, i});
      through *= blend.through;
    }
    radiance_[r] *= through;
    nearness_[r] = nearness_[r] * mean(through) + near;
    for (const Weight& w : weights_) radiance_[r] += w.weight * met_radiance_[w.hit];
  }
}

}  // namespace sideray::rt
