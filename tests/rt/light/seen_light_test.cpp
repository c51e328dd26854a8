// Tests which points take the light of the pixels that show them.
#include "rt/light/seen_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "rt/history/still_frames.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::seen_light_test {
namespace {

using namespace test;

constexpr uint32_t width = 32, height = 16;
constexpr float depth_of_wall = 4.0f;

// A wall across the whole view of an eye at the origin that looks along -z.
struct Picture {
  Picture() : view(perspective({0, 0, 0}, {0, 0, -1}, 1.0, 2)) {
    const ViewRays rays(view, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const ViewRays::Pixel pixel = rays.pixel(x, y);
        depths.push_back(static_cast<float>(rays.window_depth(pixel, static_cast<double>(depth_of_wall / -pixel.direction.z))));
        for (const float value : {static_cast<float>(x), static_cast<float>(y), -0.5f, 1.0f}) thrown.push_back(glm::packHalf1x16(value));
        open.push_back(static_cast<uint8_t>(51 * (x % 6)));
      }
  }
  SeenLight light() const {
    const DepthImage depth{reinterpret_cast<const std::byte*>(depths.data()), sizeof(float) * width, DepthFormat::d32f};
    return {view, width, height, depth, {thrown, open}};
  }
  // The point that pixel (x, y) shows, moved along z.
  PointAround at(uint32_t x, uint32_t y, float along = 0.0f, float facing = 1.0f) const {
    const glm::vec3 direction = ViewRays(view, width, height).ray(x, y).direction;
    glm::vec3 origin = direction * (depth_of_wall / -direction.z);
    origin.z += along;
    return {origin, {0, 0, facing}, 0.1f, 1.0f};
  }

  TraceView view;
  std::vector<float> depths;
  std::vector<uint16_t> thrown;
  std::vector<uint8_t> open;
};

TEST(SeenLight, OfAPointIsThatOfItsPixel) {
  const Picture picture;
  const SeenLight light = picture.light();
  for (const glm::uvec2 p : {glm::uvec2(0, 0), glm::uvec2(17, 3), glm::uvec2(width - 1, height - 1)}) {
    const std::optional<ArrivingLight> found = light.at(picture.at(p.x, p.y));
    ASSERT_TRUE(found) << p.x << " " << p.y;
    EXPECT_EQ(found->thrown, glm::vec3(p.x, p.y, -0.5f));
    EXPECT_EQ(found->open, glm::vec3(static_cast<float>(p.x % 6) * 0.2f));
  }
}

TEST(SeenLight, IsUnknownWhereThePictureShowsAnotherSurface) {
  Picture picture;
  // A pixel is .27 wide at the wall.
  EXPECT_TRUE(picture.light().at(picture.at(9, 9, 0.05f)));
  for (const float along : {-0.15f, 0.15f, -1.0f, 2.0f}) EXPECT_FALSE(picture.light().at(picture.at(9, 9, along))) << along;
  EXPECT_FALSE(picture.light().at(picture.at(9, 9, 0.0f, -1.0f))) << "the back of the wall";
  PointAround steep = picture.at(9, 9);
  steep.normal = {-1, 0, 0};
  EXPECT_FALSE(picture.light().at(steep)) << "it faces away";
  PointAround behind = picture.at(9, 9);
  behind.origin.z = depth_of_wall;
  EXPECT_FALSE(picture.light().at(behind)) << "behind the eye";
  PointAround beside = picture.at(9, 9);
  beside.origin.x += 20.0f;
  EXPECT_FALSE(picture.light().at(beside)) << "outside of the picture";
  picture.thrown[4 * (9 * width + 9) + 3] = 0;
  EXPECT_FALSE(picture.light().at(picture.at(9, 9))) << "the pixel has no answer";
  EXPECT_TRUE(picture.light().at(picture.at(10, 9)));
  constexpr uint8_t other = 1, of_open = 2;
  std::vector<uint8_t> answers(size_t{width} * height, other | of_open);
  answers[9 * width + 10] = other;
  const DepthImage depth{reinterpret_cast<const std::byte*>(picture.depths.data()), sizeof(float) * width, DepthFormat::d32f};
  const SeenLight budgeted(picture.view, width, height, depth, {picture.thrown, picture.open, answers, of_open});
  EXPECT_FALSE(budgeted.at(picture.at(10, 9))) << "its share of the sky is late";
  EXPECT_TRUE(budgeted.at(picture.at(11, 9)));
}

// Layers of a view at rest are those of its light: they are traced anew where it changes, and only then.
TEST(SeenLight, IsAnInputOfLayersAtRest) {
  TestScene scene;
  scene.quad({0, 0, -depth_of_wall}, {9, 0, 0}, {0, 9, 0}, matt(0.5f));
  sideray_material_desc bending = glass();
  bending.ior = 1.2f, bending.thickness = 0.1f;
  scene.quad({0, 0, -1.0f}, {3, 0, 0}, {0, 3, 0}, bending);
  Tracer tracer({});
  tracer.set_scene(scene.commit());
  Picture picture;
  TestFrame frame(picture.view, width, height, 1);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) frame.depth.set(x, y, picture.depths[size_t{y} * width + x], 1);
  StillFrames still;
  CacheRequest& request = frame.get();
  request.refraction = 1, request.light_bounces = true, request.still = &still;
  LayerCache cache;
  const auto next = [&](SequenceStep step) {
    request.sequence = step;
    request.lit = {picture.thrown, picture.open};
    tracer.trace_cache(request, cache);
    return std::ranges::count(cache.dirty_tiles, 1);
  };
  next(SequenceStep::first);
  next(SequenceStep::next);
  EXPECT_EQ(next(SequenceStep::next), 0);
  const glm::vec3 before = rgb(cache.radiance, texel_of(cache, width / 2, height / 2, 0));
  for (size_t i = 2; i < picture.thrown.size(); i += 4) picture.thrown[i] = glm::packHalf1x16(8.0f);
  EXPECT_GT(next(SequenceStep::next), 0);
  const glm::vec3 after = rgb(cache.radiance, texel_of(cache, width / 2, height / 2, 0));
  EXPECT_GT(after.z, before.z + 1.0f);
  next(SequenceStep::next);
  EXPECT_EQ(next(SequenceStep::next), 0);
  std::ranges::fill(picture.open, uint8_t{255});
  EXPECT_GT(next(SequenceStep::next), 0);
}

}  // namespace
}  // namespace sideray::rt::seen_light_test
