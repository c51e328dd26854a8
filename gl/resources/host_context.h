// A host's OpenGL context as the renderer uses it: never made current, never destroyed; what the host has set is put
// aside while the renderer is in a call. One thread, on which the host's context is current in every call.
#pragma once

#include <memory>

#include "gl/context/context.h"

namespace sideray::gl {

// Throws Failure (UNSUPPORTED) below OpenGL 3.3. `get_proc_address` is called in here alone.
std::unique_ptr<Context> host_context(GetProcAddress get_proc_address, void* user);

}  // namespace sideray::gl
