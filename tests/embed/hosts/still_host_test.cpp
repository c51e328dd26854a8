// Tests that a still view takes no rays and no uploads from the third equal frame on, and keeps its bits.
#include <gtest/gtest.h>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

class StillHost : public testing::Test {
 protected:
  StillHost() : depth_(host_.gl) { host_.attach(depth_); }

  sideray_frame_stats frame(double eye_x = 0) {
    FrameInputs in = host_.inputs();
    GlassHost::set_view(in, GlassHost::clip_from_world(eye_x));
    in.frame.continues = continues;
    in.frame.seed = seed;
    in.layers->denoise = denoise;
    const sideray_ticket ticket = host_.service().submit(in).value();
    EXPECT_TRUE(host_.service().wait(ticket));
    return host_.service().stats(ticket);
  }
  static uint64_t rays(const sideray_frame_stats& s) { return s.rays_primary + s.rays_reflection + s.rays_shadow; }
  bool is_kept(double eye_x = 0) {
    const sideray_frame_stats s = frame(eye_x);
    EXPECT_EQ(rays(s) == 0, s.bytes_upload == 0);
    return rays(s) == 0;
  }
  GlassHost::Picture picture() {
    return host_.draw(host_.program(330, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)"), 330);
  }

  GlassHost host_;
  gl::Renderbuffer depth_;
  bool continues = true;
  uint32_t seed = 1;
  int32_t denoise = 0;
};

TEST_F(StillHost, PaysNothingFromTheThirdFrameOn) {
  const sideray_frame_stats first = frame();
  ASSERT_GT(rays(first), 1000u);
  const GlassHost::Picture seen = picture();
  EXPECT_FALSE(is_kept());
  for (int i = 0; i < 3; ++i) {
    const sideray_frame_stats kept = frame();
    EXPECT_EQ(rays(kept), 0u);
    EXPECT_EQ(kept.bytes_upload, 0u);
    EXPECT_EQ(kept.layers_found, first.layers_found);
    EXPECT_EQ(kept.pixels_masked, first.pixels_masked);
    EXPECT_EQ(picture(), seen);
  }
}

TEST_F(StillHost, TracesAnewWhateverChanges) {
  const auto settle = [&](double eye_x = 0) {
    frame(eye_x), frame(eye_x);
    ASSERT_TRUE(is_kept(eye_x));
  };
  settle();
  EXPECT_FALSE(is_kept(0.1)) << "the view";
  settle(0.1);
  seed = 2;
  EXPECT_FALSE(is_kept(0.1)) << "the random numbers";
  settle(0.1);
  denoise = 1;
  EXPECT_FALSE(is_kept(0.1)) << "an input";
  settle(0.1);
  continues = false;
  EXPECT_FALSE(is_kept(0.1)) << "a cut";
  continues = true;
  settle(0.1);
  host_.scene().commit();
  EXPECT_TRUE(is_kept(0.1)) << "a commit that changes nothing";
  const sideray_light lamp = sideray_light_defaults();
  host_.scene().set_lights({&lamp, 1});
  host_.scene().commit();
  EXPECT_FALSE(is_kept(0.1)) << "a light";
  settle(0.1);
  host_.gl.BindFramebuffer(GL_FRAMEBUFFER, host_.framebuffer());
  host_.gl.ClearDepth(0.99999);
  host_.gl.Clear(GL_DEPTH_BUFFER_BIT);
  EXPECT_FALSE(is_kept(0.1)) << "the depth buffer";
}

}  // namespace
}  // namespace sideray::tests
