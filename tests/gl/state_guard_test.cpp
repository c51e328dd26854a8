// All state that the guards cover is set at random, dirtied at random under a guard, and compared as the driver tells
// it.
#include "gl/state_guard.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>

#include "gl/gl_contexts.h"

namespace sideray::gl {
namespace {

using State = std::map<std::string, std::vector<double>>;
using Random = std::mt19937;

constexpr uint32_t unit_count = 6, uniform_points = 4;

struct Named {
  GLenum name;
  int size;
};

// Names of state as glGet knows them; the list is kept apart from that of the guards on purpose.
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
                                 {GL_CLIP_DISTANCE7, 1}};

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
                                         {GL_POLYGON_MODE, 2}};

void read_plain(const Functions& gl, const Named& item, State& state) {
  std::vector<double> value(static_cast<size_t>(item.size));
  gl.GetDoublev(item.name, value.data());
  state[fmt::format("0x{:x}", item.name)] = value;
}

void read_textures(const Functions& gl, State& state) {
  GLint active = 0;
  gl.GetIntegerv(GL_ACTIVE_TEXTURE, &active);
  for (uint32_t unit = 0; unit < unit_count + 2; ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + unit);
    GLint values[4] = {};
    gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &values[0]);
    gl.GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &values[1]);
    gl.GetIntegerv(GL_SAMPLER_BINDING, &values[2]);
    gl.GetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &values[3]);
    state[fmt::format("unit {}", unit)] = std::vector<double>(values, values + 4);
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
  for (uint32_t i = 0; gl.version >= 41 && i < 16; ++i) {
    std::vector<double> values(9);
    GLint scissor[4] = {};
    float viewport[4] = {};
    gl.GetFloati_v(GL_VIEWPORT, i, viewport);
    gl.GetIntegeri_v(GL_SCISSOR_BOX, i, scissor);
    std::copy(viewport, viewport + 4, values.begin());
    std::copy(scissor, scissor + 4, values.begin() + 4);
    values[8] = gl.IsEnabledi(GL_SCISSOR_TEST, i);
    state[fmt::format("viewport {}", i)] = values;
  }
}

State read_state(const Functions& gl, const std::function<void()>& bind_stencil_framebuffer) {
  State state;
  for (const Named& item : plain_state) read_plain(gl, item, state);
  if (!gl.core_profile)
    for (const Named& item : compatibility_state) read_plain(gl, item, state);
  if (gl.clip_control)
    for (const GLenum name : {GL_CLIP_ORIGIN, GL_CLIP_DEPTH_MODE}) read_plain(gl, {name, 1}, state);
  if (gl.version >= 43) read_plain(gl, {GL_PRIMITIVE_RESTART_FIXED_INDEX, 1}, state);
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

  // With this one bound, queries of the stencil reference are not clamped.
  void bind_stencil_framebuffer() const { gl.BindFramebuffer(GL_FRAMEBUFFER, stencil_framebuffer.id()); }

  const Functions& gl;
  Random random;

 private:
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
  std::vector<Sampler> samplers;
  std::vector<Buffer> buffers;
  std::vector<Framebuffer> framebuffers;
  std::vector<Renderbuffer> renderbuffers;
  std::vector<VertexArray> vertex_arrays;
  std::vector<Program> programs;
};

class StateGuard : public testing::TestWithParam<std::tuple<std::string, Profile>> {
 protected:
  void SetUp() override {
    const auto& [name, profile] = GetParam();
    context = open_context(name, profile);
    if (context == nullptr && profile == Profile::core && is_required(name)) FAIL() << "required context " << name;
    if (context == nullptr) GTEST_SKIP() << "no such context here: " << name;
    shaker = std::make_unique<Shaker>(gl());
    ASSERT_EQ(take_problems(*context), std::vector<std::string>{});
  }
  void TearDown() override { shaker.reset(); }
  const Functions& gl() const { return context->functions(); }

  void shake_all() {
    shaker->shake_framebuffers();
    shaker->shake_pixel_transfer();
    shaker->shake_textures();
    shaker->shake_buffers();
    shaker->shake_draw();
    shaker->shake_stencil();
  }

  State read() const {
    return read_state(gl(), [this] { shaker->bind_stencil_framebuffer(); });
  }

  // `dirty` guards a scope and changes there what its guard covers.
  void expect_restored(const std::function<void()>& dirty) {
    for (uint32_t seed = 1; seed <= 40; ++seed) {
      shaker->random.seed(seed);
      shake_all();
      const State before = read();
      ASSERT_EQ(take_problems(*context), std::vector<std::string>{}) << "the test itself, seed " << seed;
      dirty();
      ASSERT_EQ(take_problems(*context), std::vector<std::string>{}) << "seed " << seed;
      ASSERT_EQ(differences(before, read()), std::vector<std::string>{}) << "seed " << seed;
    }
  }

  std::unique_ptr<Context> context;
  std::unique_ptr<Shaker> shaker;
};

INSTANTIATE_TEST_SUITE_P(All, StateGuard,
                         testing::Combine(testing::Values("surfaceless", "osmesa"),
                                          testing::Values(Profile::core, Profile::compatibility)),
                         [](const auto& suite) {
                           const bool core = std::get<1>(suite.param) == Profile::core;
                           return std::get<0>(suite.param) + (core ? "_core" : "_compatibility");
                         });

TEST_P(StateGuard, Framebuffers) {
  expect_restored([&] {
    const FramebufferGuard guard(gl());
    shaker->shake_framebuffers();
  });
}

TEST_P(StateGuard, PixelTransfer) {
  expect_restored([&] {
    const PixelTransferGuard guard(gl());
    shaker->shake_pixel_transfer();
  });
}

