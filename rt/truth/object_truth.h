// Finds which pixels each object of a scene covers, alone and among the others: every surface along every ray is hit. Plain
// memory; pixels of the results are counted from the TOP left. One call at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/view.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

struct ObjectTruthRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  uint32_t samples_per_side = 1;  // places in a pixel that fractions are counted at, along each side
  bool hidden_by_opaque = false;  // translucent surfaces hide nothing
  static constexpr uint32_t no_object = 0xffffffffu;
  std::vector<uint32_t> object_of;  // of each instance: index of its object, or no_object
  uint32_t objects = 0;
};

struct ObjectMask {
  uint32_t pixels = 0;
  glm::uvec2 corner{0}, size{0};  // of the least box around them
  std::vector<uint32_t> runs;     // down the columns, outside and inside in turn, from outside
};

struct ObjectTruth {
  ObjectMask visible, amodal;
  uint64_t visible_samples = 0, amodal_samples = 0;
};

// Returns one for each object.
std::vector<ObjectTruth> trace_object_truth(const ObjectTruthRequest& request, TracedScene& scene);

}  // namespace sideray::rt
