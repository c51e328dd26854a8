#include "preload/gl/functions.h"

#include <EGL/egl.h>
#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace sideray::run {
namespace {

using Dlsym = void* (*)(void*, const char*);

// Asks for dlsym with its version, since the library exports a dlsym of its own.
Dlsym find_dlsym() {
  for (const char* version : {"GLIBC_2.34", "GLIBC_2.17", "GLIBC_2.2.5"})
    if (void* found = ::dlvsym(RTLD_NEXT, "dlsym", version)) return reinterpret_cast<Dlsym>(found);
  std::fputs("sideray run: this C library has no dlsym of a known version; run the program without sideray\n", stderr);
  std::abort();
}

void* open_driver() {
  for (const char* name : {"libGL.so.1", "libGLX.so.0"})
    if (void* handle = ::dlopen(name, RTLD_LAZY | RTLD_GLOBAL)) return handle;
  std::fputs("sideray run: there is no libGL.so.1; install libgl1\n", stderr);
  std::abort();
}

Functions load() {
  Functions functions;
#define LOAD(name) functions.name = real_function<decltype(functions.name)>("gl" #name);
  SIDERAY_RUN_CALLED(LOAD)
  SIDERAY_RUN_HOOKED(LOAD)
#undef LOAD
#define LOAD(name, count, suffix, type)                                                                                  \
  functions.name##count##suffix = real_function<decltype(functions.name##count##suffix)>("gl" #name #count #suffix);       \
  functions.name##count##suffix##v = real_function<decltype(functions.name##count##suffix##v)>("gl" #name #count #suffix "v");
  SIDERAY_RUN_ATTRIBUTES(LOAD)
  SIDERAY_RUN_UNIT_ATTRIBUTES(LOAD)
#undef LOAD
  return functions;
}

}  // namespace

const Functions& real() {
  static const Functions functions = load();
  return functions;
}

GLint get_integer(GLenum name) {
  GLint value = 0;
  real().GetIntegerv(name, &value);
  return value;
}

bool is_enabled(GLenum name) {
  return real().IsEnabled(name) == GL_TRUE;
}

int texture_units() {
  static const int units = std::clamp<GLint>(get_integer(GL_MAX_TEXTURE_UNITS), 1, kept_units);
  return units;
}

void* real_dlsym(void* handle, const char* name) {
  static const Dlsym function = find_dlsym();
  return function(handle, name);
}

void* real_symbol(const char* name) {
  static void* const driver = open_driver();
  if (void* found = real_dlsym(driver, name)) return found;
  static const auto get_proc_address =
      reinterpret_cast<decltype(&::glXGetProcAddressARB)>(real_dlsym(driver, "glXGetProcAddressARB"));
  return get_proc_address ? reinterpret_cast<void*>(get_proc_address(reinterpret_cast<const GLubyte*>(name))) : nullptr;
}


void* real_egl_symbol(const char* name) {
  // Tries again at each call, as programs may load libEGL late.
  static void* library = nullptr;
  if (!library) library = ::dlopen("libEGL.so.1", RTLD_LAZY | RTLD_NOLOAD);
  return library ? real_dlsym(library, name) : nullptr;
}

void* current_egl_context() {
  const auto current = reinterpret_cast<decltype(&::eglGetCurrentContext)>(real_egl_symbol("eglGetCurrentContext"));
  const EGLContext context = current ? current() : EGL_NO_CONTEXT;
  if (context == EGL_NO_CONTEXT) return nullptr;
  const auto query = reinterpret_cast<decltype(&::eglQueryContext)>(real_egl_symbol("eglQueryContext"));
  const auto display = reinterpret_cast<decltype(&::eglGetCurrentDisplay)>(real_egl_symbol("eglGetCurrentDisplay"));
  EGLint type = 0;
  if (!query(display(), context, EGL_CONTEXT_CLIENT_TYPE, &type) || type != EGL_OPENGL_API) return nullptr;
  return context;
}

}  // namespace sideray::run
