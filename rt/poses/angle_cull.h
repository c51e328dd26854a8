// Decides which instances look too small from a point to be traced. One thread at a time may call it; it works on the
// executor's.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/executor.h"

namespace sideray::rt {

struct CullRules {
  bool keeps_translucent = false;  // set where rays alone show what is translucent
  bool remembers = true;           // off: instances culled in the previous frame do not matter
  bool operator==(const CullRules&) const = default;
};

// Culls an instance where the sphere around its bounds (model::Instance::bounds: with all that wind does) appears under
// less than the angle, 2 asin(radius / distance); the instance comes back at 1.1 times the angle. An eye inside the
// sphere keeps it. The result depends on earlier frames, so that nothing flickers at the limit.
class AngleCull {
 public:
  static constexpr double back = 1.1;

  // Returns whether an instance's answer changed. 0 degrees = nothing is culled, and the history is reset.
  bool update(const model::Snapshot& snapshot, float angle_deg, glm::vec3 eye, Executor& executor,
              CullRules rules = {});
  // Has one entry for each of the snapshot's instances, 1 = culled; or none at 0 degrees.
  const std::vector<uint8_t>& culled() const { return culled_; }

 private:
  // Moves the results to the instances of the same names, at their new indices.
  void follow(const model::Snapshot& snapshot);

  std::vector<uint8_t> culled_;
  model::Names names_;  // of the instances in culled_, in its order
};

}  // namespace sideray::rt
