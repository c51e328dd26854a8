// Checks what a host asks of layers before anything is touched. Any thread; no context is needed.
#pragma once

#include <sideray/sideray.h>

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) that names the input and what it may be.
void check_layers(const sideray_layer_inputs& inputs);
// Throws Failure (INVALID_ARGUMENT) where whole pixels are wanted of a frame that cannot have them.
void check_whole_pixels(const sideray_frame_source& source, const sideray_layer_inputs& inputs, bool host_shades);
// Throws Failure (INVALID_ARGUMENT) where an input does not go with the fixed function.
void check_fixed_layers(const sideray_layer_inputs& inputs);
// Throws Failure (INVALID_ARGUMENT) where an input does not go with a shader of the host.
void check_layer_shader(const sideray_layer_inputs& inputs);

}  // namespace sideray::bridge
