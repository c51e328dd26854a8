// Describes a point of a surface as the shading model sees it. Plain values; any thread may use them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "model/hemisphere.h"
#include "rt/base/ray.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {

// Holds what a host's shader says of a point.
struct HostAnswer {
  glm::vec3 radiance{0.0f};
  shading::SrBlend blend{};
  glm::vec3 reflectance{0.0f}, reflection{0.0f};  // direction: unit, out of the surface
};

// The frame and the alphas of the base's lobe.
inline model::Frame frame_of_base(const shading::SrSurface& s) {
  return s.anisotropy > 0.0f ? model::Frame(s.normal, s.along) : model::Frame(s.normal);
}
inline glm::vec2 alphas_of_base(const shading::SrSurface& s) {
  return s.anisotropy > 0.0f ? shading::sr_alphas(s) : glm::vec2(s.roughness * s.roughness);
}

struct SurfacePoint {
  shading::SrSurface surface;
  glm::vec3 position;
  glm::vec3 geometric_normal;  // unit, on the viewer's side
  glm::vec3 to_eye;            // unit
  float offset;      // along the geometric normal; a ray that starts there does not hit the surface it comes from
  Cone cone;         // from the point on: width here, spread per unit of distance
  float distortion;  // the material's
  int blend;         // sideray_blend_mode
  uint32_t key;      // for random numbers here: made of pixel, position and layer (rt/base/sampling.h)
  Hit hit;           // the hit that this is the point of
  shading::SrBlend blended;            // sr_blend() of the surface; whoever changes the surface computes it anew
  float weight = 1.0f;  // of its light in the pixel, in the channel where that is greatest; 1 = an upper bound
  const HostAnswer* answer = nullptr;  // the host's, where there is one; owned by its giver
};

// Returns where a ray that leaves the point's surface starts.
inline glm::vec3 start_of_ray(const SurfacePoint& p) {
  return p.position + p.geometric_normal * p.offset;
}

}  // namespace sideray::rt
