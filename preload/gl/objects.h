// Makes the library's OpenGL objects in the program's context.
#pragma once

#include <string>

#include "preload/gl/functions.h"

namespace sideray::run {

// Throws sideray::Error if the driver refuses it. `vertex`: empty = fixed-function vertices. `what`: for messages.
GLuint make_program(const std::string& vertex, const std::string& fragment, const std::string& what);

// Makes a texture without filtering and binds it to the active unit.
GLuint make_texture();

// The first unit for the service's textures, behind those whose state is kept.
constexpr GLenum service_unit = kept_units;

}  // namespace sideray::run
