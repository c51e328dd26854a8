// Decides which instances look too small from a point to be traced. One thread at a time may call it; it uses the
// executor's threads.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/executor.h"

namespace sideray::rt {

struct CullRules {
  bool keeps_translucent = false;  // keeps translucent instances, for pictures in which only rays show them
  bool remembers = true;           // false: decides without regard to the previous frame
  bool operator==(const CullRules&) const = default;
};

// Culls an instance if the sphere around its bounds (model::Instance::bounds, with all wind motion) subtends less than
// the angle, 2 asin(radius / distance); the instance returns at 1.1 times the angle. An eye inside the sphere keeps it.
// The hysteresis prevents flicker at the limit.
class AngleCull {
 public:
  static constexpr double back = 1.1;

  // Returns whether the result of any instance changed. 0 degrees = culls nothing, and resets the history.
  bool update(const model::Snapshot& snapshot, float angle_deg, glm::vec3 eye, Executor& executor,
              CullRules rules = {});
  // Has one entry for each of the snapshot's instances, 1 = culled; empty at 0 degrees.
  const std::vector<uint8_t>& culled() const { return culled_; }

 private:
  // Moves the results to the instances' new indices, by name.
  void follow(const model::Snapshot& snapshot);

  std::vector<uint8_t> culled_;
  model::Names names_;  // names of the instances of culled_, in the same order
};

}  // namespace sideray::rt
