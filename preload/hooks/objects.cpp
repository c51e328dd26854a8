// Textures, buffers, framebuffers and programs: calls that change them, and uses that the library does not follow.
#include "preload/gl/functions.h"
#include "preload/frame/session.h"

namespace sideray::run {
namespace {

// Must be called before the texels of the bound texture change.
void change_texture(GLenum target) {
  if (!session().looks() || session().is_recording()) return;
  session().before_change();
  if (target == GL_TEXTURE_2D) session().frame().textures().changed(static_cast<GLuint>(get_integer(GL_TEXTURE_BINDING_2D)));
}

void change_buffer(GLenum target) {
  if (!session().looks()) return;
  if (target != GL_ARRAY_BUFFER && target != GL_ELEMENT_ARRAY_BUFFER) return;
  session().arrays().changed(static_cast<GLuint>(get_integer(target == GL_ARRAY_BUFFER ? GL_ARRAY_BUFFER_BINDING : GL_ELEMENT_ARRAY_BUFFER_BINDING)));
}

}  // namespace
}  // namespace sideray::run

using namespace sideray::run;

#pragma GCC visibility push(default)
extern "C" {

void glTexImage2D(GLenum target, GLint level, GLint format, GLsizei width, GLsizei height, GLint border, GLenum of, GLenum type, const void* texels) {
  change_texture(target);
  real().TexImage2D(target, level, format, width, height, border, of, type, texels);
}

void glTexSubImage2D(GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height, GLenum of, GLenum type, const void* texels) {
  change_texture(target);
  real().TexSubImage2D(target, level, x, y, width, height, of, type, texels);
}

void glCompressedTexImage2D(GLenum target, GLint level, GLenum format, GLsizei width, GLsizei height, GLint border, GLsizei size, const void* data) {
  change_texture(target);
  real().CompressedTexImage2D(target, level, format, width, height, border, size, data);
}

void glCopyTexImage2D(GLenum target, GLint level, GLenum format, GLint x, GLint y, GLsizei width, GLsizei height, GLint border) {
  change_texture(target);
  if (session().looks()) session().before_cut();
  real().CopyTexImage2D(target, level, format, x, y, width, height, border);
}

void glCopyTexSubImage2D(GLenum target, GLint level, GLint dx, GLint dy, GLint x, GLint y, GLsizei width, GLsizei height) {
  change_texture(target);
  if (session().looks()) session().before_cut();
  real().CopyTexSubImage2D(target, level, dx, dy, x, y, width, height);
}

void glGenerateMipmap(GLenum target) {
  if (session().looks()) session().before_change();
  real().GenerateMipmap(target);
}

void glDeleteTextures(GLsizei count, const GLuint* names) {
  if (session().looks()) {
    session().before_change();
    for (GLsizei i = 0; i < count; ++i) session().frame().textures().deleted(names[i]);
  }
  real().DeleteTextures(count, names);
}

void glBufferData(GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
  change_buffer(target);
  real().BufferData(target, size, data, usage);
}

void glBufferSubData(GLenum target, GLintptr offset, GLsizeiptr size, const void* data) {
  change_buffer(target);
  real().BufferSubData(target, offset, size, data);
}

void* glMapBuffer(GLenum target, GLenum access) {
  change_buffer(target);
  return real().MapBuffer(target, access);
}

void* glMapBufferRange(GLenum target, GLintptr offset, GLsizeiptr length, GLbitfield access) {
  change_buffer(target);
  return real().MapBufferRange(target, offset, length, access);
}

void glDeleteBuffers(GLsizei count, const GLuint* names) {
  if (session().looks())
    for (GLsizei i = 0; i < count; ++i) session().arrays().changed(names[i]);
  real().DeleteBuffers(count, names);
}

void glBindFramebuffer(GLenum target, GLuint name) {
  if (session().looks()) session().before_cut();
  real().BindFramebuffer(target, name);
}

void glUseProgram(GLuint program) {
  if (program != 0) session().uses_shaders("glUseProgram");
  real().UseProgram(program);
}

void glUseProgramObjectARB(GLhandleARB program) {
  static const auto use = real_function<decltype(&::glUseProgramObjectARB)>("glUseProgramObjectARB");
  if (program != 0) session().uses_shaders("glUseProgramObjectARB");
  use(program);
}

void glBindProgramPipeline(GLuint pipeline) {
  if (pipeline != 0) session().uses_shaders("glBindProgramPipeline");
  real().BindProgramPipeline(pipeline);
}

}  // extern "C"
#pragma GCC visibility pop
