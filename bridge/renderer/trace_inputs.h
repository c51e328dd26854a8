// What the renderer submits to the service for a frame. GL thread.
#pragma once

#include "bridge/base/frame_inputs.h"
#include "bridge/renderer/picture_job.h"

namespace sideray::bridge {

// Of a frame whose opaque surfaces are drawn.
FrameInputs trace_inputs(const PictureJob& job, const FramePosition& position);

}  // namespace sideray::bridge
