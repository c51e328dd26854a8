#include "rt/light/diffuse_paths.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rt/base/largest.h"
#include "rt/base/sampling.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

constexpr uint32_t direction_purpose = 61, roulette_purpose = 62, emitter_purpose = 66;
constexpr float most_reflected = 0.95f;
// Roughness of the lobe over which the sky's light is averaged where a ray leaves the scene.
constexpr float blur_of_open_sky = 0.25f;
// Smoother surfaces on a path reflect no lamps but by their diffuse part: few paths would meet their highlights, and
// these would be brighter than all else that the points nearby share.
constexpr float least_roughness_of_highlights = 0.3f;
// Probabilities of sampling an emitter for a path's start and for a later point. In the bistro those of 1 are nearer by
// .005 of .24 FLIP, and add a tenth to the frame instead of a twentieth (docs/adr/0052-light-that-bounces.md).
constexpr float emitters_at_start = 0.5f, emitters_later = 0.25f;
// Spread of paths' cones: each stands for many directions, so coarse mip levels have less noise, and stay in the cache.
constexpr float spread_of_paths = 0.3f;
constexpr float short_of_hit = 1.0f - 0x1p-16f;

float sum_of(glm::vec3 light) {
  return light.x + light.y + light.z;
}

// Returns the surface's reflectance under uniform light.
glm::vec3 albedo_of(const SurfacePoint& p) {
  const shading::SrSurface& s = p.surface;
  const float n_v = std::abs(glm::dot(s.normal, p.to_eye));
  const glm::vec3 base = s.diffuse * shading::sr_diffuse_share(s, n_v) + shading::sr_specular_albedo(s);
  return glm::clamp((base * s.below_sheen + s.sheen * s.sheen_albedo) * (1.0f - s.coat_share) + s.coat_share, 0.0f,
                    most_reflected);
}

}  // namespace

void DiffusePaths::begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, SecondaryHitShader* host) {
  scene_ = &scene;
  intersector_ = &intersector;
  shadows_ = shadows;
  host_ = host;
  has_sky_ = !scene.snapshot->environment->black;
  rays = rays_shadow = 0;
  batch_.begin(scene, intersector.isa());
  batch_.occlude_by_rays();
  environment_ = {*scene.snapshot->environment, shade_kernels(intersector.isa().c_str())};
  light_.begin(scene, intersector);
  straight_.begin(scene, intersector);
  emitted_.begin(scene, intersector);
}

void DiffusePaths::follow(const PathStarts& starts, PathLight* light) {
  std::fill_n(light, starts.rays.size(), PathLight{});
  paths_.clear();
  for (uint32_t i = 0; i < starts.rays.size(); ++i)
    paths_.push_back({i, glm::vec3(1.0f), starts.keys[i], {starts.rays[i].origin, starts.normals[i]}});
  rays_.assign(starts.rays.begin(), starts.rays.end());
  cones_.clear();
  for (const float width : starts.widths) cones_.push_back({width, spread_of_paths});
  if (samples_emitters()) sample_first_emitters(light);
  hits_.resize(rays_.size());
  intersector_->nearest_opaque(rays_, {}, hits_.data());
  rays += rays_.size();
  for (size_t i = 0; i < hits_.size(); ++i)
    if (hits_[i].instance != no_instance) light[i].nearness = 1.0f / std::max(static_cast<float>(hits_[i].distance), 1e-6f);
  for (uint32_t bounce = 0; bounce < most_path_surfaces; ++bounce) {
    drop_misses();
    if (paths_.empty()) break;
    if (straight_.is_tinted()) tint(rays_);
    places_.clear();
    for (size_t i = 0; i < paths_.size(); ++i) places_.push_back({&hits_[i], &rays_[i], cones_[i]});
    light_of_points_.resize(paths_.size());
    if (host_) {
      host_->shade_secondary_hits(places_, light_of_points_.data());
    } else {
      points_.resize(places_.size());
      make_surfaces(*scene_, shade_kernels(intersector_->isa().c_str()), places_, points_.data());
      choose_ways_on(bounce);
      find_sky();
      shade();
      if (samples_emitters()) share_emission(bounce);
    }
    for (size_t i = 0; i < paths_.size(); ++i) light[paths_[i].number].radiance += paths_[i].through * light_of_points_[i];
    if (host_) return;
    go_on();
  }
  if (!samples_emitters()) return;
  for (const EmittedLight::Answer& a : emitted_.finish()) light[a.number].radiance += a.light;
  rays_shadow += std::exchange(emitted_.rays, 0);
  for (PathLight& l : std::span(light, starts.rays.size()))
    if (l.emitter_nearness > 0.0f) l.emitter_nearness /= sum_of(l.radiance);
}

void DiffusePaths::sample_first_emitters(PathLight* light) {
  if (paths_.empty()) return;
  emitted_.begin_group(paths_.front().key);
  for (const Path& path : paths_) emitted_.add(path.from, emitters_at_start, path.through, path.number, path.key);
  for (const EmittedLight::Answer& a : emitted_.finish()) {
    light[a.number].radiance = a.light;
    light[a.number].emitter_nearness = sum_of(a.light) / (emitters_at_start * a.distance);
  }
}

// Samples an emitter for each point, and takes the samples' share from the emission of points that are sampled, too.
void DiffusePaths::share_emission(uint32_t bounce) {
  for (size_t i = 0; i < paths_.size(); ++i) {
    const Path& path = paths_[i];
    const SurfacePoint& p = points_[i];
    if (scene_->emitters->get().samples(p.hit)) {
      const float share = emitted_.share_of_hit(path.from, bounce == 0 ? emitters_at_start : emitters_later, p.hit, rays_[i].direction);
      light_of_points_[i] -= (1.0f - share) * shading::sr_emitted(p.surface);
    }
    emitted_.add({start_of_ray(p), p.geometric_normal}, emitters_later, path.through * albedo_of(p), path.number,
                 random_key({path.key, emitter_purpose, bounce}));
  }
}

