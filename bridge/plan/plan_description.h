// Describes a frame's plan in words and numbers: the reason for each pass, the textures, the most work. Any thread.
#pragma once

#include <sideray/plan.h>

#include <string>
#include <vector>

#include "bridge/plan/frame_plan.h"

namespace sideray::bridge {

struct PlannedPass {
  sideray_stage stage;
  bool runs;
  std::string reason;
};

struct PlannedTexture {
  std::string name;
  const char* format;
  uint32_t width, height, layers;
  uint64_t texel_bytes;
  bool of_service = false;
  uint64_t smaller_texels = 0;  // in the other mip levels of a layer
  uint64_t bytes() const { return (uint64_t{width} * height + smaller_texels) * layers * texel_bytes; }
};

// Returns every stage but the total, in order.
std::vector<PlannedPass> planned_passes(const model::Snapshot& snapshot, const RenderOptions& options,
                                        const FramePlan& plan);
std::vector<PlannedTexture> planned_textures(const model::Snapshot& snapshot, const RenderOptions& options,
                                             const FramePlan& plan);
// `textures`: those of the same plan.
sideray_plan_work planned_work(const model::Snapshot& snapshot, const RenderOptions& options,
                               const FramePlan& plan, const std::vector<PlannedTexture>& textures);

}  // namespace sideray::bridge
