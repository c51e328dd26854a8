// Tests the host's shader inside a service: its threads and calls, that nothing hangs while it is awaited, and
// unsupported inputs.
#include <gmock/gmock.h>

#include <atomic>
#include <future>
#include <mutex>
#include <set>
#include <thread>

#include "embed/hosts/glass_host.h"
#include "embed/hosts/small_host.h"

namespace sideray::tests {
namespace {

using std::chrono::milliseconds;

constexpr float radiance[3] = {0.5f, 1.5f, 0.25f};

// A shader that records its thread, and whether the host was inside a call of Sideray.
struct Shader {
  std::atomic<bool> in_call{false}, hold{false};
  std::atomic<uint32_t> begun{0}, ended{0}, outside{0};
  std::mutex mutex{};
  std::set<std::thread::id> threads{};

  static void call(void* user, const sideray_shading_point*, size_t count, sideray_shading_result* results) {
    auto& shader = *static_cast<Shader*>(user);
    ++shader.begun;
    shader.outside += !shader.in_call;
    while (shader.hold) std::this_thread::sleep_for(milliseconds(1));
    for (size_t i = 0; i < count; ++i) std::copy(radiance, radiance + 3, results[i].radiance);
    const std::lock_guard lock(shader.mutex);
    shader.threads.insert(std::this_thread::get_id());
    ++shader.ended;
  }
  sideray_shader_desc desc(sideray_shader_thread thread) {
    sideray_shader_desc d = sideray_shader_defaults();
    d.shade = call, d.user = this, d.thread = thread;
    d.radiance_space = SIDERAY_SPACE_GAMMA22;
    return d;
  }
};

class HostShading : public testing::Test {
 protected:
  HostShading() : depth_(host_.gl) {
    const gl::Functions& gl = host_.gl;
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, GlassHost::width, GlassHost::height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, host_.framebuffer());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    gl.Clear(GL_DEPTH_BUFFER_BIT);
  }
  void use(sideray_shader_thread thread) {
    host_.scene().set_shader(shader_.desc(thread));
    host_.scene().commit();
  }
  sideray_ticket submit() {
    const FrameInputs in = host_.inputs();
    return host_.service().submit(in).value();
  }
  // Calls advance() until part of the frame waits for the host, and a while longer: it must not continue by itself.
  void let_batches_wait() {
    shader_.in_call = true;
    host_.service().advance();
    shader_.in_call = false;
    std::this_thread::sleep_for(milliseconds(30));
  }
  // Returns the cached value in the pane's middle.
  glm::vec4 seen() {
    const auto out = host_.service().layers().value();
    host_.gl.BindTexture(GL_TEXTURE_2D_ARRAY, out.radiance_texture);
    std::vector<glm::vec4> texels(size_t{GlassHost::width} * GlassHost::height);
    host_.gl.GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA, GL_FLOAT, texels.data());
    host_.gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return texels[texels.size() / 2 + GlassHost::width / 2];
  }

  Shader shader_;
  GlassHost host_;
  gl::Renderbuffer depth_;
};

TEST_F(HostShading, RunsOnWorkersWhereNothingElseIsSaid) {
  use(SIDERAY_SHADE_ON_WORKERS);
  const sideray_ticket ticket = submit();
  ASSERT_TRUE(host_.service().wait(ticket));
  EXPECT_GT(shader_.begun, 0u);
  EXPECT_FALSE(shader_.threads.contains(std::this_thread::get_id()));
  const sideray_frame_stats stats = host_.service().stats(ticket);
  EXPECT_GT(stats.points_shaded, 100u);
  EXPECT_EQ(stats.points_not_finite, 0u);
}

// Layers get the shader's values unchanged, in any colour space of the inputs.
TEST_F(HostShading, IsHandedOnAsItIs) {
  use(SIDERAY_SHADE_ON_WORKERS);
  FrameInputs in = host_.inputs();
  for (const auto space : {SIDERAY_SPACE_LINEAR, SIDERAY_SPACE_GAMMA22}) {
    in.layers->radiance_space = space;
    in.layers->radiance_scale = 3.0f;
    host_.trace(in);
    EXPECT_EQ(seen(), glm::vec4(0.5f, 1.5f, 0.25f, 1.0f));
  }
  host_.scene().set_built_in_shader();
  host_.scene().commit();
  in.layers->radiance_space = SIDERAY_SPACE_LINEAR;
  in.layers->radiance_scale = 1.0f;
  host_.trace(in);
  EXPECT_EQ(seen(), glm::vec4(0.25f, 0.5f, 0.0f, 1.0f));  // the pane's emission
}

