// The largest component of a vector. Plain values; any thread.
#pragma once

#include <algorithm>
#include <glm/glm.hpp>

namespace sideray::rt {

inline float largest(const glm::vec3& v) {
  return std::max({v.x, v.y, v.z});
}

}  // namespace sideray::rt
