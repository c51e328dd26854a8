#include "gl/random_state.h"

#include <fmt/format.h>

#include <algorithm>

namespace sideray::gl {
namespace {

struct Named {
  GLenum name;
  int size;
};

// Names of state for glGet. The list is deliberately separate from that of the guards.
constexpr Named plain_state[] = {{GL_READ_FRAMEBUFFER_BINDING, 1},
                                 {GL_DRAW_FRAMEBUFFER_BINDING, 1},
                                 {GL_RENDERBUFFER_BINDING, 1},
                                 {GL_PIXEL_PACK_BUFFER_BINDING, 1},
                                 {GL_PIXEL_UNPACK_BUFFER_BINDING, 1},
                                 {GL_PACK_SWAP_BYTES, 1},
                                 {GL_PACK_LSB_FIRST, 1},
                                 {GL_PACK_ROW_LENGTH, 1},
                                 {GL_PACK_IMAGE_HEIGHT, 1},
                                 {GL_PACK_SKIP_ROWS, 1},
                                 {GL_PACK_SKIP_PIXELS, 1},
                                 {GL_PACK_SKIP_IMAGES, 1},
                                 {GL_PACK_ALIGNMENT, 1},
                                 {GL_UNPACK_SWAP_BYTES, 1},
                                 {GL_UNPACK_LSB_FIRST, 1},
                                 {GL_UNPACK_ROW_LENGTH, 1},
                                 {GL_UNPACK_IMAGE_HEIGHT, 1},
                                 {GL_UNPACK_SKIP_ROWS, 1},
                                 {GL_UNPACK_SKIP_PIXELS, 1},
                                 {GL_UNPACK_SKIP_IMAGES, 1},
                                 {GL_UNPACK_ALIGNMENT, 1},
                                 {GL_CLAMP_READ_COLOR, 1},
                                 {GL_ACTIVE_TEXTURE, 1},
                                 {GL_ARRAY_BUFFER_BINDING, 1},
                                 {GL_COPY_READ_BUFFER, 1},
                                 {GL_COPY_WRITE_BUFFER, 1},
                                 {GL_UNIFORM_BUFFER_BINDING, 1},
                                 {GL_CURRENT_PROGRAM, 1},
                                 {GL_VERTEX_ARRAY_BINDING, 1},
                                 {GL_ELEMENT_ARRAY_BUFFER_BINDING, 1},
                                 {GL_VIEWPORT, 4},
                                 {GL_SCISSOR_BOX, 4},
                                 {GL_SCISSOR_TEST, 1},
                                 {GL_BLEND, 1},
                                 {GL_BLEND_COLOR, 4},
                                 {GL_BLEND_SRC_RGB, 1},
                                 {GL_BLEND_DST_RGB, 1},
                                 {GL_BLEND_SRC_ALPHA, 1},
                                 {GL_BLEND_DST_ALPHA, 1},
                                 {GL_BLEND_EQUATION_RGB, 1},
                                 {GL_BLEND_EQUATION_ALPHA, 1},
                                 {GL_COLOR_WRITEMASK, 4},
                                 {GL_DEPTH_TEST, 1},
                                 {GL_DEPTH_FUNC, 1},
                                 {GL_DEPTH_WRITEMASK, 1},
                                 {GL_DEPTH_RANGE, 2},
                                 {GL_DEPTH_CLEAR_VALUE, 1},
                                 {GL_STENCIL_TEST, 1},
                                 {GL_STENCIL_FUNC, 1},
                                 {GL_STENCIL_VALUE_MASK, 1},
                                 {GL_STENCIL_WRITEMASK, 1},
                                 {GL_STENCIL_FAIL, 1},
                                 {GL_STENCIL_PASS_DEPTH_FAIL, 1},
                                 {GL_STENCIL_PASS_DEPTH_PASS, 1},
                                 {GL_STENCIL_BACK_FUNC, 1},

                                 {GL_STENCIL_BACK_VALUE_MASK, 1},
                                 {GL_STENCIL_BACK_WRITEMASK, 1},
                                 {GL_STENCIL_BACK_FAIL, 1},
                                 {GL_STENCIL_BACK_PASS_DEPTH_FAIL, 1},
                                 {GL_STENCIL_BACK_PASS_DEPTH_PASS, 1},
                                 {GL_STENCIL_CLEAR_VALUE, 1},
                                 {GL_COLOR_CLEAR_VALUE, 4},
                                 {GL_CULL_FACE, 1},
                                 {GL_CULL_FACE_MODE, 1},
                                 {GL_FRONT_FACE, 1},
                                 {GL_POLYGON_MODE, 1},
                                 {GL_DEPTH_CLAMP, 1},
                                 {GL_DITHER, 1},
                                 {GL_COLOR_LOGIC_OP, 1},
                                 {GL_LOGIC_OP_MODE, 1},
                                 {GL_FRAMEBUFFER_SRGB, 1},
                                 {GL_MULTISAMPLE, 1},
                                 {GL_SAMPLE_ALPHA_TO_COVERAGE, 1},
                                 {GL_SAMPLE_ALPHA_TO_ONE, 1},
                                 {GL_SAMPLE_COVERAGE, 1},
                                 {GL_SAMPLE_MASK, 1},
                                 {GL_POLYGON_OFFSET_FILL, 1},
                                 {GL_POLYGON_OFFSET_FACTOR, 1},
                                 {GL_POLYGON_SMOOTH, 1},
                                 {GL_PRIMITIVE_RESTART, 1},
                                 {GL_RASTERIZER_DISCARD, 1},
                                 {GL_CLIP_DISTANCE0, 1},
                                 {GL_CLIP_DISTANCE3, 1},
                                 {GL_CLIP_DISTANCE7, 1},
                                 {GL_POLYGON_OFFSET_UNITS, 1},
                                 {GL_PROVOKING_VERTEX, 1},
                                 {GL_FRAGMENT_SHADER_DERIVATIVE_HINT, 1},
                                 {GL_PRIMITIVE_RESTART_INDEX, 1},
                                 {GL_SAMPLE_COVERAGE_VALUE, 1},
                                 {GL_SAMPLE_COVERAGE_INVERT, 1},
                                 {GL_POINT_SIZE, 1},
                                 {GL_LINE_WIDTH, 1},
                                 {GL_TRANSFORM_FEEDBACK_BUFFER_BINDING, 1},
                                 {GL_TEXTURE_BUFFER, 1},
                                 {GL_PROGRAM_POINT_SIZE, 1},
                                 {GL_LINE_SMOOTH, 1},
                                 {GL_POLYGON_OFFSET_LINE, 1},
                                 {GL_TEXTURE_CUBE_MAP_SEAMLESS, 1},
                                 {GL_READ_BUFFER, 1},
                                 {GL_DRAW_BUFFER0, 1},
                                 {GL_DRAW_BUFFER1, 1}};

constexpr Named compatibility_state[] = {{GL_RED_SCALE, 1},
                                         {GL_RED_BIAS, 1},
                                         {GL_GREEN_SCALE, 1},
                                         {GL_GREEN_BIAS, 1},
                                         {GL_BLUE_SCALE, 1},
                                         {GL_BLUE_BIAS, 1},
                                         {GL_ALPHA_SCALE, 1},
                                         {GL_ALPHA_BIAS, 1},
                                         {GL_DEPTH_SCALE, 1},
                                         {GL_DEPTH_BIAS, 1},
                                         {GL_MAP_COLOR, 1},
                                         {GL_MAP_STENCIL, 1},
                                         {GL_INDEX_SHIFT, 1},
                                         {GL_INDEX_OFFSET, 1},
                                         {GL_ALPHA_TEST, 1},
                                         {GL_POLYGON_STIPPLE, 1},
                                         {GL_PIXEL_MAP_S_TO_S_SIZE, 1},
                                         {GL_MATRIX_MODE, 1},
                                         {GL_CURRENT_COLOR, 4},
                                         {GL_FOG, 1},
                                         {GL_LIGHTING, 1},
                                         {GL_LIGHT0, 1},
                                         {GL_CLAMP_VERTEX_COLOR, 1},
                                         {GL_CLAMP_FRAGMENT_COLOR, 1},
                                         {GL_POLYGON_MODE, 2}};

constexpr std::pair<GLenum, GLenum> unit_bindings[] = {{GL_TEXTURE_1D, GL_TEXTURE_BINDING_1D},
                                                       {GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D},
                                                       {GL_TEXTURE_3D, GL_TEXTURE_BINDING_3D},
                                                       {GL_TEXTURE_1D_ARRAY, GL_TEXTURE_BINDING_1D_ARRAY},
                                                       {GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BINDING_2D_ARRAY},
                                                       {GL_TEXTURE_CUBE_MAP, GL_TEXTURE_BINDING_CUBE_MAP},
                                                       {GL_TEXTURE_RECTANGLE, GL_TEXTURE_BINDING_RECTANGLE},
                                                       {GL_TEXTURE_BUFFER, GL_TEXTURE_BINDING_BUFFER},
                                                       {GL_TEXTURE_2D_MULTISAMPLE, GL_TEXTURE_BINDING_2D_MULTISAMPLE},
                                                       {GL_SAMPLER_BINDING, GL_SAMPLER_BINDING}};

void read_plain(const Functions& gl, const Named& item, State& state) {
  // Room for more than is asked: some drivers give GL_POLYGON_MODE of core profiles two values too.
  std::vector<double> value(static_cast<size_t>(item.size) + 4);
  gl.GetDoublev(item.name, value.data());
  value.resize(static_cast<size_t>(item.size));
  state[fmt::format("0x{:x}", item.name)] = value;
}

void read_textures(const Functions& gl, State& state) {
  GLint active = 0;
  gl.GetIntegerv(GL_ACTIVE_TEXTURE, &active);
  for (uint32_t unit = 0; unit < unit_count + 2; ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + unit);
    for (const auto& [target, binding] : unit_bindings) {
      GLint name = 0;
      gl.GetIntegerv(binding, &name);
      state[unit_item(unit, target)] = {static_cast<double>(name)};
    }
    float bias = 0;
    if (!gl.core_profile) gl.GetTexEnvfv(GL_TEXTURE_FILTER_CONTROL, GL_TEXTURE_LOD_BIAS, &bias);
    state[fmt::format("unit {} level bias", unit)] = {static_cast<double>(bias)};
  }
  gl.ActiveTexture(static_cast<GLenum>(active));
}

void read_indexed(const Functions& gl, State& state) {
  for (uint32_t i = 0; i < uniform_points; ++i) {
    GLint64 values[3] = {};
    gl.GetInteger64i_v(GL_UNIFORM_BUFFER_BINDING, i, &values[0]);
    gl.GetInteger64i_v(GL_UNIFORM_BUFFER_START, i, &values[1]);
    gl.GetInteger64i_v(GL_UNIFORM_BUFFER_SIZE, i, &values[2]);
    state[fmt::format("uniform buffer {}", i)] = std::vector<double>(values, values + 3);
  }
  GLint samples = 0;
  gl.GetIntegeri_v(GL_SAMPLE_MASK_VALUE, 0, &samples);
  state["sample mask"] = {static_cast<double>(samples)};
  for (uint32_t i = 0; i < 8; ++i) {
    GLboolean mask[4] = {};
    gl.GetBooleani_v(GL_COLOR_WRITEMASK, i, mask);
    std::vector<double> values(mask, mask + 4);
    values.push_back(gl.IsEnabledi(GL_BLEND, i));
    if (gl.version >= 40)
      for (const GLenum name : {GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA,
                                GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA}) {
        GLint value = 0;
        gl.GetIntegeri_v(name, i, &value);
        values.push_back(value);
      }
    state[fmt::format("draw buffer {}", i)] = values;
  }
  for (uint32_t i = 0; gl.storage_buffers && i < storage_points; ++i) {
    GLint64 values[3] = {};
    gl.GetInteger64i_v(GL_SHADER_STORAGE_BUFFER_BINDING, i, &values[0]);
    gl.GetInteger64i_v(GL_SHADER_STORAGE_BUFFER_START, i, &values[1]);
    gl.GetInteger64i_v(GL_SHADER_STORAGE_BUFFER_SIZE, i, &values[2]);
    state[fmt::format("storage buffer {}", i)] = std::vector<double>(values, values + 3);
  }
  for (uint32_t i = 0; gl.version >= 41 && i < 16; ++i) {
    std::vector<double> values(11);
    GLint scissor[4] = {};
    float viewport[4] = {};
    gl.GetFloati_v(GL_VIEWPORT, i, viewport);
    gl.GetIntegeri_v(GL_SCISSOR_BOX, i, scissor);
    std::copy(viewport, viewport + 4, values.begin());
    std::copy(scissor, scissor + 4, values.begin() + 4);
    values[8] = gl.IsEnabledi(GL_SCISSOR_TEST, i);
    gl.GetDoublei_v(GL_DEPTH_RANGE, i, &values[9]);
    state[fmt::format("viewport {}", i)] = values;
  }
}

}  // namespace

