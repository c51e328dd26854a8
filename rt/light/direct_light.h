// Adds the light of punctual lights to batches of points, with shadow rays; translucent surfaces on their way tint it.
// It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/light/straight_light.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

class DirectLight {
 public:
  // Sets the scene; the caller keeps both objects alive. `tints`: translucent surfaces tint the light.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool tints = true) {
    straight_.begin(scene, intersector);
    tints_ = tints && straight_.is_tinted();
  }
  // Drops everything gathered.
  void clear();
  // Appends the unoccluded contribution of one of the batch's lights() to its points.
  void gather(SurfaceBatch& batch, size_t light);
  // Appends the lights sampled for a block of the batch's points (SurfaceBatch::draw()).
  void draw(SurfaceBatch& batch, size_t block, const LightOdds& odds, glm::vec3* offered);
  // Adds the arriving light to the points' radiance. `shadows` null: nothing occludes lights. `coherent`: the points
  // are neighbours, like the opaque surfaces of neighbouring pixels.
  void add(const Intersector* shadows, glm::vec3* radiance, bool coherent = false);
  // After add(): adds the highlights that the fixed function adds after texturing.
  void add_shine(glm::vec3* shine) const;
  // After add(): adds each point's unoccluded light to `offered`, unless null, and its arriving light to `arrived`.
  void tell(glm::vec3* offered, glm::vec3* arrived) const;

  size_t rays() const { return rays_.size(); }

 private:
  void pass_glass();
  glm::vec3 through(size_t ray) const { return through_.empty() ? glm::vec3(1.0f) : through_[ray]; }
  // Returns the ray's unoccluded light.
  glm::vec3 offer(size_t ray) const { return separate_ ? rays_.gain(ray) + rays_.shine(ray) : rays_.gain(ray); }

  ShadowRays rays_;
  StraightLight straight_;
  bool tints_ = false;
  bool separate_ = false;  // highlights are added after texturing
  std::vector<Ray> free_;  // rays without an opaque occluder that may hit translucent surfaces
  std::vector<uint32_t> of_free_;
  std::vector<glm::vec3> through_;  // transmittance of rays, if the scene has anything that tints
  std::vector<uint8_t> blocked_;
};

}  // namespace sideray::rt
