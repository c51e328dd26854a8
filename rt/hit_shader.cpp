#include "rt/hit_shader.h"

#include <algorithm>
#include <cmath>

#include "model/hemisphere.h"
#include "rt/environment_lookup.h"
#include "rt/sampling.h"

namespace sideray::rt {
namespace {

constexpr float farthest = 1e30f;
constexpr float least_share = 1e-4f;  // of reflected light in what is seen: below it no ray is worth its cost
constexpr float least_transmittance = 1e-4f;
constexpr uint32_t layers_in_reflection = 8, most_layers_in_reflection = 64;
constexpr uint32_t not_deep = 0xffffffffu;
// What the random numbers of a point's key are for.
constexpr uint32_t reflection_purpose = 0x5ef1ec7u;

float largest(glm::vec3 v) {
  return std::max({v.x, v.y, v.z});
}

float mean(glm::vec3 v) {
  return (v.x + v.y + v.z) * (1.0f / 3.0f);
}

// Of what a ray met, no nearer than what rounding tells apart.
float nearness(const Hit& hit) {
  return 1.0f / std::max(static_cast<float>(hit.distance), 1e-6f);
}

// Whether a lobe is too narrow for its directions to differ: the floor of roughness.
bool mirrors(float roughness) {
  constexpr float floor = 0.04f;
  return roughness <= floor;
}

// Where a rough lobe about `normal` reflects the eye: one of the microfacets that it sees (Heitz 2018), among those
// directions that leave the surface; `mirror` where none was found. The radiance from there stands for the mirror
// direction's in the split sum (Karis 2013, "Real Shading in Unreal Engine 4"): the lobe's albedo times the mean
// radiance that the lobe sees. That has little noise, since no weight varies from sample to sample, and agrees with the
// prefiltered environment of the rasterizer. Its bias, as Karis describes it: the albedo's and the radiance's variation
// over the lobe are taken for independent. A direction that meets nothing shows the environment prefiltered about the
// mirror direction: no noise of its own where nothing stands around, and a bias where geometry hides a part of the sky.
glm::vec3 rough_direction(const SurfacePoint& p, glm::vec3 normal, float roughness, uint32_t key, glm::vec3 mirror) {
  constexpr uint32_t tries = 8;
  const model::Frame frame(normal);
  const glm::vec3 to_eye(glm::dot(frame.x, p.to_eye), glm::dot(frame.y, p.to_eye), glm::dot(frame.z, p.to_eye));
  if (to_eye.z <= 0.0f) return mirror;
  for (uint32_t i = 0; i < tries; ++i) {
    // Independent of each other: a stratified set would not be, once some of its points were turned down.
    const uint32_t x = random_key({key, i}), y = hash_bits(x);
    const glm::vec3 h = sample_visible_normal(to_eye, roughness * roughness, {unit_float(x), unit_float(y)});
    const glm::vec3 local = h * (2.0f * glm::dot(to_eye, h)) - to_eye, direction = frame.world(local);
    if (local.z > 0.0f && glm::dot(direction, p.geometric_normal) > 0.0f) return glm::normalize(direction);
  }
  return mirror;
}

// What the base reflects of the radiance from its mirror direction: as in sr_environment().
glm::vec3 base_weight(const shading::SrSurface& s, glm::vec2 albedo_terms) {
  return shading::sr_specular_albedo(s, albedo_terms) * (s.below_sheen * (1.0f - s.coat_share) * s.occlusion);
}

glm::vec3 start_of_ray(const SurfacePoint& p) {
  return p.position + p.geometric_normal * p.offset;
}

bool bit(uint32_t bits, size_t i) {
  return (bits >> i & 1u) != 0;
}

}  // namespace

void HitShader::begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, bool tell_rough) {
  scene_ = &scene;
  intersector_ = &intersector;
  shadows_ = shadows, tell_rough_ = tell_rough;
  rough_.clear();
  rays_reflection = rays_shadow = rays_spared = points_spared = 0;
  brightest_ = 0.0f;
  const std::string isa = intersector.isa();
  for (SurfaceBatch* batch : {&seen_, &reflected_, &in_front_}) batch->begin(scene, isa);
}

void HitShader::shade(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  seen_.load(points);
  const bool spares =
      std::any_of(points.begin(), points.end(), [](const SurfacePoint& p) { return p.allowance > 0.0f; });
  allowances_.clear();
  if (spares) {
    for (const SurfacePoint& p : points) allowances_.push_back(p.allowance);
    gather_needed(seen_, allowances_, seen_light_);
  }
  trace_reflections(points);
  if (tell_rough_) collect_rough(points);
  seen_.finish(radiance);
  if (spares) {
    add_gathered(seen_light_, shadows_, radiance);
    count_spared(points.size());
  } else {
    add_direct(seen_, shadows_, {}, radiance);
  }
}

