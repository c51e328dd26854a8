// Declares the two ways to a headless context, each in a file of its own, for devices.cpp. Any thread may call them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gl/context/context.h"

namespace sideray::gl {

// Returns what EGL offers here without trying it: devices (hardware first), then the surfaceless platform. An entry
// whose reason is set cannot be opened.
std::vector<DeviceInfo> egl_candidates();
bool egl_loads();  // whether libEGL itself loads, whatever drivers it finds
DeviceInfo osmesa_candidate();

// Open a context and make it current. They throw Failure (NO_DEVICE), whose message has the reason and the remedy.
std::unique_ptr<Context> open_egl(const DeviceInfo& candidate, Profile profile);
std::unique_ptr<Context> open_osmesa(const DeviceInfo& candidate, Profile profile);

// Release the context that the platform has current on this thread; do nothing where it has none or is not loaded.
// Mesa's EGL and OSMesa share one current-context slot per thread without telling each other: each platform calls the
// other's function before it binds a context, or its own binding would do nothing and leave the other's context.
void egl_release_thread();
void osmesa_release_thread();

// Versions to request, best first, as 10 * major + minor.
inline constexpr int core_versions[] = {46, 45, 44, 43, 42, 41, 40, 33};

bool debug_requested();  // environment variable SIDERAY_GL_DEBUG

}  // namespace sideray::gl
