// EGL: swaps, contexts, and functions by name.
#include <EGL/egl.h>

#include "preload/base/signals.h"
#include "preload/frame/session.h"
#include "preload/gl/functions.h"
#include "preload/hooks/names.h"

namespace sideray::run {
namespace {

template <typename Function>
Function real_egl(const char* name) {
  return reinterpret_cast<Function>(real_egl_symbol(name));
}

}  // namespace
}  // namespace sideray::run

using namespace sideray::run;

#pragma GCC visibility push(default)
extern "C" {

EGLBoolean eglSwapBuffers(EGLDisplay display, EGLSurface surface) {
  static const auto swap = real_egl<decltype(&::eglSwapBuffers)>("eglSwapBuffers");
  const SignalsWait signals_wait;
  session().swap();
  const EGLBoolean done = swap(display, surface);
  if (signals_wait.has_one() && current_egl_context()) real().Finish();
  return done;
}

EGLBoolean eglMakeCurrent(EGLDisplay display, EGLSurface draw, EGLSurface read, EGLContext context) {
  static const auto make_current = real_egl<decltype(&::eglMakeCurrent)>("eglMakeCurrent");
  const EGLBoolean done = make_current(display, draw, read, context);
  if (done) session().make_current(current_egl_context());
  return done;
}

EGLBoolean eglDestroyContext(EGLDisplay display, EGLContext context) {
  static const auto destroy = real_egl<decltype(&::eglDestroyContext)>("eglDestroyContext");
  session().destroy(context);
  return destroy(display, context);
}

__eglMustCastToProperFunctionPointerType eglGetProcAddress(const char* name) {
  static const auto get_proc_address = real_egl<decltype(&::eglGetProcAddress)>("eglGetProcAddress");
  void* found = hooked(name);
  return found ? reinterpret_cast<__eglMustCastToProperFunctionPointerType>(found) : get_proc_address(name);
}

}  // extern "C"
#pragma GCC visibility pop
