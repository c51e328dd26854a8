// Makes every call of the service in random host state, for every kind of inputs. The state must stay, or be left as
// the policy says without being queried. It must have no influence, and pending errors of the host must stay.
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>

#include "embed/hosts/small_host.h"
#include "embed/query_counter.h"
#include "gl/gl_contexts.h"
#include "gl/random_state.h"

namespace sideray::tests::state_test {
namespace {

constexpr uint32_t first_unit = 2;

// Returns whether sideray_service_bind() may make the difference.
bool is_bound_by_us(const std::string& difference) {
  const auto names = [&](uint32_t unit, GLenum target) {
    return difference.find(gl::unit_item(unit, target) + ":") == 0;
  };
  for (uint32_t unit = first_unit; unit < first_unit + 4; ++unit)
    if (names(unit, GL_TEXTURE_2D_ARRAY) || names(unit, GL_SAMPLER_BINDING)) return true;
  return names(first_unit + 4, GL_TEXTURE_2D) || names(first_unit + 4, GL_SAMPLER_BINDING);
}

// The state that SIDERAY_HOST_RESTORES may change (docs/embedding.md), by the names of read_state().
class Left {
 public:
  explicit Left(gl::State initial) : initial_(std::move(initial)) {}

  // Returns the faults in the state that a call left.
  std::vector<std::string> wrong(const std::string& call, const SmallHost::Case& c, const gl::State& before,
                                 const gl::State& after) const {
    std::vector<std::string> list;
    for (const auto& [name, value] : before) {
      if (told(name, after.at(name)) == told(name, value)) continue;
      if (!may_change(call, c, name))
        list.push_back(name + ": not to be touched");
      else if (after.at(name) != initial_.at(name) && !is_window(name))
        list.push_back(name + ": not as it is at first");
    }
    return list;
  }

