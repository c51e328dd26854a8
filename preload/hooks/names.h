// The library's functions by name, for programs that ask for OpenGL's at run time.
#pragma once

namespace sideray::run {

// Null where there is none, or where the driver has not got it.
void* hooked(const char* name);

}  // namespace sideray::run
