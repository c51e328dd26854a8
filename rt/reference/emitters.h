// Draws points of opaque surfaces that shine, in proportion to area and radiance. Immutable once made; any thread may use
// it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/ray.h"

namespace sideray::rt {

class EmitterSampler {
 public:
  EmitterSampler() = default;
  // Keeps the snapshot. Surfaces with holes are left out, and so is what reflections do not show: rays alone meet those.
  explicit EmitterSampler(std::shared_ptr<const model::Snapshot> snapshot);

  struct Sample {
    Hit hit;         // as a ray from the point would have it
    Ray ray;         // unit, from the point to the emitter
    float density;   // per steradian; 0 = the emitter is seen from its edge
  };
  // Samples what a point sees, whether anything is in the way or not. `u`: a point of the unit square. Not where nothing
  // shines.
  Sample sample(glm::vec3 from, float choice, glm::vec2 u) const;
  // Returns the density of what a ray of this unit direction hits; 0 where that is not sampled.
  float density(const Hit& hit, glm::vec3 direction) const;

  bool empty() const { return triangles_.empty(); }
  bool is_of(const std::shared_ptr<const model::Snapshot>& snapshot) const { return snapshot_ == snapshot; }

 private:
  struct Triangle {
    glm::vec3 corner, edge1, edge2, normal;  // of the front face, unit; local space
    uint32_t instance, primitive;
    float chance_by_area;  // of being chosen, over its area
  };
  std::shared_ptr<const model::Snapshot> snapshot_;
  std::vector<Triangle> triangles_;
  std::vector<float> until_;      // cumulative chances
  std::vector<uint32_t> first_;   // of each instance: its first triangle, or none
};

}  // namespace sideray::rt
