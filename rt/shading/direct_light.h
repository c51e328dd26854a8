// Adds up the light of punctual lights at batches of points, with the shadow rays that this takes. Holds scratch
// memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

class DirectLight {
 public:
  // Forgets what was gathered.
  void clear();
  // Appends what a light adds to the batch's points where nothing blocks it.
  void gather(SurfaceBatch& batch, const shading::SrLight& light);
  // Adds the light that arrives to the points' radiance. `shadows` null: nothing blocks any light.
  void add(const Intersector* shadows, glm::vec3* radiance);
  // After add(): adds what the rays could bring to each point, and what they brought.
  void tell(glm::vec3* offered, glm::vec3* arrived) const;

  size_t rays() const { return rays_.size(); }

 private:
  ShadowRays rays_;
  std::vector<uint8_t> blocked_;
};

}  // namespace sideray::rt
