// GLX: swaps, contexts, and functions by name.
#include "preload/base/signals.h"
#include "preload/frame/session.h"
#include "preload/gl/functions.h"
#include "preload/hooks/names.h"

namespace sideray::run {
namespace {

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
  const SignalsWait signals_wait;
  session().swap();
  swap(display, drawable);
  if (signals_wait.has_one()) real().Finish();
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

}  // extern "C"
#pragma GCC visibility pop
