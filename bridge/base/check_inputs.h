// What a host asks of a frame, checked before anything is touched. Any thread, no context.
#pragma once

#include <sideray/sideray.h>

#include "gl/context/functions.h"
#include "gl/resources/state_guard.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) that names the input and what it may be.
void check_inputs(const sideray_frame_inputs& inputs);
void check_view_id(uint32_t id);

// Throws Failure (UNSUPPORTED) where an input needs what this context lacks; whatever can be done without it is.
void check_capabilities(const gl::Functions& gl, const sideray_frame_inputs& inputs);

// Of the guards around what is done for the frame.
gl::StatePolicy policy_of(const sideray_frame_inputs& inputs);

// Throws Failure (INVALID_ARGUMENT) where an input does not go with a shader of the host.
void check_shader(const sideray_frame_inputs& inputs, const sideray_shader_desc& shader);

// What is traced besides layers. A second wave adds layers alone.
bool has_masks(const sideray_frame_inputs& inputs);
bool has_reflections(const sideray_frame_inputs& inputs);

}  // namespace sideray::bridge
