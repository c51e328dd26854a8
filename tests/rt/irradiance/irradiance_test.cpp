// Compares bounced light with closed forms: a furnace, an open field; and tests still views.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <numeric>

#include "rt/base/view_rays.h"
#include "rt/irradiance/irradiance_history.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::irradiance_test {
namespace {

using namespace test;

constexpr uint32_t width = 64, height = 48, tile = frame_tile_size;

// Returns a closed room of 16 x 4 x 16 about the origin whose inner faces emit light.
std::shared_ptr<const model::Snapshot> furnace(float albedo, glm::vec3 emission) {
  TestScene scene;
  const sideray_material_desc m = matt(albedo, emission);
  for (const double side : {-1.0, 1.0}) {
    scene.quad({8 * side, 0, 0}, {0, 2, 0}, {0, 0, 8}, m);
    scene.quad({0, 2 * side, 0}, {8, 0, 0}, {0, 0, 8}, m);
    scene.quad({0, 0, 8 * side}, {8, 0, 0}, {0, 2, 0}, m);
  }
  scene.environment(glm::vec3(0.0f));
  return scene.commit();
}

// The depth of the plane y = -2, as a rasterizer stores it; upper pixels show nothing.
struct FloorFrame {
  TraceView view;
  DepthBuffer depth{width, height, 0.0f, 0};
  explicit FloorFrame(double aside = 0.0)
      : view(perspective({aside, 0, 0}, {aside, -1.2, -1.0}, 0.6, double{width} / height)) {
    const ViewRays rays(view, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const Ray ray = rays.ray(x, y);
        const glm::dvec3 p = glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * (-2.0 / static_cast<double>(ray.direction.y));
        const glm::dvec4 clip = view.clip_from_local * glm::dvec4(p, 1.0);
        depth.set(x, y, static_cast<float>(clip.z / clip.w), 0);
      }
  }
  IrradianceRequest request(bool denoise = true) const {
    IrradianceRequest r;
    r.view = view;
    r.width = width, r.height = height;
    r.depth = depth.image();
    r.denoise = denoise;
    return r;
  }
};

glm::vec3 mean(const IrradianceImage& image) {
  glm::vec3 sum(0.0f);
  for (size_t t = 0; t < size_t{width} * height; ++t) sum += rgb(image.light, t);
  return sum / static_cast<float>(width * height);
}

// Everywhere in the furnace the light of all bounces is e + a e + a^2 e + ... = e / (1 - a).
TEST(Irradiance, OfAFurnaceHasAllBounces) {
  const FloorFrame frame;
  for (const float albedo : {0.0f, 0.5f, 0.8f}) {
    const glm::vec3 emission(0.5f, 0.25f, 0.125f);
    Tracer tracer({2, ""});
    tracer.set_scene(furnace(albedo, emission));
    IrradianceImage image;
    const Counters counters = tracer.trace_irradiance(frame.request(), image);
    EXPECT_GT(counters.rays_bounce, 0u);
    const glm::vec3 found = mean(image), expected = emission / (1.0f - albedo);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.04f * expected[c]) << albedo;
  }
}

// Paths hit nothing and the sky is open, so irradiance adds nothing, not even noise.
TEST(Irradiance, OfAnOpenFieldIsNone) {
  TestScene scene;
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, matt(0.8f, glm::vec3(0.0f)));
  scene.environment(glm::vec3(1.0f, 0.5f, 0.25f));
  Tracer tracer({2, ""});
  tracer.set_scene(scene.commit());
  IrradianceImage image;
  tracer.trace_irradiance(FloorFrame().request(), image);
  for (size_t t = 0; t < size_t{width} * height; ++t)
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb(image.light, t)[c], 0.0f, 1e-3f) << t;
}

