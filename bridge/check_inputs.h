// What a host asks of a frame, checked before anything is touched. Any thread.
#pragma once

#include <sideray/sideray.h>

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) that names the input and what it may be.
void check_inputs(const sideray_frame_inputs& inputs);

}  // namespace sideray::bridge
