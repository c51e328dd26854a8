// The driver's own functions.
#pragma once

#include "preload/gl/entry_points.h"

namespace sideray::run {

constexpr int kept_units = 4;  // of texture, whose state and coordinates are kept

struct Functions {
#define MEMBER(name) decltype(&::gl##name) name = nullptr;
  SIDERAY_RUN_CALLED(MEMBER)
  SIDERAY_RUN_HOOKED(MEMBER)
#undef MEMBER
#define MEMBER(name, count, suffix, type)                          \
  decltype(&::gl##name##count##suffix) name##count##suffix = nullptr; \
  decltype(&::gl##name##count##suffix##v) name##count##suffix##v = nullptr;
  SIDERAY_RUN_ATTRIBUTES(MEMBER)
  SIDERAY_RUN_UNIT_ATTRIBUTES(MEMBER)
#undef MEMBER
};

// Found in libGL at the first call. What an old driver lacks is null.
const Functions& real();

// State of the current context.
GLint get_integer(GLenum name);
bool is_enabled(GLenum name);
// Texture units of the fixed function, of those whose state is kept (kept_units).
int texture_units();

// dlsym of the C library, and a function of the driver.
void* real_dlsym(void* handle, const char* name);
void* real_symbol(const char* name);
// A function of libEGL; null where the process has not got it.
void* real_egl_symbol(const char* name);
// The thread's context of OpenGL (not of OpenGL ES) that was made by EGL, or null.
void* current_egl_context();

template <typename Function>
Function real_function(const char* name) {
  return reinterpret_cast<Function>(real_symbol(name));
}

}  // namespace sideray::run
