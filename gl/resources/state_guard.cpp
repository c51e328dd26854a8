#include "gl/resources/state_guard.h"

#include <algorithm>

namespace sideray::gl {
namespace {

int32_t get_int(const Functions& gl, GLenum name) {
  GLint value = 0;
  gl.GetIntegerv(name, &value);
  return value;
}

uint32_t get_name(const Functions& gl, GLenum name) {
  return static_cast<uint32_t>(get_int(gl, name));
}

// Bit masks need 64 bits: as 32-bit integers, drivers clamp ~0 to 0x7fffffff.
uint32_t get_mask(const Functions& gl, GLenum name) {
  if (!gl.sync) return get_name(gl, name);  // fits: a stencil buffer has fewer bits
  GLint64 value = 0;
  gl.GetInteger64v(name, &value);
  return static_cast<uint32_t>(value);
}

// The count has 64 bits since OpenGL 3.2.
int64_t get_indexed(const Functions& gl, GLenum name, GLuint index) {
  GLint64 wide = 0;
  GLint narrow = 0;
  if (gl.version >= 32)
    gl.GetInteger64i_v(name, index, &wide);
  else
    gl.GetIntegeri_v(name, index, &narrow);
  return gl.version >= 32 ? wide : narrow;
}

bool get_bool(const Functions& gl, GLenum name) {
  GLboolean value = GL_FALSE;
  gl.GetBooleanv(name, &value);
  return value == GL_TRUE;
}

GLboolean gl_bool(bool value) {
  return value ? GL_TRUE : GL_FALSE;
}

void set_capability(const Functions& gl, GLenum capability, bool on) {
  if (on) {
    gl.Enable(capability);
  } else {
    gl.Disable(capability);
  }
}

void bind_buffer(const Functions& gl, GLenum target, uint32_t buffer) {
  gl.BindBuffer(target, buffer != 0 && gl.IsBuffer(buffer) == GL_TRUE ? buffer : 0);
}

// Names the enums of a kind of buffer with indexed binding points.
struct IndexedPoint {
  GLenum target, binding, start, size;
};

constexpr IndexedPoint uniform_point{GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START,
                                     GL_UNIFORM_BUFFER_SIZE};
constexpr IndexedPoint storage_point{GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING,
                                     GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE};

BufferRange get_range(const Functions& gl, const IndexedPoint& point, GLuint index) {
  GLint buffer = 0;
  gl.GetIntegeri_v(point.binding, index, &buffer);
  return {static_cast<uint32_t>(buffer), get_indexed(gl, point.start, index), get_indexed(gl, point.size, index)};
}

void bind_range(const Functions& gl, const IndexedPoint& point, GLuint index, const BufferRange& range) {
  const bool exists = range.buffer != 0 && gl.IsBuffer(range.buffer) == GL_TRUE;
  if (exists && range.size != 0)
    gl.BindBufferRange(point.target, index, range.buffer, range.start, range.size);
  else
    gl.BindBufferBase(point.target, index, exists ? range.buffer : 0);
}

void bind_texture(const Functions& gl, GLenum target, uint32_t texture) {
  gl.BindTexture(target, texture != 0 && gl.IsTexture(texture) == GL_TRUE ? texture : 0);
}

constexpr GLenum store_names[] = {
    GL_PACK_SWAP_BYTES,   GL_PACK_LSB_FIRST,     GL_PACK_ROW_LENGTH,    GL_PACK_IMAGE_HEIGHT,
    GL_PACK_SKIP_ROWS,    GL_PACK_SKIP_PIXELS,   GL_PACK_SKIP_IMAGES,   GL_PACK_ALIGNMENT,
    GL_UNPACK_SWAP_BYTES, GL_UNPACK_LSB_FIRST,   GL_UNPACK_ROW_LENGTH,  GL_UNPACK_IMAGE_HEIGHT,
    GL_UNPACK_SKIP_ROWS,  GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_ALIGNMENT};

constexpr GLenum scale_names[] = {GL_RED_SCALE, GL_RED_BIAS,    GL_GREEN_SCALE, GL_GREEN_BIAS,  GL_BLUE_SCALE,
                                  GL_BLUE_BIAS, GL_ALPHA_SCALE, GL_ALPHA_BIAS,  GL_DEPTH_SCALE, GL_DEPTH_BIAS};

constexpr GLenum map_names[] = {GL_MAP_COLOR, GL_MAP_STENCIL, GL_INDEX_SHIFT, GL_INDEX_OFFSET};

struct BufferTarget {
  GLenum name, binding;
  bool Functions::*needs;  // the capability that it needs; null: none
};

constexpr BufferTarget buffer_targets[] = {{GL_ARRAY_BUFFER, GL_ARRAY_BUFFER_BINDING, nullptr},
                                           {GL_COPY_READ_BUFFER, GL_COPY_READ_BUFFER, &Functions::copy_buffers},
                                           {GL_COPY_WRITE_BUFFER, GL_COPY_WRITE_BUFFER, &Functions::copy_buffers},
                                           {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING, &Functions::uniform_buffers}};

bool has(const Functions& gl, const BufferTarget& target) {
  return target.needs == nullptr || gl.*target.needs;
}

struct Capability {
  GLenum name;
  bool initial;
  int version = 0;  // the OpenGL version that introduced it, 0: before 2.1; or the extension below
  int GladGLContext::*extension = nullptr;
  bool compatibility_only = false;  // unknown to core contexts
};

using G = GladGLContext;
constexpr Capability capabilities[] = {{GL_CULL_FACE, false},
                                       {GL_DEPTH_TEST, false},
                                       {GL_STENCIL_TEST, false},
                                       {GL_DEPTH_CLAMP, false, 32, &G::ARB_depth_clamp},
                                       {GL_DITHER, true},
                                       {GL_COLOR_LOGIC_OP, false},
                                       {GL_FRAMEBUFFER_SRGB, false, 30, &G::EXT_framebuffer_sRGB},
                                       {GL_MULTISAMPLE, true},
                                       {GL_SAMPLE_ALPHA_TO_COVERAGE, false},
                                       {GL_SAMPLE_ALPHA_TO_ONE, false},
                                       {GL_SAMPLE_COVERAGE, false},
                                       {GL_SAMPLE_MASK, false, 32, &G::ARB_texture_multisample},
                                       {GL_POLYGON_OFFSET_FILL, false},
                                       {GL_POLYGON_SMOOTH, false},
                                       {GL_PRIMITIVE_RESTART, false, 31},
                                       {GL_RASTERIZER_DISCARD, false, 30},
                                       {GL_SAMPLE_SHADING, false, 40, &G::ARB_sample_shading},
                                       {GL_PRIMITIVE_RESTART_FIXED_INDEX, false, 43, &G::ARB_ES3_compatibility},
                                       {GL_CLIP_DISTANCE0, false},
                                       {GL_CLIP_DISTANCE1, false},
                                       {GL_CLIP_DISTANCE2, false},
                                       {GL_CLIP_DISTANCE3, false},
                                       {GL_CLIP_DISTANCE4, false},
                                       {GL_CLIP_DISTANCE5, false},
                                       {GL_CLIP_DISTANCE6, false, 30},
                                       {GL_CLIP_DISTANCE7, false, 30},
                                       {GL_ALPHA_TEST, false, 0, nullptr, true},
                                       {GL_POLYGON_STIPPLE, false, 0, nullptr, true}};

bool has(const Functions& gl, const Capability& capability) {
  const bool there = gl.version >= capability.version || (capability.extension && gl.*capability.extension != 0);
  return there && !(capability.compatibility_only && gl.core_profile);
}

}  // namespace

FramebufferGuard::FramebufferGuard(const Functions& gl, StatePolicy policy) : gl_(gl) {
  if (policy == StatePolicy::leave) return;
  read_ = get_name(gl, gl.separate_framebuffers ? GL_READ_FRAMEBUFFER_BINDING : GL_FRAMEBUFFER_BINDING);
  draw_ = get_name(gl, GL_DRAW_FRAMEBUFFER_BINDING);
  renderbuffer_ = get_name(gl, GL_RENDERBUFFER_BINDING);
}

FramebufferGuard::~FramebufferGuard() {
  gl_.BindFramebuffer(gl_.read_framebuffer, read_);
  gl_.BindFramebuffer(gl_.draw_framebuffer, draw_);
  const bool exists = renderbuffer_ != 0 && gl_.IsRenderbuffer(renderbuffer_) == GL_TRUE;
  gl_.BindRenderbuffer(GL_RENDERBUFFER, exists ? renderbuffer_ : 0);
}

PixelTransferGuard::PixelTransferGuard(const Functions& gl, StatePolicy policy) : gl_(gl), policy_(policy) {
  if (policy == StatePolicy::restore) save();
  neutralize();
}

void PixelTransferGuard::save() {
  pack_buffer_ = get_name(gl_, GL_PIXEL_PACK_BUFFER_BINDING);
  unpack_buffer_ = get_name(gl_, GL_PIXEL_UNPACK_BUFFER_BINDING);
  clamp_read_ = gl_.clamp_read_color ? get_int(gl_, GL_CLAMP_READ_COLOR) : GL_FIXED_ONLY;
  for (size_t i = 0; i < store_count; ++i) store_[i] = get_int(gl_, store_names[i]);
  if (gl_.core_profile) return;
  for (size_t i = 0; i < scale_count; ++i) gl_.GetFloatv(scale_names[i], &transfer_[i]);
  for (size_t i = 0; i < map_count; ++i) transfer_maps_[i] = get_int(gl_, map_names[i]);
}

void PixelTransferGuard::neutralize() const {
  gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  if (gl_.clamp_read_color) gl_.ClampColor(GL_CLAMP_READ_COLOR, GL_FIXED_ONLY);
  for (const GLenum name : store_names)
    gl_.PixelStorei(name, name == GL_PACK_ALIGNMENT || name == GL_UNPACK_ALIGNMENT ? 4 : 0);
  if (gl_.core_profile) return;
  for (size_t i = 0; i < scale_count; ++i) gl_.PixelTransferf(scale_names[i], i % 2 == 0 ? 1.0f : 0.0f);
  for (const GLenum name : map_names) gl_.PixelTransferi(name, 0);
}

PixelTransferGuard::~PixelTransferGuard() {
  if (policy_ == StatePolicy::leave) {
    neutralize();
    return;
  }
  if (!gl_.core_profile) {
    for (size_t i = 0; i < scale_count; ++i) gl_.PixelTransferf(scale_names[i], transfer_[i]);
    for (size_t i = 0; i < map_count; ++i) gl_.PixelTransferi(map_names[i], transfer_maps_[i]);
  }
  for (size_t i = 0; i < store_count; ++i) gl_.PixelStorei(store_names[i], store_[i]);
  if (gl_.clamp_read_color) gl_.ClampColor(GL_CLAMP_READ_COLOR, static_cast<GLenum>(clamp_read_));
  bind_buffer(gl_, GL_PIXEL_UNPACK_BUFFER, unpack_buffer_);
  bind_buffer(gl_, GL_PIXEL_PACK_BUFFER, pack_buffer_);
}

TextureGuard::TextureGuard(const Functions& gl, uint32_t first_unit, uint32_t count, StatePolicy policy)
    : gl_(gl), first_unit_(first_unit), active_(GL_TEXTURE0), units_(count) {
  if (policy == StatePolicy::leave) return;
  active_ = get_name(gl, GL_ACTIVE_TEXTURE);
  for (uint32_t i = 0; i < count; ++i) {
    gl.ActiveTexture(GL_TEXTURE0 + first_unit + i);
    units_[i].texture_2d = get_name(gl, GL_TEXTURE_BINDING_2D);
    units_[i].texture_2d_array = get_name(gl, GL_TEXTURE_BINDING_2D_ARRAY);
    if (gl.samplers) units_[i].sampler = get_name(gl, GL_SAMPLER_BINDING);
  }
  gl.ActiveTexture(active_);
}

TextureGuard::~TextureGuard() {
  for (uint32_t i = 0; i < units_.size(); ++i) {
    const Unit& unit = units_[i];
    gl_.ActiveTexture(GL_TEXTURE0 + first_unit_ + i);
    bind_texture(gl_, GL_TEXTURE_2D, unit.texture_2d);
    bind_texture(gl_, GL_TEXTURE_2D_ARRAY, unit.texture_2d_array);
    if (!gl_.samplers) continue;
    const bool exists = unit.sampler != 0 && gl_.IsSampler(unit.sampler) == GL_TRUE;
    gl_.BindSampler(first_unit_ + i, exists ? unit.sampler : 0);
  }
  gl_.ActiveTexture(active_);
}

BufferGuard::BufferGuard(const Functions& gl, uint32_t indexed_count)
    : gl_(gl), indexed_(gl.uniform_buffers ? indexed_count : 0) {
  for (size_t i = 0; i < generic_.size(); ++i)
    if (has(gl, buffer_targets[i])) generic_[i] = get_name(gl, buffer_targets[i].binding);
  for (uint32_t i = 0; i < indexed_.size(); ++i) indexed_[i] = get_range(gl, uniform_point, i);
}

BufferGuard::~BufferGuard() {
  // Indexed points come first: binding one also changes the generic binding.
  for (uint32_t i = 0; i < indexed_.size(); ++i) bind_range(gl_, uniform_point, i, indexed_[i]);
  for (size_t i = 0; i < generic_.size(); ++i)
    if (has(gl_, buffer_targets[i])) bind_buffer(gl_, buffer_targets[i].name, generic_[i]);
}

StorageGuard::StorageGuard(const Functions& gl, uint32_t indexed_count, StatePolicy policy)
    : gl_(gl), indexed_(indexed_count) {
  if (policy == StatePolicy::leave) return;
  generic_ = get_name(gl, GL_SHADER_STORAGE_BUFFER_BINDING);
  for (uint32_t i = 0; i < indexed_.size(); ++i) indexed_[i] = get_range(gl, storage_point, i);
}

StorageGuard::~StorageGuard() {
  // Indexed points come first: binding one also changes the generic binding.
  for (uint32_t i = 0; i < indexed_.size(); ++i) bind_range(gl_, storage_point, i, indexed_[i]);
  bind_buffer(gl_, GL_SHADER_STORAGE_BUFFER, generic_);
}

ProgramGuard::ProgramGuard(const Functions& gl, StatePolicy policy)
    : gl_(gl), program_(policy == StatePolicy::leave ? 0 : get_name(gl, GL_CURRENT_PROGRAM)) {}

ProgramGuard::~ProgramGuard() {
  gl_.UseProgram(program_ != 0 && gl_.IsProgram(program_) == GL_TRUE ? program_ : 0);
}

DrawGuard::DrawGuard(const Functions& gl, StatePolicy policy) : gl_(gl), policy_(policy), program_(gl, policy) {
  if (policy == StatePolicy::restore) {
    vertex_array_ = gl.vertex_arrays ? get_name(gl, GL_VERTEX_ARRAY_BINDING) : 0;
    for (const Capability& capability : capabilities)
      capabilities_.push_back(has(gl, capability) && gl.IsEnabled(capability.name) == GL_TRUE);
    save_windows();
    save_fragment_tests();
  }
  neutralize();
}

DrawGuard::~DrawGuard() {
  if (policy_ == StatePolicy::leave) {
    neutralize();
  } else {
    restore_fragment_tests();
    restore_windows();
    for (size_t i = 0; i < capabilities_.size(); ++i)
      if (has(gl_, capabilities[i])) set_capability(gl_, capabilities[i].name, capabilities_[i]);
  }
  if (!gl_.vertex_arrays) return;
  gl_.BindVertexArray(vertex_array_ != 0 && gl_.IsVertexArray(vertex_array_) == GL_TRUE ? vertex_array_ : 0);
}

void DrawGuard::save_windows() {
  // glViewport and glScissor set every viewport of an array (4.1), so each must be known.
  const bool arrays = gl_.viewport_arrays;
  windows_.resize(arrays ? static_cast<size_t>(std::max(1, get_int(gl_, GL_MAX_VIEWPORTS))) : 1);
  for (GLuint i = 0; i < windows_.size(); ++i) {
    Window& window = windows_[i];
    if (arrays) {
      gl_.GetFloati_v(GL_VIEWPORT, i, window.viewport.data());
      gl_.GetIntegeri_v(GL_SCISSOR_BOX, i, window.scissor.data());
      window.scissor_test = gl_.IsEnabledi(GL_SCISSOR_TEST, i) == GL_TRUE;
    } else {
      gl_.GetFloatv(GL_VIEWPORT, window.viewport.data());
      gl_.GetIntegerv(GL_SCISSOR_BOX, window.scissor.data());
      window.scissor_test = gl_.IsEnabled(GL_SCISSOR_TEST) == GL_TRUE;
    }
  }
  if (gl_.clip_control) clip_control_ = {get_name(gl_, GL_CLIP_ORIGIN), get_name(gl_, GL_CLIP_DEPTH_MODE)};
}

void DrawGuard::restore_windows() const {
  for (GLuint i = 0; i < windows_.size(); ++i) {
    const Window& window = windows_[i];
    if (gl_.viewport_arrays) {
      gl_.ViewportIndexedfv(i, window.viewport.data());
      gl_.ScissorIndexedv(i, window.scissor.data());
      if (window.scissor_test) {
        gl_.Enablei(GL_SCISSOR_TEST, i);
      } else {
        gl_.Disablei(GL_SCISSOR_TEST, i);
      }
    } else {
      const auto& v = window.viewport;
      gl_.Viewport(static_cast<GLint>(v[0]), static_cast<GLint>(v[1]), static_cast<GLsizei>(v[2]),
                   static_cast<GLsizei>(v[3]));
      gl_.Scissor(window.scissor[0], window.scissor[1], window.scissor[2], window.scissor[3]);
      set_capability(gl_, GL_SCISSOR_TEST, window.scissor_test);
    }
  }
  if (gl_.clip_control) gl_.ClipControl(clip_control_[0], clip_control_[1]);
}

void DrawGuard::save_fragment_tests() {
  depth_function_ = get_name(gl_, GL_DEPTH_FUNC);
  depth_mask_ = get_bool(gl_, GL_DEPTH_WRITEMASK);
  GLint mode[2] = {GL_FILL, GL_FILL};
  gl_.GetIntegerv(GL_POLYGON_MODE, mode);
  polygon_mode_ = {static_cast<uint32_t>(mode[0]), static_cast<uint32_t>(mode[1])};
  gl_.GetFloatv(GL_BLEND_COLOR, blend_color_.data());
  if (clamps_fragments()) clamp_fragment_ = get_name(gl_, GL_CLAMP_FRAGMENT_COLOR);
  blends_.resize(static_cast<size_t>(std::max(1, get_int(gl_, GL_MAX_DRAW_BUFFERS))));
  constexpr GLenum equations[] = {GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA};
  constexpr GLenum factors[] = {GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA};
  for (GLuint i = 0; i < blends_.size(); ++i) {
    Blend& blend = blends_[i];
    blend.enabled = (gl_.indexed_enables ? gl_.IsEnabledi(GL_BLEND, i) : gl_.IsEnabled(GL_BLEND)) == GL_TRUE;
    if (gl_.indexed_enables)
      gl_.GetBooleani_v(GL_COLOR_WRITEMASK, i, blend.color_mask.data());
    else
      gl_.GetBooleanv(GL_COLOR_WRITEMASK, blend.color_mask.data());
    const auto get = [&](GLenum name) {
      if (gl_.version < 40) return get_name(gl_, name);
      GLint value = 0;
      gl_.GetIntegeri_v(name, i, &value);
      return static_cast<uint32_t>(value);
    };
    for (size_t k = 0; k < 2; ++k) blend.equation[k] = get(equations[k]);
    for (size_t k = 0; k < 4; ++k) blend.factors[k] = get(factors[k]);
  }
}

void DrawGuard::restore_fragment_tests() const {
  gl_.DepthFunc(depth_function_);
  gl_.DepthMask(gl_bool(depth_mask_));
  if (gl_.core_profile) {
    gl_.PolygonMode(GL_FRONT_AND_BACK, polygon_mode_[0]);
  } else {
    gl_.PolygonMode(GL_FRONT, polygon_mode_[0]);
    gl_.PolygonMode(GL_BACK, polygon_mode_[1]);
  }
  gl_.BlendColor(blend_color_[0], blend_color_[1], blend_color_[2], blend_color_[3]);
  if (clamps_fragments()) gl_.ClampColor(GL_CLAMP_FRAGMENT_COLOR, clamp_fragment_);
  for (GLuint i = 0; i < blends_.size(); ++i) {
    const Blend& blend = blends_[i];
    const auto& f = blend.factors;
    const auto& mask = blend.color_mask;
    if (gl_.indexed_enables) {
      blend.enabled ? gl_.Enablei(GL_BLEND, i) : gl_.Disablei(GL_BLEND, i);
      gl_.ColorMaski(i, mask[0], mask[1], mask[2], mask[3]);
    } else {
      set_capability(gl_, GL_BLEND, blend.enabled);
      gl_.ColorMask(mask[0], mask[1], mask[2], mask[3]);
    }
    if (gl_.version >= 40) {
      gl_.BlendEquationSeparatei(i, blend.equation[0], blend.equation[1]);
      gl_.BlendFuncSeparatei(i, f[0], f[1], f[2], f[3]);
    } else if (i == 0) {
      gl_.BlendEquationSeparate(blend.equation[0], blend.equation[1]);
      gl_.BlendFuncSeparate(f[0], f[1], f[2], f[3]);
    }
  }
}

void DrawGuard::neutralize() const {
  for (const Capability& capability : capabilities)
    if (has(gl_, capability)) set_capability(gl_, capability.name, capability.initial);
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.Disable(GL_BLEND);
  gl_.BlendEquation(GL_FUNC_ADD);
  gl_.BlendFunc(GL_ONE, GL_ZERO);
  gl_.BlendColor(0, 0, 0, 0);
  if (clamps_fragments()) gl_.ClampColor(GL_CLAMP_FRAGMENT_COLOR, GL_FIXED_ONLY);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_.DepthFunc(GL_LESS);
  gl_.DepthMask(GL_TRUE);
  gl_.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  if (gl_.clip_control) gl_.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

StencilGuard::StencilGuard(const Functions& gl) : gl_(gl) {
  faces_[0] = {get_name(gl, GL_STENCIL_FUNC),
               get_name(gl, GL_STENCIL_REF),
               get_mask(gl, GL_STENCIL_VALUE_MASK),
               get_mask(gl, GL_STENCIL_WRITEMASK),
               {get_name(gl, GL_STENCIL_FAIL), get_name(gl, GL_STENCIL_PASS_DEPTH_FAIL),
                get_name(gl, GL_STENCIL_PASS_DEPTH_PASS)}};
  faces_[1] = {get_name(gl, GL_STENCIL_BACK_FUNC),
               get_name(gl, GL_STENCIL_BACK_REF),
               get_mask(gl, GL_STENCIL_BACK_VALUE_MASK),
               get_mask(gl, GL_STENCIL_BACK_WRITEMASK),
               {get_name(gl, GL_STENCIL_BACK_FAIL), get_name(gl, GL_STENCIL_BACK_PASS_DEPTH_FAIL),
                get_name(gl, GL_STENCIL_BACK_PASS_DEPTH_PASS)}};
  gl.StencilFunc(GL_ALWAYS, 0, ~0u);
  gl.StencilMask(~0u);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
}

StencilGuard::~StencilGuard() {
  constexpr GLenum sides[] = {GL_FRONT, GL_BACK};
  for (size_t i = 0; i < faces_.size(); ++i) {
    const StencilFace& face = faces_[i];
    gl_.StencilFuncSeparate(sides[i], face.function, static_cast<GLint>(face.reference), face.value_mask);
    gl_.StencilMaskSeparate(sides[i], face.write_mask);
    gl_.StencilOpSeparate(sides[i], face.operations[0], face.operations[1], face.operations[2]);
  }
}

}  // namespace sideray::gl
