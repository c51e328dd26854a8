// Refracts in screen space: samples the opaque picture where a refracted ray leaves a body of the material's thickness,
// in a mip level that matches the surface's roughness, as shaders/translucent/raster_aside.glsl does. Any thread may
// read it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/view.h"
#include "rt/drawing/opaque_levels.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

class SeenAside {
 public:
  // The caller keeps scene, view and levels alive.
  SeenAside(const ShadingScene& scene, const TraceView& view, const OpaqueLevels& levels);

  // Returns whether any surface of the scene needs it.
  static bool is_needed(const model::Snapshot& snapshot);

  // Returns what a surface adds to its pixel: the refracted picture minus the one straight behind. The latter stays in
  // the pixel, with everything that was blended before.
  glm::vec3 added(const SurfacePoint& point, glm::uvec2 pixel) const;

 private:
  glm::vec2 place(const SurfacePoint& point, glm::uvec2 pixel, float thickness, float ior) const;
  float level(const shading::SrSurface& surface, const shading::SrMaterial& material) const;

  const ShadingScene& scene_;
  const TraceView& view_;
  const OpaqueLevels& levels_;
  std::vector<uint8_t> bends_;  // by material
};

}  // namespace sideray::rt
