// Requests a picture by rays alone, and holds the picture. Plain memory; row 0 of pixels is the bottom row.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/view.h"

namespace sideray::rt {

// Requests a picture without approximations: docs/adr/0006-reference.md.
struct ReferenceRequest {
  std::vector<TraceView> views;  // one a sample position
  uint32_t width = 0, height = 0;
  uint32_t light_samples = 64;
  uint32_t bounces = 1;  // 1: docs/adr/0006-reference.md; otherwise paths, 0 = of any length (docs/adr/0028-paths.md)
  bool shadows = true;
  bool caustics = false;  // paths: light of sized lamps and emissive surfaces is refracted, not transmitted straight
  bool refraction = false;
  bool reflections = false;  // of opaque surfaces; false: they reflect only the environment. Paths always reflect
  bool surfaces = false;     // store the surfaces of the first position
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between chunks
};

struct ReferenceSurface {
  glm::vec3 position;  // infinite without a surface
  glm::vec3 normal;    // shading normal
  glm::vec3 albedo;
  float metallic, roughness;
  glm::uvec2 ids;  // surface id, primitive + 1
};

struct ReferenceImage {
  uint32_t width = 0, height = 0;
  std::vector<glm::vec4> color;            // mean over positions; A = 1 - product of transmittances
  std::vector<glm::vec3> half_difference;  // color +- this are the halves of the light samples; 0 with one sample
  std::vector<ReferenceSurface> surfaces;  // opaque ones of the first position
};

// Holds the opaque surface at each pixel centre, found by rays, for checks against the rasterizer.
struct PrimaryImage {
  std::vector<float> distance;    // +inf = nothing
  std::vector<glm::vec3> normal;  // shading normal
  std::vector<glm::uvec2> ids;    // surface id, primitive + 1
};

}  // namespace sideray::rt