// Keeps only paths with a hit, with their rays and hits.
void DiffusePaths::drop_misses() {
  size_t kept = 0;
  for (size_t i = 0; i < paths_.size(); ++i) {
    if (hits_[i].instance == no_instance) continue;
    paths_[kept] = paths_[i];
    rays_[kept] = rays_[i];
    cones_[kept] = cones_[i];
    hits_[kept++] = hits_[i];
  }
  paths_.resize(kept), rays_.resize(kept), cones_.resize(kept), hits_.resize(kept);
}

// Tints each path by the glass on its way.
void DiffusePaths::tint(std::span<const Ray> ways) {
  tinted_.assign(ways.begin(), ways.end());
  for (size_t i = 0; i < tinted_.size(); ++i) tinted_[i].t_far = static_cast<float>(hits_[i].distance) * short_of_hit;
  straight_.follow(tinted_);
  for (size_t i = 0; i < tinted_.size(); ++i) paths_[i].through *= straight_.through(i);
}

// Samples each path's next direction, and whether it continues.
void DiffusePaths::choose_ways_on(uint32_t bounce) {
  next_.clear(), next_points_.clear(), reflected_.clear(), ends_.clear(), end_points_.clear();
  for (uint32_t i = 0; i < paths_.size(); ++i) {
    const SurfacePoint& p = points_[i];
    const uint32_t key = random_key({paths_[i].key, direction_purpose, bounce});
    const glm::vec2 u(unit_float(key), unit_float(hash_bits(key)));
    const Ray ray{start_of_ray(p), 0.0f, frame_about(p.geometric_normal) * sample_cosine(u), farthest};
    const glm::vec3 albedo = albedo_of(p);
    const float chance = largest(albedo);
    if (unit_float(random_key({paths_[i].key, roulette_purpose, bounce})) < chance && bounce + 1 < most_path_surfaces) {
      next_.push_back(ray);
      next_points_.push_back(i);
      reflected_.push_back(albedo / chance);
    } else if (has_sky_) {
      ends_.push_back(ray);
      end_points_.push_back(i);
    }
  }
}

// Tests which continuing rays leave the scene.
void DiffusePaths::find_sky() {
  open_.assign(paths_.size(), 0);
  ways_.resize(paths_.size());
  next_hits_.resize(next_.size());
  intersector_->nearest_opaque(next_, {}, next_hits_.data());
  hidden_.resize(ends_.size());
  if (!ends_.empty()) intersector_->occluded(ends_, false, hidden_.data(), OpaqueSet::occludes_sky);
  rays += next_.size() + ends_.size();
  const auto note = [&](uint32_t point, const Ray& ray, bool open) { ways_[point] = ray.direction, open_[point] = open; };
  for (size_t i = 0; i < next_.size(); ++i) note(next_points_[i], next_[i], next_hits_[i].instance == no_instance);
  for (size_t i = 0; i < ends_.size(); ++i) note(end_points_[i], ends_[i], hidden_[i] == 0);
}

// Diffuse reflection receives the sky's light along the next ray, whose direction is sampled by the cosine. Other lobes
// and transmission receive all of the sky, or nothing.
void DiffusePaths::show_sky() {
  const std::span<AroundBlock> around = batch_.around();
  open_ways_.clear();
  for (size_t i = 0; i < points_.size(); ++i)
    if (open_[i]) open_ways_.push_back(ways_[i]);
  sky_.resize(open_ways_.size());
  environment_.specular(open_ways_, blur_of_open_sky, sky_.data());
  size_t seen = 0;
  for (size_t first = 0; first < points_.size(); first += block_size) {
    AroundBlock& a = around[first / block_size];
    uint32_t open = 0;
    const glm::vec3 none(0.0f);
    for (size_t i = first; i < std::min(first + block_size, points_.size()); ++i) {
      const size_t lane = i - first;
      open |= uint32_t{open_[i]} << lane;
      set_vector(a.irradiance, lane, open_[i] ? sky_[seen++] : none);
      if (open_[i]) continue;
      set_vector(a.behind, lane, none);
      set_vector(a.specular, lane, none);
      set_vector(a.coat, lane, none);
    }
    if (open != 0) batch_.reflect_environment(first / block_size, open);
  }
}

void DiffusePaths::shade() {
  batch_.load(points_);
  if (has_sky_) show_sky();
  batch_.finish(light_of_points_.data());
  // One ray represents all lights of a point.
  constexpr LightOdds odds{0.0f, std::numeric_limits<float>::max()};
  light_.clear();
  batch_.drop_highlights(least_roughness_of_highlights);
  for (size_t b = 0; b < batch_.blocks(); ++b) light_.draw(batch_, b, odds, nullptr);
  if (shadows_) rays_shadow += light_.rays();
  light_.add(shadows_ ? intersector_ : nullptr, light_of_points_.data());
}

// Moves the continuing rays to the remaining paths.
void DiffusePaths::go_on() {
  size_t kept = 0;
  for (size_t i = 0; i < next_.size(); ++i) {
    Path path = paths_[next_points_[i]];
    path.through *= reflected_[i];
    path.from = {next_[i].origin, points_[next_points_[i]].geometric_normal};
    cones_[kept] = points_[next_points_[i]].cone;
    paths_[kept++] = path;
  }
  paths_.resize(kept), cones_.resize(kept);
  std::swap(rays_, next_);
  std::swap(hits_, next_hits_);
}

}  // namespace sideray::rt
