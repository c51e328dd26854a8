#include "rt/hit_shader.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rt/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr float farthest = 1e30f;
constexpr float least_share = 1e-4f;  // of reflected light in what is seen: below it no ray is worth its cost
constexpr float least_transmittance = 1e-4f;
constexpr uint32_t layers_in_reflection = 8;
// Share of the way to a light that is not tested, so that rounding does not carry the ray past it.
constexpr float short_of_light = 1e-5f;

float largest(glm::vec3 v) {
  return std::max({v.x, v.y, v.z});
}

// Packets gain from the coherent traversal only where their rays go the same way; elsewhere it costs half the speed.
bool directions_agree(std::span<const Ray> rays) {
  constexpr float same_way = 0.95f;
  size_t agreeing = 0;
  for (size_t i = 1; i < rays.size(); ++i) agreeing += glm::dot(rays[i - 1].direction, rays[i].direction) > same_way;
  return agreeing * 10 >= rays.size() * 9;
}

bool bit(uint32_t bits, size_t i) {
  return (bits >> i & 1u) != 0;
}

}  // namespace

void HitShader::begin(const ShadingScene& scene, const Intersector& intersector, bool shadows) {
  scene_ = &scene;
  intersector_ = &intersector;
  shadows_ = shadows;
  rays_reflection = rays_shadow = 0;
  const std::string isa = intersector.isa();
  for (SurfaceBatch* batch : {&seen_, &reflected_, &in_front_}) batch->begin(scene, isa);
}

void HitShader::shade(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  seen_.load(points);
  trace_reflections(points);
  seen_.finish(radiance);
  add_direct(seen_, shadows_, radiance);
}

void HitShader::add_direct(SurfaceBatch& batch, bool shadows, glm::vec3* radiance) {
  for (const shading::SrLight& light : scene_->lights) {
    shadow_rays_.clear(), shadow_gains_.clear(), shadow_points_.clear();
    const std::span<const LightBlock> blocks = batch.light(light);
    for (size_t b = 0; b < blocks.size(); ++b) {
      const LightBlock& block = blocks[b];
      for (uint32_t bits = block.reached; bits != 0; bits &= bits - 1) {
        const auto lane = static_cast<size_t>(std::countr_zero(bits));
        shadow_rays_.push_back({vector_at(block.origin, lane), 0.0f, vector_at(block.direction, lane),
                                block.distance[lane] * (1.0f - short_of_light)});
        shadow_gains_.push_back(vector_at(block.gain, lane));
        shadow_points_.push_back(static_cast<uint32_t>(b * block_size + lane));
      }
    }
    blocked_.assign(shadow_rays_.size(), 0);
    if (shadows && !shadow_rays_.empty()) {
      rays_shadow += shadow_rays_.size();
      intersector_->occluded(shadow_rays_, true, blocked_.data());
    }
    for (size_t r = 0; r < shadow_rays_.size(); ++r)
      if (!blocked_[r]) radiance[shadow_points_[r]] += shadow_gains_[r];
  }
}

// Fills what the mirror directions of seen_ show.
void HitShader::trace_reflections(std::span<const SurfacePoint> points) {
  collect_mirror_rays(points);
  if (!mirror_rays_.empty()) {
    const bool coherent = directions_agree(mirror_rays_);
    opaque_hits_.resize(mirror_rays_.size());
    intersector_->nearest_opaque(mirror_rays_, coherent, opaque_hits_.data());
    rays_reflection += mirror_rays_.size();
    shade_reflection_hits();
    if (intersector_->has_translucent(LayerSet::all_translucent)) trace_in_front(coherent);
  }
  const std::span<AroundBlock> around = seen_.around();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    AroundBlock& block = around[mirror_points_[r] / block_size];
    const size_t lane = mirror_points_[r] % block_size;
    if (r < first_coat_) set_vector(block.specular, lane, mirror_radiance_[r]);
    if (r >= first_coat_ || bit(block.alike, lane)) set_vector(block.coat, lane, mirror_radiance_[r]);
  }
}