// The sky's colours are in its light already: directions that are all open add nothing, whichever was sampled.
TEST(Irradiance, OfAnOpenFieldUnderAColouredSkyIsNone) {
  TestScene scene;
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, matt(0.8f, glm::vec3(0.0f)));
  std::vector<glm::vec3> sky(32 * 16, glm::vec3(1.0f, 0.1f, 0.1f));
  for (size_t texel = 0; texel < sky.size(); ++texel)
    if (texel % 32 < 16) sky[texel] = glm::vec3(0.1f, 0.1f, 1.0f);
  scene.scene.set_environment(32, 16, &sky[0].x, 1.0f, 0.0f);
  Tracer tracer({2, ""});
  tracer.set_scene(scene.commit());
  IrradianceImage image;
  tracer.trace_irradiance(FloorFrame().request(false), image);
  for (size_t t = 0; t < size_t{width} * height; ++t)
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb(image.light, t)[c], 0.0f, 5e-3f) << t;
}

// The sky's mask counts a coloured sheet by the mean of its channels; irradiance adds the differences.
TEST(Irradiance, BelowGlassHasItsColour) {
  TestScene scene;
  scene.quad({0, -2, 0}, {50, 0, 0}, {0, 0, 50}, matt(0.8f, glm::vec3(0.0f)));
  sideray_material_desc red = glass();
  red.base_color[0] = 1.0f, red.base_color[1] = 0.2f, red.base_color[2] = 0.6f;
  scene.quad({0, 1, 0}, {500, 0, 0}, {0, 0, 500}, red);
  scene.environment(glm::vec3(1.0f));
  Tracer tracer({2, ""});
  tracer.set_scene(scene.commit());
  IrradianceImage image;
  tracer.trace_irradiance(FloorFrame().request(), image);
  const glm::vec3 found = mean(image);
  EXPECT_GT(found.x, 0.3f);
  EXPECT_LT(found.x, 0.4f);
  EXPECT_NEAR(found.y, -found.x, 0.01f);
  EXPECT_NEAR(found.z, 0.0f, 0.01f);
}

TEST(Irradiance, IsTheSameForAnyNumberOfThreads) {
  const FloorFrame frame;
  std::vector<uint16_t> first;
  for (const uint32_t threads : {1u, 3u}) {
    Tracer tracer({threads, ""});
    tracer.set_scene(furnace(0.5f, glm::vec3(1.0f)));
    IrradianceImage image;
    tracer.trace_irradiance(frame.request(), image);
    if (first.empty()) first = image.light;
    EXPECT_EQ(image.light, first);
  }
}

// Samples of frames add up; once all are there, no ray is traced, until something changes.
TEST(Irradiance, OfAViewThatStandsStillSettles) {
  const FloorFrame frame;
  Tracer tracer({2, ""});
  tracer.set_scene(furnace(0.8f, glm::vec3(0.5f)));
  IrradianceHistory history;
  IrradianceImage image;
  IrradianceRequest request = frame.request(false);
  request.history = &history;
  const auto spread = [&] {
    double sum = 0.0;
    for (size_t t = 0; t < size_t{width} * height; ++t) sum += std::pow(double{rgb(image.light, t).x} - 2.5, 2.0);
    return std::sqrt(sum / (width * height));
  };
  tracer.trace_irradiance(request, image);
  const double noise = spread();
  request.sequence = SequenceStep::next;
  uint32_t frames = 1;
  for (; frames < 100 && image.changed; ++frames) tracer.trace_irradiance(request, image);
  EXPECT_LT(frames, 40u);
  EXPECT_LT(spread(), 0.4 * noise);
  const std::vector<uint16_t> kept = image.light;
  EXPECT_EQ(tracer.trace_irradiance(request, image).rays_bounce, 0u);
  EXPECT_EQ(image.light, kept);
  tracer.set_scene(furnace(0.8f, glm::vec3(0.25f)));
  EXPECT_GT(tracer.trace_irradiance(request, image).rays_bounce, 0u);
  EXPECT_TRUE(image.changed);
  EXPECT_NEAR(mean(image).x, 1.25f, 0.1f) << "nothing of the other light is left";
}

