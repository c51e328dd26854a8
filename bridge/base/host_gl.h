// Reads a host's description of its OpenGL context, for the service and the renderer. Any thread.
#pragma once

#include <sideray/service.h>

namespace sideray::bridge {

// Throws Failure (INVALID_ARGUMENT, UNSUPPORTED) where there is no loader, or the struct's version is unknown.
sideray_host_gl read_host(const sideray_host_gl* given);

}  // namespace sideray::bridge
