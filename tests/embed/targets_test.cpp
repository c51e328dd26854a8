// Tests that answers do not depend on the host's formats of depth and mask, its GLSL version and its blending space.
#include <gmock/gmock.h>

#include "embed/hosts/glass_host.h"
#include "model/environment.h"

namespace sideray::tests::targets_test {
namespace {

const std::string plain = "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)";

// Counts pixels with an answer, which has no blue; pixels of the pane without one are blue.
size_t answered(const GlassHost::Picture& picture) {
  return static_cast<size_t>(
      std::count_if(picture.begin(), picture.end(), [](glm::vec4 p) { return p.w > 0 && p.z == 0.0f; }));
}
size_t fallen_back(const GlassHost::Picture& picture) {
  return static_cast<size_t>(std::count_if(picture.begin(), picture.end(), [](glm::vec4 p) { return p.z == 1.0f; }));
}

// Describes one of the places where hosts keep depth, cleared to the far plane.
struct DepthImage {
  GLenum format;
  GLenum target;  // GL_RENDERBUFFER or a texture's
  int samples = 0;
  bool framebuffer = false;  // given as one
};

class DepthTarget : public testing::TestWithParam<DepthImage> {};

void allocate(const gl::Functions& gl, const DepthImage& image, uint32_t name) {
  constexpr int w = GlassHost::width, h = GlassHost::height;
  const bool stencil = image.format == GL_DEPTH24_STENCIL8 || image.format == GL_DEPTH32F_STENCIL8;
  const GLenum type = image.format == GL_DEPTH24_STENCIL8    ? GL_UNSIGNED_INT_24_8
                      : image.format == GL_DEPTH32F_STENCIL8 ? GL_FLOAT_32_UNSIGNED_INT_24_8_REV
                                                             : GL_FLOAT;
  const GLenum format = stencil ? GL_DEPTH_STENCIL : GL_DEPTH_COMPONENT;
  if (image.target == GL_RENDERBUFFER) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, name);
    gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, image.samples, image.format, w, h);
    gl.BindRenderbuffer(GL_RENDERBUFFER, 0);
    return;
  }
  gl.BindTexture(image.target, name);
  if (image.target == GL_TEXTURE_2D_MULTISAMPLE)
    gl.TexImage2DMultisample(image.target, image.samples, image.format, w, h, GL_TRUE);
  else if (image.target == GL_TEXTURE_2D_ARRAY)
    gl.TexImage3D(image.target, 0, static_cast<GLint>(image.format), w, h, 3, 0, format, type, nullptr);
  else
    gl.TexImage2D(image.target, 0, static_cast<GLint>(image.format), w, h, 0, format, type, nullptr);
  gl.BindTexture(image.target, 0);
}

// Clears depth to the far plane, and in the left half to the near plane, which hides everything.
void clear_half(const gl::Functions& gl, const DepthImage& image, uint32_t name, uint32_t framebuffer) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  const bool stencil = image.format == GL_DEPTH24_STENCIL8 || image.format == GL_DEPTH32F_STENCIL8;
  const GLenum attachment = stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT;
  if (image.target == GL_RENDERBUFFER)
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, name);
  else if (image.target == GL_TEXTURE_2D_ARRAY)
    gl.FramebufferTextureLayer(GL_FRAMEBUFFER, attachment, name, 0, 1);
  else
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, attachment, image.target, name, 0);
  gl.DrawBuffer(GL_NONE);
  gl.ReadBuffer(GL_NONE);
  ASSERT_EQ(gl.CheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
  gl.ClearDepth(1.0);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(0, 0, GlassHost::width / 2, GlassHost::height);
  gl.ClearDepth(0.0);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  // The scissor test stays on: it must not cut our blits.
}