void HitShader::collect_mirror_rays(std::span<const SurfacePoint> points) {
  mirror_rays_.clear(), mirror_cones_.clear(), mirror_roughness_.clear(), mirror_points_.clear();
  const auto add = [&](size_t i, glm::vec3 origin, glm::vec3 direction, float roughness) {
    mirror_rays_.push_back({origin, 0.0f, direction, farthest});
    mirror_cones_.push_back(points[i].cone);
    mirror_roughness_.push_back(roughness);
    mirror_points_.push_back(static_cast<uint32_t>(i));
  };
  const std::span<const AroundBlock> around = seen_.around();
  for (size_t i = 0; i < points.size(); ++i) {
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    const float share = a.share[lane] + (bit(a.alike, lane) ? a.coat_share[lane] : 0.0f);
    if (share >= least_share)
      add(i, vector_at(a.mirror_origin, lane), vector_at(a.mirror, lane), points[i].surface.roughness);
  }
  // Coats last, so that neighbours in a packet go the same way.
  first_coat_ = mirror_rays_.size();
  for (size_t i = 0; i < points.size(); ++i) {
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    if (bit(a.coated & ~a.alike, lane) && a.coat_share[lane] >= least_share)
      add(i, vector_at(a.coat_origin, lane), vector_at(a.coat_mirror, lane), points[i].surface.coat_roughness);
  }
}

// Fills mirror_radiance_ with what the nearest opaque surfaces show.
void HitShader::shade_reflection_hits() {
  const model::Environment& environment = *scene_->snapshot->environment;
  mirror_radiance_.resize(mirror_rays_.size());
  points_.clear(), rays_of_points_.clear();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    const Hit& hit = opaque_hits_[r];
    if (hit.instance == no_instance) {
      mirror_radiance_[r] = environment_specular(environment, mirror_rays_[r].direction, mirror_roughness_[r]);
      continue;
    }
    points_.push_back(surface_point(*scene_, hit, mirror_rays_[r], mirror_cones_[r]));
    rays_of_points_.push_back(static_cast<uint32_t>(r));
  }
  shade_points(reflected_, shadows_);
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
  points_.clear(), rays_of_points_.clear(), weights_.clear();
  for (size_t r = 0; r < mirror_rays_.size(); ++r) {
    glm::vec3 through(1.0f);
    for (uint32_t k = 0; k < layer_counts_[r] && largest(through) >= least_transmittance; ++k) {
      const Hit& hit = layer_hits_[r * layers_in_reflection + k];
      if (!(scene_->snapshot->instances[hit.instance].visibility & SIDERAY_VISIBLE_REFLECTION)) continue;
      const SurfacePoint p = surface_point(*scene_, hit, mirror_rays_[r], mirror_cones_[r]);
      const shading::SrBlend blend = shading::sr_blend(p.surface, p.to_eye, p.blend);
      if (blend.cover > 0.0f) {
        points_.push_back(p);
        rays_of_points_.push_back(static_cast<uint32_t>(r));
        weights_.push_back(through * blend.cover);
      }
      through *= blend.through;
    }
    mirror_radiance_[r] *= through;
  }
  shade_points(in_front_, false);
  for (size_t i = 0; i < points_.size(); ++i) mirror_radiance_[rays_of_points_[i]] += weights_[i] * radiance_[i];
}

// Fills radiance_ with the light of points_ without further reflections: the prefiltered environment instead.
void HitShader::shade_points(SurfaceBatch& batch, bool shadows) {
  radiance_.resize(points_.size());
  if (points_.empty()) return;
  batch.load(points_);
  batch.reflect_environment();
  batch.finish(radiance_.data());
  add_direct(batch, shadows, radiance_.data());
}

}  // namespace sideray::rt
