// Tests older masks under a deadline: the order of tiles, and the masks of others meanwhile.
#include "rt/masks/older_masks.h"

#include <gmock/gmock.h>

#include "rt/base/view_rays.h"
#include "rt/masks/mask_filters.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::older_masks_test {
namespace {

using namespace test;

constexpr uint32_t width = 160, height = 96, tiles = 5 * 3;
constexpr int64_t all = 1 << 20;

// A floor with a plate above it, whose shadow is sharp, before a wall.
class OlderMaskFrames : public testing::Test {
 protected:
  OlderMaskFrames() {
    scene_.quad({0, 0, 0}, {40, 0, 0}, {0, 0, 40}, plain_material());
    plate_ = scene_.quad({0, 1.5f, 0}, {1, 0, 0}, {0, 0, 1}, plain_material());
    scene_.lights({point_light({1, 6, 1}, 20.0f)});
    look({0, 3, 6});
  }

  // The depth is that of the floor.
  void look(glm::dvec3 eye) {
    view_ = perspective(eye, eye + glm::dvec3(0, -2.5, -6), 0.7, double{width} / height);
    const ViewRays rays(view_, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const Ray ray = rays.ray(x, y);
        const glm::dvec3 from(ray.origin), d(ray.direction);
        const glm::dvec4 clip = view_.clip_from_local * glm::dvec4(from - d * (from.y / d.y), 1.0);
        depth_.set(x, y, static_cast<float>(clip.z / clip.w), 0);
      }
  }

