// GLX: swaps, contexts, and the ways to ask for functions by name.
#include <cstring>
#include <string_view>
#include <unordered_map>

#include "preload/gl/functions.h"
#include "preload/frame/session.h"

namespace sideray::run {
namespace {

using Table = std::unordered_map<std::string_view, void*>;

template <typename Function>
void* address(Function* function) {
  return reinterpret_cast<void*>(function);
}

Table make_table() {
  Table table = {{"glXSwapBuffers", address(&glXSwapBuffers)},
                 {"glXMakeCurrent", address(&glXMakeCurrent)},
                 {"glXMakeContextCurrent", address(&glXMakeContextCurrent)},
                 {"glXDestroyContext", address(&glXDestroyContext)},
                 {"glXGetProcAddress", address(&glXGetProcAddress)},
                 {"glXGetProcAddressARB", address(&glXGetProcAddressARB)},
                 {"glUseProgramObjectARB", address(&glUseProgramObjectARB)}};
#define ROW(name) table["gl" #name] = address(&gl##name);
  SIDERAY_RUN_HOOKED(ROW)
#undef ROW
#define ROW(alias, name) table["gl" #alias] = address(&gl##name);
  SIDERAY_RUN_ALIASES(ROW)
#undef ROW
#define ROW(name, count, suffix, type)                           \
  table["gl" #name #count #suffix] = address(&gl##name##count##suffix); \
  table["gl" #name #count #suffix "v"] = address(&gl##name##count##suffix##v);
  SIDERAY_RUN_ATTRIBUTES(ROW)
  SIDERAY_RUN_UNIT_ATTRIBUTES(ROW)
#undef ROW
#define ROW(name, count, suffix, type)                                  \
  table["gl" #name #count #suffix "ARB"] = address(&gl##name##count##suffix); \
  table["gl" #name #count #suffix "vARB"] = address(&gl##name##count##suffix##v);
  SIDERAY_RUN_UNIT_ATTRIBUTES(ROW)
#undef ROW
  return table;
}

// The library's function of a name, where there is one and the driver has it too.
void* hooked(const char* name) {
  if (std::strncmp(name, "gl", 2) != 0) return nullptr;
  static const Table* const table = new Table(make_table());
  const auto found = table->find(name);
  return found != table->end() && real_symbol(name) ? found->second : nullptr;
}

__GLXextFuncPtr proc_address(const GLubyte* name) {
  const char* text = reinterpret_cast<const char*>(name);
  void* found = hooked(text);
  return reinterpret_cast<__GLXextFuncPtr>(found ? found : real_symbol(text));
}

}  // namespace
}  // namespace sideray::run

using namespace sideray::run;

#pragma GCC visibility push(default)
extern "C" {

void glXSwapBuffers(Display* display, GLXDrawable drawable) {
  static const auto swap = real_function<decltype(&::glXSwapBuffers)>("glXSwapBuffers");
  session().swap();
  swap(display, drawable);
}

Bool glXMakeCurrent(Display* display, GLXDrawable drawable, GLXContext context) {
  static const auto make_current = real_function<decltype(&::glXMakeCurrent)>("glXMakeCurrent");
  const Bool done = make_current(display, drawable, context);
  if (done) session().make_current(context);
  return done;
}

Bool glXMakeContextCurrent(Display* display, GLXDrawable draw, GLXDrawable read, GLXContext context) {
  static const auto make_current = real_function<decltype(&::glXMakeContextCurrent)>("glXMakeContextCurrent");
  const Bool done = make_current(display, draw, read, context);
  if (done) session().make_current(context);
  return done;
}

void glXDestroyContext(Display* display, GLXContext context) {
  static const auto destroy = real_function<decltype(&::glXDestroyContext)>("glXDestroyContext");
  session().destroy(context);
  destroy(display, context);
}

__GLXextFuncPtr glXGetProcAddress(const GLubyte* name) {
  return proc_address(name);
}

__GLXextFuncPtr glXGetProcAddressARB(const GLubyte* name) {
  return proc_address(name);
}

// For programs that open libGL themselves. The last call is a jump, so that RTLD_NEXT still means the caller's next.
[[gnu::optimize("O2")]] void* dlsym(void* handle, const char* name) noexcept {
  if (void* found = hooked(name)) return found;
  return real_dlsym(handle, name);
}

// Older names that programs link to.
void glBindTextureEXT(GLenum target, GLuint texture) { glBindTexture(target, texture); }
void glDrawArraysEXT(GLenum mode, GLint first, GLsizei count) { glDrawArrays(mode, first, count); }
void glBindFramebufferEXT(GLenum target, GLuint name) { glBindFramebuffer(target, name); }
void glBufferDataARB(GLenum target, GLsizeiptrARB size, const void* data, GLenum usage) { glBufferData(target, size, data, usage); }
void glBufferSubDataARB(GLenum target, GLintptrARB offset, GLsizeiptrARB size, const void* data) { glBufferSubData(target, offset, size, data); }
void* glMapBufferARB(GLenum target, GLenum access) { return glMapBuffer(target, access); }
void glDeleteBuffersARB(GLsizei count, const GLuint* names) { glDeleteBuffers(count, names); }

}  // extern "C"
#pragma GCC visibility pop
