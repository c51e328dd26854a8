// Tests two views of a frame through one service, such as the eyes of a stereo picture: each has the bits of a separate
// service, whatever the other does; binding selects the view.
#include <gmock/gmock.h>

#include <cmath>

#include "embed/hosts/small_host.h"

namespace sideray::tests::views_test {
namespace {

constexpr int width = SmallHost::width, height = SmallHost::height;

class Views : public testing::Test {
 protected:
  using Ask = std::function<void(FrameInputs&)>;

  Views() {
    const gl::Functions& gl = host_.gl;
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, 2 * width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, wide_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    const glm::dvec4 wall = SmallHost::clip_from_world() * glm::dvec4(0, 0, 0, 1);
    gl.ClearDepth(0.5 + 0.5 * wall.z / wall.w);
    gl.ClearStencil(2);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
  }
  ~Views() override {
    EXPECT_EQ(host_.gl.GetError(), GLenum{GL_NO_ERROR});
    EXPECT_EQ(host_.context().take_errors(), std::vector<std::string>{});
  }

  sideray::Service service() { return sideray::Service::create(tracer_, host_.loader()).value(); }

  // Returns the inputs of an eye: the left or right half of one target, or the same rectangle of a separate target.
  FrameInputs inputs(int eye, int frame, bool halves, const Ask& ask) const {
    FrameInputs in = host_.inputs();
    SmallHost::set_view(in, SmallHost::clip_from_world((eye == 0 ? -0.1 : 0.1) + 0.05 * frame));
    if (halves) {
      in.frame.source.framebuffer = wide_.id();
      in.frame.source.x = eye * width;
    }
    in.frame.continues = frame > 0;
    in.frame.seed = static_cast<uint32_t>(frame);
    ask(in);
    return in;
  }
  void move(int frame) {
    const double pane[12] = {0.9, 0, 0, 0, 0.9, 0, 0, 0, 0.9, 0.1 * std::sin(0.7 * frame), 0, 1};
    host_.scene().move_instance(host_.pane(), pane);
    host_.scene().commit();
  }
  std::vector<uint8_t> texels(const sideray::Service& service, uint32_t view) const {
    const auto out = newest_outputs(service.get(), view);
    EXPECT_TRUE(out);
    return out ? host_.texels(*out) : std::vector<uint8_t>();
  }

  // Draws frames of both eyes, with answers at once or one frame late, and compares the last ones.
  void expect_same(bool halves, bool late, const Ask& ask) {
    sideray::Service both = service(), alone[2] = {service(), service()};
    sideray_ticket before[2] = {}, before_alone[2] = {};
    for (int frame = 0; frame < 4; ++frame) {
      move(frame);
      sideray_ticket now[2], now_alone[2];
      for (const int eye : {0, 1}) {
        FrameInputs in = inputs(eye, frame, halves, ask);
        now_alone[eye] = alone[eye].submit(in).value();
        in.frame.view_id = static_cast<uint32_t>(3 * eye);
        now[eye] = both.submit(in).value();
      }
      for (const int eye : {0, 1}) {
        const sideray_ticket wanted = late ? before[eye] : now[eye],
                             wanted_alone = late ? before_alone[eye] : now_alone[eye];
        EXPECT_TRUE(wanted == 0 || (both.wait(wanted) && alone[eye].wait(wanted_alone)));
        before[eye] = now[eye], before_alone[eye] = now_alone[eye];
      }
    }
    for (const int eye : {0, 1}) {
      EXPECT_TRUE(both.wait(before[eye]) && alone[eye].wait(before_alone[eye]));
      const auto out = newest_outputs(both.get(), static_cast<uint32_t>(3 * eye));
      ASSERT_TRUE(out);
      EXPECT_EQ(out->ticket, before[eye]);
      EXPECT_EQ(out->layers ? out->layers->x : out->masks->x, halves ? eye * width : 0);
      EXPECT_EQ(texels(both, static_cast<uint32_t>(3 * eye)) == texels(alone[eye], 0), true) << "eye " << eye;
      EXPECT_EQ(both.stats(before[eye]).rays_primary, alone[eye].stats(before_alone[eye]).rays_primary);
    }
    EXPECT_NE(texels(both, 0) == texels(both, 3), true) << "the eyes see the same: nothing is compared";
  }