 private:
  // Clamps colours: in compatibility contexts queries do so or not, by the bound framebuffer.
  static std::vector<double> told(const std::string& name, std::vector<double> value) {
    if (name == plain(GL_COLOR_CLEAR_VALUE) || name == plain(GL_BLEND_COLOR))
      for (double& v : value) v = std::clamp(v, 0.0, 1.0);
    return value;
  }
  static bool is_window(const std::string& name) {
    return name.starts_with("viewport ") || name == plain(GL_VIEWPORT) || name == plain(GL_SCISSOR_BOX);
  }
  static std::string plain(GLenum name) { return fmt::format("0x{:x}", name); }
  template <size_t n>
  static bool is_one_of(const GLenum (&names)[n], const std::string& name) {
    return std::any_of(names, names + n, [&](GLenum each) { return plain(each) == name; });
  }
  static bool is_pixel_transfer(const std::string& name) {
    constexpr GLenum names[] = {GL_PIXEL_PACK_BUFFER_BINDING,
                                GL_PIXEL_UNPACK_BUFFER_BINDING,
                                GL_CLAMP_READ_COLOR,
                                GL_PACK_SWAP_BYTES,
                                GL_PACK_LSB_FIRST,
                                GL_PACK_ROW_LENGTH,
                                GL_PACK_IMAGE_HEIGHT,
                                GL_PACK_SKIP_ROWS,
                                GL_PACK_SKIP_PIXELS,
                                GL_PACK_SKIP_IMAGES,
                                GL_PACK_ALIGNMENT,
                                GL_UNPACK_SWAP_BYTES,
                                GL_UNPACK_LSB_FIRST,
                                GL_UNPACK_ROW_LENGTH,
                                GL_UNPACK_IMAGE_HEIGHT,
                                GL_UNPACK_SKIP_ROWS,
                                GL_UNPACK_SKIP_PIXELS,
                                GL_UNPACK_SKIP_IMAGES,
                                GL_UNPACK_ALIGNMENT,
                                GL_RED_SCALE,
                                GL_RED_BIAS,
                                GL_GREEN_SCALE,
                                GL_GREEN_BIAS,
                                GL_BLUE_SCALE,
                                GL_BLUE_BIAS,
                                GL_ALPHA_SCALE,
                                GL_ALPHA_BIAS,
                                GL_DEPTH_SCALE,
                                GL_DEPTH_BIAS,
                                GL_MAP_COLOR,
                                GL_MAP_STENCIL,
                                GL_INDEX_SHIFT,
                                GL_INDEX_OFFSET};
    return is_one_of(names, name);
  }
  // The last three depend on the bound framebuffer.
  static bool is_framebuffer(const std::string& name) {
    constexpr GLenum names[] = {GL_READ_FRAMEBUFFER_BINDING,
                                GL_DRAW_FRAMEBUFFER_BINDING,
                                GL_RENDERBUFFER_BINDING,
                                GL_READ_BUFFER,
                                GL_DRAW_BUFFER0,
                                GL_DRAW_BUFFER1};
    return is_one_of(names, name);
  }
  static bool is_of_units(const std::string& name, uint32_t count) {
    for (uint32_t unit = 0; unit < count; ++unit)
      for (const GLenum target : {GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY, GL_SAMPLER_BINDING})
        if (name == gl::unit_item(unit, target)) return true;
    return name == plain(GL_ACTIVE_TEXTURE);
  }
  static bool is_of_draws(const std::string& name) {
    constexpr GLenum names[] = {GL_VERTEX_ARRAY_BINDING,
                                GL_ELEMENT_ARRAY_BUFFER_BINDING,
                                GL_SCISSOR_TEST,
                                GL_BLEND,
                                GL_BLEND_COLOR,
                                GL_CLAMP_FRAGMENT_COLOR,
                                GL_BLEND_SRC_RGB,
                                GL_BLEND_DST_RGB,
                                GL_BLEND_SRC_ALPHA,
                                GL_BLEND_DST_ALPHA,
                                GL_BLEND_EQUATION_RGB,
                                GL_BLEND_EQUATION_ALPHA,
                                GL_COLOR_WRITEMASK,
                                GL_DEPTH_TEST,
                                GL_DEPTH_FUNC,
                                GL_DEPTH_WRITEMASK,
                                GL_STENCIL_TEST,
                                GL_CULL_FACE,
                                GL_POLYGON_MODE,
                                GL_DEPTH_CLAMP,
                                GL_DITHER,
                                GL_COLOR_LOGIC_OP,
                                GL_FRAMEBUFFER_SRGB,
                                GL_MULTISAMPLE,
                                GL_SAMPLE_ALPHA_TO_COVERAGE,
                                GL_SAMPLE_ALPHA_TO_ONE,
                                GL_SAMPLE_COVERAGE,
                                GL_SAMPLE_MASK,
                                GL_POLYGON_OFFSET_FILL,
                                GL_POLYGON_SMOOTH,
                                GL_PRIMITIVE_RESTART,
                                GL_PRIMITIVE_RESTART_FIXED_INDEX,
                                GL_RASTERIZER_DISCARD,
                                GL_CLIP_DISTANCE0,
                                GL_CLIP_DISTANCE3,
                                GL_CLIP_DISTANCE7,
                                GL_ALPHA_TEST,
                                GL_POLYGON_STIPPLE,
                                GL_CLIP_ORIGIN,
                                GL_CLIP_DEPTH_MODE};
    return is_one_of(names, name) || is_window(name) || name.starts_with("draw buffer ");
  }
  static bool may_change(const std::string& call, const SmallHost::Case& c, const std::string& name) {
    const std::string inputs = c.name;
    if (call == "bind") return name == plain(GL_CURRENT_PROGRAM) || name == plain(GL_ACTIVE_TEXTURE);
    const bool moves = is_pixel_transfer(name) || is_framebuffer(name);
    if (call == "submit") {
      const bool copies = inputs.find("multisampled") == 0;
      return moves || is_of_units(name, 1) || (copies && (is_of_draws(name) || name == plain(GL_CURRENT_PROGRAM)));
    }
    if (call != "advance" && call != "wait") return false;
    return moves || is_of_units(name, 1);
  }

  gl::State initial_;
};

class ServiceState : public testing::TestWithParam<std::tuple<std::string, gl::Profile>> {
 protected:
  void SetUp() override {
    const auto& [name, profile] = GetParam();
    auto context = gl::open_context(name, profile);
    if (!context && profile == gl::Profile::core && gl::is_required(name)) FAIL() << "required context " << name;
    if (!context) GTEST_SKIP() << "no such context here: " << name;
    context->make_current();
    left_.emplace(gl::read_state(context->functions(), [] {}));
    host_.emplace(std::move(context));
    queries_.emplace(host_->context());
    shaker_.emplace(host_->gl);
    program_ = host_->program();
    ASSERT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{});
  }
  void TearDown() override {
    unsetenv("SIDERAY_TRANSPORT");
    program_ = gl::Program();
    shaker_.reset();
    queries_.reset();
    if (!host_) return;
    EXPECT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{});
    host_.reset();
  }

