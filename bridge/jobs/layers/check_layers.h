// Checks a host's inputs for layers before anything is changed. Any thread; no context is needed.
#pragma once

#include <sideray/sideray.h>

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) that names the input and the values it may have.
void check_layers(const sideray_layer_inputs& inputs);
// Throws Failure (INVALID_ARGUMENT) where a frame requests whole pixels but cannot have them.
void check_whole_pixels(const sideray_frame_source& source, const sideray_layer_inputs& inputs, bool host_shades);
// Throws Failure (INVALID_ARGUMENT) where an input cannot be combined with the fixed function.
void check_fixed_layers(const sideray_layer_inputs& inputs);
// Throws Failure (INVALID_ARGUMENT) where an input cannot be combined with a host's shader.
void check_layer_shader(const sideray_layer_inputs& inputs);

}  // namespace sideray::bridge
