// Makes the library's OpenGL objects in the program's context.
#pragma once

#include <array>
#include <string>

#include "preload/gl/functions.h"

namespace sideray::run {

// Throws sideray::Error if the driver refuses it. `vertex`: empty = fixed-function vertices. `what`: for messages.
GLuint make_program(const std::string& vertex, const std::string& fragment, const std::string& what);

// Makes a texture without filtering and binds it to the active unit.
GLuint make_texture();

// Lets OpenGL generate texture coordinates of a unit: the first `rows` rows of the matrix times positions in `space`,
// GL_OBJECT_LINEAR or GL_EYE_LINEAR. For GL_EYE_LINEAR, MODELVIEW must be the identity. Leaves the first unit active.
void generate_coordinates(int unit, GLenum space, const std::array<GLfloat, 16>& matrix, GLenum rows);

// The first texture unit for the service, behind the units whose state is saved.
constexpr GLenum service_unit = kept_units;

}  // namespace sideray::run