TEST_P(DepthTarget, IsRead) {
  const DepthImage image = GetParam();
  GlassHost host;
  const gl::Functions& gl = host.gl;
  GLint most_samples = 0;
  gl.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
  if (image.samples > most_samples) GTEST_SKIP() << "no " << image.samples << " samples here";
  uint32_t name = 0;
  if (image.target == GL_RENDERBUFFER)
    gl.GenRenderbuffers(1, &name);
  else
    gl.GenTextures(1, &name);
  allocate(gl, image, name);
  const gl::Framebuffer around(gl);
  clear_half(gl, image, name, around.id());
  gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
  FrameInputs in = host.inputs();
  if (image.framebuffer) in.frame.source.framebuffer = around.id();
  if (!image.framebuffer && image.target == GL_RENDERBUFFER) in.frame.source.depth_renderbuffer = name;
  if (!image.framebuffer && image.target != GL_RENDERBUFFER) {
    in.frame.source.depth_texture = name;
    in.frame.source.depth_texture_target = image.target;
    in.frame.source.depth_layer = 1;
  }
  host.trace(in);
  GLint bound = 0;
  gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  EXPECT_EQ(static_cast<uint32_t>(bound), host.framebuffer());
  EXPECT_TRUE(gl.IsEnabled(GL_SCISSOR_TEST));
  gl.Disable(GL_SCISSOR_TEST);
  const gl::Program program = host.program(330, plain);
  const GlassHost::Picture picture = host.draw(program, 330);
  for (int y = 0; y < GlassHost::height; ++y)
    for (int x = 0; x < GlassHost::width; ++x) {
      const glm::vec4 pixel = picture[static_cast<size_t>(y * GlassHost::width + x)];
      if (pixel.w == 0.0f) continue;  // beside the pane
      // With several samples a pixel may take its neighbour's answer.
      if (image.samples > 0 && x == GlassHost::width / 2 - 1) continue;
      EXPECT_EQ(pixel.z == 0.0f, x >= GlassHost::width / 2) << x << "," << y;
    }
  EXPECT_GT(answered(picture), 500u);
  if (image.target == GL_RENDERBUFFER)
    gl.DeleteRenderbuffers(1, &name);
  else
    gl.DeleteTextures(1, &name);
}

INSTANTIATE_TEST_SUITE_P(
    Images, DepthTarget,
    testing::Values(DepthImage{GL_DEPTH24_STENCIL8, GL_TEXTURE_2D}, DepthImage{GL_DEPTH32F_STENCIL8, GL_TEXTURE_2D},
                    DepthImage{GL_DEPTH_COMPONENT32F, GL_TEXTURE_2D}, DepthImage{GL_DEPTH_COMPONENT24, GL_TEXTURE_2D},
                    DepthImage{GL_DEPTH_COMPONENT16, GL_TEXTURE_2D},
                    DepthImage{GL_DEPTH24_STENCIL8, GL_TEXTURE_2D_ARRAY},
                    DepthImage{GL_DEPTH_COMPONENT32F, GL_TEXTURE_2D_ARRAY},
                    DepthImage{GL_DEPTH24_STENCIL8, GL_RENDERBUFFER}, DepthImage{GL_DEPTH_COMPONENT16, GL_RENDERBUFFER},
                    DepthImage{GL_DEPTH24_STENCIL8, GL_RENDERBUFFER, 4},
                    DepthImage{GL_DEPTH24_STENCIL8, GL_RENDERBUFFER, 4, true},
                    DepthImage{GL_DEPTH_COMPONENT32F, GL_RENDERBUFFER, 4, true},
                    DepthImage{GL_DEPTH_COMPONENT24, GL_TEXTURE_2D_MULTISAMPLE, 4},
                    DepthImage{GL_DEPTH32F_STENCIL8, GL_TEXTURE_2D_MULTISAMPLE, 4, true}));

TEST(DepthTarget, WhatIsNoDepthIsRefused) {
  GlassHost host;
  const gl::Texture color(host.gl);
  host.gl.BindTexture(GL_TEXTURE_2D, color.id());
  host.gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 8, 8, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  host.gl.BindTexture(GL_TEXTURE_2D, 0);
  FrameInputs in = host.inputs();
  in.frame.source.depth_texture = color.id();
  sideray_error error{};
  sideray_ticket ticket = 0;
  EXPECT_EQ(submit_frame(host.service().get(), in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("depth_texture"));
  in.frame.source.depth_renderbuffer = 3;
  EXPECT_EQ(submit_frame(host.service().get(), in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("give one of them"));
}

// A host with depth of the far plane in its own renderbuffer.
struct HostWithDepth : GlassHost {
  explicit HostWithDepth(gl::Profile profile = gl::Profile::core) : GlassHost(profile), depth(gl) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth.id());
    gl.ClearDepth(1.0);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }
  gl::Renderbuffer depth;
};

// Returns a mask of a byte a pixel for the right half of the picture: every other row has counts, the others "any
// number".
std::vector<uint8_t> half_mask(size_t row_bytes) {
  std::vector<uint8_t> mask(row_bytes * GlassHost::height);
  for (size_t y = 0; y < GlassHost::height; ++y)
    for (size_t x = GlassHost::width / 2; x < GlassHost::width; ++x) mask[y * row_bytes + x] = y % 2 ? 1 : 255;
  return mask;
}

