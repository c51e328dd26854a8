// Objects of OpenGL that the library makes in the program's context.
#pragma once

#include <array>
#include <string>

#include "preload/gl/functions.h"

namespace sideray::run {

// Throws sideray::Error where the driver does not take it. `vertex`: empty = the fixed function's vertices. `what`: for messages.
GLuint make_program(const std::string& vertex, const std::string& fragment, const std::string& what);

// A texture that shows texels as they are. It is bound to the active unit.
GLuint make_texture();

// Coordinates of a texture unit that OpenGL makes of positions in `space`, GL_OBJECT_LINEAR or GL_EYE_LINEAR: the first `rows` rows
// of the matrix times the position. MODELVIEW is the identity for those of the eye. Leaves the first unit active.
void generate_coordinates(int unit, GLenum space, const std::array<GLfloat, 16>& matrix, GLenum rows);

// Behind the units whose state is kept: the service binds its textures from here on.
constexpr GLenum service_unit = kept_units;

}  // namespace sideray::run