  void shake() {
    if (seed_ == 0) return;
    shaker_->random.seed(seed_ * 1000 + ++calls_);
    shaker_->shake_framebuffers();
    shaker_->shake_pixel_transfer();
    shaker_->shake_textures();
    shaker_->shake_buffers();
    shaker_->shake_draw();
    shaker_->shake_stencil();
    shaker_->shake_rest();
    shaker_->shake_rasterization();
  }

  // Calls `body` in random state, and returns its status.
  template <typename Body>
  sideray_status call(const char* what, const Body& body, bool binds = false) {
    const auto read = [&] { return gl::read_state(host_->gl, [&] { shaker_->bind_stencil_framebuffer(); }); };
    shake();
    const gl::State before = read();
    EXPECT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{}) << "the test itself";
    const sideray_status status = body();
    EXPECT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{}) << what;
    std::set<std::string> asked = queries_->take();
    const gl::State after = read();
    std::vector<std::string> changed =
        leaves_ ? left_->wrong(what, *case_, before, after) : gl::differences(before, after);
    if (binds) std::erase_if(changed, is_bound_by_us);
    asked.erase(fmt::format("glGetIntegerv(0x{:x})", GL_SAMPLES));  // of the frame's target
    // A program that is deleted must not be current: delete_program() of gl/resources/objects.cpp.
    if (what == std::string("destroy")) asked.erase(fmt::format("glGetIntegerv(0x{:x})", GL_CURRENT_PROGRAM));
    EXPECT_TRUE(leaves_ || what != std::string("submit") || !asked.empty()) << "queries are not seen";
    if (packs_ && what == std::string("submit")) asked.clear();  // what packing touches it puts back
    EXPECT_TRUE(!leaves_ || what == std::string("create") || asked.empty())
        << what << ": " << fmt::format("{}", fmt::join(asked, " "));
    EXPECT_EQ(changed, std::vector<std::string>{}) << what << ", seed " << seed_;
    return status;
  }

  sideray_ticket submit(sideray_service* service, const FrameInputs& in) {
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(call("submit", [&] { return submit_frame(service, in, ticket, &error); }), SIDERAY_OK)
        << error.message;
    return ticket;
  }

  // Returns the texels of two consecutive frames.
  std::vector<uint8_t> run(const SmallHost::Case& c, uint32_t seed,
                           sideray_state_policy policy = SIDERAY_SAVE_AND_RESTORE) {
    seed_ = seed, calls_ = 0;
    case_ = &c, leaves_ = policy == SIDERAY_HOST_RESTORES;
    const sideray_host_gl loader = queries_->host();
    sideray_service* service = nullptr;
    sideray_error error{};
    EXPECT_EQ(call("create", [&] { return sideray_service_create(host_->tracer(), &loader, &service, &error); }),
              SIDERAY_OK);
    std::vector<uint8_t> texels;
    for (const int32_t continues : {0, 1}) {
      FrameInputs in = host_->inputs();
      c.ask(*host_, in);
      in.frame.state_policy = policy;
      in.frame.continues = continues;
      in.frame.seed = 3 + static_cast<uint32_t>(continues);
      const sideray_ticket ticket = submit(service, in);
      for (int i = 0; i < 2; ++i)
        EXPECT_EQ(call("advance", [&] { return sideray_service_advance(service, &error); }), SIDERAY_OK);
      const auto wait_for_masks = [&] {
        return sideray_service_wait_jobs(service, ticket, SIDERAY_JOB_MASKS, -1, &error);
      };
      EXPECT_EQ(call("wait", wait_for_masks), SIDERAY_OK) << error.message;
      EXPECT_EQ(call("wait", [&] { return sideray_service_wait(service, ticket, -1, &error); }), SIDERAY_OK)
          << error.message;
      uint32_t jobs = 0;
      EXPECT_EQ(call("finished jobs", [&] { return sideray_service_finished_jobs(service, ticket, &jobs, &error); }),
                SIDERAY_OK);
      EXPECT_NE(jobs, 0u);
      FrameOutputs out;
      EXPECT_EQ(call("newest outputs", [&] { return newest_outputs(service, in.frame.view_id, out); }), SIDERAY_OK);
      const auto bind = [&] {
        return sideray_service_bind(service, in.frame.view_id, program_.id(), first_unit, &error);
      };
      // The program reads integers: such ids are refused, and nothing is changed then.
      const bool other_ids = in.layers && in.layers->float_ids;
      EXPECT_EQ(call("bind", bind, !other_ids), other_ids ? SIDERAY_INVALID_ARGUMENT : SIDERAY_OK) << error.message;
      const std::vector<uint8_t> frame = host_->texels(out);
      texels.insert(texels.end(), frame.begin(), frame.end());
    }
    FrameInputs in = host_->inputs();
    c.ask(*host_, in);
    in.frame.state_policy = policy;
    const sideray_ticket ticket = submit(service, in);
    EXPECT_EQ(call("cancel", [&] { return sideray_service_cancel(service, ticket, &error); }), SIDERAY_OK);
    EXPECT_EQ(call("wait", [&] { return sideray_service_wait(service, ticket, -1, &error); }), SIDERAY_CANCELLED);
    submit(service, in);
    // Deleting a bound object unbinds it.
    call(
        "destroy", [&] { return sideray_service_destroy(service), SIDERAY_OK; }, seed == 0);
    return texels;
  }

  std::optional<SmallHost> host_;
  std::optional<gl::Shaker> shaker_;
  std::optional<Left> left_;
  std::optional<QueryCounter> queries_;
  gl::Program program_;
  const SmallHost::Case* case_ = nullptr;
  bool leaves_ = false, packs_ = false;
  uint32_t seed_ = 0, calls_ = 0;
};