// When an instance moves, a settled view traces again, and its past counts as few samples, so that its light follows.
TEST(Irradiance, FollowsWhatMoves) {
  TestScene scene;
  scene.quad({0, -2, 0}, {20, 0, 0}, {0, 0, 20}, matt(0.5f));
  const uint32_t lamp = scene.quad({0, -1, -1.7}, {0.6, 0, 0}, {0, 0, 0.6}, glowing(glm::vec3(2.0f))) - 1;
  scene.environment(glm::vec3(0.0f));
  const FloorFrame frame;
  Tracer tracer({2, ""});
  tracer.set_scene(scene.commit());
  IrradianceHistory history;
  IrradianceImage image;
  IrradianceRequest request = frame.request();
  request.history = &history;
  const auto most_samples = [&] {
    float most = 0.0f;
    for (const CellLight& light : history.cells().lights) most = std::max(most, light.samples);
    return most;
  };
  for (uint32_t frames = 0; frames < 100 && (frames == 0 || image.changed); ++frames) {
    tracer.trace_irradiance(request, image);
    request.sequence = SequenceStep::next;
  }
  ASSERT_FALSE(image.changed);
  EXPECT_GT(most_samples(), 30.0f);
  const glm::dmat4x3 moved{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0, 0}};
  scene.scene.move_instances(&lamp, 1, &moved[0][0]);
  tracer.set_scene(scene.commit());
  EXPECT_GT(tracer.trace_irradiance(request, image).rays_bounce, 0u);
  EXPECT_TRUE(image.changed);
  EXPECT_LT(most_samples(), 10.0f);
}

// A square that shines above a black floor, with or without a pane between them.
struct Glow {
  static constexpr double half = 0.6, above = 1.0, behind = 1.7, radiance = 2.0;  // about (0, -2 + above, -behind)
  static constexpr float pane[3] = {0.9f, 0.5f, 0.1f};

  static std::shared_ptr<const model::Snapshot> scene(bool with_pane) {
    TestScene scene;
    scene.quad({0, -2, 0}, {20, 0, 0}, {0, 0, 20}, matt(0.0f, glm::vec3(0.0f)));
    scene.quad(glm::dvec3(0, -2 + above, -behind), glm::dvec3(half, 0, 0), glm::dvec3(0, 0, half),
               glowing(glm::dvec3(radiance)));
    sideray_material_desc glass_of_pane = glass();
    for (int c = 0; c < 3; ++c) glass_of_pane.base_color[c] = pane[c];
    if (with_pane) scene.quad(glm::dvec3(0, -2 + 0.5 * above, 0), {20, 0, 0}, {0, 0, 20}, glass_of_pane);
    scene.environment(glm::vec3(0.0f));
    return scene.commit();
  }

  // Returns irradiance / pi at a place on the floor. The pane lets pass what Schlick's term leaves, times its colour.
  static glm::dvec3 light_at(double x, double z, bool with_pane) {
    constexpr int steps = 24;
    constexpr double side = 2.0 * half / steps;
    glm::dvec3 sum(0.0);
    for (int j = 0; j < steps; ++j)
      for (int i = 0; i < steps; ++i) {
        const glm::dvec3 way(-half + (i + 0.5) * side - x, above, -behind - half + (j + 0.5) * side - z);
        const double squared = glm::dot(way, way), cosine = above / std::sqrt(squared);
        const double arrives = radiance * cosine * cosine / (squared * glm::pi<double>()) * side * side;
        const double passes = with_pane ? 0.96 * (1.0 - std::pow(1.0 - cosine, 5)) : 1.0;
        for (int c = 0; c < 3; ++c) sum[c] += arrives * passes * (with_pane ? double{pane[c]} : 1.0);
      }
    return sum;
  }
};

class GlowAndPane : public testing::TestWithParam<bool> {};

// Emitters light surfaces near them, tinted by glass on the way, as the integral over the emitter predicts.
TEST_P(GlowAndPane, LightWhatIsNear) {
  const FloorFrame frame;
  Tracer tracer({2, ""});
  tracer.set_scene(Glow::scene(GetParam()));
  glm::dvec3 found(0.0), expected(0.0);
  const ViewRays rays(frame.view, width, height);
  constexpr uint32_t seeds = 24;
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    IrradianceRequest request = frame.request(false);
    request.seed = seed;
    IrradianceImage image;
    tracer.trace_irradiance(request, image);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) found += glm::dvec3(rgb(image.light, size_t{y} * width + x)) / double{seeds};
  }
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const Ray ray = rays.ray(x, y);
      const glm::dvec3 p = glm::dvec3(ray.direction) * (-2.0 / double{ray.direction.y});
      expected += Glow::light_at(p.x, p.z, GetParam());
    }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.02 * expected[c]) << c;
}

