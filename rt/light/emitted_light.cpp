#include "rt/light/emitted_light.h"

#include <algorithm>

#include "rt/base/largest.h"

namespace sideray::rt {
namespace {

constexpr uint32_t choice_purpose = 65;
// Rays stop before the emitter by this share of the distance, because it would block its own light.
constexpr float short_of_emitter = 1e-3f;

float cosine_density(const LitPoint& point, glm::vec3 direction) {
  return std::max(glm::dot(point.normal, direction), 0.0f) * glm::one_over_pi<float>();
}

}  // namespace

void EmittedLight::begin(const ShadingScene& scene, const Intersector& intersector) {
  scene_ = &scene;
  intersector_ = &intersector;
  straight_.begin(scene, intersector);
  sampled_.clear();
  rays = 0;
}

void EmittedLight::add(const LitPoint& point, float probability, glm::vec3 gain, uint32_t number, uint32_t key) {
  lot_ += probability;
  if (lot_ < 1.0f) return;
  lot_ -= 1.0f;
  const uint32_t u = random_key({key, choice_purpose}), v = hash_bits(u), w = hash_bits(v);
  const EmitterSampler::Sample s = scene_->emitters->get().sample(point, unit_float(u), {unit_float(v), unit_float(w)});
  const float by_cosine = cosine_density(point, s.ray.direction);
  if (!(s.density > 0.0f && by_cosine > 0.0f)) return;
  // Random rays pass translucent surfaces, so samples alone find their emission.
  const float weight = balance(probability, s.density, is_translucent(s.hit) ? 0.0f : 1.0f, by_cosine);
  sampled_.push_back({s.hit, s.ray, gain * (by_cosine * weight), number});
}

std::span<const EmittedLight::Answer> EmittedLight::finish() {
  drop_blocked();
  if (straight_.is_tinted()) straight_.follow(rays_);
  places_.clear(), answers_.clear();
  for (const Sampled& s : sampled_) places_.push_back({&s.hit, &s.ray, Cone{}});
  points_.resize(places_.size());
  make_surfaces(*scene_, shade_kernels(intersector_->isa().c_str()), places_, points_.data());
  for (size_t i = 0; i < sampled_.size(); ++i) {
    const Sampled& s = sampled_[i];
    glm::vec3 light = s.gain * shading::sr_emitted(points_[i].surface);
    if (is_translucent(s.hit)) light *= points_[i].blended.cover;
    if (straight_.is_tinted()) light *= straight_.through(i);
    answers_.push_back({s.number, light, s.ray.t_far});
  }
  sampled_.clear();
  return answers_;
}

bool EmittedLight::is_translucent(const Hit& hit) const {
  const model::Snapshot& snapshot = *scene_->snapshot;
  return snapshot.materials[snapshot.instances[hit.instance].material].translucent;
}

// Keeps only samples without an opaque occluder, and their rays.
void EmittedLight::drop_blocked() {
  rays_.clear();
  for (const Sampled& s : sampled_) {
    rays_.push_back(s.ray);
    rays_.back().t_far *= 1.0f - short_of_emitter;
  }
  blocked_.resize(rays_.size());
  // The same surfaces as those that random rays hit.
  intersector_->occluded(rays_, false, blocked_.data(), OpaqueSet::visible_in_reflection);
  rays += rays_.size();
  size_t kept = 0;
  for (size_t i = 0; i < sampled_.size(); ++i)
    if (!blocked_[i]) sampled_[kept] = sampled_[i], rays_[kept++] = rays_[i];
  sampled_.resize(kept), rays_.resize(kept);
}

float EmittedLight::share_of_hit(const LitPoint& point, float probability, const Hit& hit, glm::vec3 direction) const {
  const float sampled = scene_->emitters->get().density(point, hit, direction), by_cosine = cosine_density(point, direction);
  return sampled > 0.0f ? by_cosine * balance(1.0f, by_cosine, probability, sampled) : 1.0f;
}

}  // namespace sideray::rt
