// Tests that a compute shader packs depth and stencil into the driver's words, for every place where hosts keep them.
#include "bridge/transport/depth_packer.h"

#include <EGL/egl.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <cstring>
#include <numeric>
#include <random>

#include "bridge/transport/readback.h"
#include "gl/gl_contexts.h"
#include "gl/resources/state_guard.h"
#include "offscreen.h"

namespace sideray::bridge::depth_packer_test {
namespace {

constexpr int width = 83, height = 61;
constexpr uint32_t largest_depth = 0xffffff;
// Up to this depth, and for the largest one, llvmpipe gives shaders exact values.
constexpr uint32_t always_exact = 0x600000;

// Holds the rectangle that is read from a source.
struct Area {
  int x, y, width, height;
};
constexpr Area areas[] = {{0, 0, width, height}, {3, 5, 17, 1}, {1, 0, 1, 13}, {width - 7, height - 3, 7, 3},
                          {2, 1, 64, 48},        {0, 0, 1, 1}};

std::vector<uint32_t> read(const gl::Functions& gl, sideray_frame_source source, const Area& area, bool persistent,
                           DepthPacker* packer) {
  source.x = area.x, source.y = area.y, source.width = area.width, source.height = area.height;
  const gl::PixelTransferGuard transfer(gl);
  const gl::FramebufferGuard framebuffers(gl);
  Readback readback;
  readback.start(gl, {source, gl::StatePolicy::restore, true, persistent, packer});
  readback.issue_fence(gl);
  const rt::DepthImage image = readback.map(gl);
  std::vector<uint32_t> words(static_cast<size_t>(area.width) * static_cast<size_t>(area.height));
  EXPECT_EQ(image.format, rt::DepthFormat::d24s8);
  EXPECT_EQ(image.row_bytes, static_cast<size_t>(area.width) * sizeof(words[0]));
  std::memcpy(words.data(), image.texels, words.size() * sizeof(words[0]));
  readback.finish(gl);
  return words;
}

// Random depths, some of them the nearest and the farthest, and every stencil value.
std::vector<uint32_t> random_words(size_t count, bool exact) {
  std::mt19937 random(5);
  std::vector<uint32_t> words(count);
  for (size_t i = 0; i < count; ++i) {
    const auto number = static_cast<uint32_t>(random());
    const uint32_t any = number % (exact ? largest_depth + 1 : always_exact);
    const uint32_t depth = i % 7 == 0 ? 0 : i % 7 == 1 ? largest_depth : any;
    words[i] = depth << 8 | static_cast<uint32_t>((i + i / 256) % 256);
  }
  return words;
}

void upload(const gl::Functions& gl, GLenum target, int level, int w, int h, int layers, const void* words) {
  if (target == GL_TEXTURE_2D_ARRAY)
    gl.TexImage3D(target, level, GL_DEPTH24_STENCIL8, w, h, layers, 0, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, words);
  else
    gl.TexImage2D(target, level, GL_DEPTH24_STENCIL8, w, h, 0, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, words);
}

sideray_frame_source source_of(uint32_t framebuffer) {
  sideray_frame_source source = sideray_frame_defaults().source;
  source.framebuffer = framebuffer;
  return source;
}

// Holds the host's images, all filled with the same words.
class Images {
 public:
  Images(const gl::Functions& gl, const std::vector<uint32_t>& words) : gl_(gl) {
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl.BindTexture(GL_TEXTURE_2D, flat_.id());
    upload(gl, GL_TEXTURE_2D, 0, width, height, 1, words.data());
    gl.BindTexture(GL_TEXTURE_2D, levels_.id());
    upload(gl, GL_TEXTURE_2D, 0, 2 * width, 2 * height, 1, nullptr);
    upload(gl, GL_TEXTURE_2D, 1, width, height, 1, words.data());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 1);
    gl.BindTexture(GL_TEXTURE_2D, 0);
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, array_.id());
    std::vector<uint32_t> twice(words.size());
    twice.insert(twice.end(), words.begin(), words.end());
    upload(gl, GL_TEXTURE_2D_ARRAY, 0, width, height, 2, twice.data());
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, of_flat_.id());
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, flat_.id(), 0);
    draw_nothing();
    gl.BindFramebuffer(GL_FRAMEBUFFER, of_level_.id());
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, levels_.id(), 1);
    draw_nothing();
    gl.BindFramebuffer(GL_FRAMEBUFFER, of_layer_.id());
    gl.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, array_.id(), 0, 1);
    draw_nothing();
    fill_renderbuffer(of_plain_, plain_, 0);
    fill_renderbuffer(of_sampled_, sampled_, 4);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
  }

  std::vector<std::pair<const char*, sideray_frame_source>> sources() const {
    std::vector<std::pair<const char*, sideray_frame_source>> list{
        {"framebuffer of a texture", source_of(of_flat_.id())},
        {"framebuffer of a level", source_of(of_level_.id())},
        {"framebuffer of a layer", source_of(of_layer_.id())},
        {"framebuffer of a renderbuffer", source_of(of_plain_.id())},
        {"multisampled framebuffer", source_of(of_sampled_.id())}};
    sideray_frame_source texture = source_of(0), layer = source_of(0), renderbuffer = source_of(0);
    texture.depth_texture = flat_.id();
    layer.depth_texture = array_.id();
    layer.depth_texture_target = GL_TEXTURE_2D_ARRAY;
    layer.depth_layer = 1;
    renderbuffer.depth_renderbuffer = plain_.id();
    list.insert(list.end(), {{"texture", texture}, {"layer", layer}, {"renderbuffer", renderbuffer}});
    return list;
  }
  uint32_t framebuffer() const { return of_flat_.id(); }

 private:
  void draw_nothing() const {
    gl_.DrawBuffer(GL_NONE);
    gl_.ReadBuffer(GL_NONE);
    EXPECT_EQ(gl_.CheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
  }
  // OpenGL cannot copy single-sampled images to multisampled ones, which therefore have one depth and one stencil
  // value.
  void fill_renderbuffer(const gl::Framebuffer& framebuffer, const gl::Renderbuffer& renderbuffer, int samples) const {
    gl_.BindRenderbuffer(GL_RENDERBUFFER, renderbuffer.id());
    gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH24_STENCIL8, width, height);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, 0);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, renderbuffer.id());
    draw_nothing();
    if (samples > 0) {
      gl_.ClearDepth(0.25);
      gl_.ClearStencil(200);
      gl_.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
      return;
    }
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, of_flat_.id());
    gl_.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT,
                        GL_NEAREST);
  }

  const gl::Functions& gl_;
  gl::Texture flat_{gl_}, levels_{gl_}, array_{gl_};
  gl::Renderbuffer plain_{gl_}, sampled_{gl_};
  gl::Framebuffer of_flat_{gl_}, of_level_{gl_}, of_layer_{gl_}, of_plain_{gl_}, of_sampled_{gl_};
};

