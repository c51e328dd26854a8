// Tests the service in a host's context: promises about state, errors, the ring, and failed frames.
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <sideray/sideray.hpp>
#include <thread>

#include "embed/hosts/frame_outputs.h"
#include "embed/hosts/one_pane.h"
#include "gl/context/context.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray::tests::service_test {
namespace {

constexpr int width = 96, height = 64;

sideray_view front_view() {
  sideray_view view{};
  set_matrices(view, clip_before_pane(double{width} / height));
  return view;
}

class ServiceInAHost : public testing::Test {
 protected:
  void SetUp() override {
    context_ = gl::Context::create("auto", "");
    context_->make_current();
    create_framebuffer(GL_DEPTH24_STENCIL8, GL_DEPTH_STENCIL_ATTACHMENT);
    const sideray_host_gl host{sizeof(host), gl::Context::get_proc_address, context_.get()};
    service_.emplace(sideray::Service::create(tracer_, host).value());
  }

  void TearDown() override {
    service_.reset();
    framebuffer_.reset();
    depth_.reset();
    EXPECT_TRUE(context_->take_errors().empty());
    context_->release_current();
  }

  void create_framebuffer(GLenum format, GLenum attachment) {
    const gl::Functions& gl = context_->functions();
    framebuffer_ = gl::Framebuffer(gl);
    depth_ = gl::Renderbuffer(gl);
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, depth_.id());
    gl.DrawBuffer(GL_NONE);
    gl.ReadBuffer(GL_NONE);
  }

  // Leaves the buffers as an opaque pass without objects and a mask pass would, with one layer marked in the rectangle.
  void mark(int x, int y, int w, int h) {
    const gl::Functions& gl = context_->functions();
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Disable(GL_SCISSOR_TEST);
    gl.StencilMask(0xff);
    gl.ClearDepth(1.0);
    gl.ClearStencil(0);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(x, y, w, h);
    gl.ClearStencil(1);
    gl.Clear(GL_STENCIL_BUFFER_BIT);
    gl.Disable(GL_SCISSOR_TEST);
  }

  FrameInputs inputs() const {
    FrameInputs in;
    in.frame.view = front_view();
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.width = width;
    in.frame.source.height = height;
    in.layers->max_layers = 1;
    return in;
  }

  sideray_status submit(const FrameInputs& in, sideray_ticket& ticket, sideray_error* error = nullptr) {
    return submit_frame(service_->get(), in, ticket, error);
  }

  sideray_status trace(const FrameInputs& in) {
    sideray_ticket ticket = 0;
    if (const sideray_status status = submit(in, ticket); status != SIDERAY_OK) return status;
    return sideray_service_wait(service_->get(), ticket, -1, nullptr);
  }

  // Returns the layer's distances, read back from the service's texture.
  std::vector<float> distances() {
    sideray_layer_outputs outputs{};
    outputs.size = sizeof(outputs);
    EXPECT_EQ(sideray_service_layers(service_->get(), 0, &outputs, nullptr), SIDERAY_OK);
    const gl::Functions& gl = context_->functions();
    std::vector<float> values(width * height);
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, outputs.distance_texture);
    gl.GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RED, GL_FLOAT, values.data());
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return values;
  }

  std::unique_ptr<gl::Context> context_;
  sideray::Scene scene_ = pane_scene();
  sideray::Tracer tracer_ = sideray::Tracer::create(scene_).value();
  gl::Framebuffer framebuffer_;
  gl::Renderbuffer depth_;
  std::optional<sideray::Service> service_;
};

TEST_F(ServiceInAHost, AnswersExactlyWhereTheStencilIsMarked) {
  mark(40, 24, 16, 16);
  ASSERT_EQ(trace(inputs()), SIDERAY_OK);
  const std::vector<float> d = distances();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool marked = x >= 40 && x < 56 && y >= 24 && y < 40;
      EXPECT_EQ(d[static_cast<size_t>(y * width + x)] > 0, marked) << x << "," << y;
    }
  // The ray through the corner shared by the four middle pixels meets the pane at distance 3.
  EXPECT_NEAR(d[static_cast<size_t>(32 * width + 48)], 3.0f, 1e-2f);
}

TEST_F(ServiceInAHost, TilesOfTheLastFrameAreCleared) {
  mark(32, 20, 8, 8);
  ASSERT_EQ(trace(inputs()), SIDERAY_OK);
  mark(56, 36, 8, 8);
  ASSERT_EQ(trace(inputs()), SIDERAY_OK);
  const std::vector<float> d = distances();
  EXPECT_EQ(d[static_cast<size_t>(24 * width + 36)], 0.0f);
  EXPECT_GT(d[static_cast<size_t>(40 * width + 60)], 0.0f);
}

