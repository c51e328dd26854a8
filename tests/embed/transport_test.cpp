// Tests the upload of results: the layers that are uploaded, and persistently mapped buffers.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <random>
#include <string>
#include <thread>

#include "bridge/jobs/layers/layer_textures.h"
#include "bridge/transport/tile_rectangles.h"
#include "bridge/transport/transport.h"
#include "gl/context/context.h"
#include "gl/resources/state_guard.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

rt::Executor copiers(2);

float half_value(uint16_t half) {
  return glm::unpackHalf1x16(half);
}

// Returns how often each pixel is covered.
std::vector<uint32_t> covered_by(const std::vector<Rectangle>& rectangles, uint32_t width, uint32_t height) {
  std::vector<uint32_t> times(size_t{width} * height);
  for (const Rectangle& r : rectangles)
    for (uint32_t y = r.y; y < r.y + r.height; ++y)
      for (uint32_t x = r.x; x < r.x + r.width; ++x) ++times.at(size_t{y} * width + x);
  return times;
}

uint64_t area_of(const std::vector<Rectangle>& rectangles) {
  uint64_t area = 0;
  for (const Rectangle& r : rectangles) area += uint64_t{r.width} * r.height;
  return area;
}

TEST(TileRectangles, CoverWhatIsWantedOnceAndByTexelsNothingElse) {
  constexpr uint32_t tile = 32;
  std::mt19937 random(11);
  for (int round = 0; round < 200; ++round) {
    const auto below = [&](uint32_t end) { return static_cast<uint32_t>(random() % end); };
    const uint32_t width = 1 + below(700), height = 1 + below(500), rare = 1 + below(6);
    const uint32_t columns = (width + tile - 1) / tile, rows = (height + tile - 1) / tile;
    std::vector<uint8_t> wanted(size_t{columns} * rows);
    for (uint8_t& w : wanted) w = random() % rare == 0;
    const std::vector<Rectangle> exact = rectangles_of(wanted, tile, width, height, RectangleCost::texels);
    const std::vector<Rectangle> few = rectangles_of(wanted, tile, width, height, RectangleCost::rectangles);
    const std::vector<uint32_t> by_exact = covered_by(exact, width, height), by_few = covered_by(few, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const size_t at = size_t{y} * width + x;
        const uint32_t is_wanted = wanted[size_t{y / tile} * columns + x / tile];
        ASSERT_EQ(by_exact[at], is_wanted);
        ASSERT_GE(by_few[at], is_wanted);
        ASSERT_LE(by_few[at], 1u);
      }
    EXPECT_LE(few.size(), exact.size());
  }
}

TEST(TileRectangles, AreOneWhereWhatLiesBetweenCostsLessThanAnother) {
  // Two tiles in rows 1 and r of a picture 100 tiles high: the rows between are 32 x 32 pixels each.
  const auto count_of = [](uint32_t r) {
    std::vector<uint8_t> wanted(100, 0);
    wanted[1] = wanted[r] = 1;
    const std::vector<Rectangle> few = rectangles_of(wanted, 32, 32, 3200, RectangleCost::rectangles);
    EXPECT_EQ(area_of(few), few.size() == 1 ? uint64_t{r} * 32 * 32 : 2u * 32 * 32);
    return few.size();
  };
  EXPECT_EQ(count_of(2 + 64), 1u);  // 65536 texels
  EXPECT_EQ(count_of(2 + 65), 2u);
}

// Returns whether SIDERAY_REQUIRE_CONTEXTS names a context of the platform.
bool is_required(const std::string& platform) {
  const char* variable = std::getenv("SIDERAY_REQUIRE_CONTEXTS");
  const std::string required = variable ? variable : "";
  if (platform == "osmesa") return required.find("osmesa") != std::string::npos;
  return required.find("surfaceless") != std::string::npos || required.find("device") != std::string::npos;
}

