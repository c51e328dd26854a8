// Checks that a frame's source is what the host says, so that a wrong name or rectangle gets an error of its own. GL
// thread.
#pragma once

#include <sideray/sideray.h>

#include "gl/context/functions.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) where no context is current on this thread: queries would return nothing.
void require_context(const gl::Functions& gl);

// Throws Failure (INVALID_ARGUMENT) where the context has no framebuffer of this name; 0 always exists.
void require_framebuffer(const gl::Functions& gl, uint32_t framebuffer);

// Throws Failure (INVALID_ARGUMENT) where the rectangle exceeds the depth attachment of `framebuffer`, which must be
// bound for reading. Sizes of the default framebuffer and, before OpenGL 4.5, of textures are unknown. Needs a guard
// over the renderbuffer.
void require_rectangle_within(const gl::Functions& gl, const sideray_frame_source& source, uint32_t framebuffer);

}  // namespace sideray::bridge
