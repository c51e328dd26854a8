// Tests sideray_is_whole() and sideray_whole() in a host's shader: pixels whose surfaces are all cached.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "embed/hosts/glass_host.h"

namespace sideray::tests::snippet_whole_test {
namespace {

constexpr int width = GlassHost::width, height = GlassHost::height;

class SnippetWhole : public testing::TestWithParam<int> {
 protected:
  // Nothing opaque is in front of the pane.
  void SetUp() override {
    const gl::Functions& gl = host_.gl;
    depth_ = gl::Renderbuffer(gl);
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, host_.framebuffer());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    gl.ClearDepth(1.0);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }

  // The pane covers the middle of the picture; the mask says how many surfaces a pixel has.
  FrameInputs inputs() {
    FrameInputs in = host_.inputs();
    in.layers->max_layers = 2;
    in.layers->whole_pixels = 1;
    in.frame.source.mask = SIDERAY_MASK_MEMORY;
    in.frame.source.mask_texels = counts_.data();
    in.frame.source.mask_row_bytes = width;
    return in;
  }

  // Returns a program for the pane: the light that is added to the picture, and the red of the transmittance; blue
  // where the pixel is not whole.
  gl::Program program() const {
    const int version = GetParam();
    const bool old = version < 130;
    const std::string head = "#version " + std::to_string(version) + "\n";
    const std::string vertex = head + (old ? "attribute" : "in") + " vec3 position;\nuniform mat4 clip_from_world;\n" +
                               "void main() { gl_Position = clip_from_world * vec4(position, 1.0); }\n";
    const std::string fragment = head + sideray_glsl(version) + (old ? "" : "out vec4 result;\n") +
                                 "void main() {\n  vec3 added, through;\n  sideray_whole(added, through);\n  " +
                                 (old ? "gl_FragColor" : "result") +
                                 " = sideray_is_whole() ? vec4(added.rg, 0.0, through.r) : vec4(0.0, 0.0, 1.0, 1.0);\n}\n";
    return gl::Program(host_.gl, "whole pixels of GLSL " + std::to_string(version), vertex, fragment);
  }

  struct Counted {
    size_t whole = 0, not_whole = 0;
  };
  // Counts the pane's pixels in the columns from `first` on.
  static Counted count(const GlassHost::Picture& picture, int first, int last) {
    Counted counted;
    for (int y = 0; y < height; ++y)
      for (int x = first; x < last; ++x) {
        const glm::vec4 p = picture[static_cast<size_t>(y * width + x)];
        if (p.w == 0.0f) continue;  // no fragment
        ++(p.z == 1.0f ? counted.not_whole : counted.whole);
      }
    return counted;
  }

  gl::Profile profile() const { return GetParam() < 130 ? gl::Profile::compatibility : gl::Profile::core; }

  GlassHost host_{profile()};
  gl::Renderbuffer depth_;
  std::vector<uint8_t> counts_ = std::vector<uint8_t>(size_t{width} * height, 1);
};

TEST_P(SnippetWhole, HoldsTheSurfacesOfCountedPixels) {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width / 2; ++x) counts_[static_cast<size_t>(y * width + x)] = 2;  // one more than there is
  host_.trace(inputs());
  const gl::Program reader = program();
  const GlassHost::Picture picture = host_.draw(reader, GetParam());
  const Counted left = count(picture, 0, width / 2), right = count(picture, width / 2, width);
  EXPECT_EQ(left.whole, 0u);
  EXPECT_GT(left.not_whole, 100u);
  EXPECT_GT(right.whole, 100u);
  // Rasterizer and rays may disagree about the pane's very edge.
  EXPECT_LT(right.not_whole, right.whole / 10);
  // It glows with (0.25, 0.5, 0) and covers half.
  for (const glm::vec4& p : picture) {
    if (p.w == 0.0f || p.z == 1.0f) continue;
    EXPECT_NEAR(p.x, 0.125f, 1e-3f);
    EXPECT_NEAR(p.y, 0.25f, 1e-3f);
    EXPECT_NEAR(p.w, 0.5f, 1e-3f);
  }
}

