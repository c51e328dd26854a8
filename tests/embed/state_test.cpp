// Every call of the service amid a host's random state, for every kind of input: the state stays as it was, has no
// influence, and errors that the host has pending are still there.
#include <gmock/gmock.h>

#include <cstdlib>

#include "gl/gl_contexts.h"
#include "gl/random_state.h"
#include "small_host.h"

namespace sideray::tests {
namespace {

constexpr uint32_t first_unit = 2;

// What sideray_service_bind() is there to change.
bool is_bound_by_us(const std::string& difference) {
  const auto names = [&](uint32_t unit, GLenum target) {
    return difference.find(gl::unit_item(unit, target) + ":") == 0;
  };
  for (uint32_t unit = first_unit; unit < first_unit + 4; ++unit)
    if (names(unit, GL_TEXTURE_2D_ARRAY) || names(unit, GL_SAMPLER_BINDING)) return true;
  return names(first_unit + 4, GL_TEXTURE_2D) || names(first_unit + 4, GL_SAMPLER_BINDING);
}

class ServiceState : public testing::TestWithParam<std::tuple<std::string, gl::Profile>> {
 protected:
  void SetUp() override {
    const auto& [name, profile] = GetParam();
    auto context = gl::open_context(name, profile);
    if (!context && profile == gl::Profile::core && gl::is_required(name)) FAIL() << "required context " << name;
    if (!context) GTEST_SKIP() << "no such context here: " << name;
    host_.emplace(std::move(context));
    shaker_.emplace(host_->gl);
    program_ = host_->program();
    ASSERT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{});
  }
  void TearDown() override {
    unsetenv("SIDERAY_TRANSPORT");
    program_ = gl::Program();
    shaker_.reset();
    if (!host_) return;
    EXPECT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{});
    host_.reset();
  }

  void shake() {
    if (seed_ == 0) return;
    shaker_->random.seed(seed_ * 1000 + ++calls_);
    shaker_->shake_framebuffers(), shaker_->shake_pixel_transfer(), shaker_->shake_textures();
    shaker_->shake_buffers(), shaker_->shake_draw(), shaker_->shake_stencil(), shaker_->shake_rest();
  }

  // Whatever `body` returns, as it is called amid random state.
  template <typename Body>
  sideray_status call(const char* what, const Body& body, bool binds = false) {
    const auto read = [&] { return gl::read_state(host_->gl, [&] { shaker_->bind_stencil_framebuffer(); }); };
    shake();
    const gl::State before = read();
    EXPECT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{}) << "the test itself";
    const sideray_status status = body();
    EXPECT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{}) << what;
    std::vector<std::string> changed = gl::differences(before, read());
    if (binds) std::erase_if(changed, is_bound_by_us);
    EXPECT_EQ(changed, std::vector<std::string>{}) << what << ", seed " << seed_;
    return status;
  }

  sideray_ticket submit(sideray_service* service, const sideray_frame_inputs& in) {
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(call("submit", [&] { return sideray_service_submit(service, &in, &ticket, &error); }), SIDERAY_OK)
        << error.message;
    return ticket;
  }

  // The texels of two frames that follow each other.
  std::vector<uint8_t> run(const SmallHost::Case& c, uint32_t seed) {
    seed_ = seed, calls_ = 0;
    const sideray_host_gl loader = host_->loader();
    sideray_service* service = nullptr;
    sideray_error error{};
    EXPECT_EQ(call("create", [&] { return sideray_service_create(host_->tracer(), &loader, &service, &error); }),
              SIDERAY_OK);
    std::vector<uint8_t> texels;
    for (const int32_t continues : {0, 1}) {
      sideray_frame_inputs in = host_->inputs();
      c.ask(*host_, in);
      in.continues = continues, in.seed = 3 + static_cast<uint32_t>(continues);
      const sideray_ticket ticket = submit(service, in);
      for (int i = 0; i < 2; ++i)
        EXPECT_EQ(call("advance", [&] { return sideray_service_advance(service, &error); }), SIDERAY_OK);
      EXPECT_EQ(call("wait", [&] { return sideray_service_wait(service, ticket, -1, &error); }), SIDERAY_OK)
          << error.message;
      sideray_frame_outputs out{};
      out.size = sizeof(out);
      EXPECT_EQ(call("latest", [&] { return sideray_service_latest(service, &out, &error); }), SIDERAY_OK);
      const auto bind = [&] { return sideray_service_bind(service, program_.id(), first_unit, &error); };
      EXPECT_EQ(call("bind", bind, true), SIDERAY_OK) << error.message;
      const std::vector<uint8_t> frame = host_->texels(out);
      texels.insert(texels.end(), frame.begin(), frame.end());
    }
    sideray_frame_inputs in = host_->inputs();
    c.ask(*host_, in);
    const sideray_ticket ticket = submit(service, in);
    EXPECT_EQ(call("cancel", [&] { return sideray_service_cancel(service, ticket, &error); }), SIDERAY_OK);
    EXPECT_EQ(call("wait", [&] { return sideray_service_wait(service, ticket, -1, &error); }), SIDERAY_CANCELLED);
    submit(service, in);
    // What is deleted while it is bound is not bound any more.
    call(
        "destroy", [&] { return sideray_service_destroy(service), SIDERAY_OK; }, seed == 0);
    return texels;
  }

  std::optional<SmallHost> host_;
  std::optional<gl::Shaker> shaker_;
  gl::Program program_;
  uint32_t seed_ = 0, calls_ = 0;
};

