// The text of the GLSL files in this folder, compiled into the library. Any thread.
#pragma once

#include <string_view>

namespace sideray::shaders {

// Returns the text of the file `name` ("shading.h", "sideray.glsl"), zero-terminated; empty if there is no such file.
std::string_view source(std::string_view name);

}  // namespace sideray::shaders
