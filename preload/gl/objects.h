// Objects of OpenGL that the library makes in the program's context.
#pragma once

#include <string>

#include "preload/gl/functions.h"

namespace sideray::run {

// Throws sideray::Error where the driver does not take it. `vertex`: empty = the fixed function's vertices. `what`: for messages.
GLuint make_program(const std::string& vertex, const std::string& fragment, const std::string& what);

// A texture that shows texels as they are. It is bound to the active unit.
GLuint make_texture();

// Behind the units whose state is kept: the service binds its textures from here on.
constexpr GLenum service_unit = kept_units;

}  // namespace sideray::run