// Makes a context of each platform current; null where this machine has none.
struct Transported : testing::TestWithParam<const char*> {
  void SetUp() override {
    try {
      context = gl::Context::create(GetParam(), "");
    } catch (const Failure& failure) {
      if (is_required(GetParam())) FAIL() << failure.what();
      GTEST_SKIP() << failure.what();
    }
    context->make_current();
  }
  void TearDown() override {
    if (!context) return;
    EXPECT_EQ(context->functions().GetError(), unsigned{GL_NO_ERROR});
    EXPECT_TRUE(context->take_errors().empty());
    context->release_current();
  }
  const gl::Functions& gl() const { return context->functions(); }

  template <typename T>
  std::vector<T> read(uint32_t texture, GLenum format, GLenum type, size_t count) const {
    std::vector<T> values(count);
    const gl::PixelTransferGuard transfer(gl());
    gl().PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl().BindTexture(GL_TEXTURE_2D_ARRAY, texture);
    gl().GetTexImage(GL_TEXTURE_2D_ARRAY, 0, format, type, values.data());
    return values;
  }

  std::unique_ptr<gl::Context> context;
};
INSTANTIATE_TEST_SUITE_P(All, Transported, testing::Values("egl", "osmesa"),
                         [](const auto& suite) { return std::string(suite.param); });

// Makes frames whose tiles and layers change from one to the next.
struct Frames {
  explicit Frames(uint32_t seed) : random(seed) {
    cache.width = 101, cache.height = 67, cache.layers = 4;
    cache.radiance.resize(4 * texels()), cache.distance.resize(texels()), cache.surface_id.resize(texels());
    cache.traced_tiles.assign(4 * 3, 0);
  }
  size_t plane() const { return size_t{cache.width} * cache.height; }
  size_t texels() const { return plane() * cache.layers; }

  void next() {
    const std::vector<uint8_t> before = cache.traced_tiles;
    cache.dirty_tiles.assign(before.size(), first ? 1 : 0);
    first = false;
    for (size_t tile = 0; tile < before.size(); ++tile) {
      cache.traced_tiles[tile] = random() % 2;
      if (before[tile] || cache.traced_tiles[tile]) cache.dirty_tiles[tile] = 1;
      const uint32_t most = number() % (cache.layers + 1);
      if (cache.dirty_tiles[tile]) fill(tile, cache.traced_tiles[tile] ? most : 0);
    }
  }

  void fill(size_t tile, uint32_t most_layers) {
    const auto x0 = static_cast<uint32_t>(tile % 4) * 32, y0 = static_cast<uint32_t>(tile / 4) * 32;
    for (uint32_t y = y0; y < std::min(y0 + 32, cache.height); ++y)
      for (uint32_t x = x0; x < std::min(x0 + 32, cache.width); ++x) {
        const uint32_t count = most_layers ? number() % (most_layers + 1) : 0;
        for (uint32_t layer = 0; layer < cache.layers; ++layer) {
          const size_t i = plane() * layer + size_t{y} * cache.width + x;
          const bool there = layer < count;
          cache.distance[i] = there ? 1.0f + static_cast<float>(random() % 1000) : 0.0f;
          cache.surface_id[i] = there ? number() : 0;
          for (size_t c = 0; c < 4; ++c)
            cache.radiance[4 * i + c] = there ? static_cast<uint16_t>(random() % 0x7c00) : uint16_t{0};
        }
      }
  }

  uint32_t number() { return static_cast<uint32_t>(random()); }

  rt::LayerCache cache;
  std::mt19937 random;
  bool first = true;
};

