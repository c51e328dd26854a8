#include "gl/resources/objects.h"

#include <chrono>
#include <thread>

#include "model/failure.h"

namespace sideray::gl {
namespace {

constexpr std::chrono::microseconds poll_interval{50};

}  // namespace

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

// Unbinds the program first: a current program lives on until another one is used. NVIDIA's driver (580.159.04) then
// reads memory that it has freed in one of the next draws, and crashes if shaders are compiled meanwhile:
// docs/limits.md.
static void delete_program(const Functions& gl, GLuint id) {
  GLint current = 0;
  gl.GetIntegerv(GL_CURRENT_PROGRAM, &current);
  if (static_cast<GLuint>(current) == id) gl.UseProgram(0);
  gl.DeleteProgram(id);
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
      delete_program(gl, name);
      break;
  }
}

Fence::Fence(const Functions& gl) : gl_(&gl), issued_(true) {
  if (gl.sync) {
    sync_ = gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (sync_ == nullptr)
      fail(SIDERAY_GL_FAILED, "cannot create a fence: the driver returned none; is the context current and alive?");
  } else {
    begin_query();
  }
  gl.Flush();
}

// Does nothing while another query of samples is active, which may be the host's: only one can be.
void Fence::begin_query() {
  GLint under_way = 0, of_any_samples = 0;
  gl_->GetQueryiv(GL_SAMPLES_PASSED, GL_CURRENT_QUERY, &under_way);
  if (gl_->ARB_occlusion_query2 != 0) gl_->GetQueryiv(GL_ANY_SAMPLES_PASSED, GL_CURRENT_QUERY, &of_any_samples);
  if (under_way != 0 || of_any_samples != 0) return;
  query_ = Query(*gl_);
  gl_->BeginQuery(GL_SAMPLES_PASSED, query_.id());
  gl_->EndQuery(GL_SAMPLES_PASSED);
}

Fence Fence::try_issue(const Functions& gl) {
  try {
    return Fence(gl);
  } catch (const Failure&) {
    return {};
  }
}

Fence& Fence::operator=(Fence&& other) noexcept {
  if (this != &other) {
    reset();
    gl_ = other.gl_;
    issued_ = std::exchange(other.issued_, false);
    sync_ = std::exchange(other.sync_, nullptr);
    query_ = std::move(other.query_);
  }
  return *this;
}

bool Fence::wait(uint64_t timeout_ns) const {
  if (!gl_->sync) return wait_for_query(timeout_ns);
  const GLenum result = gl_->ClientWaitSync(sync_, 0, timeout_ns);
  if (result == GL_WAIT_FAILED) fail(SIDERAY_GL_FAILED, "waiting for a fence failed: the context may be lost");
  return result != GL_TIMEOUT_EXPIRED;
}

bool Fence::wait_for_query(uint64_t timeout_ns) const {
  using Clock = std::chrono::steady_clock;
  if (!query_) return true;
  const Clock::time_point end = Clock::now() + std::chrono::nanoseconds(timeout_ns);
  for (;;) {
    GLuint there = GL_TRUE;  // a lost context writes no result: the next mapping fails
    gl_->GetQueryObjectuiv(query_.id(), GL_QUERY_RESULT_AVAILABLE, &there);
    if (there == GL_TRUE) return true;
    if (Clock::now() >= end) return false;
    std::this_thread::sleep_for(poll_interval);
  }
}

bool Fence::wait_or_give_up(uint64_t timeout_ns) const {
  try {
    return wait(timeout_ns);
  } catch (const Failure&) {
    return false;
  }
}

void Fence::reset() {
  if (sync_ != nullptr) gl_->DeleteSync(std::exchange(sync_, nullptr));
  query_.reset();
  issued_ = false;
}

void Fence::abandon() {
  sync_ = nullptr;
  query_.abandon();
  issued_ = false;
}

const void* map_to_read(const Functions& gl, GLenum target, uint64_t bytes) {
  if (gl.map_buffer_range) return gl.MapBufferRange(target, 0, static_cast<GLsizeiptr>(bytes), GL_MAP_READ_BIT);
  return gl.MapBuffer(target, GL_READ_ONLY);
}

}  // namespace sideray::gl
