// Provides the driver's own functions.
#pragma once

#include "preload/gl/entry_points.h"

namespace sideray::run {

constexpr int kept_units = 4;  // texture units whose state and coordinates are kept

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

// Returns functions found in libGL at the first call; those that an old driver lacks are null.
const Functions& real();

// Return state of the current context.
GLint get_integer(GLenum name);
bool is_enabled(GLenum name);
// Returns the number of the fixed function's texture units, at most kept_units.
int texture_units();

// Return dlsym of the C library, and a function of the driver.
void* real_dlsym(void* handle, const char* name);
void* real_symbol(const char* name);
// Returns a function of libEGL; null if the process has not loaded it.
void* real_egl_symbol(const char* name);
// Returns the thread's current context, if it is one of OpenGL (not OpenGL ES) by EGL, or null.
void* current_egl_context();

template <typename Function>
Function real_function(const char* name) {
  return reinterpret_cast<Function>(real_symbol(name));
}

}  // namespace sideray::run