// In every frame and each way, texels that a shader can read equal the cache; others are not uploaded.
TEST_P(Transported, LayersArriveAsTheyAre) {
  for (const bool persistent : {false, true}) {
    if (persistent && !gl().buffer_storage) continue;
    Frames frames(3);
    CacheTextures textures;
    const size_t plane = frames.plane(), count = frames.texels();
    for (int frame = 0; frame < 6; ++frame) {
      if (frame == 4) textures.invalidate();
      frames.next();
      const rt::LayerCache& cache = frames.cache;
      {
        const gl::PixelTransferGuard transfer(gl());
        textures.upload(gl(), cache, {}, {persistent, copiers});
      }
      EXPECT_EQ(textures.bytes(), count * 16);
      const auto distance = read<float>(textures.distance(), GL_RED, GL_FLOAT, count);
      const auto id = read<uint32_t>(textures.surface_id(), GL_RED_INTEGER, GL_UNSIGNED_INT, count);
      const auto radiance = read<glm::vec3>(textures.radiance(), GL_RGB, GL_FLOAT, count);
      for (size_t i = 0; i < count; ++i) {
        const bool reachable = i < plane || cache.distance[i - plane] > 0.0f;
        if (!reachable) continue;
        ASSERT_EQ(distance[i], cache.distance[i]) << "frame " << frame << " texel " << i;
        if (cache.distance[i] == 0.0f) continue;
        ASSERT_EQ(id[i], cache.surface_id[i]);
        const uint16_t* halfs = &cache.radiance[4 * i];
        const glm::vec3 expected(half_value(halfs[0]), half_value(halfs[1]), half_value(halfs[2]));
        ASSERT_EQ(radiance[i], expected) << "frame " << frame << " texel " << i;
      }
    }
  }
}

// A layer in one tile takes an upload of its three planes; in the next frame, without it, of its distances alone.
TEST_P(Transported, OnlyLayersThatHoldSomethingAreMoved) {
  Frames frames(5);
  CacheTextures textures;
  const gl::PixelTransferGuard transfer(gl());
  rt::LayerCache& cache = frames.cache;
  cache.dirty_tiles.assign(12, 1);
  EXPECT_EQ(textures.upload(gl(), cache, {}, {false, copiers}), frames.texels() * 4)
      << "of new textures, all distances";
  cache.dirty_tiles.assign(12, 0);
  cache.dirty_tiles[5] = 1;
  cache.distance[40 * cache.width + 40] = 2.0f;
  EXPECT_EQ(textures.upload(gl(), cache, {}, {false, copiers}), 32u * 32u * (8 + 4 + 4));
  EXPECT_EQ(textures.upload(gl(), cache, {}, {false, copiers}), 32u * 32u * (8 + 4 + 4));
  cache.distance[40 * cache.width + 40] = 0.0f;
  EXPECT_EQ(textures.upload(gl(), cache, {}, {false, copiers}), 32u * 32u * 4);
  EXPECT_EQ(textures.upload(gl(), cache, {}, {false, copiers}), 0u);
  EXPECT_EQ(textures.upload(gl(), cache, {.float_ids = true}, {false, copiers}), frames.texels() * 4)
      << "ids of another kind are new textures";
}

struct Environment {
  explicit Environment(const char* value) {
    value ? setenv("SIDERAY_TRANSPORT", value, 1) : unsetenv("SIDERAY_TRANSPORT");
  }
  ~Environment() { unsetenv("SIDERAY_TRANSPORT"); }
};

// Records the offsets in a buffer at which uploads begin.
struct Offsets {
  static inline PFNGLTEXSUBIMAGE2DPROC send = nullptr;
  static inline std::vector<std::pair<uintptr_t, GLenum>> sent;

  static void GLAD_API_PTR call(GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height,
                                GLenum format, GLenum type, const void* texels) {
    sent.emplace_back(reinterpret_cast<uintptr_t>(texels), type);
    send(target, level, x, y, width, height, format, type, texels);
  }
  explicit Offsets(gl::Functions& functions) { send = std::exchange(functions.TexSubImage2D, &call); }
  ~Offsets() { sent.clear(); }
};