TEST_F(HostShading, RunsInsideCallsOfTheHost) {
  use(SIDERAY_SHADE_IN_CALLS);
  const sideray_ticket ticket = submit();
  let_batches_wait();
  shader_.in_call = true;
  ASSERT_TRUE(host_.service().wait(ticket));
  shader_.in_call = false;
  EXPECT_GT(shader_.begun, 0u);
  EXPECT_EQ(shader_.outside, 0u);
  EXPECT_THAT(shader_.threads, testing::ElementsAre(std::this_thread::get_id()));
  EXPECT_EQ(seen().y, 1.5f);
}

TEST_F(HostShading, AdvanceAloneBringsAFrameHome) {
  use(SIDERAY_SHADE_IN_CALLS);
  const sideray_ticket ticket = submit();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!host_.service().layers() && std::chrono::steady_clock::now() < end) {
    shader_.in_call = true;
    host_.service().advance();
    shader_.in_call = false;
    std::this_thread::sleep_for(milliseconds(1));
  }
  ASSERT_TRUE(host_.service().layers());
  EXPECT_EQ(host_.service().layers()->ticket, ticket);
  EXPECT_EQ(shader_.outside, 0u);
}

TEST_F(HostShading, ATimedWaitGivesUpAndGoesOn) {
  use(SIDERAY_SHADE_IN_CALLS);
  const sideray_ticket ticket = submit();
  while (!host_.service().wait(ticket, 1)) {
  }
  EXPECT_GT(host_.service().stats(ticket).points_shaded, 100u);
}

TEST_F(HostShading, CancelEndsWhatWaitsForTheHost) {
  use(SIDERAY_SHADE_IN_CALLS);
  const sideray_ticket ticket = submit();
  let_batches_wait();
  const uint32_t before = shader_.begun;
  host_.service().cancel(ticket);
  EXPECT_THROW(host_.service().wait(ticket), Error);
  EXPECT_EQ(shader_.begun, before);
  ASSERT_TRUE(host_.service().wait(submit()));  // the next frame is as ever
  EXPECT_EQ(seen().y, 1.5f);
}

TEST_F(HostShading, AbandonEndsWhatWaitsForTheHost) {
  use(SIDERAY_SHADE_IN_CALLS);
  submit();
  let_batches_wait();
  const uint32_t before = shader_.begun;
  host_.service().abandon_context();
  EXPECT_EQ(shader_.begun, before);
}

class SecondService {
 public:
  explicit SecondService(GlassHost& host)
      : service_(sideray::Service::create(host.tracer(),
                                          {sizeof(sideray_host_gl), gl::Context::get_proc_address, &host.context()})
                     .value()) {}
  sideray::Service* operator->() { return &service_; }

 private:
  sideray::Service service_;
};

// One frame waits for the host, one for the tracer.
TEST_F(HostShading, DestroyEndsWhatWaitsForTheHost) {
  use(SIDERAY_SHADE_IN_CALLS);
  submit();
  let_batches_wait();
  {
    SecondService second(host_);
    second->submit(host_.inputs());
    second->advance();
    second->advance();
  }
  {
    std::optional<SecondService> third(host_);
    third->operator->()->submit(host_.inputs());
    third->operator->()->advance();
  }
}

TEST_F(HostShading, AnyServiceOfTheTracerServes) {
  use(SIDERAY_SHADE_IN_CALLS);
  const sideray_ticket first = submit();
  let_batches_wait();
  SecondService second(host_);
  const auto ticket = second->submit(host_.inputs());
  EXPECT_TRUE(second->wait(ticket.value(), 20000));
  EXPECT_TRUE(host_.service().wait(first, 20000));
}

