// Computes how much of the sky's light passes translucent surfaces to opaque ones. It has scratch memory: one object
// per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/surfaces/surface.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

// Returns whether any translucent instance is visible to ambient occlusion.
bool veils_sky(const model::Snapshot& snapshot);

class Veils {
 public:
  // Follows rays without an opaque hit. The nearest sixteen surfaces on a ray that are visible to ambient occlusion
  // count.
  void meet(const ShadingScene& scene, const Intersector& intersector, std::span<const Ray> rays, bool coherent);
  // Returns the straight transmittance of all surfaces on the ray, with absorption by their thickness; additive
  // surfaces have 1.
  glm::vec3 color(size_t ray) const { return colors_[ray]; }
  // Returns its mean over red, green and blue.
  float through(size_t ray) const { return through_[ray]; }
  // Returns the distance of the nearest surface that absorbs or reflects; infinite if there is none.
  float distance(size_t ray) const { return distance_[ray]; }

 private:
  std::vector<Hit> hits_;
  std::vector<uint32_t> counts_, of_places_;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> points_;
  std::vector<glm::vec3> colors_;
  std::vector<float> through_, distance_;
};

}  // namespace sideray::rt
