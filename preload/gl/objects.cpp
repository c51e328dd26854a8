#include "preload/gl/objects.h"

#include <sideray/sideray.hpp>

namespace sideray::run {
namespace {

GLuint compile(GLenum type, const std::string& text, const std::string& what) {
  const Functions& gl = real();
  const GLuint shader = gl.CreateShader(type);
  const char* source = text.c_str();
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint done = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done) return shader;
  char log[512] = "";
  gl.GetShaderInfoLog(shader, sizeof(log), nullptr, log);
  throw Error(SIDERAY_UNSUPPORTED, "the driver does not compile the shader of " + what + ": " + log);
}

}  // namespace

GLuint make_program(const std::string& vertex, const std::string& fragment, const std::string& what) {
  const Functions& gl = real();
  const GLuint program = gl.CreateProgram();
  for (const auto& [type, text] : {std::pair{GLenum{GL_VERTEX_SHADER}, &vertex}, {GLenum{GL_FRAGMENT_SHADER}, &fragment}}) {
    if (text->empty()) continue;
    const GLuint shader = compile(type, *text, what);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  GLint done = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &done);
  if (!done) throw Error(SIDERAY_UNSUPPORTED, "the driver does not link the shader of " + what);
  return program;
}

GLuint make_texture() {
  const Functions& gl = real();
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  for (const GLenum filter : {GLenum{GL_TEXTURE_MIN_FILTER}, GLenum{GL_TEXTURE_MAG_FILTER}}) gl.TexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
  return texture;
}

void generate_coordinates(int unit, GLenum space, const std::array<GLfloat, 16>& matrix, GLenum rows) {
  const Functions& gl = real();
  gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  for (GLenum row = 0; row < 4; ++row) {
    if (row >= rows) {
      gl.Disable(GL_TEXTURE_GEN_S + row);
      continue;
    }
    const GLfloat plane[4] = {matrix[row], matrix[4 + row], matrix[8 + row], matrix[12 + row]};
    gl.TexGeni(GL_S + row, GL_TEXTURE_GEN_MODE, static_cast<GLint>(space));
    gl.TexGenfv(GL_S + row, space == GL_OBJECT_LINEAR ? GL_OBJECT_PLANE : GL_EYE_PLANE, plane);
    gl.Enable(GL_TEXTURE_GEN_S + row);
  }
  constexpr GLfloat unchanged[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  gl.MatrixMode(GL_TEXTURE);
  gl.LoadMatrixf(unchanged);
  gl.ActiveTexture(GL_TEXTURE0);
}

}  // namespace sideray::run