TEST_F(ServiceInAHost, TheRingRefusesAFourthFrameAndEveryTicketCompletes) {
  mark(0, 0, width, height);
  sideray_ticket tickets[3] = {}, fourth = 0;
  for (sideray_ticket& ticket : tickets) ASSERT_EQ(submit(inputs(), ticket), SIDERAY_OK);
  EXPECT_EQ(submit(inputs(), fourth), SIDERAY_NOT_READY);
  EXPECT_EQ(fourth, 0u);
  for (const sideray_ticket ticket : {tickets[2], tickets[0], tickets[1]})
    EXPECT_EQ(sideray_service_wait(service_->get(), ticket, -1, nullptr), SIDERAY_OK);
  EXPECT_EQ(submit(inputs(), fourth), SIDERAY_OK);
}

TEST_F(ServiceInAHost, AdvanceAloneFinishesAFrame) {
  mark(0, 0, width, height);
  sideray_ticket ticket = 0;
  ASSERT_EQ(submit(inputs(), ticket), SIDERAY_OK);
  sideray_layer_outputs outputs{};
  outputs.size = sizeof(outputs);
  // Without wait(), advance() must suffice. The timeout only guards against hanging, and is far above the time needed.
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  sideray_status status = SIDERAY_NOT_READY;
  while (status == SIDERAY_NOT_READY && std::chrono::steady_clock::now() < give_up) {
    ASSERT_EQ(sideray_service_advance(service_->get(), nullptr), SIDERAY_OK);
    status = sideray_service_layers(service_->get(), 0, &outputs, nullptr);
    std::this_thread::yield();
  }
  ASSERT_EQ(status, SIDERAY_OK);
  EXPECT_EQ(outputs.ticket, ticket);
}

TEST_F(ServiceInAHost, ACancelledFrameLeavesTheLastOutputs) {
  mark(40, 24, 16, 16);
  ASSERT_EQ(trace(inputs()), SIDERAY_OK);
  const std::vector<float> before = distances();
  mark(0, 0, width, height);
  sideray_ticket ticket = 0;
  ASSERT_EQ(submit(inputs(), ticket), SIDERAY_OK);
  ASSERT_EQ(sideray_service_cancel(service_->get(), ticket, nullptr), SIDERAY_OK);
  EXPECT_EQ(sideray_service_wait(service_->get(), ticket, -1, nullptr), SIDERAY_CANCELLED);
  EXPECT_EQ(distances(), before);
  mark(40, 24, 16, 16);
  ASSERT_EQ(trace(inputs()), SIDERAY_OK);
  EXPECT_EQ(distances(), before) << "tiles traced by the cancelled frame must not linger";
}