TEST_P(SnippetWhole, CompositesInTheOrderAlongTheRay) {
  host_.add_pane(GlassHost::glass_id + 1);
  std::fill(counts_.begin(), counts_.end(), uint8_t{2});
  host_.trace(inputs());
  const gl::Program reader = program();
  const GlassHost::Picture picture = host_.draw(reader, GetParam());
  size_t whole = 0;
  for (const glm::vec4& p : picture) {
    if (p.w == 0.0f || p.z == 1.0f) continue;
    ++whole;
    EXPECT_NEAR(p.x, 0.125f + 0.5f * 0.125f, 1e-3f);
    EXPECT_NEAR(p.w, 0.25f, 1e-3f);
  }
  EXPECT_GT(whole, 100u);
}

TEST_P(SnippetWhole, NoneIsWholeUnlessAskedFor) {
  FrameInputs in = inputs();
  in.layers->whole_pixels = 0;
  host_.trace(in);
  EXPECT_EQ(host_.service().layers()->whole_transmittance_texture, 0u);
  const gl::Program reader = program();
  EXPECT_EQ(count(host_.draw(reader, GetParam()), 0, width).whole, 0u);
  // Whole pixels can be requested later, and then no longer.
  host_.trace(inputs());
  EXPECT_NE(host_.service().layers()->whole_transmittance_texture, 0u);
  EXPECT_GT(count(host_.draw(reader, GetParam()), 0, width).whole, 100u);
  host_.trace(in);
  EXPECT_EQ(count(host_.draw(reader, GetParam()), 0, width).whole, 0u);
}

// A pixel stops being whole when it is no longer traced, or its count changes.
TEST_P(SnippetWhole, PixelsAreForgotten) {
  host_.trace(inputs());
  const gl::Program reader = program();
  EXPECT_GT(count(host_.draw(reader, GetParam()), 0, width).whole, 100u);
  std::fill(counts_.begin(), counts_.end(), uint8_t{0});
  host_.trace(inputs());
  EXPECT_EQ(count(host_.draw(reader, GetParam()), 0, width).whole, 0u);
  std::fill(counts_.begin(), counts_.end(), uint8_t{255});  // as many or more
  host_.trace(inputs());
  EXPECT_EQ(count(host_.draw(reader, GetParam()), 0, width).whole, 0u);
}

INSTANTIATE_TEST_SUITE_P(Glsl, SnippetWhole, testing::Values(120, 130, 330),
                         [](const auto& test) { return std::to_string(test.param); });

struct Refused {
  const char* name;
  void (*change)(FrameInputs&);
  const char* told;
};

class WholeInputs : public testing::TestWithParam<Refused> {};

TEST_P(WholeInputs, AreRefusedByName) {
  GlassHost host;
  FrameInputs in = host.inputs();
  std::vector<uint8_t> counts(size_t{width} * height, 1);
  in.frame.source.mask = SIDERAY_MASK_MEMORY;
  in.frame.source.mask_texels = counts.data();
  in.frame.source.mask_row_bytes = width;
  in.layers->whole_pixels = 1;
  GetParam().change(in);
  sideray_ticket ticket = 0;
  sideray_error error{};
  EXPECT_EQ(submit_frame(host.service().get(), in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_NE(std::string(error.message).find(GetParam().told), std::string::npos) << error.message;
}

INSTANTIATE_TEST_SUITE_P(
    Each, WholeInputs,
    testing::Values(
        Refused{"mask", [](FrameInputs& in) { in.frame.source.mask = SIDERAY_MASK_NONE; }, "whole_pixels: no mask"},
        Refused{"rate", [](FrameInputs& in) { in.layers->cache_rate = SIDERAY_RATE_QUARTER; }, "whole_pixels: at a"},
        Refused{"mode", [](FrameInputs& in) { in.layers->mode = SIDERAY_COMPOSITE; }, "whole_pixels: a composite"},
        Refused{"space", [](FrameInputs& in) { in.layers->radiance_space = SIDERAY_SPACE_GAMMA22; }, "whole_pixels: they"},
        Refused{"scale", [](FrameInputs& in) { in.layers->radiance_scale = 2.0f; }, "whole_pixels: they"},
        Refused{"bits", [](FrameInputs& in) { in.layers->others_bits = 0x100; }, "others_bits 0x100"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace sideray::tests::snippet_whole_test
