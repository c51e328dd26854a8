// Tests sideray_renderer_render_many: each picture has the bits that it has alone, for any renderer and number of
// threads.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

constexpr uint32_t width = 40, height = 30;

struct Drawn {
  std::map<std::string, std::vector<uint32_t>> planes;  // bits
  double build_ms = 0;
};

Drawn read(const Picture& picture) {
  Drawn drawn;
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel channel = picture.channel(i);
    std::vector<uint32_t> bits(size_t{width} * height);
    std::memcpy(bits.data(), channel.values, bits.size() * sizeof(uint32_t));
    drawn.planes[channel.name] = std::move(bits);
  }
  drawn.build_ms = picture.stage(SIDERAY_STAGE_BUILD).median;
  return drawn;
}

// Returns cameras around the scene's middle.
std::vector<sideray_camera> cameras_around(const sideray_camera& first, size_t count) {
  std::vector<sideray_camera> cameras(count, first);
  for (size_t i = 0; i < count; ++i) {
    const double a = 0.07 * static_cast<double>(i), c = std::cos(a), s = std::sin(a);
    for (size_t column = 0; column < 4; ++column) {
      const double* from = &first.world_from_camera[3 * column];
      double* to = &cameras[i].world_from_camera[3 * column];
      to[0] = c * from[0] + s * from[2];
      to[2] = c * from[2] - s * from[0];
    }
  }
  return cameras;
}

class ManyPictures : public testing::Test {
 protected:
  void load(const char* name) {
    const scenes::Content content = scenes::generate(name, {});
    scene_ = Scene::create().value();
    scenes::fill(scene_, content, std::vector<bool>(content.objects.size(), true));
    cameras_ = cameras_around(content.cameras.at(0).camera, 6);
    options_.picture.width = width;
    options_.picture.height = height;
    options_.picture.aovs = SIDERAY_AOV_Z | SIDERAY_AOV_ID | SIDERAY_AOV_FIRST;
  }
  static Renderer renderer(const char* gl, uint32_t threads) {
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.gl = gl;
    desc.threads = threads;
    return Renderer::create(desc).value();
  }

  Scene scene_ = Scene::create().value();
  std::vector<sideray_camera> cameras_;
  RenderOptions options_;
};

TEST_F(ManyPictures, HaveTheBitsThatTheyHaveAlone) {
  for (const char* name : {"panes", "frosted", "smoke"}) {
    load(name);
    for (const char* gl : {"auto", "none"})
      for (const uint32_t threads : {1u, 3u}) {
        Renderer together = renderer(gl, threads), alone = renderer(gl, threads);
        const std::vector<Picture> pictures = together.render_many(scene_, cameras_, options_.c()).value();
        ASSERT_EQ(pictures.size(), cameras_.size());
        for (size_t i = 0; i < pictures.size(); ++i) {
          const Drawn one = read(pictures[i]), other = read(alone.render(scene_, cameras_[i], options_).value());
          EXPECT_EQ(one.planes, other.planes) << name << ", " << gl << ", " << threads << " threads, picture " << i;
          EXPECT_EQ(one.build_ms > 0, i == 0) << "the scene is built once";
        }
      }
  }
}

TEST_F(ManyPictures, OfCallersWithOtherCameras) {
  load("solids");
  Renderer renderer = ManyPictures::renderer("none", 2);
  const Drawn expected = read(renderer.render(scene_, cameras_[1], options_).value());
  constexpr size_t stride = sizeof(sideray_camera) + 16;
  std::vector<std::byte> bytes(stride * 2);
  for (size_t i = 0; i < 2; ++i) {
    cameras_[i].size = stride;
    std::memcpy(&bytes[stride * i], &cameras_[i], sizeof(sideray_camera));
  }
  const sideray_render_options options = options_.c();
  sideray_picture* pictures[2] = {};
  sideray_error error{};
  ASSERT_EQ(sideray_renderer_render_many(renderer.get(), scene_.get(), reinterpret_cast<const sideray_camera*>(bytes.data()), 2,
                                         &options, pictures, &error),
            SIDERAY_OK)
      << error.message;
  EXPECT_EQ(read(Picture(pictures[1])).planes, expected.planes);
  sideray_picture_release(pictures[0]);
}

TEST_F(ManyPictures, AreAllThereOrNone) {
  load("solids");
  Renderer renderer = ManyPictures::renderer("none", 2);
  const auto message_of = [&](const std::vector<sideray_camera>& cameras, const sideray_render_options& options) {
    sideray_error error{};
    std::vector<sideray_picture*> pictures(cameras.size(), nullptr);
    EXPECT_EQ(sideray_renderer_render_many(renderer.get(), scene_.get(), cameras.data(), cameras.size(), &options,
                                           pictures.data(), &error),
              SIDERAY_INVALID_ARGUMENT);
    EXPECT_THAT(pictures, testing::Each(nullptr));
    return std::string(error.message);
  };
  std::vector<sideray_camera> wrong = cameras_;
  wrong[4].yfov = -1;
  EXPECT_THAT(message_of(wrong, options_.c()), testing::HasSubstr("yfov"));
  options_.picture.continues = 1;
  EXPECT_THAT(message_of(cameras_, options_.c()), testing::HasSubstr("several pictures"));
  options_.picture.continues = 0;
  options_.picture.budget_ms = 5;
  EXPECT_THAT(message_of(cameras_, options_.c()), testing::HasSubstr("budgets"));
  options_.picture.budget_ms = 0;
  EXPECT_TRUE(renderer.render_many(scene_, {}, options_.c()).value().empty());
  EXPECT_EQ(renderer.render_many(scene_, cameras_, options_.c()).value().size(), cameras_.size());
}

}  // namespace
}  // namespace sideray::tests
