// Adds up the light of punctual lights at batches of points, with the shadow rays that this takes; what is translucent on
// their way tints it. Holds scratch memory: one object per thread.
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
  // Sets the scene that lights the points; the caller keeps both objects. `tints`: translucent surfaces tint the light.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool tints = true) {
    straight_.begin(scene, intersector);
    tints_ = tints && straight_.is_tinted();
  }
  // Forgets what was gathered.
  void clear();
  // Appends what one of the batch's lights() adds to the batch's points where nothing blocks it.
  void gather(SurfaceBatch& batch, size_t light);
  // Appends the lights that are drawn for a block of the batch's points (SurfaceBatch::draw()).
  void draw(SurfaceBatch& batch, size_t block, const LightOdds& odds, glm::vec3* offered);
  // Adds the light that arrives to the points' radiance. `shadows` null: nothing blocks any light. `coherent`: the points lie
  // beside each other, as the surfaces of neighbouring pixels that are opaque.
  void add(const Intersector* shadows, glm::vec3* radiance, bool coherent = false);
  // After add(): adds the highlights that the fixed function adds apart.
  void add_shine(glm::vec3* shine) const;
  // After add(): adds what the rays could bring to each point, where `offered` is not null, and what they brought.
  void tell(glm::vec3* offered, glm::vec3* arrived) const;

  size_t rays() const { return rays_.size(); }

 private:
  void pass_glass();
  glm::vec3 through(size_t ray) const { return through_.empty() ? glm::vec3(1.0f) : through_[ray]; }
  // What the ray brings where nothing blocks it.
  glm::vec3 offer(size_t ray) const { return separate_ ? rays_.gain(ray) + rays_.shine(ray) : rays_.gain(ray); }

  ShadowRays rays_;
  StraightLight straight_;
  bool tints_ = false;
  bool separate_ = false;  // highlights are apart
  std::vector<Ray> free_;  // rays that nothing opaque stops and that may hit something translucent
  std::vector<uint32_t> of_free_;
  std::vector<glm::vec3> through_;  // what is left of the rays' light, where the scene has something that tints it
  std::vector<uint8_t> blocked_;
};

}  // namespace sideray::rt
