#include "rt/shading/direct_light.h"

#include <algorithm>

namespace sideray::rt {
namespace {

// This share of the way to a light is not tested, so that rounding does not carry the ray past it.
constexpr float short_of_light = 1e-5f;
// spare() makes this many rounds: later ones find next to nothing.
constexpr int most_rounds = 4;

// Returns the error of adding half of a gain in place of the answer, which is all or nothing.
float doubt(glm::vec3 gain) {
  return 0.5f * std::max({gain.x, gain.y, gain.z});
}

}  // namespace

void DirectLight::clear() {
  rays_.clear();
  sure_.clear();
}

void DirectLight::gather(SurfaceBatch& batch, const shading::SrLight& light) {
  batch.gather(light, 1.0f - short_of_light, rays_);
}

void DirectLight::count(size_t points) {
  counts_.assign(points, 0);
  skips_.assign(points, 0);
  for (size_t r = 0; r < rays_.size(); ++r) ++counts_[rays_.point(r)];
}

// Takes out the rays that are within an equal share of what their point has left, all of which could be taken out
// together; returns how many.
size_t DirectLight::spare_once(std::span<float> allowances) {
  for (size_t p = 0; p < allowances.size(); ++p)
    shares_[p] = allowances[p] / static_cast<float>(std::max(counts_[p], 1u));
  size_t kept = 0;
  for (size_t r = 0; r < rays_.size(); ++r) {
    const Gain gain{rays_.gain(r), rays_.point(r)};
    const float bound = doubt(gain.radiance);
    if (bound <= shares_[gain.point]) {
      sure_.push_back({gain.radiance * 0.5f, gain.point});
      allowances[gain.point] -= bound;
      --counts_[gain.point];
      skips_[gain.point] = 1;
      continue;
    }
    rays_.move(r, kept++);
  }
  const size_t taken = rays_.size() - kept;
  rays_.keep(kept);
  return taken;
}

// Takes rays out in rounds, without sorting: what dim lights leave of their shares goes to brighter ones.
void DirectLight::spare(std::span<float> allowances) {
  count(allowances.size());
  shares_.resize(allowances.size());
  for (int round = 0; round < most_rounds; ++round)
    if (spare_once(allowances) == 0) break;
  for (float& allowance : allowances) allowance = std::max(allowance, 0.0f);
}

void DirectLight::add(const Intersector* shadows, glm::vec3* radiance) {
  for (const Gain& gain : sure_) radiance[gain.point] += gain.radiance;
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
