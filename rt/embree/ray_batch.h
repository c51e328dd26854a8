// Describes batches of rays, however they are traced. Plain values; any thread may use them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/ray.h"

namespace sideray::rt {

// Returns whether a packet should be traced as coherent: that is faster only if its rays have similar directions, and
// half as fast otherwise.
inline bool directions_agree(std::span<const Ray> rays) {
  constexpr float same_way = 0.95f;
  size_t agreeing = 0;
  for (size_t i = 1; i < rays.size(); ++i) agreeing += glm::dot(rays[i - 1].direction, rays[i].direction) > same_way;
  return agreeing * 10 >= rays.size() * 9;
}

// Holds all surfaces of several rays. Those of ray i are hits[k] for ends[i - 1] <= k < ends[i], with ends[-1] = 0.
struct RaySurfaces {
  std::vector<Hit> hits;
  std::vector<uint32_t> ends;
};

}  // namespace sideray::rt
