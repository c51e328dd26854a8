// Screen-space refraction: looks the opaque picture up where a refracted ray leaves a body of the material's thickness,
// in a mip level as coarse as the surface is rough, as shaders/translucent/raster_aside.glsl does. Any thread may read
// it.
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
  // The caller keeps the scene, the view and the levels.
  SeenAside(const ShadingScene& scene, const TraceView& view, const OpaqueLevels& levels);

  // Returns whether any surface of the scene is seen through so.
  static bool is_needed(const model::Snapshot& snapshot);

  // Returns what a surface adds to its pixel: what is seen aside less what is seen straight through, which stays in its place
  // with all that is blended before it.
  glm::vec3 added(const SurfacePoint& point, glm::uvec2 pixel) const;

 private:
  glm::vec2 place(const SurfacePoint& point, glm::uvec2 pixel, float thickness, float ior) const;
  float level(const shading::SrSurface& surface, const shading::SrMaterial& material) const;

  const ShadingScene& scene_;
  const TraceView& view_;
  const OpaqueLevels& levels_;
  std::vector<uint8_t> bends_;  // of each material
};

}  // namespace sideray::rt