INSTANTIATE_TEST_SUITE_P(All, ServiceState,
                         testing::Combine(testing::ValuesIn(gl::driver_contexts()),
                                          testing::Values(gl::Profile::core, gl::Profile::compatibility)),
                         [](const auto& suite) {
                           const bool core = std::get<1>(suite.param) == gl::Profile::core;
                           return std::get<0>(suite.param) + (core ? "_core" : "_compatibility");
                         });

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
      EXPECT_EQ(run(c, seed) == still, true) << "texels differ, seed " << seed;
    }
    if (HasFailure()) return;
  }
}

// A host that finds an error after one of our calls must find its own, and a host that has one must not lose it.
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
  for (const auto& [code, cause] : errors) {
    const auto pending = [&](const char* what, const auto& body) {
      cause();
      EXPECT_EQ(body(), SIDERAY_OK) << what;
      EXPECT_EQ(gl.GetError(), code) << what;
      EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR}) << what;
    };
    const sideray_host_gl loader = host_->loader();
    sideray_service* service = nullptr;
    pending("create", [&] { return sideray_service_create(host_->tracer(), &loader, &service, nullptr); });
    sideray_frame_inputs in = host_->inputs();
    sideray_ticket ticket = 0;
    pending("submit", [&] { return sideray_service_submit(service, &in, &ticket, nullptr); });
    pending("wait", [&] { return sideray_service_wait(service, ticket, -1, nullptr); });
    pending("bind", [&] { return sideray_service_bind(service, program_.id(), first_unit, nullptr); });
    pending("advance", [&] { return sideray_service_advance(service, nullptr); });
    pending("destroy", [&] { return sideray_service_destroy(service), SIDERAY_OK; });
  }
  host_->context().take_errors();
}

// Inputs that name what is not there are refused, and the driver's errors about them do not get out.
TEST_P(ServiceState, NamesThatAreNotThereAreRefusedWithoutErrors) {
  setenv("SIDERAY_TRANSPORT", "copy", 1);
  const sideray_host_gl loader = host_->loader();
  sideray_service* service = nullptr;
  ASSERT_EQ(sideray_service_create(host_->tracer(), &loader, &service, nullptr), SIDERAY_OK);
  constexpr uint32_t none = 987654;
  uint32_t sideray_frame_inputs::*const names[] = {
      &sideray_frame_inputs::framebuffer, &sideray_frame_inputs::depth_texture,
      &sideray_frame_inputs::depth_renderbuffer, &sideray_frame_inputs::reflection_normals};
  for (const auto name : names) {
    sideray_frame_inputs in = host_->inputs();
    in.*name = none;
    sideray_error error{};
    sideray_ticket ticket = 0;
    seed_ = 1;
    EXPECT_LT(sideray_service_submit(service, &in, &ticket, &error), 0);
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
    EXPECT_EQ(sideray_service_bind(service, program, unit, nullptr), SIDERAY_INVALID_ARGUMENT);
    EXPECT_EQ(host_->gl.GetError(), GLenum{GL_NO_ERROR});
  }
  host_->gl.DeleteShader(shader);
  sideray_service_destroy(service);
  host_->context().take_errors();
}

}  // namespace
}  // namespace sideray::tests
