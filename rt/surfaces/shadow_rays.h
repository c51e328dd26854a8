// Collects shadow rays for traversal. Its memory never shrinks: one object per thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/ray.h"
#include "rt/surfaces/shade_kernels.h"

namespace sideray::rt {

// Holds shadow rays by component, and the unoccluded light that each adds to its point.
class ShadowRays {
 public:
  size_t size() const { return count_; }
  void clear() { count_ = 0; }
  // Makes room for `more` rays.
  void reserve(size_t more);
  void append(const ShadeKernels& kernels, const LightBlock& light, float share, uint32_t point);
  // Returns the highlight that the fixed function adds after texturing; undefined if it does not separate highlights.
  glm::vec3 shine(size_t ray) const { return {shine_[0][ray], shine_[1][ray], shine_[2][ray]}; }
  RayColumns columns() const;
  uint32_t point(size_t ray) const { return points_[ray]; }
  glm::vec3 gain(size_t ray) const { return {gain_[0][ray], gain_[1][ray], gain_[2][ray]}; }

 private:
  std::vector<float> origin_[3], direction_[3], gain_[3], shine_[3], t_far_;
  std::vector<float> t_near_;  // all 0
  std::vector<uint32_t> points_;
  size_t count_ = 0;
};

}  // namespace sideray::rt