  Counters frame(int64_t pieces, SequenceStep step = SequenceStep::next) {
    tracer_.set_scene(scene_.commit());
    return trace(pieces, step, &older_, masks_);
  }
  Counters trace(int64_t pieces, SequenceStep step, OlderMasks* older, OcclusionMasks& masks) {
    MaskRequest r;
    r.view = view_;
    r.width = width, r.height = height;
    r.depth = depth_.image();
    r.shadow_lights = 1;
    r.ao_rays = sky_ ? 1 : 0;
    r.ao_distance = 2.0f;
    r.sequence = step;
    PiecesLeft left(pieces);
    r.work.pieces = &left;
    r.older = older;
    r.seed = seed_;
    r.filters = filtered_ ? &filters_ : nullptr;
    return tracer_.trace_masks(r, masks);
  }
  void soften() {
    sideray_light lamp = point_light({1, 6, 1}, 20.0f);
    lamp.radius = 0.5f;
    lamp.shadow_filter_radius = 16.0f;
    lamp.shadow_filter_frames = 8;
    scene_.lights({lamp});
  }
  OcclusionMasks whole() {
    OcclusionMasks masks;
    trace(all, SequenceStep::first, nullptr, masks);
    return masks;
  }
  static size_t differing(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    size_t count = 0;
    for (size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
  }
  static size_t dark(const std::vector<uint8_t>& a) { return static_cast<size_t>(std::count(a.begin(), a.end(), 0)); }

  TestScene scene_;
  uint32_t plate_;
  Tracer tracer_{{2, ""}};
  TraceView view_;
  DepthBuffer depth_{width, height, 0.0f, 0};
  OlderMasks older_;
  MaskFilters filters_;
  OcclusionMasks masks_;
  uint32_t seed_ = 1;
  bool sky_ = false, filtered_ = false;
};

TEST_F(OlderMaskFrames, every_tile_has_its_turn) {
  constexpr uint64_t pixels = uint64_t{width} * height, tile = 32 * 32;
  for (uint64_t f = 1; f <= 4; ++f) {
    const Counters c = frame(4, f == 1 ? SequenceStep::first : SequenceStep::next);
    ASSERT_EQ(c.mask_pixels_late, pixels - std::min<uint64_t>(4 * f, tiles) * tile) << f;
    ASSERT_EQ(c.mask_pixels_older, std::min<uint64_t>(4 * (f - 1), tiles - 4) * tile) << f;
  }
  EXPECT_EQ(masks_.lit, whole().lit);
  EXPECT_GT(dark(masks_.lit), 100u);
  for (int f = 0; f < 10; ++f) ASSERT_LT(frame(4).answer_age, 4u);
}

// A pixel is late as long as it lacks the mask of the lights or of the sky.
TEST_F(OlderMaskFrames, both_kinds_count) {
  sky_ = true;
  constexpr uint64_t pixels = uint64_t{width} * height, tile = 32 * 32;
  frame(3, SequenceStep::first);
  for (uint64_t f = 2; f <= 5; ++f) {
    const Counters c = frame(3);
    ASSERT_EQ(c.mask_pixels_late, pixels - 3 * f * tile) << f;
    ASSERT_EQ(c.mask_pixels_older, 3 * (f - 1) * tile) << f;
  }
  EXPECT_EQ(masks_.lit, whole().lit);
  EXPECT_EQ(masks_.open, whole().open);
}

// The filter always takes traced masks, never its own results.
TEST_F(OlderMaskFrames, filtered_masks_stay_steady) {
  filtered_ = sky_ = true;
  frame(all, SequenceStep::first);
  const std::vector<uint8_t> first = masks_.open;
  for (int f = 0; f < 20; ++f) frame(0);
  EXPECT_EQ(masks_.open, first);
}

// Where few tiles have their turn, the others are what they were, to the bit.
TEST_F(OlderMaskFrames, only_what_is_traced_is_filtered) {
  filtered_ = true;
  soften();
  frame(all, SequenceStep::first);
  for (int f = 0; f < 8; ++f) {
    const std::vector<uint8_t> before = masks_.lit;
    frame(2);
    int changed_tiles = 0, most = 0;
    for (uint32_t v = 0; v < height; v += 32)
      for (uint32_t u = 0; u < width; u += 32) {
        bool changed = false;
        for (uint32_t y = v; y < v + 32; ++y)
          for (uint32_t x = u; x < u + 32; ++x) {
            const int off = std::abs(masks_.lit[y * width + x] - before[y * width + x]);
            most = std::max(most, off);
            changed = changed || off != 0;
          }
        changed_tiles += changed;
      }
    EXPECT_LE(changed_tiles, 2);
    EXPECT_LT(most, 64) << "of the same rays, filtered beside what is filtered already";
  }
  const std::vector<uint8_t> some = masks_.lit;
  frame(all, SequenceStep::first);
  double sum = 0.0;
  for (size_t i = 0; i < some.size(); ++i) sum += std::abs(some[i] - masks_.lit[i]);
  EXPECT_GT(sum, 0.0);
  EXPECT_LT(sum / static_cast<double>(some.size()), 0.5);
}

// A penumbra that was filtered again in every frame would grow.
TEST_F(OlderMaskFrames, penumbrae_move_as_they_are) {
  filtered_ = true;
  soften();
  frame(all, SequenceStep::first);
  const auto grey = [](const std::vector<uint8_t>& a) {
    return std::count_if(a.begin(), a.end(), [](uint8_t m) { return m > 0 && m < 255; });
  };
  const auto at_first = grey(masks_.lit);
  ASSERT_GT(at_first, 300);
  for (int f = 1; f <= 20; ++f) {
    look({0.002 * f, 3, 6});
    frame(0);
  }
  EXPECT_NEAR(static_cast<double>(grey(masks_.lit)), static_cast<double>(at_first), 0.1 * static_cast<double>(at_first));
}

// Frames that trace most of their tiles go on with the mean of the frames before.
TEST_F(OlderMaskFrames, most_tiles_are_averaged) {
  filtered_ = true;
  soften();
  OcclusionMasks alone;
  MaskFilters filters;
  for (uint32_t f = 0; f < 4; ++f) {
    seed_ = f + 1;
    const SequenceStep step = f == 0 ? SequenceStep::first : SequenceStep::next;
    frame(f == 3 ? tiles - 1 : all, step);
    std::swap(filters, filters_);
    trace(all, step, nullptr, alone);
    std::swap(filters, filters_);
  }
  filters_ = {};
  OcclusionMasks unaveraged;
  trace(all, SequenceStep::first, nullptr, unaveraged);
  EXPECT_GT(differing(alone.lit, unaveraged.lit), 300u);
  EXPECT_LT(differing(alone.lit, masks_.lit), 9u * 32 * 32 / 10) << "beyond the tile that was left and its neighbours";
}

TEST_F(OlderMaskFrames, masks_move_with_their_surface) {
  for (const glm::dvec3 step : {glm::dvec3(0.01, 0, 0), glm::dvec3(0.1, 0, 0.1), glm::dvec3(-0.02, 0.05, -0.1)}) {
    look({0, 3, 6});
    frame(all, SequenceStep::first);
    for (int f = 1; f <= 5; ++f) {
      look(glm::dvec3(0, 3, 6) + double(f) * step);
      const Counters c = frame(0);
      EXPECT_GT(c.mask_pixels_older, uint64_t{width} * height * 4 / 5);
      const OcclusionMasks now = whole();
      EXPECT_GT(dark(masks_.lit), dark(now.lit) * 9 / 10);
      // Edges of the shadow are off by a pixel or two.
      EXPECT_LT(differing(masks_.lit, now.lit), dark(now.lit) / 5) << f;
    }
  }
}

// Every pixel has the mask of the pixel that it was, whatever else the tiles there hold: dark, lit or mixed ones. The
// bits of what a tile holds are those of its pixels.
TEST_F(OlderMaskFrames, each_pixel_has_the_mask_of_where_it_was) {
  constexpr uint32_t side = OcclusionMasks::filter_tile;
  scene_.quad({-6, 1.5f, -3}, {5, 0, 0}, {0, 0, 4}, plain_material());
  Executor executor(2);
  PixelTrail trail;
  frame(all, SequenceStep::first);
  trail.begin({view_, depth_.image(), {width, height}, {}, false}, executor);
  size_t carried[2] = {0, 0}, lost = 0;
  for (int f = 1; f <= 12; ++f) {
    const std::vector<uint8_t> then = masks_.lit;
    // First toward the plate's shadow, which comes in at the picture's border, then back.
    look(glm::dvec3(-0.15 * (f <= 8 ? f : 16 - f), 3, 6.0 - 0.1 * f));
    frame(0);
    trail.begin({view_, depth_.image(), {width, height}, {}, true}, executor);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const uint32_t from = *trail.from(x, y);
        const uint8_t mask = masks_.lit[y * width + x];
        ASSERT_EQ(mask, from == PixelTrail::nowhere ? 255 : then[from]) << x << ' ' << y << " in frame " << f;
        const uint8_t holds = masks_.seen[masks_.filter_index(0, x / side, y / side)];
        ASSERT_TRUE(holds & (mask == 0 ? OcclusionMasks::seen_dark : OcclusionMasks::seen_lit)) << x << ' ' << y;
        if (from == PixelTrail::nowhere) ++lost;
        else ++carried[mask != 0];
      }
  }
  EXPECT_GT(carried[0], 1000u);
  EXPECT_GT(carried[1], 1000u);
  EXPECT_GT(lost, 100u);
}

TEST_F(OlderMaskFrames, masks_of_a_scene_at_rest_do_not_age) {
  frame(all, SequenceStep::first);
  for (int f = 1; f <= 3; ++f) {
    look({0.01 * f, 3, 6});
    const Counters c = trace(0, SequenceStep::next, &older_, masks_);
    EXPECT_GT(c.mask_pixels_older, 0u);
    EXPECT_EQ(c.answer_age, 0u);
  }
}

TEST_F(OlderMaskFrames, other_surroundings_leave_nothing) {
  sky_ = true;
  frame(all, SequenceStep::first);
  EXPECT_GT(frame(0).mask_pixels_older, 0u);
  scene_.environment(glm::vec3(0.5f));
  EXPECT_EQ(frame(0).mask_pixels_older, 0u);
}

// Where a tile's pixels come from tiles with and without masks, each has what was known of its own place.
TEST_F(OlderMaskFrames, tiles_are_known_pixel_by_pixel) {
  PixelTrail trail;
  Executor executor(2);
  const auto follow = [&](bool follows) {
    trail.begin({view_, depth_.image(), {width, height}, glm::dvec3(0.0), follows}, executor);
  };
  frame(7, SequenceStep::first);
  follow(false);
  const std::vector<uint8_t> before = older_.answers(OlderMasks::of_lights);
  look({0.4, 3, 6});
  frame(0);
  follow(true);
  const std::vector<uint8_t> after = older_.answers(OlderMasks::of_lights);
  size_t known = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t from = *trail.from(x, y);
      const bool was_known = from != PixelTrail::nowhere && before[from] != OlderMasks::no_answer;
      ASSERT_EQ(after[y * width + x] != OlderMasks::no_answer, was_known) << x << ", " << y;
      known += was_known;
    }
  EXPECT_GT(known, 4000u);
  EXPECT_LT(known, 7u * 32 * 32 + 1);
}

