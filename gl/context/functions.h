// Holds the OpenGL entry points of one context, which its owner's loader provides. Calls must come from the thread on
// which that context is current.
#pragma once

#include <glad/gl.h>

#include <string>

namespace sideray::gl {

// The members of GladGLContext are the entry points without their gl prefix, also those that an extension has under a
// suffix. Capabilities follow from version and extension string, since loaders return non-null for names that do not
// exist. A capability is cleared where an entry point that it needs is null.
struct Functions : GladGLContext {
  int version = 0;  // 21, 33, 45, 46
  bool core_profile = false;
  bool software = false;         // llvmpipe, softpipe, swrast: timer queries measure nothing
  bool storage_buffers = false;  // in fragment shaders, OpenGL 4.3
  bool compute = false;          // OpenGL 4.3, with texture views and sampling of stencil
  bool clip_control = false, sync = false, buffer_storage = false, debug = false;
  // The service works without these features of OpenGL 3.3; their state is saved where they exist.
  bool separate_framebuffers = false;  // one to read from, one to draw to, and blits between them
  bool attachment_sizes = false;       // a framebuffer can be asked for the bits of its attachments
  bool indexed_enables = false;        // blending and colour mask for each draw buffer
  bool viewport_arrays = false;        // OpenGL 4.1
  bool map_buffer_range = false, samplers = false, vertex_arrays = false, copy_buffers = false, uniform_buffers = false;
  bool clamp_read_color = false, integer_textures = false;
  // Targets of glBindFramebuffer and its like; both are GL_FRAMEBUFFER where the context has only one.
  GLenum read_framebuffer = GL_READ_FRAMEBUFFER, draw_framebuffer = GL_DRAW_FRAMEBUFFER;
  int texture_units = 16;           // of a fragment shader
  int64_t storage_block_bytes = 0;  // the largest size of a storage buffer's block
  std::string renderer, version_string;
};

using GetProcAddress = void* (*)(void* user, const char* name);

// Throws Failure (UNSUPPORTED) that names everything that the service needs (docs/embedding.md) and the context lacks.
Functions load_functions(GetProcAddress get_proc_address, void* user);

// Throws Failure (UNSUPPORTED) below OpenGL 3.3: the rasterizer needs more than the service.
void require_renderer(const Functions& gl);

}  // namespace sideray::gl
