#include "gl/context/functions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <initializer_list>
#include <string_view>

#include "model/failure.h"

namespace sideray::gl {
namespace {

constexpr int renderer_floor = 33;

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

using Extension = int GladGLContext::*;

bool offers(const Functions& gl, int version, std::initializer_list<Extension> extensions) {
  return gl.version >= version ||
         std::any_of(extensions.begin(), extensions.end(), [&](Extension extension) { return gl.*extension != 0; });
}

// Returns 130 for "1.30 - with a vendor's words".
int glsl_version(const Functions& gl) {
  if (gl.VERSION_2_0 == 0) return 0;
  const std::string version = text(gl, GL_SHADING_LANGUAGE_VERSION);
  const size_t dot = version.find('.');
  return 100 * std::atoi(version.c_str()) + (dot == std::string::npos ? 0 : std::atoi(version.c_str() + dot + 1));
}

int context_version(const Functions& gl) {
  if (gl.VERSION_3_0 == 0) return gl.VERSION_2_1 != 0 ? 21 : gl.VERSION_2_0 != 0 ? 20 : 15;
  GLint major = 0, minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  return 10 * major + minor;
}

// Returns whether the fixed function is gone. Profiles came with 3.2; before, an extension or a flag says so.
bool is_core(const Functions& gl) {
  GLint bits = 0;
  if (gl.version >= 32) {
    gl.GetIntegerv(GL_CONTEXT_PROFILE_MASK, &bits);
    return (bits & GL_CONTEXT_CORE_PROFILE_BIT) != 0;
  }
  if (gl.version == 31) return gl.ARB_compatibility == 0;
  if (gl.version == 30) gl.GetIntegerv(GL_CONTEXT_FLAGS, &bits);
  return (bits & GL_CONTEXT_FLAG_FORWARD_COMPATIBLE_BIT) != 0;
}

bool has_framebuffers_of_3_0(const Functions& gl) {
  return offers(gl, 30, {&Functions::ARB_framebuffer_object});
}

void use_older_framebuffers(Functions& gl) {
  gl.BindFramebuffer = gl.BindFramebufferEXT;
  gl.BindRenderbuffer = gl.BindRenderbufferEXT;
  gl.CheckFramebufferStatus = gl.CheckFramebufferStatusEXT;
  gl.DeleteFramebuffers = gl.DeleteFramebuffersEXT;
  gl.DeleteRenderbuffers = gl.DeleteRenderbuffersEXT;
  gl.FramebufferRenderbuffer = gl.FramebufferRenderbufferEXT;
  gl.FramebufferTexture2D = gl.FramebufferTexture2DEXT;
  gl.GenFramebuffers = gl.GenFramebuffersEXT;
  gl.GenRenderbuffers = gl.GenRenderbuffersEXT;
  gl.GetFramebufferAttachmentParameteriv = gl.GetFramebufferAttachmentParameterivEXT;
  gl.GetRenderbufferParameteriv = gl.GetRenderbufferParameterivEXT;
  gl.IsFramebuffer = gl.IsFramebufferEXT;
  gl.IsRenderbuffer = gl.IsRenderbufferEXT;
  gl.RenderbufferStorage = gl.RenderbufferStorageEXT;
  if (gl.EXT_framebuffer_blit != 0)
    gl.BlitFramebuffer = gl.BlitFramebufferEXT;
  else
    gl.read_framebuffer = gl.draw_framebuffer = GL_FRAMEBUFFER;
}

// Copies entry points of extensions to the names of OpenGL 3.0, which are the only ones that callers use.
void use_older_names(Functions& gl) {
  if (!has_framebuffers_of_3_0(gl)) {
    if (gl.EXT_framebuffer_object != 0) use_older_framebuffers(gl);
    if (gl.EXT_texture_array != 0) gl.FramebufferTextureLayer = gl.FramebufferTextureLayerEXT;
  }
  if (gl.version >= 30) return;
  if (gl.ARB_color_buffer_float != 0) gl.ClampColor = gl.ClampColorARB;
  if (gl.EXT_draw_buffers2 == 0) return;
  gl.Enablei = gl.EnableIndexedEXT;
  gl.Disablei = gl.DisableIndexedEXT;
  gl.IsEnabledi = gl.IsEnabledIndexedEXT;
  gl.ColorMaski = gl.ColorMaskIndexedEXT;
  gl.GetBooleani_v = gl.GetBooleanIndexedvEXT;
  gl.GetIntegeri_v = gl.GetIntegerIndexedvEXT;
}

void require_capabilities(const Functions& gl) {
  using F = Functions;
  const struct {
    const char* name;
    bool present;
  } needs[] = {
      {"GLSL 1.20", glsl_version(gl) >= 120},
      {"pixel buffers (OpenGL 2.1 or ARB_pixel_buffer_object)", offers(gl, 21, {&F::ARB_pixel_buffer_object})},
      {"framebuffer objects (3.0, ARB_framebuffer_object or EXT_framebuffer_object)",
       has_framebuffers_of_3_0(gl) || gl.EXT_framebuffer_object != 0},
      {"packed depth and stencil (3.0, ARB_framebuffer_object or EXT_packed_depth_stencil)",
       has_framebuffers_of_3_0(gl) || gl.EXT_packed_depth_stencil != 0},
      {"texture arrays (3.0 or EXT_texture_array)", offers(gl, 30, {&F::EXT_texture_array})},
      {"float textures (3.0 or ARB_texture_float)", offers(gl, 30, {&F::ARB_texture_float})},
      {"textures of one channel (3.0 or ARB_texture_rg)", offers(gl, 30, {&F::ARB_texture_rg})},
      {"half floats (3.0 or ARB_half_float_pixel)", offers(gl, 30, {&F::ARB_half_float_pixel})},
  };
  std::string missing;
  for (const auto& need : needs)
    if (!need.present) missing += std::string(missing.empty() ? "" : ", ") + need.name;
  if (!missing.empty())
    fail(SIDERAY_UNSUPPORTED,
         "the context is OpenGL \"{}\" ({}) and lacks {}; ask for a newer context or update the driver",
         gl.version_string, gl.renderer, missing);
}

// A null pointer proves that the loader lacks it, as wglGetProcAddress lacks OpenGL 1.1; a non-null one proves nothing.
void require_entry_points(const Functions& gl) {
  const struct {
    const char* name;
    bool present;
  } entries[] = {
      {"glGetString", gl.GetString != nullptr},
      {"glReadPixels", gl.ReadPixels != nullptr},
      {"glTexSubImage3D", gl.TexSubImage3D != nullptr},
      {"glMapBuffer", gl.MapBuffer != nullptr},
      {"glGetQueryObjectuiv", gl.GetQueryObjectuiv != nullptr},
      {"glStencilFuncSeparate", gl.StencilFuncSeparate != nullptr},
      {"glUniform1iv", gl.Uniform1iv != nullptr},
      {"glGetStringi", gl.version < 30 || gl.GetStringi != nullptr},
      {"glBindFramebuffer", gl.BindFramebuffer != nullptr},
      {"glFramebufferTextureLayer", gl.FramebufferTextureLayer != nullptr},
      {"glBlitFramebuffer", gl.BlitFramebuffer != nullptr || gl.read_framebuffer == GL_FRAMEBUFFER},
  };
  for (const auto& entry : entries)
    if (!entry.present)
      fail(SIDERAY_UNSUPPORTED,
           "OpenGL function {} not found: get_proc_address returned null; it must resolve every "
           "function of the context, those of OpenGL 1.1 too",
           entry.name);
}

void find_capabilities(Functions& gl) {
  using F = Functions;
  const bool framebuffers_of_3_0 = has_framebuffers_of_3_0(gl);
  gl.sync = offers(gl, 32, {&F::ARB_sync}) && gl.FenceSync != nullptr;
  gl.map_buffer_range = offers(gl, 30, {&F::ARB_map_buffer_range}) && gl.MapBufferRange != nullptr;
  gl.buffer_storage =
      offers(gl, 44, {&F::ARB_buffer_storage}) && gl.BufferStorage != nullptr && gl.map_buffer_range && gl.sync;
  gl.clip_control = offers(gl, 45, {&F::ARB_clip_control}) && gl.ClipControl != nullptr;
  gl.debug = offers(gl, 43, {&F::KHR_debug}) && gl.DebugMessageCallback != nullptr;
  gl.storage_buffers = gl.version >= 43;
  gl.separate_framebuffers = framebuffers_of_3_0 || gl.EXT_framebuffer_blit != 0;
  gl.attachment_sizes = framebuffers_of_3_0;
  gl.indexed_enables = offers(gl, 30, {&F::EXT_draw_buffers2}) && gl.IsEnabledi != nullptr;
  gl.viewport_arrays =
      offers(gl, 41, {&F::ARB_viewport_array}) && gl.indexed_enables && gl.ViewportIndexedfv != nullptr;
  gl.samplers = offers(gl, 33, {&F::ARB_sampler_objects}) && gl.BindSampler != nullptr;
  gl.vertex_arrays = offers(gl, 30, {&F::ARB_vertex_array_object}) && gl.BindVertexArray != nullptr;
  gl.copy_buffers = offers(gl, 31, {&F::ARB_copy_buffer});
  gl.uniform_buffers = offers(gl, 31, {&F::ARB_uniform_buffer_object}) && gl.BindBufferRange != nullptr;
  gl.compute = gl.version >= 43 && gl.separate_framebuffers && gl.samplers && gl.DispatchCompute != nullptr &&
               gl.MemoryBarrier != nullptr && gl.TextureView != nullptr && gl.TexStorage2D != nullptr &&
               gl.BindBufferBase != nullptr;
  gl.clamp_read_color = offers(gl, 30, {&F::ARB_color_buffer_float}) && gl.ClampColor != nullptr;
  // Where EXT_texture_integer alone provides integer textures, none of the snippet's shaders can sample them.
  gl.integer_textures = gl.version >= 30 || (gl.EXT_texture_integer != 0 && glsl_version(gl) >= 130);
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
         "the context is \"{}\": depth and stencil cannot be read back from OpenGL ES; use a desktop OpenGL context",
         gl.version_string);
  gl.version = context_version(gl);
  require_capabilities(gl);
  use_older_names(gl);
  require_entry_points(gl);
  gl.core_profile = is_core(gl);
  gl.software = is_software(gl.renderer);
  find_capabilities(gl);
  gl.GetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &gl.texture_units);
  GLint64 bytes = 0;
  if (gl.storage_buffers) gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
  gl.storage_block_bytes = bytes;
  return gl;
}

void require_renderer(const Functions& gl) {
  if (gl.version < renderer_floor)
    fail(SIDERAY_UNSUPPORTED,
         "the context is OpenGL \"{}\" ({}): 3.3 or later is needed (sampler objects, texture "
         "arrays, fences); ask for a newer context or update the driver",
         gl.version_string, gl.renderer);
}

}  // namespace sideray::gl
