// Tests that rays look for translucent surfaces in every pixel that shows one, and in few others.
#include "rt/drawing/translucent_places.h"

#include <gtest/gtest.h>

#include <random>

#include "rt/drawing/opaque_pixels.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::test {
namespace {

constexpr uint32_t width = 40, height = 30;

class Random {
 public:
  float in(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }
  glm::vec3 vector(float size) { return {in(-size, size), in(-size, size), in(-size, size)}; }

 private:
  std::mt19937 engine_{3};
};

// The same view with depths from -1 at the near plane to 1.
TraceView unreversed(TraceView view) {
  glm::dmat4 turn(1.0);
  turn[2][2] = -2.0, turn[3][2] = 1.0;
  view.clip_from_local = turn * view.clip_from_local;
  view.local_from_clip = view.local_from_clip * glm::inverse(turn);
  view.reversed_depth = view.zero_to_one_depth = false;
  return view;
}

std::vector<uint8_t> counts_of(Tracer& tracer, const TraceView& view) {
  const OpaqueRequest request{.view = view, .width = width, .height = height, .normals = false};
  OpaquePixels pixels;
  tracer.trace_opaque(request, pixels);
  return tracer.count_translucent(request, pixels, false, 60);
}

TEST(TranslucentPlaces, HoldEveryPixelThatShowsOne) {
  Random random;
  size_t seen = 0, places_in_all = 0;
  constexpr int pictures = 300;
  for (int round = 0; round < pictures; ++round) {
    TestScene scene;
    for (int i = 0; i < 6; ++i)
      scene.quad(random.vector(2.0f), random.vector(0.4f), random.vector(0.4f), i % 2 == 0 ? glass() : plain_material());
    const auto snapshot = scene.commit();
    Tracer tracer({.threads = 2, .isa = ""});
    tracer.set_scene(snapshot);
    const glm::dvec3 eye = random.vector(4.0f), target = random.vector(1.0f);
    TraceView view = round % 3 == 0 ? orthographic(eye, target, 2.0, double{width} / height)
                                    : perspective(eye, target, 0.9, double{width} / height);
    if (round % 2 == 0) view = unreversed(view);
    const std::vector<uint8_t> places = translucent_places(*snapshot, view, width, height), counts = counts_of(tracer, view);
    for (size_t i = 0; i < places.size(); ++i) {
      seen += counts[i] > 0;
      places_in_all += places[i] != 0;
      ASSERT_TRUE(counts[i] == 0 || places[i] == 255) << "round " << round << ", pixel " << i % width << ' ' << i / width;
    }
  }
  EXPECT_GT(seen, 2000u);
  EXPECT_LT(places_in_all, pictures * width * height / 3);
}

TEST(TranslucentPlaces, OfWhatReachesBehindTheEyeAreWhereTheRestIs) {
  TestScene scene;
  scene.quad({0, -1, 0}, {50, 0, 0}, {0, 0, 50}, glass());
  const auto snapshot = scene.commit();
  const TraceView level = perspective({0, 0, 0}, {0, 0, -1}, 0.9, 1.0);
  for (const TraceView& view : {level, unreversed(level)}) {
    const std::vector<uint8_t> places = translucent_places(*snapshot, view, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const bool below_horizon = y + 2 < height / 2, above = y > height / 2 + 2;
        EXPECT_TRUE(!below_horizon || places[y * width + x] == 255) << x << ' ' << y;
        EXPECT_TRUE(!above || places[y * width + x] == 0) << x << ' ' << y;
      }
  }
}

TEST(TranslucentPlaces, AreNowhereWithoutGlass) {
  TestScene scene;
  scene.quad({0, 0, -3}, {1, 0, 0}, {0, 1, 0}, plain_material());
  const auto places = translucent_places(*scene.commit(), perspective({0, 0, 0}, {0, 0, -1}, 0.9, 1.0), width, height);
  EXPECT_EQ(places, std::vector<uint8_t>(size_t{width} * height, 0));
}

}  // namespace
}  // namespace sideray::rt::test