INSTANTIATE_TEST_SUITE_P(All, ServiceState,
                         testing::Combine(testing::ValuesIn(gl::driver_contexts()),
                                          testing::Values(gl::Profile::core, gl::Profile::compatibility)),
                         gl::name_of_driver_and_profile);

TEST_P(ServiceState, EveryCallLeavesAndTakesNothing) {
  constexpr const char* transports[] = {nullptr, "copy", "persistent"};
  for (const SmallHost::Case& c : SmallHost::cases()) {
    SCOPED_TRACE(c.name);
    setenv("SIDERAY_TRANSPORT", "copy", 1);
    const std::vector<uint8_t> still = run(c, 0);
    EXPECT_TRUE(std::any_of(still.begin(), still.end(), [](uint8_t b) { return b != 0; })) << "nothing to compare";
    for (uint32_t seed = 1; seed <= 3; ++seed) {
      const char* way = transports[seed - 1];
      if (way && way[0] == 'p' && !host_->gl.buffer_storage) continue;
      way ? setenv("SIDERAY_TRANSPORT", way, 1) : unsetenv("SIDERAY_TRANSPORT");
      EXPECT_EQ(SmallHost::difference(run(c, seed), still), "") << "seed " << seed;
    }
    if (HasFailure()) return;
  }
}

// Compares packing with itself, since some drivers round depth for shaders.
TEST_P(ServiceState, PackingLeavesAndTakesNothing) {
  if (!host_->gl.compute || !host_->gl.buffer_storage) GTEST_SKIP() << "the GPU packs nothing here";
  setenv("SIDERAY_TRANSPORT", "packed", 1);
  packs_ = true;
  for (const SmallHost::Case& c : SmallHost::cases()) {
    SCOPED_TRACE(c.name);
    const std::vector<uint8_t> still = run(c, 0);
    EXPECT_EQ(SmallHost::difference(run(c, 1), still), "");
    EXPECT_EQ(SmallHost::difference(run(c, 2, SIDERAY_HOST_RESTORES), still), "");
    if (HasFailure()) return;
  }
  unsetenv("SIDERAY_TRANSPORT");
  run(SmallHost::cases().front(), 3, SIDERAY_HOST_RESTORES);  // while it is measured
}

TEST_P(ServiceState, WhereTheHostRestoresNothingIsReadAndAsMuchAnswered) {
  setenv("SIDERAY_TRANSPORT", "copy", 1);
  for (const SmallHost::Case& c : SmallHost::cases()) {
    SCOPED_TRACE(c.name);
    const std::vector<uint8_t> still = run(c, 0);
    EXPECT_EQ(SmallHost::difference(run(c, 1, SIDERAY_HOST_RESTORES), still), "");
    if (HasFailure()) return;
  }
}