// Some drivers refuse uploads whose offset is not a multiple of their type's size.
TEST_P(Transported, PiecesOfSeveralTypesBeginWhereTheirTypeMay) {
  if (!gl().buffer_storage) GTEST_SKIP() << "no buffers that stay mapped";
  constexpr TexelFormat byte1{GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1};
  const std::vector<uint8_t> bytes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const std::vector<float> floats{0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f,
                                  0.9f, 1.0f, 1.1f, 1.2f, 1.3f, 1.4f, 1.5f};
  gl::Functions functions = gl();
  const Offsets offsets(functions);
  gl::Texture small(functions), large(functions);
  const gl::PixelTransferGuard transfer(functions);
  for (const auto& [texture, format] : {std::pair(small.id(), byte1), std::pair(large.id(), single)}) {
    functions.BindTexture(GL_TEXTURE_2D, texture);
    functions.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format.internal), 5, 3, 0, format.format, format.type,
                         nullptr);
  }
  const TexturePiece pieces[] = {
      {GL_TEXTURE_2D, small.id(), 0, byte1, {0, 0, 5, 3}, reinterpret_cast<const std::byte*>(bytes.data()), 5},
      {GL_TEXTURE_2D, large.id(), 0, single, {0, 0, 5, 3}, reinterpret_cast<const std::byte*>(floats.data()), 5}};
  TextureUpload upload;
  EXPECT_EQ(upload.send(functions, pieces, {true, copiers}), 15u + 60u);
  for (const auto& [offset, type] : Offsets::sent) {
    EXPECT_EQ(offset % (type == GL_FLOAT ? sizeof(float) : 1), 0u);
  }
  ASSERT_EQ(Offsets::sent.size(), 2u);
  std::vector<uint8_t> got_bytes(15);
  std::vector<float> got_floats(15);
  functions.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  functions.PixelStorei(GL_PACK_ALIGNMENT, 1);
  functions.BindTexture(GL_TEXTURE_2D, small.id());
  functions.GetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_UNSIGNED_BYTE, got_bytes.data());
  functions.BindTexture(GL_TEXTURE_2D, large.id());
  functions.GetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_FLOAT, got_floats.data());
  functions.BindTexture(GL_TEXTURE_2D, 0);
  EXPECT_EQ(got_bytes, bytes);
  EXPECT_EQ(got_floats, floats);
}

// Counts buffers, and lets no fence be reached.
struct SlowDriver {
  static inline PFNGLGENBUFFERSPROC gen_buffers = nullptr;
  static inline int buffers = 0;

  static void GLAD_API_PTR count(GLsizei n, GLuint* names) {
    buffers += n;
    gen_buffers(n, names);
  }
  static GLenum GLAD_API_PTR wait(GLsync, GLbitfield, GLuint64) { return GL_TIMEOUT_EXPIRED; }
  explicit SlowDriver(gl::Functions& functions) {
    gen_buffers = std::exchange(functions.GenBuffers, &count);
    functions.ClientWaitSync = &wait;
    buffers = 0;
  }
};

// Uploads faster than the driver never overwrite texels that it may still read.
TEST_P(Transported, WhatTheDriverMayStillReadIsNotOverwritten) {
  if (!gl().buffer_storage || !gl().ClientWaitSync) GTEST_SKIP() << "no buffers that stay mapped, or no fences";
  gl::Functions functions = gl();
  const SlowDriver slow(functions);
  const gl::Texture texture(functions);
  const gl::PixelTransferGuard transfer(functions);
  functions.BindTexture(GL_TEXTURE_2D, texture.id());
  functions.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, 5, 3, 0, GL_RED, GL_FLOAT, nullptr);
  TextureUpload upload;
  std::vector<float> texels(15), got(15);
  const TexturePiece piece{
      GL_TEXTURE_2D, texture.id(), 0, single, {0, 0, 5, 3}, reinterpret_cast<const std::byte*>(texels.data()), 5};
  for (int sent = 1; sent <= 4; ++sent) {
    std::fill(texels.begin(), texels.end(), static_cast<float>(sent));
    EXPECT_EQ(upload.send(functions, {&piece, 1}, {true, copiers}), 60u);
    EXPECT_EQ(SlowDriver::buffers, sent) << "another buffer for each, old ones being left to the driver";
    functions.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    functions.BindTexture(GL_TEXTURE_2D, texture.id());
    functions.GetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_FLOAT, got.data());
    EXPECT_EQ(got, texels);
  }
  functions.BindTexture(GL_TEXTURE_2D, 0);
}

