// What the renderer submits to the service for a planned frame. Any thread.
#pragma once

#include "bridge/base/frame_inputs.h"
#include "bridge/plan/frame_plan.h"

namespace sideray::bridge {

// All but the view and what names textures and framebuffers of the rasterizer.
FrameInputs frame_inputs(const FramePlan& plan, const RenderOptions& options);

}  // namespace sideray::bridge