TEST(MaskSource, TextureAndMemoryAreTheSame) {
  HostWithDepth host;
  const gl::Functions& gl = host.gl;
  const gl::Program program = host.program(330, plain);
  const std::vector<uint8_t> tight = half_mask(GlassHost::width), wide = half_mask(GlassHost::width + 5);
  const gl::Texture texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, GlassHost::width, GlassHost::height, 0, GL_RED, GL_UNSIGNED_BYTE,
                tight.data());
  gl.BindTexture(GL_TEXTURE_2D, 0);
  FrameInputs in = host.inputs();
  in.frame.source.mask = SIDERAY_MASK_TEXTURE;
  in.frame.source.mask_texture = texture.id();
  host.trace(in);
  const GlassHost::Picture from_texture = host.draw(program, 330);
  in.frame.source.mask = SIDERAY_MASK_MEMORY;
  in.frame.source.mask_texels = wide.data();
  in.frame.source.mask_row_bytes = GlassHost::width + 5;
  host.trace(in);
  EXPECT_EQ(host.draw(program, 330), from_texture);
  for (size_t i = 0; i < from_texture.size(); ++i)
    if (from_texture[i].w > 0) {
      EXPECT_EQ(from_texture[i].z == 0.0f, i % GlassHost::width >= GlassHost::width / 2) << i;
    }
  EXPECT_GT(answered(from_texture), 500u);
  EXPECT_GT(fallen_back(from_texture), 500u);
}

class GlslVersion : public testing::TestWithParam<int> {};

TEST_P(GlslVersion, GetsTheSameAnswers) {
  const int version = GetParam();
  HostWithDepth host(gl::Profile::compatibility);
  if (version > 10 * host.gl.version) GTEST_SKIP() << "no GLSL " << version << " here";
  host.trace(host.inputs());
  const GlassHost::Picture expected = host.draw(host.program(330, plain), 330);
  EXPECT_GT(answered(expected), 1000u);
  EXPECT_EQ(fallen_back(expected), 0u);
  FrameInputs in = host.inputs();
  in.layers->float_ids = version < 130;
  host.trace(in);
  EXPECT_EQ(host.draw(host.program(version, plain), version), expected);
  in.layers->cache_rate = SIDERAY_RATE_CHECKERBOARD;  // through neighbours
  host.trace(in);
  const GlassHost::Picture sparse = host.draw(host.program(version, plain), version);
  EXPECT_GT(answered(sparse), answered(expected) * 95 / 100);
}

INSTANTIATE_TEST_SUITE_P(Versions, GlslVersion, testing::Values(120, 130, 140, 150, 330, 400, 410, 420, 430, 440, 450));

// The colour of a fragment: the radiance of a resolved layer, or blue: 2 = hidden behind one, 1 = anything else.
const std::string look = "look(world, id)";
const std::string look_function =
    "vec3 look(vec3 at, SIDERAY_UINT surface) {\n"
    "  vec3 radiance;\n"
    "  int answer = sideray_look_up(at, surface, radiance);\n"
    "  if (answer == SIDERAY_REFRACTED) return radiance;\n"
    "  return vec3(0.0, 0.0, answer == SIDERAY_HIDDEN ? 2.0 : 1.0);\n"
    "}\n";

size_t hidden(const GlassHost::Picture& picture) {
  return static_cast<size_t>(std::count_if(picture.begin(), picture.end(), [](glm::vec4 p) { return p.z == 2.0f; }));
}

// The wall behind the glass comes from rays alone, and the host's own fragments behind the glass are hidden.
TEST_P(GlslVersion, ShowsWhatIsSeenThroughGlassThatBends) {
  const int version = GetParam();
  HostWithDepth host(gl::Profile::compatibility);
  if (version > 10 * host.gl.version) GTEST_SKIP() << "no GLSL " << version << " here";
  host.bend_light();
  FrameInputs in = host.inputs();
  in.layers->float_ids = version < 130;
  in.layers->refraction = 1;
  const gl::Program program = host.program(version, look, look_function);
  const glm::dmat4 clip = GlassHost::clip_from_world();
  for (const sideray_cache_rate rate : {SIDERAY_RATE_FULL, SIDERAY_RATE_CHECKERBOARD}) {
    in.layers->cache_rate = rate;
    host.trace(in);
    const GlassHost::Picture seen = host.draw(program, version);
    EXPECT_GT(answered(seen), 1000u);
    EXPECT_LT(fallen_back(seen), answered(seen) / 20);
    const glm::vec4 middle = seen[GlassHost::width * (GlassHost::height / 2) + GlassHost::width / 2];
    EXPECT_NEAR(middle.x, 0.25f * 0.96f, 0.005f);  // 0.04 is reflected, of nothing
    EXPECT_NEAR(middle.y, 0.5f * 0.96f, 0.005f);
    const GlassHost::Picture behind = host.draw(program, version, clip, {0, 0, -0.5f});
    EXPECT_GT(hidden(behind), 500u);
    EXPECT_EQ(answered(behind), 0u);
    const GlassHost::Picture in_front = host.draw(program, version, clip, {0, 0, 0.5f});
    EXPECT_EQ(hidden(in_front) + answered(in_front), 0u);
  }
  in.layers->refraction = 0;
  in.layers->cache_rate = SIDERAY_RATE_FULL;
  host.trace(in);
  const GlassHost::Picture straight = host.draw(program, version);
  EXPECT_EQ(hidden(straight) + answered(straight), 0u);
}

