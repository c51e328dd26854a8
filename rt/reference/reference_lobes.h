// Samples the directions from which a surface point receives light, from a mixture of its lobes' distributions.
// Immutable once made; any thread may use it.
#pragma once

#include <glm/glm.hpp>

#include "model/hemisphere.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

class LobeSampler {
 public:
  explicit LobeSampler(const SurfacePoint& point);

  // Returns whether the point reflects any light.
  bool reflects() const { return shares_[0] + shares_[1] + shares_[2] + shares_[3] > 0.0f; }
  // Returns the approximate directional albedo of all lobes.
  float albedo() const { return albedo_; }
  // Returns the albedo of the base and coat lobes.
  float glossy_albedo() const { return glossy_albedo_; }

  // Returns the share of sampled directions that come from diffuse lobes.
  float wide_share() const { return shares_[diffuse] + shares_[behind]; }

  // Samples a unit direction, with density density(), or zero if the sample is rejected; `u` is a point of the unit
  // square.
  glm::vec3 sample(glm::vec2 u) const;
  // Returns the density per steradian; it is positive wherever sr_reflection() is, up to rounding.
  float density(glm::vec3 to_light) const;

 private:
  // Describes a GGX lobe in its own frame.
  struct Lobe {
    Lobe(const model::Frame& frame, glm::vec3 to_eye, glm::vec2 alpha);
    glm::vec3 sample(glm::vec2 u) const;
    float density(glm::vec3 to_light) const;
    model::Frame frame;
    glm::vec3 to_eye;  // in the lobe's frame
    glm::vec2 alpha;   // along the frame's x and y
    bool faces_eye;    // false: the shading normal turns away from the eye, and directions are sampled about the normal
  };

  enum { diffuse, behind, base, coat, lobes };
  Lobe base_, coat_;
  float shares_[lobes];
  float albedo_, glossy_albedo_;
};

}  // namespace sideray::rt
