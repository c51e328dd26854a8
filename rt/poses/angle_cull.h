// Which instances look too small from a point to be traced. One thread at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/executor.h"

namespace sideray::rt {

struct CullRules {
  bool keeps_translucent = false;  // where rays alone show what is translucent
  bool remembers = true;           // off: the instances culled before count for nothing
  bool operator==(const CullRules&) const = default;
};

// An instance leaves where the sphere around its bounds (model::Instance::bounds: with all that wind does) appears
// under less than the angle, 2 asin(radius / distance), and comes back at 1.1 times the angle. An eye inside the sphere
// keeps it. What is culled depends on the frames before, so that nothing flickers at the limit.
class AngleCull {
 public:
  static constexpr double back = 1.1;

  // 0 degrees = nothing is culled, and what was is forgotten. True where an instance's answer changed.
  bool update(const model::Snapshot& snapshot, float angle_deg, glm::vec3 eye, Executor& executor,
              CullRules rules = {});
  // 1 = culled; one for each of the snapshot's instances, or none at 0 degrees.
  const std::vector<uint8_t>& culled() const { return culled_; }

 private:
  // What is known goes with the instances' names, not with their places.
  void follow(const model::Snapshot& snapshot);

  std::vector<uint8_t> culled_;
  model::Names names_;  // of these
};

}  // namespace sideray::rt