void HitShader::shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  shade_points(points, reflected_, shadows_, {}, radiance);
}

void HitShader::add_direct(SurfaceBatch& batch, bool shadows, std::span<float> allowances, glm::vec3* radiance) {
  if (!allowances.empty()) {
    gather_needed(batch, allowances, light_);
    add_gathered(light_, shadows, radiance);
    return;
  }
  for (const shading::SrLight& light : scene_->lights) {
    light_.clear();
    light_.gather(batch, light);
    add_gathered(light_, shadows, radiance);
  }
}

// Of all lights at once, so that each point spares the rays of the least bright ones.
void HitShader::gather_needed(SurfaceBatch& batch, std::span<float> allowances, DirectLight& direct) {
  direct.clear();
  for (const shading::SrLight& light : scene_->lights) direct.gather(batch, light);
  if (shadows_) direct.spare(allowances);
}

void HitShader::add_gathered(DirectLight& light, bool shadows, glm::vec3* radiance) {
  if (shadows) rays_shadow += light.rays(), rays_spared += light.spared();
  light.add(shadows ? intersector_ : nullptr, radiance);
}

void HitShader::count_spared(size_t points) {
  std::vector<uint8_t>& traced = traced_points_;
  traced.assign(points, 0);
  for (const uint32_t point : mirror_points_) traced[point] = 1;
  const auto skip = [&](size_t point) {
    points_spared += traced[point] == 0 && (!shadows_ || seen_light_.rays_of(point) == 0);
    traced[point] = 1;
  };
  for (const uint32_t point : mirrors_spared_) skip(point);
  for (size_t point = 0; shadows_ && point < points; ++point)
    if (seen_light_.has_spared(point)) skip(point);
}

// Fills what the mirror directions of seen_ show.
void HitShader::trace_reflections(std::span<const SurfacePoint> points) {
  collect_mirror_rays(points);
  share_allowances(points.size());
  follow_mirror_rays();
  const std::span<AroundBlock> around = seen_.around();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    AroundBlock& block = around[mirror_points_[r] / block_size];
    const size_t lane = mirror_points_[r] % block_size;
    if (r < first_coat_) set_vector(block.specular, lane, mirror_radiance_[r]);
    if (r >= first_coat_ || bit(block.alike, lane)) set_vector(block.coat, lane, mirror_radiance_[r]);
  }
}

// Whether a mirror ray can show nothing that counts; the environment takes its place, as the rasterizer has it. What
// the filter of rough reflections takes is traced in full: it goes to neighbours, where it has other weights.
bool HitShader::spares_mirror(size_t point, float share, const Mirror& mirror, bool alike) {
  if (allowances_.empty() || brightest_ <= 0.0f || (tell_rough_ && !mirrors(mirror.roughness))) return false;
  const float bound = share * brightest_;
  if (bound > allowances_[point]) return false;
  allowances_[point] -= bound;
  ++rays_spared;
  mirrors_spared_.push_back(static_cast<uint32_t>(point));
  AroundBlock& block = seen_.around()[point / block_size];
  const size_t lane = point % block_size;
  const glm::vec3 shown = environment_specular(*scene_->snapshot->environment, mirror.direction, mirror.roughness);
  if (mirror.layer == 0) set_vector(block.specular, lane, shown);
  if (mirror.layer == 1 || alike) set_vector(block.coat, lane, shown);
  return true;
}

// What direct light leaves of its point's allowance, to the mirror rays in equal parts.
void HitShader::share_allowances(size_t points) {
  mirror_allowances_.clear();
  if (allowances_.empty()) return;
  rays_of_points_.assign(points, 0);
  for (const uint32_t point : mirror_points_) ++rays_of_points_[point];
  for (size_t r = 0; r < mirror_points_.size(); ++r) {
    const uint32_t point = mirror_points_[r];
    const bool filtered = tell_rough_ && !mirrors(mirrors_[r].roughness);
    const float share = mirror_shares_[r] * static_cast<float>(rays_of_points_[point]);
    mirror_allowances_.push_back(filtered ? 0.0f : allowances_[point] / share);
  }
}

// Fills mirror_radiance_ and mirror_nearness_.
void HitShader::follow_mirror_rays() {
  if (mirror_rays_.empty()) return;
  const bool coherent = directions_agree(mirror_rays_);
  opaque_hits_.resize(mirror_rays_.size());
  intersector_->nearest_opaque(mirror_rays_, coherent, opaque_hits_.data());
  rays_reflection += mirror_rays_.size();
  shade_reflection_hits();
  if (intersector_->has_translucent(LayerSet::all_translucent)) trace_in_front(coherent);
}

