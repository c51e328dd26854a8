// Tests tints of glass between lights and opaque pixels, against separate rays and along sequences.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rt/base/view_rays.h"
#include "rt/kernel_sets.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/older_masks.h"
#include "rt/refraction/refraction_scene.h"
#include "rt/scene/traced_scene.h"
#include "rt/light/straight_light.h"

namespace sideray::rt::tint_masks_test {
namespace {

using namespace test;

constexpr uint32_t width = 120, height = 88;
const glm::vec3 sun(0.4f, -1.0f, 0.3f);

// A floor, a ball of coloured glass made of a box, a pane, and an opaque plate beside.
class TintMasks : public testing::Test {
 protected:
  TintMasks() {
    scene_.quad({0, 0, 0}, {20, 0, 0}, {0, 0, 20}, plain_material());
    sideray_material_desc m = solid_glass(1.5f, {0.9f, 0.3f, 0.1f}, 0.5f);
    Triangles box;
    const glm::vec3 x(0.6f, 0.1f, 0.2f), y(-0.1f, 0.4f, 0.1f), z(-0.2f, 0.1f, 0.5f), c(0, 1, 0);
    box.polygon({c - x - y + z, c + x - y + z, c + x + y + z, c - x + y + z});
    box.polygon({c + x - y - z, c - x - y - z, c - x + y - z, c + x + y - z});
    box.polygon({c + x - y + z, c + x - y - z, c + x + y - z, c + x + y + z});
    box.polygon({c - x - y - z, c - x - y + z, c - x + y + z, c - x + y - z});
    box.polygon({c - x + y + z, c + x + y + z, c + x + y - z, c - x + y - z});
    box.polygon({c - x - y - z, c + x - y - z, c + x - y + z, c - x - y + z});
    glass_ = box.add_to(scene_, m);
    pane_ = scene_.quad({-1.3f, 0.8f, 0.4f}, {0.5f, 0, 0}, {0, 0.2f, -0.4f}, blended({0.2f, 0.4f, 0.8f}, 0.4f));
    scene_.quad({1.1f, 0.7f, -0.2f}, {0.4f, 0, 0}, {0, 0, 0.4f}, plain_material());
    light_ = directional_light(glm::normalize(sun), 1.0f);
    commit();
    look({0.2, 4, 5});
  }

  void commit() {
    scene_.lights({light_});
    tracer_.set_scene(scene_.commit());
  }

  // Instances are numbered as they were added, like their surfaces.
  void let_cast(uint32_t instance, bool casts) {
    scene_.scene.set_visibility(instance, casts ? SIDERAY_VISIBLE_ALL : SIDERAY_VISIBLE_ALL & ~SIDERAY_VISIBLE_SHADOW);
  }

  void look(glm::dvec3 eye) {
    view_ = perspective(eye, {0, 0.2, 0.3}, 0.6, double{width} / height);
    const ViewRays rays(view_, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const glm::dvec4 clip = view_.clip_from_local * glm::dvec4(floor_at(rays, x, y), 1.0);
        depth_.set(x, y, static_cast<float>(clip.z / clip.w), 0);
      }
  }

  static glm::dvec3 floor_at(const ViewRays& rays, uint32_t x, uint32_t y) {
    const Ray ray = rays.ray(x, y);
    const glm::dvec3 from(ray.origin), d(ray.direction);
    return from - d * (from.y / d.y);
  }

  MaskRequest request(SequenceStep step = SequenceStep::first) {
    MaskRequest r;
    r.view = view_;
    r.width = width, r.height = height;
    r.depth = depth_.image();
    r.shadow_lights = 1;
    r.sequence = step;
    return r;
  }

  OcclusionMasks fresh() {
    OcclusionMasks masks;
    tracer_.trace_masks(request(), masks);
    return masks;
  }

