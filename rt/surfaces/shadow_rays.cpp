#include "rt/surfaces/shadow_rays.h"

#include <algorithm>

namespace sideray::rt {

void ShadowRays::reserve(size_t more) {
  const size_t needed = count_ + more + block_size;
  if (points_.size() >= needed) return;
  const size_t size = std::max(needed, 2 * points_.size());
  for (std::vector<float>* columns : {origin_, direction_, gain_, shine_})
    for (int c = 0; c < 3; ++c) columns[c].resize(size);
  t_far_.resize(size);
  t_near_.resize(size);
  points_.resize(size);
}

void ShadowRays::append(const ShadeKernels& kernels, const LightBlock& light, float share, uint32_t point) {
  const ShadowRayColumns columns{{origin_[0].data(), origin_[1].data(), origin_[2].data()},
                                 {direction_[0].data(), direction_[1].data(), direction_[2].data()},
                                 t_far_.data(),
                                 {gain_[0].data(), gain_[1].data(), gain_[2].data()},
                                 {shine_[0].data(), shine_[1].data(), shine_[2].data()},
                                 points_.data()};
  count_ += kernels.pack(light, share, point, static_cast<uint32_t>(count_), columns);
}

RayColumns ShadowRays::columns() const {
  return {{origin_[0].data(), origin_[1].data(), origin_[2].data()},
          {direction_[0].data(), direction_[1].data(), direction_[2].data()},
          t_near_.data(),
          t_far_.data(),
          count_};
}

}  // namespace sideray::rt