  SmallHost host_{gl::Context::create("auto", "")};
  gl::Framebuffer wide_{host_.gl};
  gl::Renderbuffer depth_{host_.gl};
  sideray::Tracer tracer_ = sideray::Tracer::create(host_.scene()).value();
};

TEST_F(Views, AnswerAsServicesOfTheirOwn) {
  const Ask asks[] = {[](auto&) {}, [](auto& in) { in.layers->cache_rate = SIDERAY_RATE_CHECKERBOARD; },
                      [](auto& in) { in.layers->mode = SIDERAY_COMPOSITE; },
                      [](auto& in) {
                        in.layers.reset();
                        in.frame.source.mask = SIDERAY_MASK_NONE;
                        in.masks = sideray_mask_inputs_defaults();
                        in.masks->shadow_lights = 1;
                        in.masks->ao_rays = 2;
                      }};
  for (size_t i = 0; i < std::size(asks); ++i)
    for (const bool late : {false, true}) {
      SCOPED_TRACE(testing::Message() << "inputs " << i << (late ? ", late" : ", at once"));
      expect_same(true, late, asks[i]);
    }
}

// With separate targets, for every kind of inputs.
TEST_F(Views, AnswerSoWithAllThatAFrameBrings) {
  for (const SmallHost::Case& c : SmallHost::cases()) {
    const std::string name = c.name;
    if (name != "everything" && name != "inexact masks with a rest pose" && name != "array layer") continue;
    SCOPED_TRACE(name);
    expect_same(false, false, [&](FrameInputs& in) { c.ask(host_, in); });
  }
}

TEST_F(Views, BindingPicksTheView) {
  sideray::Service both = service();
  const gl::Program program = host_.program();
  const auto is = [&](const char* name, int count) {
    std::vector<float> values(static_cast<size_t>(count));
    host_.gl.GetUniformfv(program.id(), program.uniform(name), values.data());
    return values;
  };
  for (const int eye : {0, 1}) {
    FrameInputs in = inputs(eye, 0, true, [](auto&) {});
    in.frame.view_id = static_cast<uint32_t>(eye);
    EXPECT_TRUE(both.wait(both.submit(in).value()));
  }
  for (const uint32_t eye : {1u, 0u}) {
    both.bind(program.id(), 2, eye);
    EXPECT_FLOAT_EQ(is("sideray_viewport", 4)[0], static_cast<float>(eye * width));
    EXPECT_EQ(is("sideray_layers", 1)[0], 2.0f);
    GLint bound = 0;
    host_.gl.ActiveTexture(GL_TEXTURE2);
    host_.gl.GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &bound);
    EXPECT_EQ(static_cast<uint32_t>(bound), both.layers(eye)->radiance_texture);
  }
  both.bind(program.id(), 2, 7);
  EXPECT_EQ(is("sideray_layers", 1)[0], 0.0f) << "of a view that never was: no answer";
  EXPECT_FALSE(both.layers(7));
}

// Submits a second wave of one view while the other has a frame in flight.
TEST_F(Views, ASecondWaveIsItsViewsAffair) {
  sideray::Service both = service();
  FrameInputs in = inputs(0, 0, true, [](auto& i) { i.layers->cache_rate = SIDERAY_RATE_CHECKERBOARD; });
  const sideray_ticket first = both.submit(in).value();
  EXPECT_TRUE(both.wait(first));
  FrameInputs other = inputs(1, 0, true, [](auto&) {});
  other.frame.view_id = 1;
  const sideray_ticket others = both.submit(other).value();
  in.layers->adds_to = first;
  in.layers->requested_bits = 0x40;
  const auto wave = both.submit(in);
  ASSERT_TRUE(wave);
  EXPECT_TRUE(both.wait(*wave) && both.wait(others));
  EXPECT_EQ(both.layers(0)->ticket, *wave);
  other.layers->adds_to = *wave;
  other.layers->requested_bits = 0x40;
  EXPECT_THROW(static_cast<void>(both.submit(other)), sideray::Error) << "another view's frame";
}

TEST_F(Views, HavePlacesOfTheirOwn) {
  sideray::Service both = service();
  FrameInputs in = inputs(0, 0, true, [](auto&) {});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(both.submit(in));
  EXPECT_FALSE(both.submit(in)) << "three of the view are in flight";
  in.frame.view_id = SIDERAY_MAX_VIEWS - 1;
  const auto last = both.submit(in);
  ASSERT_TRUE(last);
  EXPECT_TRUE(both.wait(*last));
  in.frame.view_id = SIDERAY_MAX_VIEWS;
  EXPECT_THROW(static_cast<void>(both.submit(in)), sideray::Error);
  EXPECT_THROW(static_cast<void>(both.layers(SIDERAY_MAX_VIEWS)), sideray::Error);
}

// Cancelling a view's frames ends its history, but not the other's.
TEST_F(Views, DoNotEndEachOthersPast) {
  sideray::Service both = service(), alone = service();
  const Ask ask = [](auto& in) {
    in.layers.reset();
    in.frame.source.mask = SIDERAY_MASK_NONE;
    in.masks = sideray_mask_inputs_defaults();
    in.masks->shadow_lights = 1;
    in.masks->ao_rays = 2;
  };
  for (int frame = 0; frame < 4; ++frame) {
    FrameInputs in = inputs(0, frame, true, ask), other = inputs(1, frame, true, ask);
    other.frame.view_id = 1;
    const sideray_ticket cancelled = both.submit(other).value();
    both.cancel(cancelled);
    EXPECT_TRUE(both.wait(both.submit(in).value()) && alone.wait(alone.submit(in).value()));
    EXPECT_EQ(texels(both, 0) == texels(alone, 0), true) << "frame " << frame;
  }
}

}  // namespace
}  // namespace sideray::tests::views_test