TEST_F(HostShading, RaysOfTheHostGetTheirTurn) {
  use(SIDERAY_SHADE_IN_CALLS);
  submit();
  let_batches_wait();
  const sideray_ray ray{{0, 0, 3}, {0, 0, -1}, 0.0f, 10.0f};
  EXPECT_EQ(host_.tracer().trace(SIDERAY_RAYS_TRANSLUCENT, {&ray, 1}).front().surface_id, GlassHost::glass_id);
}

// While a batch runs on a worker.
TEST_F(HostShading, CancelAndDestroyWaitForWhatRuns) {
  use(SIDERAY_SHADE_ON_WORKERS);
  for (const bool cancels : {true, false}) {
    shader_.begun = shader_.ended = 0;
    shader_.hold = true;
    std::optional<SecondService> service(host_);
    const auto ticket = service->operator->()->submit(host_.inputs()).value();
    while (shader_.begun == 0) service->operator->()->advance();
    if (cancels) service->operator->()->cancel(ticket);
    const auto released = std::async(std::launch::async, [&] {
      std::this_thread::sleep_for(milliseconds(20));
      shader_.hold = false;
    });
    service.reset();
    EXPECT_EQ(shader_.begun, shader_.ended);
    EXPECT_FALSE(shader_.hold);
  }
}

TEST_F(HostShading, AFrameKeepsTheShaderOfItsCommit) {
  Shader other;
  use(SIDERAY_SHADE_ON_WORKERS);
  const sideray_ticket ticket = submit();
  host_.scene().set_shader(other.desc(SIDERAY_SHADE_ON_WORKERS));
  host_.scene().commit();
  ASSERT_TRUE(host_.service().wait(ticket));
  EXPECT_GT(shader_.begun, 0u);
  EXPECT_EQ(other.begun, 0u);
  ASSERT_TRUE(host_.service().wait(submit()));
  EXPECT_GT(other.begun, 0u);
}

TEST_F(HostShading, IsReleasedWhenNoFrameHasIt) {
  std::atomic<int> released = 0;
  struct Owner {
    Shader shader;
    std::atomic<int>* released;
  };
  auto* owner = new Owner{{}, &released};
  sideray_shader_desc desc = owner->shader.desc(SIDERAY_SHADE_ON_WORKERS);
  desc.user = owner;
  desc.shade = [](void* user, const sideray_shading_point* points, size_t count, sideray_shading_result* results) {
    Shader::call(&static_cast<Owner*>(user)->shader, points, count, results);
  };
  desc.release = [](void* user) {
    auto* gone = static_cast<Owner*>(user);
    ++*gone->released;
    delete gone;
  };
  host_.scene().set_shader(desc);
  host_.scene().commit();
  const sideray_ticket ticket = submit();
  use(SIDERAY_SHADE_ON_WORKERS);
  ASSERT_TRUE(host_.service().wait(ticket)) << "a frame of the former commit";
  EXPECT_EQ(shader_.begun, 0u);
  ASSERT_TRUE(host_.service().wait(submit()));
  EXPECT_EQ(released, 1);
}

// Pieces begun before the deadline are finished however late the host calls, so that every frame has new answers.
TEST_F(HostShading, ALateFrameHasTheAnswersThatItHasBegun) {
  use(SIDERAY_SHADE_IN_CALLS);
  FrameInputs in = host_.inputs();
  in.frame.deadline_ms = 400.0f;
  const sideray_ticket ticket = host_.service().submit(in).value();
  let_batches_wait();
  std::this_thread::sleep_for(milliseconds(450));
  ASSERT_TRUE(host_.service().wait(ticket));
  EXPECT_GT(shader_.begun, 0u);
  EXPECT_LT(host_.service().stats(ticket).pixels_late, uint64_t{GlassHost::width} * GlassHost::height);
}

