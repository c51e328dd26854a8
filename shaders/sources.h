// The text of the GLSL files in this folder, compiled into the library. Any thread.
#pragma once

#include <string_view>

namespace sideray::shaders {

// Text of the file `name` ("shading.h", "sideray.glsl"); empty where there is no such file. Zero-terminated.
std::string_view source(std::string_view name);

}  // namespace sideray::shaders
