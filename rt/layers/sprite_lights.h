// Lights each sprite once for a view, as the rasterizer does: at its centre, whatever part of it a pixel shows. One thread
// calls light(), on the executor's; then any thread may ask.
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
    bool shadows;  // they say what hides lights
    bool tints;    // and what tints them
  };
  // Of the scene's quads (rt/poses/particle_quads.h). Returns the rays traced.
  Counters light(const ShadingScene& scene, const Intersector& intersector, Rays rays, Executor& executor);
  bool empty() const { return first_.empty(); }
  // Returns the light that leaves a point of a sprite.
  glm::vec3 radiance(const shading::SrSurface& sprite, const Hit& hit) const {
    return sprite.emissive + sprite.diffuse * white_[first_[hit.instance] + hit.primitive / 2];
  }

 private:
  std::vector<FragmentShader> shaders_;
  std::vector<uint32_t> first_;   // of each instance, the place of its first sprite in white_; 0 where it has none
  std::vector<glm::vec3> white_;  // what leaves a sprite of albedo 1
};

}  // namespace sideray::rt