  TestScene scene_;
  uint32_t glass_ = 0, pane_ = 0;
  sideray_light light_{};
  Tracer tracer_{{2, ""}};
  TraceView view_;
  DepthBuffer depth_{width, height, 0.0f, 0};
};

// How many pixels differ from the median of their neighbours by more than an eighth of the light.
size_t dots(const OcclusionMasks& masks) {
  const auto plane = masks.tint_plane(1, 1);
  size_t count = 0;
  for (uint32_t y = 1; y + 1 < height; ++y)
    for (uint32_t x = 1; x + 1 < width; ++x) {
      std::vector<int> around;
      for (uint32_t v = y - 1; v <= y + 1; ++v)
        for (uint32_t u = x - 1; u <= x + 1; ++u) around.push_back(plane[size_t{v} * width + u]);
      std::nth_element(around.begin(), around.begin() + 4, around.end());
      count += std::abs(int{plane[size_t{y} * width + x]} - around[4]) > 32;
    }
  return count;
}

// A lamp behind glass that a tenth of the rays to it miss, seen through a pane just over the floor, for which the filter is
// as narrow as a pixel.
TEST_F(TintMasks, BehindNearGlassABulbLeavesFewDots) {
  TestScene scene;
  scene.quad({0, 0, 0}, {20, 0, 0}, {0, 0, 20}, plain_material());
  scene.quad({0, 0.02f, 0}, {9, 0, 0}, {0, 0, 9}, blended(glm::vec3(0.9f), 0.3f));
  scene.quad({0.8f, 7.5f, 0}, {1, 0, 0}, {0, 0, 1}, blended(glm::vec3(0.1f), 0.6f));
  sideray_light lamp = point_light({0, 8, 0}, 64.0f);
  lamp.radius = 0.3f;
  scene.lights({lamp});
  tracer_.set_scene(scene.commit());
  OcclusionMasks raw, filtered;
  tracer_.trace_masks(request(), raw);
  ASSERT_EQ(raw.tints, 1u);
  MaskFilters filters;
  MaskRequest r = request();
  r.filters = &filters;
  tracer_.trace_masks(r, filtered);
  constexpr size_t pixels = size_t{width} * height;
  EXPECT_GT(dots(raw), pixels / 15);
  EXPECT_LT(dots(filtered), pixels / 50);
}

// Returns the mean of a tint's green in each of 4x4 parts of the picture.
std::vector<double> means_of_parts(const OcclusionMasks& masks) {
  std::vector<double> means(16);
  const auto plane = masks.tint_plane(1, 1);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      means[y * 4 / height * 4 + x * 4 / width] += plane[size_t{y} * width + x] / (width * height / 16.0);
  return means;
}

// A lamp beside a pane that half of the rays to it pass. The penumbra is wider than the picture.
TEST_F(TintMasks, InWidePenumbraeComeFromAQuarterOfTheRays) {
  TestScene scene;
  scene.quad({0, 0, 0}, {20, 0, 0}, {0, 0, 20}, plain_material());
  scene.quad({4, 7.95f, 0}, {4, 0, 0}, {0, 0, 4}, blended(glm::vec3(0.4f), 0.6f));
  scene.quad({-4, 7.95f, 0}, {0, 0, 0.1f}, {0.1f, 0, 0}, blended(glm::vec3(0.4f), 0.6f));  // all rays come near glass
  sideray_light lamp = point_light({0, 8, 0}, 64.0f);
  lamp.radius = 0.04f;
  scene.lights({lamp});
  tracer_.set_scene(scene.commit());
  constexpr uint64_t pixels = uint64_t{width} * height;
  MaskFilters filters;
  MaskRequest r = request();
  r.filters = &filters;
  OcclusionMasks filtered, raw;
  EXPECT_LT(tracer_.trace_masks(r, filtered).rays_shadow, pixels + pixels * 3 / 10);
  r.filters = nullptr;
  EXPECT_GT(tracer_.trace_masks(r, raw).rays_shadow, pixels + pixels * 9 / 10);
  ASSERT_EQ(raw.tints, 1u);
  const std::vector<double> expected = means_of_parts(raw), found = means_of_parts(filtered);
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], 8.0) << "part " << i;
}

