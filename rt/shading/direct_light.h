// Adds up the light of punctual lights at batches of points, with the shadow rays that this takes. Skips rays whose
// answer cannot matter. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

class DirectLight {
 public:
  // Forgets what was gathered.
  void clear();
  // Appends what a light adds to the batch's points where nothing blocks it.
  void gather(SurfaceBatch& batch, const shading::SrLight& light);
  // Skips rays, the least bright first, as long as this changes point p by at most allowances[p] in any channel: half
  // of the light is added in place of the answer. Each allowance becomes what is left of it.
  void spare(std::span<float> allowances);
  // Adds the light that arrives to the points' radiance. `shadows` null: nothing blocks any light.
  void add(const Intersector* shadows, glm::vec3* radiance);
  // After add(): adds what the rays could bring to each point, and what they brought.
  void tell(glm::vec3* offered, glm::vec3* arrived) const;

  size_t rays() const { return rays_.size(); }
  size_t skipped() const { return sure_.size(); }
  // After spare(): rays_of() counts the rays of a point that are left, and has_skipped() tells whether some were
  // skipped.
  uint32_t rays_of(size_t point) const { return counts_[point]; }
  bool has_skipped(size_t point) const { return skips_[point] != 0; }

 private:
  struct Gain {
    glm::vec3 radiance;
    uint32_t point;
  };
  void count(size_t points);
  size_t spare_once(std::span<float> allowances);

  ShadowRays rays_;
  std::vector<Gain> sure_;  // half the gain of each skipped ray
  std::vector<uint8_t> blocked_;
  std::vector<uint32_t> counts_;
  std::vector<uint8_t> skips_;
  std::vector<float> shares_;
};

}  // namespace sideray::rt