TEST_P(StateGuard, Textures) {
  expect_restored([&] {
    const TextureGuard guard(gl(), 0, unit_count);
    shaker->shake_textures();
  });
}

TEST_P(StateGuard, TexturesOfSomeUnits) {
  expect_restored([&] {
    const TextureGuard guard(gl(), 2, 3);
    for (uint32_t unit = 2; unit < 5; ++unit) {
      gl().ActiveTexture(GL_TEXTURE0 + unit);
      gl().BindTexture(GL_TEXTURE_2D, 0);
      gl().BindTexture(GL_TEXTURE_2D_ARRAY, 0);
      gl().BindSampler(unit, 0);
    }
  });
}

TEST_P(StateGuard, Buffers) {
  expect_restored([&] {
    const BufferGuard guard(gl(), uniform_points);
    shaker->shake_buffers();
  });
}

TEST_P(StateGuard, ProgramInUse) {
  expect_restored([&] {
    const ProgramGuard guard(gl());
    shaker->shake_program();
  });
}

TEST_P(StateGuard, Draw) {
  expect_restored([&] {
    const DrawGuard guard(gl());
    shaker->shake_draw();
  });
}

TEST_P(StateGuard, Stencil) {
  expect_restored([&] {
    const FramebufferGuard framebuffers(gl());
    shaker->bind_stencil_framebuffer();
    const StencilGuard guard(gl());
    shaker->shake_stencil();
  });
}

TEST_P(StateGuard, AllTogether) {
  expect_restored([&] {
    const FramebufferGuard framebuffers(gl());
    shaker->bind_stencil_framebuffer();
    const StencilGuard stencil(gl());
    const PixelTransferGuard pixels(gl());
    const TextureGuard textures(gl(), 0, unit_count);
    const BufferGuard buffers(gl(), uniform_points);
    const DrawGuard draw(gl());
    shake_all();
  });
}

// The comparison has to notice what no guard put back.
TEST_P(StateGuard, TheTestSeesUnguardedChanges) {
  shaker->random.seed(1);
  shake_all();
  const State before = read();
  shaker->shake_pixel_transfer();
  EXPECT_FALSE(differences(before, read()).empty());
}

// A whole pass under the guards, over random state, equals the pass in a fresh context.
TEST_P(StateGuard, PassesAreNotInfluencedByTheHost) {
  constexpr int side = 64;
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    shaker->random.seed(seed);
    shake_all();
    const State before = read();
    {
      const FramebufferGuard framebuffers(gl());
      const PixelTransferGuard pixels(gl());
      const TextureGuard textures(gl(), 0, 1);
      const BufferGuard buffers(gl());
      const DrawGuard draw(gl());
      gl().ActiveTexture(GL_TEXTURE0);
      float clear[4];
      gl().GetFloatv(GL_COLOR_CLEAR_VALUE, clear);
      const Target target(gl(), GL_RGBA8, side);
      draw_triangle(gl(), test_corners, "vec4(1.0, 0.0, 0.0, 1.0)");
      const std::vector<uint8_t> picture = target.read_rgba8();
      for (size_t i = 0; i < picture.size(); i += 4) {
        const int x = static_cast<int>(i / 4) % side, y = static_cast<int>(i / 4) / side;
        ASSERT_EQ(picture[i], in_test_triangle(x, y) ? 255 : 0) << x << ", " << y << ", seed " << seed;
      }
      gl().ClearColor(clear[0], clear[1], clear[2], clear[3]);
    }
    ASSERT_EQ(differences(before, read()), std::vector<std::string>{}) << "seed " << seed;
  }
  EXPECT_EQ(take_problems(*context), std::vector<std::string>{});
}

// A host may delete its program while it is in use; it lives until another one is used.
TEST_P(StateGuard, DeletedProgramCausesNoError) {
  Program program(gl(), "deleted", "#version 330\nvoid main() { gl_Position = vec4(1.0); }\n",
                  "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n");
  program.use();
  program = Program();
  {
    const ProgramGuard guard(gl());
    gl().UseProgram(0);
  }
  EXPECT_EQ(take_problems(*context), std::vector<std::string>{});
}

// glPixelTransfer alters depth on its way out; under the guard what is stored is what is read.
TEST_P(StateGuard, DepthReadbackIsNotScaled) {
  const Renderbuffer depth(gl());
  const Framebuffer framebuffer(gl());
  gl().BindRenderbuffer(GL_RENDERBUFFER, depth.id());
  gl().RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH32F_STENCIL8, 4, 4);
  gl().BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  gl().FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth.id());
  gl().DrawBuffer(GL_NONE);
  gl().ReadBuffer(GL_NONE);
  gl().ClearDepth(0.75);
  gl().ClearStencil(5);
  gl().Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  if (!gl().core_profile) {
    gl().PixelTransferf(GL_DEPTH_SCALE, 0.5f);
    gl().PixelTransferf(GL_DEPTH_BIAS, 0.1f);
    gl().PixelTransferi(GL_INDEX_OFFSET, 3);
  }
  gl().PixelStorei(GL_PACK_SKIP_ROWS, 7);
  const PixelTransferGuard guard(gl());
  std::vector<float> depths(16, -1.0f);
  std::vector<uint8_t> stencils(16, 0);
  gl().ReadPixels(0, 0, 4, 4, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  gl().ReadPixels(0, 0, 4, 4, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencils.data());
  EXPECT_EQ(depths, std::vector<float>(16, 0.75f));
  EXPECT_EQ(stencils, std::vector<uint8_t>(16, 5));
  EXPECT_EQ(take_problems(*context), std::vector<std::string>{});
}

}  // namespace
}  // namespace sideray::gl
