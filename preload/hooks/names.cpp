#include "preload/hooks/names.h"

#include <EGL/egl.h>

#include <cstring>
#include <string_view>
#include <unordered_map>

#include "preload/gl/functions.h"

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
                 {"eglSwapBuffers", address(&eglSwapBuffers)},
                 {"eglMakeCurrent", address(&eglMakeCurrent)},
                 {"eglDestroyContext", address(&eglDestroyContext)},
                 {"eglGetProcAddress", address(&eglGetProcAddress)},
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

}  // namespace

void* hooked(const char* name) {
  const bool is_egl = std::strncmp(name, "egl", 3) == 0;
  if (!is_egl && std::strncmp(name, "gl", 2) != 0) return nullptr;
  static const Table* const table = new Table(make_table());
  const auto found = table->find(name);
  return found != table->end() && (is_egl ? real_egl_symbol(name) : real_symbol(name)) ? found->second : nullptr;
}

}  // namespace sideray::run

using sideray::run::hooked;
using sideray::run::real_dlsym;

#pragma GCC visibility push(default)
extern "C" {

// Serves programs that open libGL themselves. The last call is a jump, so that RTLD_NEXT is relative to the caller.
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
