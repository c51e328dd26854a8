// The library's functions by name, for programs that ask for OpenGL's at run time.
#pragma once

namespace sideray::run {

// Returns null if the library has no such function, or if the driver lacks it.
void* hooked(const char* name);

}  // namespace sideray::run