// A still view is complete after at most about as many frames as it has pieces.
TEST_F(HostShading, EveryPixelIsAnsweredAfterSomeLateFrames) {
  const sideray_light lamp = sideray_light_defaults();
  host_.scene().set_lights({&lamp, 1});
  use(SIDERAY_SHADE_IN_CALLS);
  FrameInputs in = host_.inputs();
  in.masks = sideray_mask_inputs_defaults();
  in.masks->shadow_lights = 1;
  in.frame.continues = 1;
  in.frame.deadline_ms = 40.0f;
  uint64_t without = 1;
  constexpr int pieces = 48;
  for (int frame = 0; frame < 2 * pieces && without > 0; ++frame) {
    const sideray_ticket ticket = host_.service().submit(in).value();
    ASSERT_TRUE(host_.service().wait(ticket));
    without = host_.service().stats(ticket).pixels_late;
  }
  EXPECT_EQ(without, 0u);
}

// For every kind of job, also reflections of opaque surfaces and masks.
TEST(HostShadingOfAnyFrame, IsTheSameInCallsAndOnWorkers) {
  Shader shader;
  SmallHost host(gl::Context::create("auto", ""));
  const sideray_host_gl loader = host.loader();
  sideray_service* service = nullptr;
  ASSERT_EQ(sideray_service_create(host.tracer(), &loader, &service, nullptr), SIDERAY_OK);
  const auto texels = [&](const SmallHost::Case& c, sideray_shader_thread thread) {
    host.scene().set_shader(shader.desc(thread));
    host.scene().commit();
    shader.threads.clear();
    FrameInputs in = host.inputs();
    c.ask(host, in);
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(submit_frame(service, in, ticket, &error), SIDERAY_OK) << c.name << ": " << error.message;
    EXPECT_EQ(sideray_service_wait(service, ticket, -1, &error), SIDERAY_OK) << c.name << ": " << error.message;
    const std::optional<FrameOutputs> out = newest_outputs(service);
    return out ? host.texels(*out) : std::vector<uint8_t>();
  };
  size_t asked = 0;
  for (const SmallHost::Case& c : SmallHost::cases()) {
    SCOPED_TRACE(c.name);
    const std::vector<uint8_t> on_workers = texels(c, SIDERAY_SHADE_ON_WORKERS);
    EXPECT_EQ(texels(c, SIDERAY_SHADE_IN_CALLS), on_workers);
    const bool somewhere_else = shader.threads.size() > (shader.threads.contains(std::this_thread::get_id()) ? 1u : 0u);
    EXPECT_FALSE(somewhere_else);
    asked += !shader.threads.empty();
  }
  EXPECT_GT(asked, 10u);
  sideray_service_destroy(service);
}

TEST_F(HostShading, RefusesWhatDoesNotGoWithIt) {
  use(SIDERAY_SHADE_ON_WORKERS);
  const auto refusal = [&](const FrameInputs& in) {
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(submit_frame(host_.service().get(), in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
    return std::string(error.message);
  };
  for (const sideray_service_mode mode : {SIDERAY_CACHE, SIDERAY_COMPOSITE}) {
    FrameInputs in = host_.inputs();
    in.layers->mode = mode;
    in.layers->particles = 1;
    EXPECT_THAT(refusal(in), testing::HasSubstr("particles")) << mode;
  }

  const auto set = [&](const std::function<void(sideray_shader_desc&)>& change) {
    sideray_shader_desc d = shader_.desc(SIDERAY_SHADE_ON_WORKERS);
    change(d);
    sideray_error error{};
    EXPECT_EQ(sideray_scene_set_shader(host_.scene().get(), &d, &error), SIDERAY_INVALID_ARGUMENT);
    return std::string(error.message);
  };
  EXPECT_THAT(set([](auto& d) { d.shade = nullptr; }), testing::HasSubstr("shade"));
  EXPECT_THAT(set([](auto& d) { d.size = 4; }), testing::HasSubstr("size"));
  EXPECT_THAT(set([](auto& d) { std::memset(&d.thread, 1, sizeof(d.thread)); }), testing::HasSubstr("thread"));
  EXPECT_THAT(set([](auto& d) { d.radiance_scale = 0.0f; }), testing::HasSubstr("radiance_scale"));
  EXPECT_THAT(set([](auto& d) { std::memset(&d.radiance_space, 1, sizeof(d.thread)); }),
              testing::HasSubstr("radiance_space"));
}

}  // namespace
}  // namespace sideray::tests