TEST_F(OlderMaskFrames, slow_motion_is_followed) {
  frame(all, SequenceStep::first);
  for (int f = 1; f <= 40; ++f) {
    look({0.005 * f, 3, 6});
    frame(0);
  }
  const OcclusionMasks now = whole();
  EXPECT_LT(differing(masks_.lit, now.lit), dark(now.lit) / 12);
}

// A surface that replaces another has no mask of it.
TEST_F(OlderMaskFrames, another_surface_is_lit) {
  frame(all, SequenceStep::first);
  size_t shown = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      if (masks_.lit[y * width + x] == 0 && (x & 1)) depth_.set(x, y, 0.1f, 0), ++shown;
  const Counters c = frame(0);
  EXPECT_EQ(c.mask_pixels_late, shown);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 1; x < width; x += 2) ASSERT_EQ(masks_.lit[y * width + x], 255);
}

TEST_F(OlderMaskFrames, lamps_and_cuts_leave_nothing) {
  frame(all, SequenceStep::first);
  ASSERT_GT(dark(masks_.lit), 100u);
  frame(0, SequenceStep::first);
  EXPECT_EQ(dark(masks_.lit), 0u);
  frame(all, SequenceStep::first);
  scene_.lights({point_light({-1, 6, 1}, 20.0f)});
  const Counters c = frame(0);
  EXPECT_EQ(c.mask_pixels_older, 0u);
  EXPECT_EQ(dark(masks_.lit), 0u);
}

TEST_F(OlderMaskFrames, nothing_is_older_than_the_bound) {
  frame(all, SequenceStep::first);
  for (uint32_t f = 1; f <= OlderMasks::oldest + 1u; ++f) {
    const double to[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.01 * f, 0, 0};
    scene_.scene.move_instances(&plate_, 1, to);
    const Counters c = frame(0);
    ASSERT_EQ(c.mask_pixels_older > 0, f <= OlderMasks::oldest) << f;
    ASSERT_EQ(c.answer_age, f <= OlderMasks::oldest ? f : 0u);
  }
  EXPECT_EQ(dark(masks_.lit), 0u);
}

}  // namespace
}  // namespace sideray::rt::older_masks_test
