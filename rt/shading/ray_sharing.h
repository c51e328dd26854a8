// The values that shaders exchange to reuse rays of other points: what a point's rays found, and what needs no rays.
// Plain values, and the interface of such shaders, which belong to one thread.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "rt/surfaces/surface_point.h"

namespace sideray::rt {

// Holds what the rays of a point found.
struct RayAnswer {
  glm::vec3 mirrored{0.0f};  // radiance from the base's mirror direction, without weight
  float nearness = 0.0f;     // RoughReflection::nearness; 0 = the ray left the scene
  bool has_mirror = false;   // a mirror ray was traced
  glm::vec3 offered{0.0f};   // what the lights add where nothing blocks them
  glm::vec3 arrived{0.0f};   // what of it arrives
};

// Holds the values of a point that need no rays.
struct RayProspect {
  glm::vec3 offered;  // RayAnswer::offered
  float share;  // of the mirrored radiance in what the eye sees; below least_mirror_share nothing is traced
  // Its reflections need rays of their own: a coat mirrors by itself, or a rough lobe that counts is sampled by one
  // random direction a point, and a filter needs all of these.
  bool keeps_mirrors;
};

// A share of reflected light in what is seen: below it no ray is worth its cost.
inline constexpr float least_mirror_share = 1e-4f;

// What takes the place of a point's rays.
struct ReusedRays {
  bool traces_mirrors = false;  // it has mirror rays of its own
  bool has_mirror = false;      // otherwise: what a mirror ray would have shown is reused
  glm::vec3 mirrored{0.0f};
  float nearness = 0.0f;  // 0: the point's own surroundings take the place of `mirrored`
  glm::vec3 lit{1.0f};    // share of what the lights offer that arrives
};

class RaySharing {
 public:
  virtual ~RaySharing() = default;
  // Writes what the rays of the points of the last PointShader::shade() found.
  virtual void write_answers(RayAnswer* answers) const = 0;
  // Takes points for shade_reusing(), and writes what needs no rays of each.
  virtual void consider(std::span<const SurfacePoint> points, RayProspect* prospects) = 0;
  // Writes the light that leaves these points, with reused rays in place of shadow rays and, mostly, of mirror rays.
  // PointShader::rough() has answers then.
  virtual void shade_reusing(std::span<const SurfacePoint> points, std::span<const ReusedRays> reused,
                             glm::vec3* radiance) = 0;
};

}  // namespace sideray::rt
