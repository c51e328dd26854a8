// Wraps a host's OpenGL context for the renderer: never made current, never destroyed; its state is saved during the
// renderer's calls. One thread, on which the host's context is current in every call.
#pragma once

#include <memory>

#include "gl/context/context.h"

namespace sideray::gl {

// Throws Failure (UNSUPPORTED) below OpenGL 3.3. Calls `get_proc_address` only within this function.
std::unique_ptr<Context> host_context(GetProcAddress get_proc_address, void* user);

}  // namespace sideray::gl
