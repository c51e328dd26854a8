// Samples for each pixel one of the lights that have no mask of their own, with a probability in proportion to its
// unshadowed contribution there. Any thread may use it; a Block is scratch memory of its thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "rt/masks/depth_points.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

class CombinedLights {
 public:
  static constexpr uint32_t first_light = 32;  // index in the snapshot

  CombinedLights() = default;
  explicit CombinedLights(const ShadingScene& scene);

  // Holds bounds of the lights over a block of neighbouring points, from which each point samples by rejection.
  class Block {
   public:
    void begin(const CombinedLights& lights, std::span<const DepthPoint> points);
    // Returns the light's index in the snapshot, or nothing if no light reaches the point. `key` is for its random
    // numbers.
    std::optional<uint32_t> draw(const DepthPoint& point, uint32_t key);

   private:
    std::optional<uint32_t> draw_by_weight(const DepthPoint& point, float u);
    const CombinedLights* lights_ = nullptr;
    std::vector<uint32_t> candidates_;  // lights that may reach some point
    std::vector<float> bounds_;         // upper bounds of their weights
    std::vector<double> sums_;          // running sums of the bounds
    std::vector<float> weights_;        // scratch memory of draw_by_weight()
  };

  // Returns the unshadowed irradiance that a light adds to the surface, summed over channels.
  float weight(size_t light, const DepthPoint& point) const;

 private:
  float bound(size_t light, const glm::vec3& least, const glm::vec3& most) const;
  std::vector<shading::SrLight> lights_;
  std::vector<uint32_t> numbers_;  // indices in the snapshot
};

}  // namespace sideray::rt
