// Finds which pixels each object of a scene covers, alone and among the others, from every surface along every ray.
// Plain memory; row 0 of result pixels is the TOP row. One call at a time.
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
  uint32_t samples_per_side = 1;  // samples along each side of a pixel, from which fractions are counted
  bool hidden_by_opaque = false;  // translucent surfaces do not hide objects
  static constexpr uint32_t no_object = 0xffffffffu;
  std::vector<uint32_t> object_of;  // by instance: index of its object, or no_object
  uint32_t objects = 0;
};

struct ObjectMask {
  uint32_t pixels = 0;
  glm::uvec2 corner{0}, size{0};  // smallest box around the pixels
  std::vector<uint32_t> runs;     // run lengths down the columns, outside and inside in turn, starting outside
};

struct ObjectTruth {
  ObjectMask visible, amodal;
  uint64_t visible_samples = 0, amodal_samples = 0;
};

// Returns one entry for each object.
std::vector<ObjectTruth> trace_object_truth(const ObjectTruthRequest& request, TracedScene& scene);

}  // namespace sideray::rt
