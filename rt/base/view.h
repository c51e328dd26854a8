// Describes a view, and its depth buffer after readback. Plain values; any thread may use them.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

namespace sideray::rt {

// Names the formats in which depth and stencil are read back. d24: floats that were rounded to 24 bits.
enum class DepthFormat { d16, d24, d24s8, d32f, d32f_s8 };
struct DepthImage {
  const std::byte* texels = nullptr;
  size_t row_bytes = 0;
  DepthFormat format = DepthFormat::d32f_s8;
};

struct TraceView {
  glm::dmat4 clip_from_local, local_from_clip;
  bool reversed_depth = false, zero_to_one_depth = false;
};

// Returns the direction from the scene to the viewer (+z of OpenGL's eye space), in local space.
glm::vec3 way_to_viewer(const TraceView& view);

}  // namespace sideray::rt
