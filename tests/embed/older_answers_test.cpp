// Tests older answers under a deadline, which frames that continue may show. A deadline that has passed before any ray
// begins stands for one that is too short.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

const std::string plain = "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)";
constexpr float ample = 1e6f, none = 1e-5f;

class OlderAnswers : public testing::Test {
 protected:
  OlderAnswers() : depth_(host_.gl) {
    const gl::Functions& gl = host_.gl;
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, GlassHost::width, GlassHost::height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, host_.framebuffer());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    gl.ClearDepth(1.0);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }

  sideray_frame_stats frame(float deadline_ms, bool continues, double eye_x = 0) {
    FrameInputs in = host_.inputs();
    GlassHost::set_view(in, GlassHost::clip_from_world(eye_x));
    in.frame.deadline_ms = deadline_ms;
    in.frame.continues = continues;
    const sideray_ticket ticket = host_.service().submit(in).value();
    EXPECT_TRUE(host_.service().wait(ticket));
    return host_.service().stats(ticket);
  }
  GlassHost::Picture picture(double eye_x = 0, glm::vec3 offset = glm::vec3(0)) {
    return host_.draw(host_.program(330, plain), 330, GlassHost::clip_from_world(eye_x), offset);
  }
  static size_t answered(const GlassHost::Picture& picture) {
    return static_cast<size_t>(
        std::count_if(picture.begin(), picture.end(), [](glm::vec4 p) { return p.w > 0.0f && p.z == 0.0f; }));
  }
  static size_t drawn(const GlassHost::Picture& picture) {
    return static_cast<size_t>(std::count_if(picture.begin(), picture.end(), [](glm::vec4 p) { return p.w > 0.0f; }));
  }

  GlassHost host_;
  gl::Renderbuffer depth_;
};

TEST_F(OlderAnswers, AreThoseOfAStillViewToTheLastBit) {
  EXPECT_EQ(frame(ample, false).pixels_late, 0u);
  const GlassHost::Picture first = picture();
  ASSERT_GT(answered(first), 1000u);
  const sideray_frame_stats later = frame(none, true);
  EXPECT_EQ(later.pixels_older, later.pixels_masked);
  EXPECT_EQ(later.pixels_late, 0u);
  EXPECT_EQ(later.answer_age, 0u);
  EXPECT_EQ(later.bytes_upload, 0u);
  EXPECT_EQ(picture(), first);
}

TEST_F(OlderAnswers, MoveWithTheEye) {
  frame(ample, false);
  for (int f = 1; f <= 10; ++f) {
    const double x = 0.013 * f;
    const sideray_frame_stats later = frame(none, true, x);
    EXPECT_EQ(later.answer_age, static_cast<uint64_t>(f));
    const GlassHost::Picture seen = picture(x);
    EXPECT_GT(answered(seen), drawn(seen) * 9 / 10) << f;
    // A pane that has moved finds no answers.
    EXPECT_EQ(answered(picture(x, {0, 0, 0.1f})), 0u);
  }
}

TEST_F(OlderAnswers, AreNotThereBehindACut) {
  frame(ample, false);
  const sideray_frame_stats cut = frame(none, false);
  EXPECT_EQ(cut.pixels_late, cut.pixels_masked);
  EXPECT_EQ(cut.pixels_older, 0u);
  EXPECT_EQ(answered(picture()), 0u);
}

// Without a deadline nothing is reused, and a frame has the bits of one without a history.
TEST_F(OlderAnswers, AreForgottenWithoutADeadline) {
  frame(0.0f, false);
  const GlassHost::Picture first = picture();
  frame(ample, true, 0.1);
  frame(none, true);
  frame(0.0f, true);
  EXPECT_EQ(picture(), first);
  const sideray_frame_stats later = frame(none, true);
  EXPECT_EQ(later.pixels_older, 0u);
  EXPECT_EQ(answered(picture()), 0u);
}

}  // namespace
}  // namespace sideray::tests
