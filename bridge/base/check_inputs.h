// Checks the inputs that all jobs of a frame share: source, view, time. Any thread; no context is needed.
#pragma once

#include <sideray/sideray.h>

#include "bridge/base/frame_inputs.h"
#include "gl/resources/state_guard.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) that names the input and the values it may have.
void check_frame(const FrameInputs& inputs);
void check_view_id(uint32_t id);

// Returns the policy of state guards in this frame's calls.
inline gl::StatePolicy policy_of(const FrameInputs& in) {
  return in.state_policy == SIDERAY_HOST_RESTORES ? gl::StatePolicy::leave : gl::StatePolicy::restore;
}

}  // namespace sideray::bridge