class DepthPacking : public testing::TestWithParam<std::tuple<std::string, gl::Profile>> {
 protected:
  void SetUp() override {
    const auto& [name, profile] = GetParam();
    context_ = gl::open_context(name, profile);
    if (!context_ && profile == gl::Profile::core && gl::is_required(name)) FAIL() << "required context " << name;
    if (!context_) GTEST_SKIP() << "no such context here: " << name;
    context_->make_current();
    if (!gl().compute) GTEST_SKIP() << "no compute shaders";
    packer_ = std::make_unique<DepthPacker>(gl());
    exact_ = is_exact();
  }
  void TearDown() override {
    packer_.reset();
    if (!context_) return;
    EXPECT_EQ(gl::take_problems(*context_), std::vector<std::string>{});
    context_->release_current();
  }
  bool is_exact() {
    const gl::PixelTransferGuard transfer(gl());
    const gl::FramebufferGuard framebuffers(gl());
    return packer_->is_exact();
  }
  const gl::Functions& gl() const { return context_->functions(); }

  std::unique_ptr<gl::Context> context_;
  std::unique_ptr<DepthPacker> packer_;
  bool exact_ = false;
};
INSTANTIATE_TEST_SUITE_P(All, DepthPacking,
                         testing::Combine(testing::ValuesIn(gl::driver_contexts()),
                                          testing::Values(gl::Profile::core, gl::Profile::compatibility)),
                         gl::name_of_driver_and_profile);

