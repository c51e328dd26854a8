#include "gl/functions.h"

#include <fmt/format.h>

#include <string_view>

#include "model/failure.h"

namespace sideray::gl {
namespace {

constexpr int version_floor = 33;

struct Loader {
  GetProcAddress get_proc_address;
  void* user;
};

GLADapiproc load(void* loader, const char* name) {
  const auto* l = static_cast<const Loader*>(loader);
  return reinterpret_cast<GLADapiproc>(l->get_proc_address(l->user, name));
}

std::string text(const Functions& gl, GLenum name) {
  const GLubyte* value = gl.GetString(name);
  return value != nullptr ? reinterpret_cast<const char*>(value) : "";
}

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

bool is_software(std::string_view renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "lavapipe", "SWR", "Software Rasterizer"})
    if (contains(renderer, name)) return true;
  return false;
}

// A null pointer proves absence (a non-null one proves nothing): wglGetProcAddress, for one, knows no OpenGL 1.1.
void require_entry_points(const Functions& gl) {
  const struct {
    const char* name;
    bool present;
  } entries[] = {
      {"glGetString", gl.GetString != nullptr},
      {"glReadPixels", gl.ReadPixels != nullptr},
      {"glTexSubImage3D", gl.TexSubImage3D != nullptr},
      {"glGetStringi", gl.GetStringi != nullptr},
      {"glBindFramebuffer", gl.BindFramebuffer != nullptr},
      {"glMapBufferRange", gl.MapBufferRange != nullptr},
      {"glFenceSync", gl.FenceSync != nullptr},
      {"glBindSampler", gl.BindSampler != nullptr},
  };
  for (const auto& entry : entries)
    if (!entry.present)
      fail(SIDERAY_UNSUPPORTED,
           "OpenGL function {} not found: get_proc_address returned null; it must resolve every "
           "function of the context, those of OpenGL 1.1 too",
           entry.name);
}

}  // namespace

Functions load_functions(GetProcAddress get_proc_address, void* user) {
  Loader loader{get_proc_address, user};
  Functions gl{};
  if (gladLoadGLContextUserPtr(&gl, &load, &loader) == 0)
    fail(SIDERAY_UNSUPPORTED,
         "no OpenGL functions: get_proc_address resolves none, or no context is current on this "
         "thread; make one current first");
  gl.version_string = text(gl, GL_VERSION);
  gl.renderer = text(gl, GL_RENDERER);
  if (contains(gl.version_string, "OpenGL ES"))
    fail(SIDERAY_UNSUPPORTED,
         "the context is \"{}\": depth and stencil cannot be read back from OpenGL ES; use a "
         "desktop OpenGL 3.3 context",
         gl.version_string);
  GLint major = 0, minor = 0;
  if (gl.VERSION_3_0 != 0) {
    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  }
  gl.version = 10 * major + minor;
  if (gl.version < version_floor)
    fail(SIDERAY_UNSUPPORTED,
         "the context is OpenGL \"{}\" ({}): 3.3 or later is needed (sampler objects, texture "
         "arrays, fences); ask for a newer context or update the driver",
         gl.version_string, gl.renderer);
  require_entry_points(gl);
  GLint profile = 0;
  gl.GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
  gl.core_profile = (profile & GL_CONTEXT_CORE_PROFILE_BIT) != 0;
  gl.software = is_software(gl.renderer);
  gl.clip_control = gl.version >= 45 || gl.ARB_clip_control != 0;
  gl.buffer_storage = (gl.version >= 44 || gl.ARB_buffer_storage != 0) && gl.BufferStorage != nullptr;
  gl.blend_per_buffer = gl.version >= 40;
  gl.storage_buffers = gl.version >= 43;
  gl.debug = gl.version >= 43 || gl.KHR_debug != 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &gl.texture_units);
  gl.sync = true;         // core since 3.2
  gl.dual_source = true;  // core since 3.3
  return gl;
}

}  // namespace sideray::gl
