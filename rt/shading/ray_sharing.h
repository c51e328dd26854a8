// Says what rays told of a point, and what they could tell: what shaders give and take that do without rays at some
// points. Plain values, and the interface of such shaders, which belong to one thread.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "rt/surfaces/surface_point.h"

namespace sideray::rt {

// Holds what rays told of a point.
struct RayAnswer {
  glm::vec3 mirrored{0.0f};  // radiance from the base's mirror direction, without weight
  float nearness = 0.0f;     // RoughReflection::nearness; 0 = the ray left the scene
  bool has_mirror = false;   // a mirror ray was traced
  glm::vec3 offered{0.0f};   // what the lights add where nothing blocks them
  glm::vec3 arrived{0.0f};   // what of it arrives
};

// Holds what is known of a point without rays.
struct RayProspect {
  glm::vec3 offered;  // RayAnswer::offered
  float share;  // of what the mirror direction shows, in what the eye sees; below least_mirror_share nothing is traced
  // What its mirrors show cannot be lent: a coat mirrors by itself, or a rough lobe that counts is known from one
  // random direction a point, of which a filter needs all there are.
  bool keeps_mirrors;
};

// A share of reflected light in what is seen: below it no ray is worth its cost.
inline constexpr float least_mirror_share = 1e-4f;

// Stands for rays of a point.
struct RayLoan {
  bool traces_mirrors = false;  // it has mirror rays of its own
  bool has_mirror = false;      // otherwise: what a mirror ray would have shown is lent
  glm::vec3 mirrored{0.0f};
  float nearness = 0.0f;  // 0: the point's own surroundings take the place of `mirrored`
  glm::vec3 lit{1.0f};    // share of what the lights offer that arrives
};

class RayLending {
 public:
  virtual ~RayLending() = default;
  // Writes what the rays of the points told that PointShader::shade() had last.
  virtual void tell(RayAnswer* answers) const = 0;
  // Takes points for lend(), and writes what is known of each.
  virtual void consider(std::span<const SurfacePoint> points, RayProspect* prospects) = 0;
  // Writes the light that leaves these points, with a loan each in place of shadow rays and, mostly, of mirror rays.
  // PointShader::rough() has answers then.
  virtual void lend(std::span<const SurfacePoint> points, std::span<const RayLoan> loans, glm::vec3* radiance) = 0;
};

}  // namespace sideray::rt