TEST_P(DepthPacking, GivesTheWordsOfTheDriverWhereverTheyAre) {
  const std::vector<uint32_t> words = random_words(size_t{width} * height, exact_);
  const Images images(gl(), words);
  for (const auto& [name, source] : images.sources())
    for (const Area& area : areas)
      for (const bool persistent : {false, true}) {
        if (persistent && !gl().buffer_storage) continue;
        SCOPED_TRACE(testing::Message() << name << " " << area.x << "," << area.y << " " << area.width << "x"
                                        << area.height << (persistent ? " persistent" : ""));
        const std::vector<uint32_t> copied = read(gl(), source, area, persistent, nullptr);
        EXPECT_EQ(read(gl(), source, area, persistent, packer_.get()), copied);
        if (std::string(name) != "multisampled framebuffer") {
          const auto at = static_cast<size_t>(area.y * width + area.x);
          EXPECT_EQ(copied[0], words[at]) << "the test itself";
        }
      }
}

TEST_P(DepthPacking, IsExactForEachDepthWhereItSaysSo) {
  if (!exact_) GTEST_SKIP() << "this driver rounds depth on its way to a shader";
  constexpr int side = 4096;
  std::vector<uint32_t> words(size_t{side} * side);
  for (uint32_t i = 0; i < words.size(); ++i) words[i] = i << 8 | (i * 2654435761u >> 24);
  const gl::Texture texture(gl());
  gl().BindTexture(GL_TEXTURE_2D, texture.id());
  upload(gl(), GL_TEXTURE_2D, 0, side, side, 1, words.data());
  gl().BindTexture(GL_TEXTURE_2D, 0);
  sideray_frame_source source = source_of(0);
  source.depth_texture = texture.id();
  EXPECT_EQ(read(gl(), source, {0, 0, side, side}, false, packer_.get()), words);
}

// Packs the default framebuffer of a window, which no shader can sample.
TEST(DepthPackingOfAWindow, GivesTheWordsOfTheDriver) {
  std::unique_ptr<Offscreen> window;
  try {
    window = std::make_unique<Offscreen>("auto", width, height, false);
  } catch (const std::runtime_error& error) {
    if (std::getenv("SIDERAY_REQUIRE_CONTEXTS")) FAIL() << "required contexts: " << error.what();
    GTEST_SKIP() << error.what();
  }
  const gl::Functions gl = gl::load_functions(
      [](void*, const char* name) { return reinterpret_cast<void*>(eglGetProcAddress(name)); }, nullptr);
  if (!gl.compute) GTEST_SKIP() << "no compute shaders";
  DepthPacker packer(gl);
  const std::vector<uint32_t> words = random_words(size_t{width} * height, false);
  const Images images(gl, words);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, images.framebuffer());
  gl.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT, GL_NEAREST);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  ASSERT_EQ(read(gl, source_of(0), areas[0], false, nullptr), words) << "the test itself";
  for (const Area& area : areas)
    EXPECT_EQ(read(gl, source_of(0), area, false, &packer), read(gl, source_of(0), area, false, nullptr));
  EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
}

// The driver packs other formats.
TEST_P(DepthPacking, LeavesOtherFormatsToTheDriver) {
  const gl::Texture texture(gl());
  gl().BindTexture(GL_TEXTURE_2D, texture.id());
  std::vector<float> depths(size_t{width} * height);
  std::iota(depths.begin(), depths.end(), 1.0f);
  for (float& depth : depths) depth /= static_cast<float>(depths.size());
  gl().TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, width, height, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                  depths.data());
  gl().BindTexture(GL_TEXTURE_2D, 0);
  sideray_frame_source source = source_of(0);
  source.depth_texture = texture.id();
  source.width = width, source.height = height;
  const gl::PixelTransferGuard transfer(gl());
  const gl::FramebufferGuard framebuffers(gl());
  Readback readback;
  readback.start(gl(), {source, gl::StatePolicy::restore, false, false, packer_.get()});
  const rt::DepthImage image = readback.map(gl());
  EXPECT_EQ(image.format, rt::DepthFormat::d32f);
  EXPECT_EQ(std::memcmp(image.texels, depths.data(), depths.size() * sizeof(float)), 0);
  readback.finish(gl());
}

}  // namespace
}  // namespace sideray::bridge::depth_packer_test
