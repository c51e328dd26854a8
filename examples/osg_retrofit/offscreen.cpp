#include "offscreen.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <stdexcept>
#include <vector>

namespace {

template <typename F>
F entry_point(const char* name) {
  return reinterpret_cast<F>(eglGetProcAddress(name));
}

// Returns initialized displays of the platform, in the driver's order.
std::vector<EGLDisplay> displays(const std::string& platform) {
  const auto get_display = entry_point<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  const auto query_devices = entry_point<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  std::vector<EGLDisplay> candidates, started;
  if (!get_display) return {};
  if (platform != "device")
    candidates.push_back(get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  EGLDeviceEXT devices[16];
  EGLint count = 0;
  if (platform != "surfaceless" && query_devices && query_devices(16, devices, &count))
    for (EGLint i = 0; i < count; ++i) candidates.push_back(get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
  for (const EGLDisplay display : candidates)
    if (display && eglInitialize(display, nullptr, nullptr)) started.push_back(display);
  return started;
}

constexpr EGLint wanted[] = {EGL_SURFACE_TYPE,
                             EGL_PBUFFER_BIT,
                             EGL_RENDERABLE_TYPE,
                             EGL_OPENGL_BIT,
                             EGL_RED_SIZE,
                             8,
                             EGL_GREEN_SIZE,
                             8,
                             EGL_BLUE_SIZE,
                             8,
                             EGL_DEPTH_SIZE,
                             24,
                             EGL_STENCIL_SIZE,
                             8,
                             EGL_NONE};

}  // namespace

Offscreen::Offscreen(const std::string& platform, int width, int height, bool debug) {
  for (const EGLDisplay display : displays(platform)) {
    EGLConfig config = nullptr;
    EGLint count = 0;
    const EGLint size[] = {EGL_WIDTH, width, EGL_HEIGHT, height, EGL_NONE};
    const EGLint profile[] = {EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT,
                              EGL_CONTEXT_OPENGL_DEBUG, debug ? EGL_TRUE : EGL_FALSE, EGL_NONE};
    display_ = display;
    const bool usable = eglBindAPI(EGL_OPENGL_API) && eglChooseConfig(display, wanted, &config, 1, &count) &&
                        count == 1 && (surface_ = eglCreatePbufferSurface(display, config, size)) != nullptr &&
                        (context_ = eglCreateContext(display, config, EGL_NO_CONTEXT, profile)) != nullptr &&
                        eglMakeCurrent(display, surface_, surface_, context_);
    if (usable) return;
  }
  throw std::runtime_error("no headless OpenGL context (EGL platform " + platform +
                           "): neither a pbuffer of Mesa's surfaceless platform nor of a device; use --context window");
}

Offscreen::~Offscreen() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglDestroySurface(display_, surface_);
}
