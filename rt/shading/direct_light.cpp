#include "rt/shading/direct_light.h"

namespace sideray::rt {
namespace {

// This share of the way to a light is not tested, so that rounding does not carry the ray past it.
constexpr float short_of_light = 1e-5f;

}  // namespace

void DirectLight::clear() {
  rays_.clear();
}

void DirectLight::gather(SurfaceBatch& batch, const shading::SrLight& light) {
  batch.gather(light, 1.0f - short_of_light, rays_);
}

void DirectLight::add(const Intersector* shadows, glm::vec3* radiance) {
  blocked_.assign(rays_.size(), 0);
  // The traversal is not the coherent one: surfaces of neighbouring pixels lie apart, and traversal for coherent
  // packets takes 10 % longer (bench_trace --benchmark_filter=shade_shadowed).
  if (shadows && rays_.size() > 0) shadows->occluded(rays_.columns(), false, blocked_.data());
  for (size_t r = 0; r < rays_.size(); ++r)
    if (!blocked_[r]) radiance[rays_.point(r)] += rays_.gain(r);
}

void DirectLight::tell(glm::vec3* offered, glm::vec3* arrived) const {
  for (size_t r = 0; r < rays_.size(); ++r) {
    offered[rays_.point(r)] += rays_.gain(r);
    if (!blocked_[r]) arrived[rays_.point(r)] += rays_.gain(r);
  }
}

}  // namespace sideray::rt