std::string unit_item(uint32_t unit, GLenum target) {
  return fmt::format("unit {} 0x{:x}", unit, target);
}

State read_state(const Functions& gl, const std::function<void()>& bind_stencil_framebuffer) {
  State state;
  for (const Named& item : plain_state) read_plain(gl, item, state);
  if (!gl.core_profile)
    for (const Named& item : compatibility_state) read_plain(gl, item, state);
  if (gl.clip_control)
    for (const GLenum name : {GL_CLIP_ORIGIN, GL_CLIP_DEPTH_MODE}) read_plain(gl, {name, 1}, state);
  if (gl.version >= 43) read_plain(gl, {GL_PRIMITIVE_RESTART_FIXED_INDEX, 1}, state);
  if (gl.storage_buffers) read_plain(gl, {GL_SHADER_STORAGE_BUFFER_BINDING, 1}, state);
  if (gl.version >= 46) read_plain(gl, {GL_POLYGON_OFFSET_CLAMP, 1}, state);
  if (gl.version >= 40)
    for (const GLenum name : {GL_MIN_SAMPLE_SHADING_VALUE, GL_DRAW_INDIRECT_BUFFER_BINDING, GL_PATCH_VERTICES})
      read_plain(gl, {name, 1}, state);
  if (gl.version >= 41) read_plain(gl, {GL_PROGRAM_PIPELINE_BINDING, 1}, state);
  read_textures(gl, state);
  read_indexed(gl, state);
  GLint read = 0, draw = 0;
  gl.GetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read);
  gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
  bind_stencil_framebuffer();
  for (const GLenum name : {GL_STENCIL_REF, GL_STENCIL_BACK_REF}) read_plain(gl, {name, 1}, state);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read));
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw));
  return state;
}

std::vector<std::string> differences(const State& before, const State& after) {
  std::vector<std::string> list;
  for (const auto& [name, value] : before)
    if (const auto& now = after.at(name); now != value)
      list.push_back(fmt::format("{}: {} became {}", name, fmt::join(value, " "), fmt::join(now, " ")));
  return list;
}

}  // namespace sideray::gl
