// Describes the first opaque surface along a ray. Plain values; any thread may use them.
#pragma once

#include <glm/glm.hpp>

namespace sideray::rt {

// Says where a pixel's ray hits the first opaque surface that the rasterizer draws there.
struct OpaquePoint {
  double distance;   // along the ray; infinite = nothing
  glm::vec3 normal;  // geometric, unit
};

}  // namespace sideray::rt
