// Finds out whether a frame's source is what the host takes it for, so that a wrong name or rectangle is refused by its
// own name. GL thread.
#pragma once

#include <sideray/sideray.h>

#include "gl/context/functions.h"

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT) where no context is current on this thread: every query would answer nothing then.
void require_context(const gl::Functions& gl);

// Throws Failure (INVALID_ARGUMENT) where there is no framebuffer of this name in the context; 0 is always there.
void require_framebuffer(const gl::Functions& gl, uint32_t framebuffer);

// Throws Failure (INVALID_ARGUMENT) where the rectangle reaches beyond the depth of `framebuffer`, which is bound for
// reading. Unknown: the default framebuffer's size, and before OpenGL 4.5 a texture's. Needs a guard over the
// renderbuffer.
void require_rectangle_within(const gl::Functions& gl, const sideray_frame_source& source, uint32_t framebuffer);

}  // namespace sideray::bridge