TEST_F(ServiceInAHost, BadInputsAreRefusedByName) {
  sideray_ticket ticket = 0;
  sideray_error error{};
  FrameInputs in = inputs();
  in.layers->max_layers = 9;
  EXPECT_EQ(submit(in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_NE(std::string(error.message).find("max_layers"), std::string::npos);
  in = inputs();
  in.frame.view.world_from_clip[0] *= 2;
  EXPECT_EQ(submit(in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  in = inputs();
  in.frame.source.stencil_bits = 0x5;
  EXPECT_EQ(submit(in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  in = inputs();
  in.reflections = sideray_reflection_inputs_defaults();
  in.reflections->normal_texture = 1;
  in.reflections->max_roughness = 2.0f;
  EXPECT_EQ(submit(in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_NE(std::string(error.message).find("reflections max_roughness"), std::string::npos);
  in = inputs();
  in.frame.source.width = 0;
  EXPECT_EQ(submit(in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(sideray_service_wait(service_->get(), 999, 0, &error), SIDERAY_INVALID_ARGUMENT);
}

// Traces a checkerboard of the pane in the rectangle, then the odd pixels of a row.
TEST_F(ServiceInAHost, ASecondWaveAddsToItsFrame) {
  FrameInputs in = inputs();
  in.layers->cache_rate = SIDERAY_RATE_CHECKERBOARD;
  mark(40, 24, 16, 16);
  sideray_ticket first = 0, second = 0;
  ASSERT_EQ(submit(in, first), SIDERAY_OK);
  ASSERT_EQ(sideray_service_wait(service_->get(), first, -1, nullptr), SIDERAY_OK);
  const std::vector<float> before = distances();
  const gl::Functions& gl = context_->functions();
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(45, 30, 4, 1);
  gl.ClearStencil(0x41);
  gl.Clear(GL_STENCIL_BUFFER_BIT);
  gl.Disable(GL_SCISSOR_TEST);
  in.layers->adds_to = first;
  in.layers->requested_bits = 0x40;
  ASSERT_EQ(submit(in, second), SIDERAY_OK);
  ASSERT_EQ(sideray_service_wait(service_->get(), second, -1, nullptr), SIDERAY_OK);
  const std::vector<float> after = distances();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool marked = x >= 40 && x < 56 && y >= 24 && y < 40, even = (x + y) % 2 == 0;
      const bool asked = x >= 45 && x < 49 && y == 30;
      const auto i = static_cast<size_t>(y * width + x);
      EXPECT_EQ(before[i] > 0, marked && even) << x << "," << y;
      EXPECT_EQ(after[i] > 0, (marked && even) || asked) << x << "," << y;
      EXPECT_TRUE(before[i] == 0 || after[i] == before[i]) << x << "," << y;
    }
}

TEST_F(ServiceInAHost, ASecondWaveNeedsItsFrame) {
  FrameInputs in = inputs();
  in.layers->cache_rate = SIDERAY_RATE_CHECKERBOARD;
  in.layers->requested_bits = 0x40;
  mark(40, 24, 16, 16);
  sideray_ticket first = 0, ticket = 0;
  sideray_error error{};
  const auto expect_refused = [&](FrameInputs wave, const char* word) {
    EXPECT_EQ(submit(wave, ticket, &error), SIDERAY_INVALID_ARGUMENT);
    EXPECT_NE(std::string(error.message).find(word), std::string::npos) << error.message;
  };
  in.layers->adds_to = 1;
  expect_refused(in, "newest finished frame");
  in.layers->adds_to = 0;
  ASSERT_EQ(submit(in, first), SIDERAY_OK);
  in.layers->adds_to = first;
  expect_refused(in, "in flight");
  ASSERT_EQ(sideray_service_wait(service_->get(), first, -1, nullptr), SIDERAY_OK);
  FrameInputs other = in;
  other.layers->max_layers = 2;
  expect_refused(other, "max_layers");
  other = in;
  other.layers->requested_bits = 0x60;
  expect_refused(other, "requested_bits");
  EXPECT_EQ(submit(in, ticket, &error), SIDERAY_OK) << error.message;
  EXPECT_EQ(sideray_service_wait(service_->get(), ticket, -1, nullptr), SIDERAY_OK);
}

TEST_F(ServiceInAHost, ReadsEveryDepthFormat) {
  struct Case {
    GLenum format, attachment;
    sideray_mask_source mask;
  };
  for (const Case c : {Case{GL_DEPTH24_STENCIL8, GL_DEPTH_STENCIL_ATTACHMENT, SIDERAY_MASK_COUNT},
                       Case{GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL_ATTACHMENT, SIDERAY_MASK_COUNT},
                       Case{GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT, SIDERAY_MASK_NONE},
                       Case{GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT, SIDERAY_MASK_NONE},
                       Case{GL_DEPTH_COMPONENT16, GL_DEPTH_ATTACHMENT, SIDERAY_MASK_NONE}}) {
    create_framebuffer(c.format, c.attachment);
    mark(0, 0, width, height);
    FrameInputs in = inputs();
    in.frame.source.mask = c.mask;
    ASSERT_EQ(trace(in), SIDERAY_OK) << std::hex << c.format;
    EXPECT_NEAR(distances()[static_cast<size_t>(32 * width + 48)], 3.0f, 1e-2f) << std::hex << c.format;
  }
}

TEST_F(ServiceInAHost, AMaskWithoutStencilIsRefused) {
  create_framebuffer(GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
  mark(0, 0, width, height);
  sideray_ticket ticket = 0;
  sideray_error error{};
  EXPECT_EQ(submit(inputs(), ticket, &error), SIDERAY_UNSUPPORTED);
  EXPECT_NE(std::string(error.message).find("stencil"), std::string::npos);
}

// All samplers of a new program are on unit 0, which samplers of different kinds must not share.
TEST_F(ServiceInAHost, AProgramDrawsOnceItIsBoundAnswersOrNone) {
  const gl::Functions& gl = context_->functions();
  const gl::Program program(gl, "host's", "#version 330\nvoid main() { gl_Position = vec4(0.0); }\n",
                            std::string("#version 330\n") + sideray_glsl(330) +
                                "out vec4 c;\nvoid main() { c = vec4(sideray_translucent(vec3(0.5), vec3(1.0), 5u) * "
                                "sideray_shadow(0) * sideray_ao(), 1.0); }\n");
  const gl::VertexArray vertices(gl);
  gl.BindVertexArray(vertices.id());
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  const auto error_of_draw = [&] {
    program.use();
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    return gl.GetError();
  };
  if (gl.software) {
    EXPECT_EQ(error_of_draw(), GLenum{GL_INVALID_OPERATION});
  }
  context_->take_errors();
  service_->bind(program.id(), 0);
  EXPECT_EQ(error_of_draw(), GLenum{GL_NO_ERROR});
  gl.UseProgram(0);
  gl.BindVertexArray(0);
}

TEST_F(ServiceInAHost, AnAbandonedContextIsNeverTouchedAgain) {
  mark(0, 0, width, height);
  sideray_ticket ticket = 0;
  ASSERT_EQ(submit(inputs(), ticket), SIDERAY_OK);
  sideray_service_abandon_context(service_->get());
  context_->release_current();
  service_.reset();
  context_->make_current();
}

}  // namespace
}  // namespace sideray::tests::service_test
