#include "rt/light/direct_light.h"

namespace sideray::rt {
namespace {

// Rays stop before the light by this share of the distance, so that rounding does not carry them past it.
constexpr float short_of_light = 1e-5f;

}  // namespace

void DirectLight::clear() {
  rays_.clear();
}

void DirectLight::gather(SurfaceBatch& batch, size_t light) {
  separate_ = batch.is_separate();
  batch.gather(light, 1.0f - short_of_light, rays_);
}

void DirectLight::draw(SurfaceBatch& batch, size_t block, const LightOdds& odds, glm::vec3* offered) {
  separate_ = batch.is_separate();
  batch.draw(block, odds, 1.0f - short_of_light, rays_, offered);
}

void DirectLight::add(const Intersector* shadows, glm::vec3* radiance, bool coherent) {
  blocked_.assign(rays_.size(), 0);
  // Translucent surfaces of neighbouring pixels are far apart, and coherent traversal takes 10 % longer (bench_trace
  // --benchmark_filter=shade_shadowed).
  if (shadows && rays_.size() > 0) shadows->occluded(rays_.columns(), coherent, blocked_.data());
  through_.clear();
  if (shadows && tints_) pass_glass();
  for (size_t r = 0; r < rays_.size(); ++r)
    if (!blocked_[r]) radiance[rays_.point(r)] += rays_.gain(r) * through(r);
}

// Fills through_.
void DirectLight::pass_glass() {
  const RayColumns columns = rays_.columns();
  free_.clear();
  of_free_.clear();
  through_.assign(rays_.size(), glm::vec3(1.0f));
  straight_.choose(columns, blocked_.data(), free_, of_free_);
  straight_.follow(free_);
  for (size_t i = 0; i < free_.size(); ++i) through_[of_free_[i]] = straight_.through(i);
}

void DirectLight::add_shine(glm::vec3* shine) const {
  for (size_t r = 0; r < rays_.size(); ++r)
    if (!blocked_[r]) shine[rays_.point(r)] += rays_.shine(r) * through(r);
}

void DirectLight::tell(glm::vec3* offered, glm::vec3* arrived) const {
  for (size_t r = 0; r < rays_.size(); ++r) {
    if (offered) offered[rays_.point(r)] += offer(r);
    if (!blocked_[r]) arrived[rays_.point(r)] += offer(r) * through(r);
  }
}

}  // namespace sideray::rt
