// Lights each sprite once for a view, as the rasterizer does: at its centre, for all its pixels. One thread calls
// light(), which uses the executor's threads; afterwards any thread may read.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/layers/fragment_shader.h"

namespace sideray::rt {

class SpriteLights {
 public:
  explicit SpriteLights(uint32_t threads) : shaders_(threads) {}

  struct Rays {
    bool shadows;  // rays shadow the lights
    bool tints;    // translucent surfaces tint them
  };
  // Lights the scene's quads (rt/poses/particle_quads.h). Returns the counts of traced rays.
  Counters light(const ShadingScene& scene, const Intersector& intersector, Rays rays, Executor& executor);
  bool empty() const { return first_.empty(); }
  // Returns the outgoing light of a point of a sprite.
  glm::vec3 radiance(const shading::SrSurface& sprite, const Hit& hit) const {
    return sprite.emissive + sprite.diffuse * white_[first_[hit.instance] + hit.primitive / 2];
  }

 private:
  std::vector<FragmentShader> shaders_;
  std::vector<uint32_t> first_;   // by instance: index of its first sprite in white_; 0 if it has none
  std::vector<glm::vec3> white_;  // outgoing light of a sprite of albedo 1
};

}  // namespace sideray::rt
