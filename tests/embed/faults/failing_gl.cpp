#include "embed/faults/failing_gl.h"

#include <cstring>
#include <string_view>

namespace sideray::tests {
namespace {

using Kind = FailingGl::Failure;

FailingGl* current = nullptr;

const gl::Functions& driver() {
  return current->context().functions();
}

// Returns whether a call reaches the driver, which none does in a lost context.
bool passes() {
  current->note_call();
  if (!current->is_lost()) return true;
  current->raise(GL_CONTEXT_LOST);
  return false;
}

bool allocates() {
  if (!passes()) return false;
  if (current->strikes(Kind::allocation)) return current->raise(GL_OUT_OF_MEMORY), false;
  return passes();
}

template <auto member>
struct Plain;  // a call that only a lost context stops

template <typename... Args, void (GLAD_API_PTR* GladGLContext::*member)(Args...)>
struct Plain<member> {
  static void GLAD_API_PTR call(Args... args) {
    if (passes()) (driver().*member)(args...);
  }
};

template <auto member>
struct Allocating;

template <typename... Args, void (GLAD_API_PTR* GladGLContext::*member)(Args...)>
struct Allocating<member> {
  static void GLAD_API_PTR call(Args... args) {
    if (allocates()) (driver().*member)(args...);
  }
};

template <auto member>
struct Generating {
  static inline const char* kind = "";
  static void GLAD_API_PTR call(GLsizei count, GLuint* names) {
    std::memset(names, 0, static_cast<size_t>(count) * sizeof(*names));
    if (!passes() || current->strikes(Kind::name) || !passes()) return;
    (driver().*member)(count, names);
    for (GLsizei i = 0; i < count; ++i) current->alive_[kind].insert(names[i]);
  }
};

template <auto member>
struct Deleting {
  static inline const char* kind = "";
  static void GLAD_API_PTR call(GLsizei count, const GLuint* names) {
    current->note_call();
    for (GLsizei i = 0; i < count; ++i)
      if (names[i] != 0 && current->alive_[kind].erase(names[i]) == 0) ++current->unknown_deletions_;
    (driver().*member)(count, names);
  }
};

GLuint GLAD_API_PTR create_program() {
  if (!passes() || current->strikes(Kind::name) || !passes()) return 0;
  const GLuint name = driver().CreateProgram();
  current->alive_["program"].insert(name);
  return name;
}

void GLAD_API_PTR delete_program(GLuint name) {
  current->note_call();
  current->alive_["program"].erase(name);
  driver().DeleteProgram(name);
}

GLuint GLAD_API_PTR create_shader(GLenum type) {
  if (!passes() || current->strikes(Kind::name) || !passes()) return 0;
  const GLuint name = driver().CreateShader(type);
  current->alive_["shader"].insert(name);
  return name;
}

void GLAD_API_PTR delete_shader(GLuint name) {
  current->note_call();
  current->alive_["shader"].erase(name);
  driver().DeleteShader(name);
}

void* GLAD_API_PTR map_buffer_range(GLenum target, GLintptr start, GLsizeiptr size, GLbitfield access) {
  if (!passes()) return nullptr;
  if (current->strikes(Kind::mapping)) return current->raise(GL_OUT_OF_MEMORY), nullptr;
  return passes() ? driver().MapBufferRange(target, start, size, access) : nullptr;
}

GLsync GLAD_API_PTR fence_sync(GLenum condition, GLbitfield flags) {
  if (!passes() || current->strikes(Kind::fence) || !passes()) return nullptr;
  const GLsync fence = driver().FenceSync(condition, flags);
  current->alive_["fence"].insert(reinterpret_cast<uint64_t>(fence));
  return fence;
}

void GLAD_API_PTR delete_sync(GLsync fence) {
  current->note_call();
  current->alive_["fence"].erase(reinterpret_cast<uint64_t>(fence));
  driver().DeleteSync(fence);
}

GLenum GLAD_API_PTR client_wait_sync(GLsync fence, GLbitfield flags, GLuint64 timeout) {
  if (!passes()) return GL_WAIT_FAILED;
  if (current->strikes(Kind::never)) return GL_TIMEOUT_EXPIRED;
  if (current->strikes(Kind::waiting)) return current->raise(GL_INVALID_VALUE), GL_WAIT_FAILED;
  return passes() ? driver().ClientWaitSync(fence, flags, timeout) : GL_WAIT_FAILED;
}

GLenum GLAD_API_PTR get_error() {
  current->note_call();
  const GLenum error = current->take_error();
  return error != GL_NO_ERROR ? error : driver().GetError();
}

// In a lost context the results of queries are not written.
void GLAD_API_PTR get_integer(GLenum name, GLint* value) {
  if (passes()) driver().GetIntegerv(name, value);
}

GLenum GLAD_API_PTR check_framebuffer(GLenum target) {
  return passes() ? driver().CheckFramebufferStatus(target) : 0;
}

struct Entry {
  const char* name;
  void* function;
};

template <typename Function>
void* pointer(Function* function) {
  return reinterpret_cast<void*>(function);
}

#define PLAIN(name) \
  { "gl" #name, pointer(&Plain<&GladGLContext::name>::call) }
#define ALLOCATING(name) \
  { "gl" #name, pointer(&Allocating<&GladGLContext::name>::call) }
#define NAMED(upper)                                                           \
  {"glGen" #upper, pointer(&Generating<&GladGLContext::Gen##upper>::call)}, {  \
    "glDelete" #upper, pointer(&Deleting<&GladGLContext::Delete##upper>::call) \
  }

const Entry entries[] = {NAMED(Textures),
                         NAMED(Buffers),
                         NAMED(Framebuffers),
                         NAMED(Renderbuffers),
                         NAMED(VertexArrays),
                         NAMED(Samplers),
                         NAMED(Queries),
                         ALLOCATING(TexImage2D),
                         ALLOCATING(TexImage3D),
                         ALLOCATING(TexStorage2D),
                         ALLOCATING(TexStorage3D),
                         ALLOCATING(BufferData),
                         ALLOCATING(BufferStorage),
                         ALLOCATING(RenderbufferStorage),
                         ALLOCATING(RenderbufferStorageMultisample),
                         ALLOCATING(TextureView),
                         PLAIN(ReadPixels),
                         PLAIN(BindBufferBase),
                         PLAIN(DispatchCompute),
                         PLAIN(MemoryBarrier),
                         PLAIN(TexSubImage2D),
                         PLAIN(TexSubImage3D),
                         PLAIN(BindTexture),
                         PLAIN(BindBuffer),
                         PLAIN(BindFramebuffer),
                         PLAIN(BindSampler),
                         PLAIN(FramebufferTexture2D),
                         PLAIN(DrawBuffer),
                         PLAIN(TexParameteri),
                         PLAIN(BlitFramebuffer),
                         PLAIN(DrawArrays),
                         PLAIN(UseProgram),
                         PLAIN(Uniform1i),
                         PLAIN(Finish),
                         {"glCreateProgram", pointer(&create_program)},
                         {"glDeleteProgram", pointer(&delete_program)},
                         {"glCreateShader", pointer(&create_shader)},
                         {"glDeleteShader", pointer(&delete_shader)},
                         {"glMapBufferRange", pointer(&map_buffer_range)},
                         {"glFenceSync", pointer(&fence_sync)},
                         {"glDeleteSync", pointer(&delete_sync)},
                         {"glClientWaitSync", pointer(&client_wait_sync)},
                         {"glGetError", pointer(&get_error)},
                         {"glGetIntegerv", pointer(&get_integer)},
                         {"glCheckFramebufferStatus", pointer(&check_framebuffer)}};

#undef PLAIN
#undef ALLOCATING
#undef NAMED

void name_all_kinds() {
  const auto name = [](const char* kind, auto& generating, auto& deleting) { generating = deleting = kind; };
  using G = GladGLContext;
  name("texture", Generating<&G::GenTextures>::kind, Deleting<&G::DeleteTextures>::kind);
  name("buffer", Generating<&G::GenBuffers>::kind, Deleting<&G::DeleteBuffers>::kind);
  name("framebuffer", Generating<&G::GenFramebuffers>::kind, Deleting<&G::DeleteFramebuffers>::kind);
  name("renderbuffer", Generating<&G::GenRenderbuffers>::kind, Deleting<&G::DeleteRenderbuffers>::kind);
  name("vertex array", Generating<&G::GenVertexArrays>::kind, Deleting<&G::DeleteVertexArrays>::kind);
  name("sampler", Generating<&G::GenSamplers>::kind, Deleting<&G::DeleteSamplers>::kind);
  name("query", Generating<&G::GenQueries>::kind, Deleting<&G::DeleteQueries>::kind);
}

}  // namespace

FailingGl::FailingGl(gl::Context& context) : context_(context) {
  current = this;
  name_all_kinds();
}

FailingGl::~FailingGl() {
  current = nullptr;
}

void* FailingGl::get_proc_address(void* user, const char* name) {
  for (const Entry& entry : entries)
    if (std::string_view(entry.name) == name) return entry.function;
  return gl::Context::get_proc_address(&static_cast<FailingGl*>(user)->context_, name);
}

void FailingGl::fail(Failure failure, int n) {
  failure_ = failure, countdown_ = n;
  failed_ = lost_ = false;
  pending_ = GL_NO_ERROR;
}

bool FailingGl::strikes(Failure failure) {
  if (failure == Failure::never) return failed_ |= failure_ == failure, failure_ == failure;
  const bool loses = failure_ == Failure::lost;
  if ((failure_ != failure && !loses) || --countdown_ != 0) return false;
  failed_ = true;
  lost_ = loses;
  return !loses;
}

uint32_t FailingGl::take_error() {
  const uint32_t error = pending_;
  pending_ = GL_NO_ERROR;
  return error;
}

size_t FailingGl::alive_count() const {
  size_t count = 0;
  for (const auto& [kind, names] : alive_) count += names.size();
  return count;
}

}  // namespace sideray::tests
