#include "gl/objects.h"

#include "model/failure.h"

namespace sideray::gl {

uint32_t create_object(const Functions& gl, ObjectKind kind) {
  GLuint id = 0;
  switch (kind) {
    case ObjectKind::texture:
      gl.GenTextures(1, &id);
      break;
    case ObjectKind::buffer:
      gl.GenBuffers(1, &id);
      break;
    case ObjectKind::framebuffer:
      gl.GenFramebuffers(1, &id);
      break;
    case ObjectKind::renderbuffer:
      gl.GenRenderbuffers(1, &id);
      break;
    case ObjectKind::vertex_array:
      gl.GenVertexArrays(1, &id);
      break;
    case ObjectKind::sampler:
      gl.GenSamplers(1, &id);
      break;
    case ObjectKind::query:
      gl.GenQueries(1, &id);
      break;
    case ObjectKind::program:
      id = gl.CreateProgram();
      break;
  }
  if (id == 0)
    fail(SIDERAY_GL_FAILED, "cannot create an OpenGL object: the driver returned no name; is the context current?");
  return id;
}

void delete_object(const Functions& gl, ObjectKind kind, uint32_t id) {
  const GLuint name = id;
  switch (kind) {
    case ObjectKind::texture:
      gl.DeleteTextures(1, &name);
      break;
    case ObjectKind::buffer:
      gl.DeleteBuffers(1, &name);
      break;
    case ObjectKind::framebuffer:
      gl.DeleteFramebuffers(1, &name);
      break;
    case ObjectKind::renderbuffer:
      gl.DeleteRenderbuffers(1, &name);
      break;
    case ObjectKind::vertex_array:
      gl.DeleteVertexArrays(1, &name);
      break;
    case ObjectKind::sampler:
      gl.DeleteSamplers(1, &name);
      break;
    case ObjectKind::query:
      gl.DeleteQueries(1, &name);
      break;
    case ObjectKind::program:
      gl.DeleteProgram(name);
      break;
  }
}

Fence::Fence(const Functions& gl) : gl_(&gl), sync_(gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)) {
  if (sync_ == nullptr)
    fail(SIDERAY_GL_FAILED, "cannot create a fence: the driver returned none; is the context current and alive?");
  gl.Flush();
}

Fence& Fence::operator=(Fence&& other) noexcept {
  if (this != &other) {
    reset();
    gl_ = other.gl_;
    sync_ = std::exchange(other.sync_, nullptr);
  }
  return *this;
}

bool Fence::wait(uint64_t timeout_ns) const {
  const GLenum result = gl_->ClientWaitSync(sync_, 0, timeout_ns);
  if (result == GL_WAIT_FAILED) fail(SIDERAY_GL_FAILED, "waiting for a fence failed: the context may be lost");
  return result != GL_TIMEOUT_EXPIRED;
}

void Fence::reset() {
  if (sync_ != nullptr) gl_->DeleteSync(std::exchange(sync_, nullptr));
}

}  // namespace sideray::gl
