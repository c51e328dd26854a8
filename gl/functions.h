// The table of OpenGL entry points of one context, loaded through whoever owns it. Calls need that context current.
#pragma once

#include <glad/gl.h>

#include <string>

namespace sideray::gl {

// Members of GladGLContext are the entry points without their gl prefix. Capabilities are decided by version and
// extension string, never by pointer: loaders return non-null for names that do not exist.
struct Functions : GladGLContext {
  int version = 0;  // 33, 45, 46
  bool core_profile = false;
  bool software = false;          // llvmpipe, softpipe, swrast: timer queries measure nothing
  bool blend_per_buffer = false;  // OpenGL 4.0
  bool storage_buffers = false;   // of fragment shaders, OpenGL 4.3
  bool clip_control = false, sync = false, buffer_storage = false, debug = false, dual_source = false;
  int texture_units = 16;  // of a fragment shader
  std::string renderer, version_string;
};

using GetProcAddress = void* (*)(void* user, const char* name);

// Throws Failure (UNSUPPORTED) naming what the context lacks.
Functions load_functions(GetProcAddress get_proc_address, void* user);

}  // namespace sideray::gl