INSTANTIATE_TEST_SUITE_P(Irradiance, GlowAndPane, testing::Bool());

// Under a budget the tiles of a still view's position take turns. When all are traced, the result has the same bits as
// without a budget.
TEST(Irradiance, UnderABudgetComesToTheSameBits) {
  const FloorFrame frame;
  Tracer tracer({2, ""});
  tracer.set_scene(furnace(0.5f, glm::vec3(1.0f)));
  IrradianceImage whole, image;
  IrradianceHistory whole_history, history;
  IrradianceRequest request = frame.request();
  request.position_frames = 1;
  request.history = &whole_history;
  tracer.trace_irradiance(request, whole);
  request.history = &history;
  constexpr uint32_t tiles = 4;
  uint64_t late = 0;
  for (uint32_t turn = 1; turn <= tiles; ++turn) {
    PiecesLeft pieces{1};
    request.work.pieces = &pieces;
    request.position_frames = turn;
    request.sequence = turn == 1 ? SequenceStep::first : SequenceStep::next;
    const Counters counters = tracer.trace_irradiance(request, image);
    EXPECT_GT(counters.rays_bounce, 0u) << turn;
    EXPECT_TRUE(turn == 1 || counters.irradiance_pixels_late < late) << turn;
    late = counters.irradiance_pixels_late;
    EXPECT_EQ(image.light == whole.light, turn == tiles) << turn;
    EXPECT_EQ(image.changed, turn == 1 || turn == tiles) << turn;
  }
  EXPECT_EQ(late, 0u);
  // Further frames of the position leave it unchanged.
  PiecesLeft more{1};
  request.work.pieces = &more;
  request.position_frames = tiles + 1;
  EXPECT_EQ(tracer.trace_irradiance(request, image).rays_bounce, 0u);
  EXPECT_FALSE(image.changed);
  EXPECT_EQ(image.light, whole.light);
}

// Views of several sizes share a tracer, but each has its own history.
TEST(Irradiance, OfAViewKnowsNothingOfAnothers) {
  const FloorFrame frame;
  Tracer tracer({2, ""});
  tracer.set_scene(furnace(0.5f, glm::vec3(1.0f)));
  const auto trace = [&](bool with_other) {
    IrradianceHistory history, of_other;
    IrradianceImage image, other;
    IrradianceRequest request = frame.request();
    for (int i = 0; i < 4; ++i) {
      request.sequence = i == 0 ? SequenceStep::first : SequenceStep::next;
      request.width = width, request.height = height, request.history = &history;
      tracer.trace_irradiance(request, image);
      request.width = request.height = tile, request.history = &of_other;  // a corner of the picture
      if (with_other) tracer.trace_irradiance(request, other);
    }
    return image.light;
  };
  EXPECT_EQ(trace(true), trace(false));
}

