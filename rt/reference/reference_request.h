// A request for a picture by rays alone, and the picture. Plain memory; pixels: row 0 is the bottom row.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/view.h"

namespace sideray::rt {

// Everything by rays, exact and unlimited: docs/adr/0006-reference.md.
struct ReferenceRequest {
  std::vector<TraceView> views;  // one a sample position
  uint32_t width = 0, height = 0;
  uint32_t light_samples = 64;
  uint32_t bounces = 1;  // 1: docs/adr/0006-reference.md; else paths, 0 = of any length (docs/adr/0028-paths.md)
  bool shadows = true;
  bool caustics = false;  // paths: sized lamps and shining surfaces are found through refraction, not straight
  bool refraction = false;
  bool reflections = false;  // of opaque surfaces: else they reflect the environment alone; paths always reflect
  bool surfaces = false;     // keep what the first position sees
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between chunks
};

struct ReferenceSurface {
  glm::vec3 position;  // infinite where nothing is
  glm::vec3 normal;    // shading normal
  glm::vec3 albedo;
  float metallic, roughness;
  glm::uvec2 ids;  // surface id, primitive + 1
};

struct ReferenceImage {
  uint32_t width = 0, height = 0;
  std::vector<glm::vec4> color;            // mean over the positions; A = 1 - product of transmittances
  std::vector<glm::vec3> half_difference;  // color +- this: the halves of the light samples; 0 where there was one
  std::vector<ReferenceSurface> surfaces;  // opaque ones of the first position
};

// Opaque surface seen through each pixel centre, by rays: for checks against the rasterizer.
struct PrimaryImage {
  std::vector<float> distance;    // +inf = nothing
  std::vector<glm::vec3> normal;  // shading normal
  std::vector<glm::uvec2> ids;    // surface id, primitive + 1
};

}  // namespace sideray::rt
