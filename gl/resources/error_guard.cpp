#include "gl/resources/error_guard.h"

#include <cstdint>
#include <limits>

#include "gl/resources/objects.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

// Leaves the host's buffer bound.
void resize_buffer(const Functions& gl, GLuint buffer, GLsizeiptr size) {
  const GLenum target = gl.copy_buffers ? GL_COPY_WRITE_BUFFER : GL_ARRAY_BUFFER;
  GLint before = 0;
  gl.GetIntegerv(gl.copy_buffers ? GL_COPY_WRITE_BUFFER : GL_ARRAY_BUFFER_BINDING, &before);
  gl.BindBuffer(target, buffer);
  gl.BufferData(target, size, nullptr, GL_STREAM_READ);
  gl.BindBuffer(target, static_cast<GLuint>(before));
}

void exceed_memory(const Functions& gl) {
  GLuint buffer = 0;
  gl.GenBuffers(1, &buffer);
  resize_buffer(gl, buffer, std::numeric_limits<GLsizeiptr>::max() / 2);
  gl.DeleteBuffers(1, &buffer);
}

void read_incomplete_framebuffer(const Functions& gl) {
  GLint before = 0, pack = 0;
  gl.GetIntegerv(gl.separate_framebuffers ? GL_READ_FRAMEBUFFER_BINDING : GL_FRAMEBUFFER_BINDING, &before);
  gl.GetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pack);
  GLuint framebuffer = 0;
  gl.GenFramebuffers(1, &framebuffer);
  gl.BindFramebuffer(gl.read_framebuffer, framebuffer);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  uint32_t texel = 0;
  gl.ReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, &texel);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack));
  gl.BindFramebuffer(gl.read_framebuffer, static_cast<GLuint>(before));
  gl.DeleteFramebuffers(1, &framebuffer);
}

void raise(const Functions& gl, GLenum error) {
  switch (error) {
    case GL_NO_ERROR:
    case GL_CONTEXT_LOST:
      return;
    case GL_INVALID_ENUM:
      return gl.Enable(~GLenum{0});
    case GL_INVALID_VALUE:
      return gl.PixelStorei(GL_PACK_ALIGNMENT, 3);
    case GL_OUT_OF_MEMORY:
      return exceed_memory(gl);
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return read_incomplete_framebuffer(gl);
    default:
      return resize_buffer(gl, 0, 1);  // GL_INVALID_OPERATION: there is no buffer
  }
}

}  // namespace

ErrorGuard::ErrorGuard(const Functions& gl) : gl_(gl) {
  for (GLenum& error : pending_)
    if (error = gl.GetError(); error == GL_NO_ERROR) return;
}

ErrorGuard::~ErrorGuard() {
  take();
  for (const GLenum error : pending_) raise(gl_, error);
}

// The loop is bounded: a lost context never runs out of errors.
GLenum ErrorGuard::take() const {
  GLenum first = GL_NO_ERROR;
  for (size_t i = 0; i < kinds; ++i) {
    const GLenum error = gl_.GetError();
    if (error == GL_NO_ERROR) break;
    if (first == GL_NO_ERROR || error == GL_CONTEXT_LOST) first = error;
  }
  return first;
}

void ErrorGuard::check(const char* what) const {
  if (const GLenum error = take(); error != GL_NO_ERROR) fail_with(gl_, error, what);
}

void fail_with(const Functions& gl, GLenum error, const char* what) {
  if (error == GL_CONTEXT_LOST)
    fail(SIDERAY_GL_FAILED,
         "{}: the OpenGL context is lost; call sideray_service_abandon_context, destroy the service and create it in "
         "another context",
         what);
  if (error == GL_OUT_OF_MEMORY)
    fail(SIDERAY_OUT_OF_MEMORY, "{}: the OpenGL driver is out of memory; lower the resolution or the number of layers",
         what);
  fail(SIDERAY_GL_FAILED,
       "{}: OpenGL error {:#x} on {}; check that the names in the inputs are alive and of this context", what, error,
       gl.renderer);
}

}  // namespace sideray::gl
