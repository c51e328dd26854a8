// Holds the values that shaders exchange to reuse rays of other points: results of a point's rays, and values that need
// no rays. Plain values, and the interface of such shaders, which belong to one thread.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "rt/surfaces/surface_point.h"

namespace sideray::rt {

// Holds the results of a point's rays.
struct RayAnswer {
  glm::vec3 mirrored{0.0f};  // radiance from the base's mirror direction, unweighted
  float nearness = 0.0f;     // RoughReflection::nearness; 0 = the ray left the scene
  bool has_mirror = false;   // a mirror ray was traced
  glm::vec3 offered{0.0f};   // unshadowed light
  glm::vec3 arrived{0.0f};   // shadowed light
};

// Holds the values of a point that need no rays.
struct RayProspect {
  glm::vec3 offered;  // RayAnswer::offered
  float share;  // weight of the mirrored radiance in the outgoing light; below least_mirror_share no ray is traced
  // Its reflections need rays of their own: a coat has its own mirror ray, and a rough lobe with enough weight is
  // sampled at random at each point, because a filter needs all samples.
  bool keeps_mirrors;
};

// The smallest share of reflected light in the outgoing light that is worth a ray.
inline constexpr float least_mirror_share = 1e-4f;

// Holds the values that replace a point's rays.
struct ReusedRays {
  bool traces_mirrors = false;  // it has mirror rays of its own
  bool has_mirror = false;      // the radiance of a mirror ray is reused
  glm::vec3 mirrored{0.0f};
  float nearness = 0.0f;  // 0: the point's own surroundings replace `mirrored`
  glm::vec3 lit{1.0f};    // visible share of the lights' unshadowed light
};

class RaySharing {
 public:
  virtual ~RaySharing() = default;
  // Writes the ray results of the points of the last PointShader::shade().
  virtual void write_answers(RayAnswer* answers) const = 0;
  // Takes points for shade_reusing(), and writes the values of each that need no rays.
  virtual void consider(std::span<const SurfacePoint> points, RayProspect* prospects) = 0;
  // Writes the outgoing light of these points, with reused values instead of shadow rays and of most mirror rays.
  // Afterwards PointShader::rough() has results.
  virtual void shade_reusing(std::span<const SurfacePoint> points, std::span<const ReusedRays> reused,
                             glm::vec3* radiance) = 0;
};

}  // namespace sideray::rt