struct Choice : Transported {
  void SetUp() override {
    Transported::SetUp();
    if (!context) return;
    depth = gl::Renderbuffer(gl());
    framebuffer = gl::Framebuffer(gl());
    gl().BindRenderbuffer(GL_RENDERBUFFER, depth.id());
    gl().RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, 64, 48);
    gl().BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    gl().FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth.id());
    gl().DrawBuffer(GL_NONE);
    gl().ReadBuffer(GL_NONE);
    gl().ClearDepth(0.625);
    gl().Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }
  void TearDown() override {
    framebuffer.reset(), depth.reset();
    Transported::TearDown();
  }
  Transport choose(const gl::Functions& functions,
                   sideray_frame_source source = sideray_frame_defaults().source) const {
    source.framebuffer = framebuffer.id();
    source.width = 64;
    source.height = 48;
    const bool stencil = source.mask == SIDERAY_MASK_STENCIL || source.mask == SIDERAY_MASK_COUNT;
    const gl::PixelTransferGuard transfer(functions);
    return choose_transport(functions, {source, gl::StatePolicy::restore, stencil, false}, copiers);
  }
  gl::Renderbuffer depth;
  gl::Framebuffer framebuffer;
};
INSTANTIATE_TEST_SUITE_P(All, Choice, testing::Values("egl", "osmesa"),
                         [](const auto& suite) { return std::string(suite.param); });

TEST_P(Choice, IsPinnedByTheEnvironment) {
  {
    const Environment pinned("copy");
    const Transport copy = choose(gl());
    EXPECT_FALSE(copy.persistent_readback || copy.persistent_upload);
  }
  if (gl().buffer_storage) {
    const Environment pinned("persistent");
    const Transport persistent = choose(gl());
    EXPECT_TRUE(persistent.persistent_readback && persistent.persistent_upload);
  }
  if (gl().buffer_storage && gl().compute) {
    const Environment pinned("packed");
    const Transport packed = choose(gl());
    EXPECT_TRUE(packed.packer && packed.persistent_readback && packed.persistent_upload);
  }
  const Environment pinned("fast");
  EXPECT_THROW(choose(gl()), Failure);
}

TEST_P(Choice, MeasuresAndLeavesNoTrace) {
  const Environment none(nullptr);
  choose(gl());
  GLint bound = -1;
  for (const GLenum name : {GL_PIXEL_PACK_BUFFER_BINDING, GL_PIXEL_UNPACK_BUFFER_BINDING}) {
    gl().GetIntegerv(name, &bound);
    EXPECT_EQ(bound, 0);
  }
}

// Lets mapped bytes end at a page that must not be read.
struct Fenced {
  static inline PFNGLMAPBUFFERRANGEPROC map = nullptr;
  static inline std::vector<std::pair<void*, size_t>> areas;

  static void* GLAD_API_PTR call(GLenum target, GLintptr offset, GLsizeiptr length, GLbitfield access) {
    void* const bytes = map(target, offset, length, access);
    if (!bytes || (access & GL_MAP_PERSISTENT_BIT)) return bytes;
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE)), size = static_cast<size_t>(length);
    const size_t whole = (size + page - 1) / page * page;
    void* const area = mmap(nullptr, whole + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (area == MAP_FAILED) return nullptr;
    areas.emplace_back(area, whole + page);
    auto* const end = static_cast<std::byte*>(area) + whole;
    mprotect(end, page, PROT_NONE);
    return std::memcpy(end - size, bytes, size);
  }
  explicit Fenced(gl::Functions& functions) { map = std::exchange(functions.MapBufferRange, &call); }
  ~Fenced() {
    for (const auto& [area, size] : areas) munmap(area, size);
    areas.clear();
  }
};