void HitShader::reflect(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  mirror_rays_.clear(), mirror_cones_.clear(), mirror_points_.clear(), mirrors_.clear(), mirror_allowances_.clear();
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    const glm::vec3 n = p.surface.normal, mirrored = n * (2.0f * glm::dot(p.to_eye, n)) - p.to_eye;
    add_mirror_ray(points, i, start_of_ray(p),
                   {shading::sr_lifted(mirrored, p.geometric_normal), n, p.surface.roughness, 0});
  }
  first_coat_ = mirror_rays_.size();
  follow_mirror_rays();
  std::copy(mirror_radiance_.begin(), mirror_radiance_.begin() + static_cast<ptrdiff_t>(points.size()), radiance);
  rough_.clear();
  if (!tell_rough_) return;
  rough_.resize(points.size(), RoughReflection{});
  for (size_t i = 0; i < points.size(); ++i)
    if (!mirrors(mirrors_[i].roughness))
      rough_[i] = {mirror_radiance_[i], glm::vec3(1.0f), mirrors_[i].roughness, mirror_nearness_[i]};
}

void HitShader::collect_rough(std::span<const SurfacePoint> points) {
  rough_.assign(points.size(), RoughReflection{});
  const std::span<const AroundBlock> around = seen_.around();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    if (mirrors(mirrors_[r].roughness)) continue;
    const uint32_t i = mirror_points_[r];
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    const shading::SrSurface& s = points[i].surface;
    const glm::vec3 coat(s.coat_share * s.occlusion);
    const glm::vec3 base = base_weight(s, {a.albedo_terms[0][lane], a.albedo_terms[1][lane]});
    add_rough(r, r >= first_coat_ ? coat : bit(a.alike, lane) ? base + coat : base, rough_[i]);
  }
}

// A coat and a base that are both rough count as one lobe between them: as rough as the one that reflects more.
void HitShader::add_rough(size_t ray, glm::vec3 weight, RoughReflection& rough) const {
  const glm::vec3 both = rough.weight + weight;
  const glm::vec3 light = rough.radiance * rough.weight + mirror_radiance_[ray] * weight;
  const float before = largest(rough.weight), now = largest(weight);
  if (now > before) rough.roughness = mirrors_[ray].roughness;
  if (now > 0.0f) rough.nearness = (rough.nearness * before + mirror_nearness_[ray] * now) / (before + now);
  for (int c = 0; c < 3; ++c) rough.radiance[c] = both[c] > 0.0f ? light[c] / both[c] : 0.0f;
  rough.weight = both;
}

void HitShader::collect_mirror_rays(std::span<const SurfacePoint> points) {
  mirror_rays_.clear(), mirror_cones_.clear(), mirror_points_.clear(), mirrors_.clear();
  mirror_shares_.clear(), mirrors_spared_.clear();
  const std::span<const AroundBlock> around = seen_.around();
  for (size_t i = 0; i < points.size(); ++i) {
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    const bool alike = bit(a.alike, lane);
    const float share = a.share[lane] + (alike ? a.coat_share[lane] : 0.0f);
    if (share < least_share) continue;
    const shading::SrSurface& s = points[i].surface;
    const Mirror mirror{vector_at(a.mirror, lane), s.normal, s.roughness, 0};
    if (spares_mirror(i, share, mirror, alike)) continue;
    add_mirror_ray(points, i, vector_at(a.mirror_origin, lane), mirror);
    mirror_shares_.push_back(share);
  }
  // Coats last, so that neighbours in a packet go the same way.
  first_coat_ = mirror_rays_.size();
  for (size_t i = 0; i < points.size(); ++i) {
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    if (!bit(a.coated & ~a.alike, lane) || a.coat_share[lane] < least_share) continue;
    const shading::SrSurface& s = points[i].surface;
    const Mirror mirror{vector_at(a.coat_mirror, lane), s.coat_normal, s.coat_roughness, 1};
    if (spares_mirror(i, a.coat_share[lane], mirror, false)) continue;
    add_mirror_ray(points, i, vector_at(a.coat_origin, lane), mirror);
    mirror_shares_.push_back(a.coat_share[lane]);
  }
}

void HitShader::add_mirror_ray(std::span<const SurfacePoint> points, size_t i, glm::vec3 origin, const Mirror& mirror) {
  const SurfacePoint& p = points[i];
  if (mirrors(mirror.roughness)) {
    mirror_rays_.push_back({origin, 0.0f, mirror.direction, farthest});
  } else {
    const uint32_t key = random_key({p.key, reflection_purpose, mirror.layer});
    mirror_rays_.push_back(
        {start_of_ray(p), 0.0f, rough_direction(p, mirror.normal, mirror.roughness, key, mirror.direction), farthest});
  }
  mirror_cones_.push_back(p.cone);
  mirror_points_.push_back(static_cast<uint32_t>(i));
  mirrors_.push_back(mirror);
}

