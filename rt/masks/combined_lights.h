// Draws for each pixel one of the lights that have no mask of their own, with a probability in proportion to what each
// would add there unshadowed. Any thread; a Block is scratch memory of its thread.
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
  static constexpr uint32_t first_light = 32;  // of the snapshot's

  CombinedLights() = default;
  explicit CombinedLights(const ShadingScene& scene);

  // Bounds of the lights over a block of neighbouring points, from which each point draws by rejection.
  class Block {
   public:
    void begin(const CombinedLights& lights, std::span<const DepthPoint> points);
    // The light's number in the snapshot; none where no light reaches the point. `key`: of its random numbers.
    std::optional<uint32_t> draw(const DepthPoint& point, uint32_t key);

   private:
    std::optional<uint32_t> draw_by_weight(const DepthPoint& point, float u);
    const CombinedLights* lights_ = nullptr;
    std::vector<uint32_t> candidates_;  // lights that may reach some point
    std::vector<float> bounds_;         // that none of their weights exceeds
    std::vector<double> sums_;          // of the bounds up to each
    std::vector<float> weights_;        // scratch memory of draw_by_weight()
  };

  // The irradiance that a light adds to the surface there, the sum of its channels.
  float weight(size_t light, const DepthPoint& point) const;

 private:
  float bound(size_t light, const glm::vec3& least, const glm::vec3& most) const;
  std::vector<shading::SrLight> lights_;
  std::vector<uint32_t> numbers_;  // of them in the snapshot
};

}  // namespace sideray::rt