TEST(RadianceSpace, IsThatOfTheHost) {
  HostWithDepth host;
  const gl::Program program = host.program(330, plain);
  for (const sideray_radiance_space space : {SIDERAY_SPACE_LINEAR, SIDERAY_SPACE_SRGB, SIDERAY_SPACE_GAMMA22})
    for (const float scale : {1.0f, 3.0f}) {
      FrameInputs in = host.inputs();
      host.trace(in);
      const GlassHost::Picture linear = host.draw(program, 330);
      in.layers->radiance_space = space;
      in.layers->radiance_scale = scale;
      host.trace(in);
      const GlassHost::Picture encoded = host.draw(program, 330);
      ASSERT_EQ(answered(encoded), answered(linear));
      for (size_t i = 0; i < linear.size(); ++i)
        for (int c = 0; c < 2; ++c)
          ASSERT_NEAR(encoded[i][c], linear[i].w > 0 ? model::encode_radiance(linear[i][c], space, scale) : 0.0f,
                      encoded[i].y / 1024);
    }
}

TEST(RadianceSpace, TransferFunctionsAreThoseOfTheirNames) {
  EXPECT_FLOAT_EQ(model::encode_radiance(0.5f, SIDERAY_SPACE_LINEAR, 2.0f), 1.0f);
  EXPECT_NEAR(model::encode_radiance(0.2158605f, SIDERAY_SPACE_SRGB, 1.0f), 128.0f / 255, 1e-5);  // IEC 61966-2-1
  EXPECT_NEAR(model::encode_radiance(0.002f, SIDERAY_SPACE_SRGB, 1.0f), 0.02584f, 1e-6);
  EXPECT_NEAR(model::encode_radiance(0.2176376f, SIDERAY_SPACE_GAMMA22, 1.0f), 0.5f, 1e-5);
}

const std::string moving = "sideray_translucent_moving(vec3(0.0, 0.0, 1.0), world, id, before)";

// Pane and camera have moved since the cached frame.
TEST(MovingGlass, FindsItsAnswerWhereItWas) {
  HostWithDepth host;
  host.trace(host.inputs());
  const glm::vec3 offset(0.13f, -0.07f, 0.21f);
  for (const double eye_x : {0.0, 0.2}) {
    const glm::dmat4 clip = GlassHost::clip_from_world(eye_x);
    const GlassHost::Picture late = host.draw(host.program(330, plain), 330, clip, offset);
    const GlassHost::Picture followed = host.draw(host.program(330, moving), 330, clip, offset);
    const size_t pane = answered(followed) + fallen_back(followed);
    EXPECT_GT(pane, 1000u);
    EXPECT_LT(answered(late), pane / 10) << "without its motion it must not be taken for where it was";
    EXPECT_GT(answered(followed), pane * 97 / 100);
  }
}

TEST(MovingGlass, ThatHasNotMovedIsDrawnAsIfItCouldNot) {
  HostWithDepth host;
  host.trace(host.inputs());
  EXPECT_EQ(host.draw(host.program(330, moving), 330), host.draw(host.program(330, plain), 330));
}

// Surfaces from outside the cached picture have no answer, and take no other one.
TEST(MovingGlass, FromBeyondTheEdgeFallsBack) {
  HostWithDepth host;
  FrameInputs in = host.inputs();
  GlassHost::set_view(in, GlassHost::clip_from_world(2.6));  // sees the left part of the pane alone
  host.trace(in);
  const GlassHost::Picture picture = host.draw(host.program(330, moving), 330);
  EXPECT_GT(answered(picture), 100u);
  EXPECT_GT(fallen_back(picture), 100u);
}

}  // namespace
}  // namespace sideray::tests::targets_test
