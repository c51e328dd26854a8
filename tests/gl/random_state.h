// Sets OpenGL state at random and reads it back from the driver, for the tests of the state guards.
#pragma once

#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray::gl {

using State = std::map<std::string, std::vector<double>>;

inline constexpr uint32_t unit_count = 28, uniform_points = 4, storage_points = 3;

// Of the state of one unit, as read_state() names it; a target of textures, or GL_SAMPLER_BINDING.
std::string unit_item(uint32_t unit, GLenum target);

// Reads the state. Queries of the stencil reference are clamped unless a framebuffer with a stencil buffer is bound.
State read_state(const Functions& gl, const std::function<void()>& bind_stencil_framebuffer);

// One line for each item that is not the same.
std::vector<std::string> differences(const State& before, const State& after);

// Objects to bind, and calls that set state at random.
class Shaker {
 public:
  explicit Shaker(const Functions& table) : gl(table) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, stencil_buffer.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, 1, 1);
    gl.BindFramebuffer(GL_FRAMEBUFFER, stencil_framebuffer.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, stencil_buffer.id());
    for (int i = 0; i < 3; ++i) {
      flat.emplace_back(gl);
      arrays.emplace_back(gl);
      samplers.emplace_back(gl);
      buffers.emplace_back(gl);
      framebuffers.emplace_back(gl);
      renderbuffers.emplace_back(gl);
      vertex_arrays.emplace_back(gl);
      for (const GLenum target : {GL_TEXTURE_3D, GL_TEXTURE_CUBE_MAP, GL_TEXTURE_RECTANGLE, GL_TEXTURE_BUFFER}) {
        others[target].emplace_back(gl);
        gl.BindTexture(target, others[target].back().id());
      }
      programs.emplace_back(gl, "shaken", "#version 330\nvoid main() { gl_Position = vec4(1.0); }\n",
                            "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n");
      gl.BindTexture(GL_TEXTURE_2D, flat.back().id());
      gl.BindTexture(GL_TEXTURE_2D_ARRAY, arrays.back().id());
      gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffers.back().id());
      gl.BindRenderbuffer(GL_RENDERBUFFER, renderbuffers.back().id());
      gl.BindVertexArray(vertex_arrays.back().id());
      gl.BindBuffer(GL_UNIFORM_BUFFER, buffers.back().id());
      gl.BufferData(GL_UNIFORM_BUFFER, 4096, nullptr, GL_STATIC_DRAW);
    }
  }

  bool coin() { return random() % 2 == 0; }
  int number(int first, int last) { return std::uniform_int_distribution(first, last)(random); }
  float real() { return static_cast<float>(number(-8, 8)) * 0.125f; }
  template <size_t n>
  GLenum pick(const GLenum (&list)[n]) {
    return list[static_cast<size_t>(number(0, static_cast<int>(n) - 1))];
  }
  template <typename T>
  uint32_t pick_or_zero(const std::vector<T>& list) {
    const int i = number(-1, static_cast<int>(list.size()) - 1);
    return i < 0 ? 0 : list[static_cast<size_t>(i)].id();
  }
  void toggle(GLenum capability) { coin() ? gl.Enable(capability) : gl.Disable(capability); }
  void toggle(GLenum capability, GLuint index) {
    coin() ? gl.Enablei(capability, index) : gl.Disablei(capability, index);
  }

  void shake_framebuffers() {
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, pick_or_zero(framebuffers));
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, pick_or_zero(framebuffers));
    gl.BindRenderbuffer(GL_RENDERBUFFER, pick_or_zero(renderbuffers));
  }

  void shake_pixel_transfer() {
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, pick_or_zero(buffers));
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, pick_or_zero(buffers));
    constexpr GLenum clamps[] = {GL_TRUE, GL_FALSE, GL_FIXED_ONLY};
    gl.ClampColor(GL_CLAMP_READ_COLOR, pick(clamps));
    for (const GLenum name : {GL_PACK_SWAP_BYTES, GL_PACK_LSB_FIRST, GL_UNPACK_SWAP_BYTES, GL_UNPACK_LSB_FIRST})
      gl.PixelStorei(name, coin());
    for (const GLenum name : {GL_PACK_ROW_LENGTH, GL_PACK_IMAGE_HEIGHT, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS,
                              GL_PACK_SKIP_IMAGES, GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_ROWS,
                              GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES})
      gl.PixelStorei(name, number(0, 100));
    for (const GLenum name : {GL_PACK_ALIGNMENT, GL_UNPACK_ALIGNMENT}) gl.PixelStorei(name, 1 << number(0, 3));
    if (gl.core_profile) return;
    for (const GLenum name : {GL_RED_SCALE, GL_RED_BIAS, GL_GREEN_SCALE, GL_GREEN_BIAS, GL_BLUE_SCALE, GL_BLUE_BIAS,
                              GL_ALPHA_SCALE, GL_ALPHA_BIAS, GL_DEPTH_SCALE, GL_DEPTH_BIAS})
      gl.PixelTransferf(name, real());
    for (const GLenum name : {GL_MAP_COLOR, GL_MAP_STENCIL}) gl.PixelTransferi(name, coin());
    for (const GLenum name : {GL_INDEX_SHIFT, GL_INDEX_OFFSET}) gl.PixelTransferi(name, number(-3, 3));
  }

  void shake_textures() {
    for (uint32_t unit = 0; unit < unit_count; ++unit) {
      gl.ActiveTexture(GL_TEXTURE0 + unit);
      gl.BindTexture(GL_TEXTURE_2D, pick_or_zero(flat));
      gl.BindTexture(GL_TEXTURE_2D_ARRAY, pick_or_zero(arrays));
      gl.BindSampler(unit, pick_or_zero(samplers));
    }
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(number(0, unit_count - 1)));
  }

  void shake_buffers() {
    for (uint32_t i = 0; i < uniform_points; ++i) {
      const uint32_t buffer = pick_or_zero(buffers);
      if (buffer != 0 && coin()) {
        gl.BindBufferRange(GL_UNIFORM_BUFFER, i, buffer, 256 * number(0, 3), 16 * number(1, 9));
      } else {
        gl.BindBufferBase(GL_UNIFORM_BUFFER, i, buffer);
      }
    }
    for (const GLenum target : {GL_ARRAY_BUFFER, GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, GL_UNIFORM_BUFFER})
      gl.BindBuffer(target, pick_or_zero(buffers));
  }

  void shake_program() { gl.UseProgram(pick_or_zero(programs)); }

  void shake_draw() {
    shake_program();
    gl.BindVertexArray(pick_or_zero(vertex_arrays));
    for (const GLenum name :
         {GL_CULL_FACE, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_DEPTH_CLAMP, GL_DITHER, GL_COLOR_LOGIC_OP,
          GL_FRAMEBUFFER_SRGB, GL_MULTISAMPLE, GL_SAMPLE_ALPHA_TO_COVERAGE, GL_SAMPLE_ALPHA_TO_ONE, GL_SAMPLE_COVERAGE,
          GL_SAMPLE_MASK, GL_POLYGON_OFFSET_FILL, GL_POLYGON_SMOOTH, GL_PRIMITIVE_RESTART, GL_RASTERIZER_DISCARD,
          GL_CLIP_DISTANCE0, GL_CLIP_DISTANCE3, GL_CLIP_DISTANCE7})
      toggle(name);
    if (gl.version >= 43) toggle(GL_PRIMITIVE_RESTART_FIXED_INDEX);
    shake_windows();
    shake_blending();
    shake_depth();
    constexpr GLenum modes[] = {GL_POINT, GL_LINE, GL_FILL};
    gl.PolygonMode(GL_FRONT_AND_BACK, pick(modes));
    if (gl.core_profile) return;
    gl.PolygonMode(GL_BACK, pick(modes));
    toggle(GL_ALPHA_TEST);
    toggle(GL_POLYGON_STIPPLE);
    constexpr GLenum clamps[] = {GL_TRUE, GL_FALSE, GL_FIXED_ONLY};
    gl.ClampColor(GL_CLAMP_FRAGMENT_COLOR, pick(clamps));
  }

  void shake_stencil() {
    constexpr GLenum operations[] = {GL_KEEP, GL_ZERO, GL_REPLACE, GL_INCR, GL_INVERT, GL_DECR_WRAP};
    constexpr GLuint masks[] = {0, 1, 0x3f, 0x80000000u, ~0u};
    for (const GLenum face : {GL_FRONT, GL_BACK}) {
      gl.StencilFuncSeparate(face, pick(functions), number(0, 255), pick(masks));
      gl.StencilMaskSeparate(face, pick(masks));
      gl.StencilOpSeparate(face, pick(operations), pick(operations), pick(operations));
    }
  }

  // Changes state that only the rasterizer touches or depends on, not the service.
  void shake_rasterization() {
    gl.CullFace(coin() ? GL_FRONT : GL_BACK);
    gl.FrontFace(coin() ? GL_CW : GL_CCW);
    gl.ProvokingVertex(coin() ? GL_FIRST_VERTEX_CONVENTION : GL_LAST_VERTEX_CONVENTION);
    constexpr GLenum hints[] = {GL_DONT_CARE, GL_FASTEST, GL_NICEST};
    gl.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, pick(hints));
    if (gl.version >= 46 && coin())
      gl.PolygonOffsetClamp(real(), real(), real());
    else
      gl.PolygonOffset(real(), real());
    gl.DepthRange(0.125 * number(0, 8), 0.125 * number(0, 8));
    for (GLuint i = 0; gl.version >= 41 && coin() && i < 16; ++i)
      gl.DepthRangeIndexed(i, 0.125 * number(0, 8), 0.125 * number(0, 8));
    if (gl.storage_buffers) shake_storage();
    if (gl.core_profile) return;
    for (uint32_t unit = 0; unit < unit_count; ++unit) {
      gl.ActiveTexture(GL_TEXTURE0 + unit);
      gl.TexEnvf(GL_TEXTURE_FILTER_CONTROL, GL_TEXTURE_LOD_BIAS, real());
    }
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(number(0, unit_count - 1)));
  }

  // Changes state that guards do not cover, because our code does not touch it.
  void shake_rest() {
    for (uint32_t unit = 0; unit < unit_count; ++unit) {
      gl.ActiveTexture(GL_TEXTURE0 + unit);
      for (const auto& [target, textures] : others) gl.BindTexture(target, pick_or_zero(textures));
    }
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(number(0, unit_count - 1)));
    gl.ClearDepth(0.125 * number(0, 8));
    gl.ClearStencil(number(0, 255));
    gl.ClearColor(real(), real(), real(), real());
    gl.LogicOp(coin() ? GL_XOR : GL_COPY);
    gl.PrimitiveRestartIndex(static_cast<GLuint>(number(0, 999)));
    gl.SampleCoverage(0.125f * static_cast<float>(number(0, 8)), coin());
    gl.SampleMaski(0, static_cast<GLbitfield>(random()));
    gl.PointSize(static_cast<float>(number(1, 5)));
    for (const GLenum target : {GL_TRANSFORM_FEEDBACK_BUFFER, GL_TEXTURE_BUFFER})
      gl.BindBuffer(target, pick_or_zero(buffers));
    toggle(GL_PROGRAM_POINT_SIZE);
    toggle(GL_LINE_SMOOTH);
    toggle(GL_POLYGON_OFFSET_LINE);
    toggle(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    if (gl.version >= 40) gl.MinSampleShading(0.125f * static_cast<float>(number(0, 8)));
    if (gl.version >= 40) gl.BindBuffer(GL_DRAW_INDIRECT_BUFFER, pick_or_zero(buffers));
    if (gl.core_profile) return;
    gl.ClampColor(GL_CLAMP_VERTEX_COLOR, coin() ? GL_TRUE : GL_FIXED_ONLY);
    gl.MatrixMode(coin() ? GL_PROJECTION : GL_MODELVIEW);
    gl.Color4f(real(), real(), real(), real());
    toggle(GL_FOG);
    toggle(GL_LIGHTING);
    toggle(GL_LIGHT0);
  }

  // With this one bound, queries of the stencil reference are not clamped.
  void bind_stencil_framebuffer() const { gl.BindFramebuffer(GL_FRAMEBUFFER, stencil_framebuffer.id()); }

  const Functions& gl;
  std::mt19937 random;

 private:
  void shake_storage() {
    for (uint32_t i = 0; i < storage_points; ++i) {
      const uint32_t buffer = pick_or_zero(buffers);
      if (buffer != 0 && coin())
        gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, i, buffer, 256 * number(0, 3), 16 * number(1, 9));
      else
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffer);
    }
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, pick_or_zero(buffers));
  }

  void shake_windows() {
    gl.Viewport(number(-9, 9), number(-9, 9), number(0, 99), number(0, 99));
    gl.Scissor(number(-9, 9), number(-9, 9), number(0, 99), number(0, 99));
    toggle(GL_SCISSOR_TEST);
    for (GLuint i = 0; gl.version >= 41 && coin() && i < 16; ++i) {
      gl.ViewportIndexedf(i, real(), real(), 10.5f + real(), 20.25f + real());
      gl.ScissorIndexed(i, number(0, 9), number(0, 9), number(0, 99), number(0, 99));
      toggle(GL_SCISSOR_TEST, i);
    }
    constexpr GLenum origins[] = {GL_LOWER_LEFT, GL_UPPER_LEFT}, depths[] = {GL_NEGATIVE_ONE_TO_ONE, GL_ZERO_TO_ONE};
    if (gl.clip_control) gl.ClipControl(pick(origins), pick(depths));
  }

  void shake_blending() {
    constexpr GLenum factors[] = {GL_ZERO,       GL_ONE,           GL_SRC_ALPHA, GL_ONE_MINUS_DST_COLOR,
                                  GL_SRC1_COLOR, GL_CONSTANT_ALPHA};
    constexpr GLenum equations[] = {GL_FUNC_ADD, GL_MIN, GL_MAX, GL_FUNC_REVERSE_SUBTRACT};
    gl.BlendColor(coin(), 0.25f, 0.5f, 0.75f);
    gl.BlendFuncSeparate(pick(factors), pick(factors), pick(factors), pick(factors));
    gl.BlendEquationSeparate(pick(equations), pick(equations));
    toggle(GL_BLEND);
    gl.ColorMask(coin(), coin(), coin(), coin());
    if (coin()) return;
    for (GLuint i = 0; i < 8; ++i) {
      toggle(GL_BLEND, i);
      gl.ColorMaski(i, coin(), coin(), coin(), coin());
      if (gl.version < 40) continue;
      gl.BlendFuncSeparatei(i, pick(factors), pick(factors), pick(factors), pick(factors));
      gl.BlendEquationSeparatei(i, pick(equations), pick(equations));
    }
  }

  void shake_depth() {
    gl.DepthFunc(pick(functions));
    gl.DepthMask(coin());
  }

  static constexpr GLenum functions[] = {GL_NEVER, GL_LESS, GL_EQUAL, GL_GEQUAL, GL_ALWAYS};
  Renderbuffer stencil_buffer{gl};
  Framebuffer stencil_framebuffer{gl};
  std::vector<Texture> flat, arrays;
  std::map<GLenum, std::vector<Texture>> others;
  std::vector<Sampler> samplers;
  std::vector<Buffer> buffers;
  std::vector<Framebuffer> framebuffers;
  std::vector<Renderbuffer> renderbuffers;
  std::vector<VertexArray> vertex_arrays;
  std::vector<Program> programs;
};

}  // namespace sideray::gl
