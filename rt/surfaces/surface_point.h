// Describes a point of a surface for the shading model. Plain values; any thread may use them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "model/hemisphere.h"
#include "rt/base/ray.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {

// Holds the result of a host's shader at a point.
struct HostAnswer {
  glm::vec3 radiance{0.0f};
  shading::SrBlend blend{};
  glm::vec3 reflectance{0.0f}, reflection{0.0f};  // direction: unit, out of the surface
};

// Return the frame and the alphas of the base's lobe.
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
  float offset;      // along the geometric normal, so that a ray starting there does not hit its own surface
  Cone cone;         // starting at the point: width there, spread per unit of distance
  float distortion;  // the material's
  int blend;         // sideray_blend_mode
  uint32_t key;      // for random numbers, made of pixel, position and layer (rt/base/sampling.h)
  Hit hit;           // where the point lies
  shading::SrBlend blended;            // sr_blend() of the surface; to be recomputed by code that changes the surface
  float weight = 1.0f;  // upper bound of the share of its light in the pixel, in any channel
  const HostAnswer* answer = nullptr;  // the host shader's, or null; owned by the code that set it
};

// Returns the start of a ray that leaves the point's surface.
inline glm::vec3 start_of_ray(const SurfacePoint& p) {
  return p.position + p.geometric_normal * p.offset;
}

}  // namespace sideray::rt