TEST_F(TintMasks, AreWhatRaysOfTheirOwnSay) {
  const OcclusionMasks masks = fresh();
  ASSERT_EQ(masks.tints, 1u);
  ASSERT_EQ(masks.tint_places.at(0), 1u);
  TracedScene scene({.threads = 1, .isa = ""});
  scene.set_scene(scene_.commit());
  StraightLight straight;
  straight.begin(scene.shading(), scene.intersector());
  const ViewRays rays(view_, width, height);
  size_t tinted = 0, apart = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const size_t i = size_t{y} * width + x;
      const Ray ray{glm::vec3(floor_at(rays, x, y)) + glm::vec3(0, 1e-4f, 0), 0.0f, -glm::normalize(sun), farthest};
      straight.follow({&ray, 1});
      bool same = true;
      for (uint32_t c = 0; c < 3 && masks.lit[i] != 0; ++c)
        same = same && std::abs(straight.through(0)[static_cast<int>(c)] * 255.0f - static_cast<float>(masks.tint_plane(1, c)[i])) <= 3.0f;
      tinted += masks.tint_plane(1, 1)[i] < 250;
      apart += !same;
    }
  EXPECT_GT(tinted, size_t{width} * height / 40);
  EXPECT_LE(apart, tinted / 50) << "beyond edges, where rays start a little aside";
}

TEST_F(TintMasks, HaveTheSameBitsForAnyThreadsAndInstructionSet) {
  light_.angular_diameter_deg = 2.0f;
  commit();
  std::vector<uint8_t> first;
  for (const char* isa : kernel_sets())
    for (const uint32_t threads : {1u, 3u}) {
      Tracer tracer({threads, isa});
      tracer.set_scene(scene_.commit());
      MaskFilters filters;
      MaskRequest r = request();
      r.filters = &filters;
      OcclusionMasks masks;
      tracer.trace_masks(r, masks);
      ASSERT_FALSE(masks.tint.empty());
      if (first.empty()) first = masks.tint;
      EXPECT_EQ(masks.tint, first) << isa << ' ' << threads;
    }
}

TEST_F(TintMasks, KeepTheMaskOfWhatIsOpaque) {
  const OcclusionMasks with = fresh();
  let_cast(glass_, false);
  let_cast(pane_, false);
  commit();
  const OcclusionMasks without = fresh();
  EXPECT_EQ(with.lit, without.lit);
  EXPECT_EQ(without.tints, 0u);
  EXPECT_TRUE(without.tint.empty());
}

TEST_F(TintMasks, FollowGlassThatComesAndGoesInASequence) {
  KeptMasks kept;
  OcclusionMasks masks;
  for (const bool casts : {true, false, true}) {
    let_cast(glass_, casts);
    commit();
    for (int frame = 0; frame < 3; ++frame) {
      MaskRequest r = request(SequenceStep::next);
      r.kept = &kept;
      tracer_.trace_masks(r, masks);
      EXPECT_EQ(kept.keeps(0), frame > 0) << "frame " << frame;
    }
    EXPECT_EQ(masks.tint, fresh().tint) << casts;
  }
  let_cast(glass_, false);
  let_cast(pane_, false);
  commit();
  MaskRequest r = request(SequenceStep::next);
  r.kept = &kept;
  tracer_.trace_masks(r, masks);
  EXPECT_FALSE(masks.is_tinted(1));
  EXPECT_EQ(static_cast<size_t>(std::count(masks.tint.begin(), masks.tint.end(), uint8_t{255})), masks.tint.size());
}

