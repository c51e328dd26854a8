// What the renderer asks of a frame's jobs. Any thread.
#pragma once

#include "bridge/base/frame_inputs.h"
#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// All but the names of OpenGL's objects.
FrameInputs trace_inputs(const PictureJob& job, const FramePosition& position);

}  // namespace sideray::bridge
