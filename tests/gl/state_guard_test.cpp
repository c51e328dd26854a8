// What the guards cover is set at random, dirtied at random under a guard, and compared as the driver tells it.
#include "gl/resources/state_guard.h"

#include <gmock/gmock.h>

#include <functional>

#include "gl/gl_contexts.h"
#include "gl/random_state.h"

namespace sideray::gl {
namespace {

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
                         testing::Combine(testing::ValuesIn(driver_contexts()),
                                          testing::Values(Profile::core, Profile::compatibility)),
                         name_of_driver_and_profile);

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