TEST_F(TintMasks, AreForgottenByTheFiltersTooWhereGlassIsGone) {
  light_.angular_diameter_deg = 3.0f;
  commit();
  MaskFilters filters;
  OcclusionMasks masks;
  const auto draw = [&](uint32_t seed) {
    MaskRequest r = request(seed == 1 ? SequenceStep::first : SequenceStep::next);
    r.filters = &filters;
    r.seed = seed;
    tracer_.trace_masks(r, masks);
  };
  for (uint32_t seed = 1; seed <= 4; ++seed) draw(seed);
  EXPECT_TRUE(masks.is_tinted(1));
  let_cast(glass_, false);
  let_cast(pane_, false);
  commit();
  for (uint32_t seed = 5; seed <= 80; ++seed) draw(seed);
  EXPECT_FALSE(masks.is_tinted(1));
}

// A mean over the pixels of a soft shadow is that of rays without a filter.
TEST_F(TintMasks, FiltersKeepTheMean) {
  light_.angular_diameter_deg = 4.0f;
  commit();
  MaskFilters filters;
  MaskRequest r = request();
  r.filters = &filters;
  OcclusionMasks filtered;
  tracer_.trace_masks(r, filtered);
  const OcclusionMasks noisy = fresh();
  const auto mean = [&](const OcclusionMasks& m, uint32_t c) {
    double sum = 0;
    for (size_t i = 0; i < size_t{width} * height; ++i)
      sum += static_cast<double>(m.lit[i]) * static_cast<double>(m.tint_plane(1, c)[i]) / (255.0 * 255.0);
    return sum / (width * height);
  };
  for (uint32_t c = 0; c < 3; ++c) EXPECT_NEAR(mean(filtered, c), mean(noisy, c), 0.004) << c;
}

// In the soft shadow of opaque strips below a pane, pixels whose own ray is blocked have the tint of their neighbours.
TEST_F(TintMasks, KeepTheMeanInShadowsOfOpaqueStripsBelowAPane) {
  TestScene scene;
  scene.quad({0, 0, 0}, {20, 0, 0}, {0, 0, 20}, plain_material());
  scene.quad({0, 3, 0}, {20, 0, 0}, {0, 0, 20}, blended(glm::vec3(0.2f), 0.8f));
  for (int i = -20; i < 20; ++i)
    scene.quad({0.3f * static_cast<float>(i), 2, 0}, {0.09f, 0, 0}, {0, 0, 20}, plain_material());
  light_.angular_diameter_deg = 8.0f;
  scene.lights({light_});
  tracer_.set_scene(scene.commit());
  MaskFilters filters;
  MaskRequest r = request();
  r.filters = &filters;
  OcclusionMasks filtered;
  tracer_.trace_masks(r, filtered);
  ASSERT_EQ(filtered.tints, 1u);
  const auto plane = filtered.tint_plane(1, 1);
  double light = 0, tinted = 0;
  for (size_t i = 0; i < size_t{width} * height; ++i) {
    light += filtered.lit[i];
    tinted += static_cast<double>(filtered.lit[i]) * static_cast<double>(plane[i]) / 255.0;
  }
  EXPECT_NEAR(tinted / light, 0.2, 0.05) << "a block without a lit pixel keeps white, which the filter spreads";
}

TEST_F(TintMasks, StayWithTheSurfaceUnderADeadline) {
  OlderMasks older;
  OcclusionMasks masks;
  const auto draw = [&](bool in_time) {
    MaskRequest r = request(SequenceStep::next);
    r.older = &older;
    r.work.deadline = Deadline::clock::now() + (in_time ? std::chrono::hours(1) : std::chrono::hours(-1));
    tracer_.trace_masks(r, masks);
  };
  draw(true);
  EXPECT_EQ(masks.tint, fresh().tint);
  draw(false);
  EXPECT_EQ(masks.tint, fresh().tint) << "the view stands still";
  look({0.35, 4, 5});
  draw(false);
  const OcclusionMasks now = fresh();
  size_t apart = 0;
  for (size_t i = 0; i < now.tint.size(); ++i) apart += std::abs(int{now.tint[i]} - int{masks.tint[i]}) > 12;
  EXPECT_LT(apart, now.tint.size() / 40);
  EXPECT_TRUE(masks.is_tinted(1));
}

}  // namespace
}  // namespace sideray::rt::tint_masks_test