// Our calls must neither leave an OpenGL error nor remove one of the host.
TEST_P(ServiceState, ErrorsOfTheHostStayPending) {
  setenv("SIDERAY_TRANSPORT", "copy", 1);
  const gl::Functions& gl = host_->gl;
  const gl::Framebuffer empty(gl);
  const std::pair<GLenum, std::function<void()>> errors[] = {
      {GL_INVALID_ENUM, [&] { gl.Enable(GL_FLOAT); }},
      {GL_INVALID_VALUE, [&] { gl.LineWidth(-1.0f); }},
      {GL_INVALID_OPERATION, [&] { gl.UseProgram(0), gl.Uniform1i(0, 1); }},
      {GL_INVALID_FRAMEBUFFER_OPERATION,
       [&] {
         gl.BindFramebuffer(GL_FRAMEBUFFER, empty.id());
         gl.Clear(GL_COLOR_BUFFER_BIT);
         gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
       }},
      {GL_OUT_OF_MEMORY, [&] {
         const gl::Buffer buffer(gl);
         gl.BindBuffer(GL_ARRAY_BUFFER, buffer.id());
         gl.BufferData(GL_ARRAY_BUFFER, PTRDIFF_MAX / 4, nullptr, GL_STATIC_DRAW);
         gl.BindBuffer(GL_ARRAY_BUFFER, 0);
       }}};
  for (const auto& error : errors) {
    const auto pending = [&](const char* what, const auto& body) {
      error.second();
      EXPECT_EQ(body(), SIDERAY_OK) << what;
      EXPECT_EQ(gl.GetError(), error.first) << what;
      EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR}) << what;
    };
    const sideray_host_gl loader = host_->loader();
    sideray_service* service = nullptr;
    pending("create", [&] { return sideray_service_create(host_->tracer(), &loader, &service, nullptr); });
    FrameInputs in = host_->inputs();
    in.frame.state_policy = error.first == GL_INVALID_VALUE ? SIDERAY_HOST_RESTORES : SIDERAY_SAVE_AND_RESTORE;
    sideray_ticket ticket = 0;
    pending("submit", [&] { return submit_frame(service, in, ticket); });
    pending("wait", [&] { return sideray_service_wait_jobs(service, ticket, SIDERAY_JOB_LAYERS, -1, nullptr); });
    pending("wait", [&] { return sideray_service_wait(service, ticket, -1, nullptr); });
    pending("bind", [&] { return sideray_service_bind(service, 0, program_.id(), first_unit, nullptr); });
    pending("advance", [&] { return sideray_service_advance(service, nullptr); });
    pending("destroy", [&] { return sideray_service_destroy(service), SIDERAY_OK; });
  }
  host_->context().take_errors();
}

// Inputs with names that do not exist are refused, and leave no OpenGL errors.
TEST_P(ServiceState, NamesThatAreNotThereAreRefusedWithoutErrors) {
  setenv("SIDERAY_TRANSPORT", "copy", 1);
  const sideray_host_gl loader = host_->loader();
  sideray_service* service = nullptr;
  ASSERT_EQ(sideray_service_create(host_->tracer(), &loader, &service, nullptr), SIDERAY_OK);
  constexpr uint32_t none = 987654;
  void (*const name_none[])(FrameInputs&) = {[](FrameInputs& in) { in.frame.source.framebuffer = none; },
                                             [](FrameInputs& in) { in.frame.source.depth_texture = none; },
                                             [](FrameInputs& in) { in.frame.source.depth_renderbuffer = none; },
                                             [](FrameInputs& in) {
                                               in.reflections = sideray_reflection_inputs_defaults();
                                               in.reflections->normal_texture = none;
                                             }};
  for (const auto name : name_none) {
    FrameInputs in = host_->inputs();
    name(in);
    sideray_error error{};
    sideray_ticket ticket = 0;
    seed_ = 1;
    EXPECT_LT(submit_frame(service, in, ticket, &error), 0);
    EXPECT_EQ(host_->gl.GetError(), GLenum{GL_NO_ERROR});
    EXPECT_STRNE(error.message, "");
  }
  const uint32_t shader = host_->gl.CreateShader(GL_VERTEX_SHADER);
  GLint units = 0;
  host_->gl.GetIntegerv(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, &units);
  for (const auto& [program, unit] : {std::pair<uint32_t, uint32_t>{none, 0},
                                      {shader, 0},
                                      {program_.id(), static_cast<uint32_t>(units) - 2},
                                      {program_.id(), 0xffffffffu}}) {
    EXPECT_EQ(sideray_service_bind(service, 0, program, unit, nullptr), SIDERAY_INVALID_ARGUMENT);
    EXPECT_EQ(host_->gl.GetError(), GLenum{GL_NO_ERROR});
  }
  host_->gl.DeleteShader(shader);
  sideray_service_destroy(service);
  host_->context().take_errors();
}

}  // namespace
}  // namespace sideray::tests::state_test