// Under a budget with a moving camera, a frame traces a row of tiles and reprojects the others.
TEST(Irradiance, OfAMovingCameraUnderABudgetIsCarriedAlong) {
  Tracer tracer({2, ""});
  tracer.set_scene(furnace(0.5f, glm::vec3(1.0f)));
  IrradianceHistory history;
  IrradianceImage image;
  constexpr uint32_t columns = width / tile, rows = (height + tile - 1) / tile;
  for (uint32_t i = 0; i < 6; ++i) {
    const FloorFrame frame(0.01 * i);
    PiecesLeft pieces{columns};
    IrradianceRequest request = frame.request();
    request.history = &history;
    request.work.pieces = &pieces;
    request.sequence = i == 0 ? SequenceStep::first : SequenceStep::next;
    const Counters counters = tracer.trace_irradiance(request, image);
    EXPECT_GT(counters.rays_bounce, 0u);
    size_t known = 0;
    for (size_t t = 0; t < size_t{width} * height; ++t) {
      if (image.light[4 * t + 3] == 0) continue;
      ++known;
      EXPECT_NEAR(rgb(image.light, t).x, 2.0f, 0.5f) << "frame " << i << ", pixel " << t;
    }
    const uint64_t fresh = width * height - counters.irradiance_pixels_older - counters.irradiance_pixels_late;
    EXPECT_EQ(fresh, i % rows == 0 ? width * (height - tile) : width * tile) << i;
    EXPECT_EQ(known, width * height - counters.irradiance_pixels_late) << i;
    if (i >= rows) {
      EXPECT_LT(counters.irradiance_pixels_late, width * height / 20) << i;
      EXPECT_GT(counters.irradiance_pixels_older, 0u) << i;
    }
  }
}

// Reprojected light moves with its surface: an image of each pixel's place on the floor stays right.
TEST(Irradiance, ThatIsCarriedAlongMovesWithItsSurface) {
  constexpr double step = 0.3, pixel = 0.06;  // on the floor
  const FloorFrame before, after(step);
  const auto place = [](const FloorFrame& frame, size_t texel) {
    const Ray ray = ViewRays(frame.view, width, height).ray(static_cast<uint32_t>(texel % width), static_cast<uint32_t>(texel / width));
    return ray.origin.x + ray.direction.x * (-2.0f / ray.direction.y);
  };
  Tracer tracer({2, ""});
  tracer.set_scene(furnace(0.5f, glm::vec3(1.0f)));
  IrradianceHistory history;
  IrradianceImage image;
  IrradianceRequest request = before.request();
  request.history = &history;
  PiecesLeft all{1 << 20}, pieces{width / tile};
  request.work.pieces = &all;
  tracer.trace_irradiance(request, image);
  for (size_t t = 0; t < size_t{width} * height; ++t) image.light[4 * t] = glm::packHalf1x16(place(before, t));
  request = after.request();
  request.history = &history;
  request.sequence = SequenceStep::next;
  request.work.pieces = &pieces;
  const Counters counters = tracer.trace_irradiance(request, image);
  EXPECT_GT(counters.irradiance_pixels_older, width * tile / 2u);
  // The second row of tiles is traced.
  for (size_t t = 0; t < size_t{width} * tile; ++t) {
    if (image.light[4 * t + 3] == 0) continue;
    ASSERT_NEAR(rgb(image.light, t).x, place(after, t), pixel) << t;
  }
}

// A frame without time for a row traces nothing and shows the reprojected image. The next traced row goes on with the
// samples from before.
TEST(Irradiance, WithoutTimeForARowIsCarriedAlong) {
  Tracer tracer({2, ""});
  tracer.set_scene(furnace(0.5f, glm::vec3(1.0f)));
  IrradianceHistory history;
  IrradianceImage image;
  const auto draw = [&](const FloorFrame& frame, SequenceStep step, const WorkTime& work) {
    IrradianceRequest request = frame.request();
    request.history = &history;
    request.sequence = step;
    request.work = work;
    return tracer.trace_irradiance(request, image);
  };
  const auto continued = [&] {
    return std::ranges::count_if(history.cells().lights, [](const CellLight& light) { return light.samples > 1.0f; });
  };
  PiecesLeft all{1 << 20}, row{width / tile};
  draw(FloorFrame(), SequenceStep::first, {.pieces = &all});
  EXPECT_EQ(continued(), 0);
  const Counters idle = draw(FloorFrame(0.3), SequenceStep::next, {.deadline = Deadline::clock::now()});
  EXPECT_EQ(idle.rays_bounce, 0u);
  EXPECT_GT(idle.irradiance_pixels_older, idle.irradiance_pixels_late);
  draw(FloorFrame(0.6), SequenceStep::next, {.pieces = &row});
  EXPECT_GT(continued(), width * tile / 4 / 4);
}

}  // namespace
}  // namespace sideray::rt::irradiance_test