TEST_P(Choice, MeasuresWithinTheBytesOfDepthWhereAMaskIsReadToo) {
  const Environment none(nullptr);
  if (!gl().buffer_storage) GTEST_SKIP() << "nothing is measured here";
  const gl::Texture mask(gl());
  gl().BindTexture(GL_TEXTURE_2D, mask.id());
  gl().TexImage2D(GL_TEXTURE_2D, 0, GL_R8, 64, 48, 0, GL_RED, GL_UNSIGNED_BYTE, nullptr);
  gl().BindTexture(GL_TEXTURE_2D, 0);
  sideray_frame_source source = sideray_frame_defaults().source;
  source.mask = SIDERAY_MASK_TEXTURE;
  source.mask_texture = mask.id();
  gl::Functions functions = gl();
  const Fenced fenced(functions);
  choose(functions, source);
  EXPECT_FALSE(Fenced::areas.empty());
}

void* without_buffer_storage(void* context, const char* name) {
  return std::strcmp(name, "glBufferStorage") == 0 ? nullptr : gl::Context::get_proc_address(context, name);
}

TEST_P(Choice, WithoutTheEntryPointIsToCopy) {
  const gl::Functions hidden = gl::load_functions(&without_buffer_storage, context.get());
  EXPECT_FALSE(hidden.buffer_storage);
  {
    const Environment none(nullptr);
    const Transport transport = choose(hidden);
    EXPECT_FALSE(transport.persistent_readback || transport.persistent_upload);
  }
  for (const char* way : {"persistent", "packed"}) {
    const Environment pinned(way);
    EXPECT_THROW(choose(hidden), Failure);
  }
}

void* without_compute(void* context, const char* name) {
  return std::strcmp(name, "glDispatchCompute") == 0 ? nullptr : gl::Context::get_proc_address(context, name);
}

TEST_P(Choice, WithoutComputeShadersLeavesPackingToTheDriver) {
  const gl::Functions hidden = gl::load_functions(&without_compute, context.get());
  EXPECT_FALSE(hidden.compute);
  {
    const Environment none(nullptr);
    EXPECT_FALSE(choose(hidden).packer);
  }
  const Environment pinned("packed");
  EXPECT_THROW(choose(hidden), Failure);
}

// A driver whose copy is so slow that any other correct way is chosen.
struct SlowCopy {
  static inline PFNGLREADPIXELSPROC read = nullptr;

  static void GLAD_API_PTR read_slowly(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,
                                       void* pixels) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    read(x, y, width, height, format, type, pixels);
  }
  static void GLAD_API_PTR dispatch_nothing(GLuint, GLuint, GLuint) {}
  static void GLAD_API_PTR blit_nothing(GLint, GLint, GLint, GLint, GLint, GLint, GLint, GLint, GLbitfield, GLenum) {}
  explicit SlowCopy(gl::Functions& functions) { read = std::exchange(functions.ReadPixels, &read_slowly); }
};

TEST_P(Choice, IsToPackWhereThatIsFasterAndRight) {
  const Environment none(nullptr);
  if (!gl().buffer_storage || !gl().compute) GTEST_SKIP() << "the GPU packs nothing here";
  gl::Functions functions = gl();
  const SlowCopy slow(functions);
  const gl::PixelTransferGuard transfer(functions);
  const gl::FramebufferGuard framebuffers(functions);
  const bool exact = DepthPacker(functions).is_exact();
  EXPECT_EQ(choose(functions).packer != nullptr, exact);
  functions.BlitFramebuffer = &SlowCopy::blit_nothing;
  EXPECT_FALSE(choose(functions).packer) << "the frame's bits count, not only those of the probe";
  functions.BlitFramebuffer = gl().BlitFramebuffer;
  functions.DispatchCompute = &SlowCopy::dispatch_nothing;
  EXPECT_FALSE(choose(functions).packer);
}

}  // namespace
}  // namespace sideray::bridge
