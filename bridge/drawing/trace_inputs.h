// Makes the inputs of a picture's jobs. Any thread.
#pragma once

#include "bridge/base/frame_inputs.h"
#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Returns all inputs except the names of OpenGL objects.
FrameInputs trace_inputs(const PictureJob& job, const FramePosition& position);

}  // namespace sideray::bridge
