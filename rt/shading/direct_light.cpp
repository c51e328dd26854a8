#include "rt/shading/direct_light.h"

#include <algorithm>
#include <bit>

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
  gains_.clear();
  sure_.clear();
}

void DirectLight::gather(SurfaceBatch& batch, const shading::SrLight& light) {
  const std::span<const LightBlock> blocks = batch.light(light);
  for (size_t b = 0; b < blocks.size(); ++b) {
    const LightBlock& block = blocks[b];
    for (uint32_t bits = block.reached; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(bits));
      rays_.push_back({vector_at(block.origin, lane), 0.0f, vector_at(block.direction, lane),
                       block.distance[lane] * (1.0f - short_of_light)});
      gains_.push_back({vector_at(block.gain, lane), static_cast<uint32_t>(b * block_size + lane)});
    }
  }
}

void DirectLight::count(size_t points) {
  counts_.assign(points, 0);
  skips_.assign(points, 0);
  for (const Gain& gain : gains_) ++counts_[gain.point];
}

// Takes out the rays that are within an equal share of what their point has left, all of which could be taken out
// together; returns how many.
size_t DirectLight::spare_once(std::span<float> allowances) {
  for (size_t p = 0; p < allowances.size(); ++p)
    shares_[p] = allowances[p] / static_cast<float>(std::max(counts_[p], 1u));
  size_t kept = 0;
  for (size_t r = 0; r < rays_.size(); ++r) {
    const Gain gain = gains_[r];
    const float bound = doubt(gain.radiance);
    if (bound <= shares_[gain.point]) {
      sure_.push_back({gain.radiance * 0.5f, gain.point});
      allowances[gain.point] -= bound;
      --counts_[gain.point];
      skips_[gain.point] = 1;
      continue;
    }
    rays_[kept] = rays_[r];
    gains_[kept++] = gain;
  }
  const size_t taken = rays_.size() - kept;
  rays_.resize(kept);
  gains_.resize(kept);
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
  if (shadows && !rays_.empty()) shadows->occluded(rays_, false, blocked_.data());
  for (size_t r = 0; r < rays_.size(); ++r)
    if (!blocked_[r]) radiance[gains_[r].point] += gains_[r].radiance;
}

}  // namespace sideray::rt