// Fills mirror_radiance_ with what the nearest opaque surfaces show.
void HitShader::shade_reflection_hits() {
  const model::Environment& environment = *scene_->snapshot->environment;
  mirror_radiance_.resize(mirror_rays_.size());
  mirror_nearness_.assign(mirror_rays_.size(), 0.0f);
  points_.clear(), rays_of_points_.clear(), hit_allowances_.clear();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    const Hit& hit = opaque_hits_[r];
    if (hit.instance == no_instance) {
      mirror_radiance_[r] = environment_specular(environment, mirrors_[r].direction, mirrors_[r].roughness);
      continue;
    }
    mirror_nearness_[r] = nearness(hit);
    points_.push_back(surface_point(*scene_, hit, mirror_rays_[r], mirror_cones_[r]));
    rays_of_points_.push_back(static_cast<uint32_t>(r));
    if (!mirror_allowances_.empty()) hit_allowances_.push_back(mirror_allowances_[r]);
  }
  radiance_.resize(points_.size());
  shade_points(points_, reflected_, shadows_, hit_allowances_, radiance_.data());
  for (size_t i = 0; i < points_.size(); ++i) mirror_radiance_[rays_of_points_[i]] = radiance_[i];
}

// Translucent surfaces between a reflecting point and what it reflects, composited over mirror_radiance_.
void HitShader::trace_in_front(bool coherent) {
  for (size_t r = 0; r < mirror_rays_.size(); ++r)
    if (opaque_hits_[r].instance != no_instance) mirror_rays_[r].t_far = static_cast<float>(opaque_hits_[r].distance);
  layer_hits_.resize(mirror_rays_.size() * layers_in_reflection);
  layer_counts_.resize(mirror_rays_.size());
  intersector_->nearest_layers(LayerSet::all_translucent, mirror_rays_, layers_in_reflection, coherent,
                               layer_hits_.data(), layer_counts_.data());
  rays_reflection += mirror_rays_.size();
  trace_deep(coherent);
  points_.clear(), rays_of_points_.clear(), weights_.clear();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    glm::vec3 through(1.0f);
    float near = 0.0f;  // of the translucent ones
    const uint32_t deep = deep_rank_[r];
    const Hit* hits =
        deep == not_deep ? &layer_hits_[r * layers_in_reflection] : &deep_hits_[deep * most_layers_in_reflection];
    const uint32_t count = deep == not_deep ? layer_counts_[r] : deep_counts_[deep];
    for (uint32_t k = 0; k < count && largest(through) >= least_transmittance; ++k) {
      const Hit& hit = hits[k];
      if (!(scene_->snapshot->instances[hit.instance].visibility & SIDERAY_VISIBLE_REFLECTION)) continue;
      const SurfacePoint p = surface_point(*scene_, hit, mirror_rays_[r], mirror_cones_[r]);
      const shading::SrBlend blend = shading::sr_blend(p.surface, p.to_eye, p.blend);
      if (blend.cover > 0.0f) {
        points_.push_back(p);
        rays_of_points_.push_back(static_cast<uint32_t>(r));
        weights_.push_back(through * blend.cover);
      }
      near += nearness(hit) * std::max(mean(through) - mean(through * blend.through), 0.0f);
      through *= blend.through;
    }
    mirror_radiance_[r] *= through;
    mirror_nearness_[r] = mirror_nearness_[r] * mean(through) + near;
  }
  radiance_.resize(points_.size());
  shade_points(points_, in_front_, false, {}, radiance_.data());
  for (size_t i = 0; i < points_.size(); ++i) mirror_radiance_[rays_of_points_[i]] += weights_[i] * radiance_[i];
}

// Rays that met as many surfaces as one traversal holds are traced again for more: few are.
void HitShader::trace_deep(bool coherent) {
  deep_rays_.clear();
  deep_rank_.assign(mirror_rays_.size(), not_deep);
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    if (layer_counts_[r] < layers_in_reflection) continue;
    deep_rank_[r] = static_cast<uint32_t>(deep_rays_.size());
    deep_rays_.push_back(mirror_rays_[r]);
  }
  if (deep_rays_.empty()) return;
  deep_hits_.resize(deep_rays_.size() * most_layers_in_reflection);
  deep_counts_.resize(deep_rays_.size());
  intersector_->nearest_layers(LayerSet::all_translucent, deep_rays_, most_layers_in_reflection, coherent,
                               deep_hits_.data(), deep_counts_.data());
  rays_reflection += deep_rays_.size();
}

// Light without further reflections: the prefiltered environment instead.
void HitShader::shade_points(std::span<const SurfacePoint> points, SurfaceBatch& batch, bool shadows,
                             std::span<float> allowances, glm::vec3* radiance) {
  if (points.empty()) return;
  batch.load(points);
  batch.reflect_environment();
  batch.finish(radiance);
  add_direct(batch, shadows, allowances, radiance);
}

}  // namespace sideray::rt
