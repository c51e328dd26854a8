// Tests the mask that all lights from the 33rd on share: one ray a pixel, to a light drawn by its unshadowed
// contribution.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "rt/base/sampling.h"
#include "rt/masks/combined_lights.h"
#include "rt/masks/mask_filters.h"
#include "rt/tracer.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

constexpr uint32_t width = 48, height = 32;

sideray_light spot_light(glm::vec3 position, glm::vec3 direction, float intensity) {
  sideray_light l = point_light(position, intensity);
  l.type = SIDERAY_LIGHT_SPOT;
  for (int i = 0; i < 3; ++i) l.direction[i] = direction[i];
  l.inner_cone = 0.2f;
  l.outer_cone = 0.6f;
  return l;
}

// Of every kind, near and far, one of them just above the floor, one out of reach of most of it.
std::vector<sideray_light> test_lights() {
  std::vector<sideray_light> lights{
      point_light({-1.5f, 1.2f, 0.0f}, 2.0f), point_light({1.0f, 2.0f, -1.0f}, 5.0f),
      point_light({0.3f, 0.02f, 0.1f}, 0.01f), directional_light({0.5f, -0.8f, 0.33f}, 0.7f),
      spot_light({0.5f, 2.0f, 0.5f}, {0.0f, -1.0f, 0.0f}, 6.0f), point_light({2.0f, 0.7f, 1.0f}, 1.0f),
      point_light({0.0f, -1.0f, 0.0f}, 9.0f)};  // below the floor: it adds nothing
  lights[1].intensity[0] = 0.0f;
  lights[5].range = 1.5f;
  return lights;
}

class CombinedMask : public testing::Test {
 protected:
  CombinedMask() {
    for (TestScene* scene : {&combined_, &single_}) {
      scene->quad({0, 0, 0}, {10, 0, 0}, {0, 0, 10}, plain_material());
      scene->quad({-0.4f, 0.6f, 0.1f}, {0.4f, 0, 0}, {0, 0, 0.3f}, plain_material());
      scene->quad({0.7f, 0.4f, 0.3f}, {0.02f, 0, 0}, {0, 0.4f, 0}, plain_material());
    }
    std::vector<sideray_light> lights(CombinedLights::first_light, point_light({0, 50, 0}, 100.0f));
    for (const sideray_light& light : test_lights()) lights.push_back(light);
    combined_.lights(lights);
    single_.lights(test_lights());
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) set_depth(x, y);
  }

  // What a rasterizer stores of the floor.
  void set_depth(uint32_t x, uint32_t y) {
    const glm::dvec2 ndc((x + 0.5) / width * 2.0 - 1.0, (y + 0.5) / height * 2.0 - 1.0);
    const glm::dvec4 h = view_.local_from_clip * glm::dvec4(ndc, 0.5, 1.0);
    const glm::dvec3 direction = glm::dvec3(h) / h.w - eye_;
    if (direction.y >= 0.0) return;
    const glm::dvec3 point = eye_ - direction * (eye_.y / direction.y);
    const glm::dvec4 clip = view_.clip_from_local * glm::dvec4(point, 1.0);
    depth_.set(x, y, static_cast<float>(clip.z / clip.w), 0);
    points_[{x, y}] = point;
  }

  MaskRequest request(uint32_t seed) {
    MaskRequest r;
    r.view = view_;
    r.width = width;
    r.height = height;
    r.depth = depth_.image();
    r.combined_lights = true;
    r.seed = seed;
    return r;
  }
  // Every light has a mask of its own.
  OcclusionMasks of_each_light(Tracer& tracer, const std::shared_ptr<const model::Snapshot>& snapshot) {
    tracer.set_scene(snapshot);
    MaskRequest each = request(1);
    each.combined_lights = false;
    each.shadow_lights = (1u << test_lights().size()) - 1u;
    OcclusionMasks single;
    tracer.trace_masks(each, single);
    return single;
  }

  const glm::dvec3 eye_{0.2, 2.5, 2.5};
  const TraceView view_ = perspective(eye_, {0.2, 0, 0}, 0.8, double{width} / height);
  TestScene combined_, single_;
  DepthBuffer depth_{width, height, 0.0f, 0};
  std::map<std::pair<uint32_t, uint32_t>, glm::dvec3> points_;
};

// Computes the expected mask from every light's own mask and its contribution to a floor that faces up.
double expected_at(const model::Snapshot& snapshot, const OcclusionMasks& masks, glm::vec3 position, size_t texel) {
  const ShadingScene scene(std::make_shared<const model::Snapshot>(snapshot));
  double lit = 0.0, sum = 0.0;
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const shading::SrIncidence in = shading::sr_incidence(scene.lights[i], position);
    const double weight = static_cast<double>(std::max(in.to_light.y, 0.0f) *
                                              (in.irradiance.x + in.irradiance.y + in.irradiance.z));
    sum += weight;
    lit += masks.lit[i * width * height + texel] / 255.0 * weight;
  }
  return lit / sum;
}

TEST_F(CombinedMask, MeanIsTheVisibilityWeightedByWhatLightsAdd) {
  Tracer tracer({2, ""});
  const auto snapshot = single_.commit();
  const OcclusionMasks single = of_each_light(tracer, snapshot);

  tracer.set_scene(combined_.commit());
  constexpr uint32_t seeds = 400;
  std::vector<uint32_t> lit(size_t{width} * height);
  OcclusionMasks masks;
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    const Counters counters = tracer.trace_masks(request(seed), masks);
    EXPECT_LE(counters.rays_shadow, lit.size());
    ASSERT_EQ(masks.layers, 1u);
    for (size_t i = 0; i < lit.size(); ++i) {
      ASSERT_TRUE(masks.lit[i] == 0 || masks.lit[i] == 255);
      lit[i] += masks.lit[i] == 255;
    }
  }
  double off = 0.0, variance = 0.0;
  int partly = 0, beyond = 0;
  for (const auto& [pixel, point] : points_) {
    const size_t texel = size_t{pixel.second} * width + pixel.first;
    const double expected = expected_at(*snapshot, single, glm::vec3(point), texel);
    const double error = lit[texel] / double{seeds} - expected;
    const double standard = std::sqrt(std::max(expected * (1.0 - expected), 1e-6) / seeds);
    partly += expected > 0.02 && expected < 0.98;
    beyond += std::abs(error) > 4.0 * standard;
    EXPECT_LT(std::abs(error), 5.5 * standard) << pixel.first << "," << pixel.second << " expected " << expected;
    off += error;
    variance += standard * standard;
  }
  EXPECT_GT(partly, 200);
  EXPECT_LE(beyond, 1) << "of " << points_.size() << " pixels, beyond four standard errors";
  EXPECT_LT(std::abs(off), 4.0 * std::sqrt(variance)) << "all pixels together";
}

// The mean contribution of the drawn light, tint included, equals that of all lights by their own masks and tints.
TEST_F(CombinedMask, TintsAreWeightedByWhatLightsAdd) {
  sideray_material_desc pane = glass();
  pane.thickness = 0.0f;
  pane.base_color[1] = 0.5f, pane.base_color[2] = 0.2f;
  for (TestScene* scene : {&combined_, &single_}) scene->quad({0.6f, 0.3f, 0.0f}, {0.8f, 0, 0}, {0, 0.1f, 0.9f}, pane);
  Tracer tracer({2, ""});
  const auto snapshot = single_.commit();
  const OcclusionMasks single = of_each_light(tracer, snapshot);
  ASSERT_GT(single.tints, 2u);
  tracer.set_scene(combined_.commit());
  constexpr uint32_t seeds = 200;
  const size_t pixels = size_t{width} * height;
  const auto arriving = [&](const OcclusionMasks& masks, uint32_t layer, uint32_t channel, size_t texel) {
    const uint32_t place = masks.tints > 0 ? masks.tint_places[layer] : 0;
    const uint8_t left = place == 0 ? uint8_t{255} : masks.tint_plane(place, channel)[texel];
    return masks.lit[layer * pixels + texel] / 255.0 * left / 255.0;
  };
  std::array<std::vector<double>, 3> seen;
  for (auto& plane : seen) plane.resize(pixels);
  OcclusionMasks masks;
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    tracer.trace_masks(request(seed), masks);
    for (uint32_t c = 0; c < 3; ++c)
      for (size_t i = 0; i < pixels; ++i) seen[c][i] += arriving(masks, 0, c, i) / seeds;
  }
  const ShadingScene scene(snapshot);
  size_t tinted = 0, beyond = 0;
  double off = 0.0;
  for (const auto& [pixel, point] : points_) {
    const size_t texel = size_t{pixel.second} * width + pixel.first;
    for (uint32_t c = 0; c < 3; ++c) {
      double sum = 0.0, lit = 0.0, untinted = 0.0;
      for (uint32_t i = 0; i < scene.lights.size(); ++i) {
        const shading::SrIncidence in = shading::sr_incidence(scene.lights[i], glm::vec3(point));
        const double weight = static_cast<double>(std::max(in.to_light.y, 0.0f) *
                                                  (in.irradiance.x + in.irradiance.y + in.irradiance.z));
        sum += weight;
        lit += weight * arriving(single, i, c, texel);
        untinted += weight * single.lit[i * pixels + texel] / 255.0;
      }
      tinted += untinted - lit > 0.05 * sum;
      // Of a share between 0 and 1 the standard error is 0.5 / sqrt(seeds) at most.
      beyond += std::abs(seen[c][texel] - lit / sum) > 4.0 * 0.5 / std::sqrt(double{seeds});
      off += (seen[c][texel] - lit / sum) / static_cast<double>(3 * points_.size());
    }
  }
  EXPECT_GT(tinted, 300u);
  EXPECT_LE(beyond, 3u) << "beyond four standard errors, where glass tints only the corner of a block";
  EXPECT_LT(std::abs(off), 0.003);
}

TEST_F(CombinedMask, IsTheSameBitsForAnyNumberOfThreads) {
  OcclusionMasks masks[2];
  for (const uint32_t threads : {1u, 3u}) {
    Tracer tracer({threads, ""});
    tracer.set_scene(combined_.commit());
    tracer.trace_masks(request(7), masks[threads / 3]);
  }
  EXPECT_EQ(masks[0].lit, masks[1].lit);
}

TEST_F(CombinedMask, ComesBehindTheMasksOfSingleLights) {
  Tracer tracer({1, ""});
  tracer.set_scene(combined_.commit());
  OcclusionMasks alone, both, first;
  tracer.trace_masks(request(3), alone);
  MaskRequest r = request(3);
  r.shadow_lights = 0x80000001u;
  tracer.trace_masks(r, both);
  r.combined_lights = false;
  tracer.trace_masks(r, first);
  const size_t pixels = size_t{width} * height;
  ASSERT_EQ(both.layers, 3u);
  EXPECT_TRUE(std::equal(first.lit.begin(), first.lit.end(), both.lit.begin()));
  EXPECT_TRUE(std::equal(alone.lit.begin(), alone.lit.end(), both.lit.begin() + static_cast<ptrdiff_t>(2 * pixels)));
}

TEST_F(CombinedMask, IsLitWhereTheSceneHasNoLightsBeyondThe32nd) {
  Tracer tracer({1, ""});
  tracer.set_scene(single_.commit());
  OcclusionMasks masks;
  EXPECT_EQ(tracer.trace_masks(request(1), masks).rays_shadow, 0u);
  EXPECT_EQ(static_cast<size_t>(std::count(masks.lit.begin(), masks.lit.end(), uint8_t{255})), masks.lit.size());
}

TEST_F(CombinedMask, IsFiltered) {
  Tracer tracer({1, ""});
  tracer.set_scene(combined_.commit());
  MaskFilters filters;
  MaskRequest r = request(1);
  r.filters = &filters;
  OcclusionMasks masks, raw;
  tracer.trace_masks(r, masks);
  tracer.trace_masks(request(1), raw);
  const auto between = [](const OcclusionMasks& m) {
    return std::count_if(m.lit.begin(), m.lit.end(), [](uint8_t v) { return v != 0 && v != 255; });
  };
  EXPECT_EQ(between(raw), 0);
  EXPECT_GT(between(masks), 200);
}

// Thousands of lights, among them some that lie within the block, where bounds say nothing.
TEST(CombinedLights, ALightIsDrawnByItsWeight) {
  std::vector<sideray_light> lights(CombinedLights::first_light, point_light({0, 1, 0}, 1.0f));
  uint32_t bits = 1;
  const auto unit = [&] { return unit_float(bits = hash_bits(bits)); };
  for (int i = 0; i < 4000; ++i)
    lights.push_back(point_light({40.0f * unit() - 20.0f, 0.05f + 4.0f * unit(), 40.0f * unit() - 20.0f}, unit()));
  for (int i = 0; i < 3; ++i) lights.push_back(point_light({0.2f * unit(), 0.01f, 0.2f * unit()}, 1e-4f));
  TestScene scene;
  scene.quad({0, 0, 0}, {20, 0, 0}, {0, 0, 20}, plain_material());
  scene.lights(lights);
  const ShadingScene shading(scene.commit());
  const CombinedLights combined(shading);
  std::vector<DepthPoint> points(2);
  points[0].front = {0.01f, 0.0f, 0.02f};
  points[1].front = {0.25f, 0.0f, 0.2f};
  for (DepthPoint& p : points) p.normal = {0, 1, 0};
  CombinedLights::Block block;
  block.begin(combined, points);
  for (const DepthPoint& p : points) {
    std::vector<double> weights(lights.size());
    double sum = 0.0;
    for (size_t i = CombinedLights::first_light; i < lights.size(); ++i)
      sum += weights[i] = double{combined.weight(i - CombinedLights::first_light, p)};
    constexpr uint32_t draws = 100000;
    std::vector<uint32_t> drawn(lights.size());
    for (uint32_t k = 0; k < draws; ++k) ++drawn[block.draw(p, random_key({5, k})).value()];
    // Pearson's statistic over lights that are drawn often enough, all others as one.
    double statistic = 0.0, rest = draws, rest_drawn = draws;
    int cells = 0;
    for (size_t i = 0; i < lights.size(); ++i) {
      const double expected = draws * weights[i] / sum;
      if (expected < 20.0) continue;
      ++cells;
      rest -= expected;
      rest_drawn -= drawn[i];
      statistic += (drawn[i] - expected) * (drawn[i] - expected) / expected;
    }
    statistic += (rest_drawn - rest) * (rest_drawn - rest) / rest;
    EXPECT_GT(cells, 50);
    EXPECT_LT(std::abs(statistic - cells), 4.0 * std::sqrt(2.0 * cells));
  }
}

// The floor is drawn at y = 0, and traced a little above, as where its tessellation is coarser.
TEST(GivenShadowBias, RaysStartOffTheSurface) {
  TestScene scene;
  scene.quad({0, 0.05f, 0}, {50, 0, 0}, {0, 0, 50}, plain_material());
  scene.lights({directional_light({0.3f, -1.0f, 0.2f}, 1.0f)});
  Tracer tracer({1, ""});
  tracer.set_scene(scene.commit());
  const glm::dvec3 eye(0, 3, 0);
  const TraceView view = perspective(eye, {0, 0, -0.01}, 0.8, double{width} / height);
  const glm::dvec4 clip = view.clip_from_local * glm::dvec4(0, 0, 0, 1);
  const DepthBuffer depth(width, height, static_cast<float>(clip.z / clip.w), 0);
  MaskRequest r;
  r.view = view;
  r.width = width;
  r.height = height;
  r.depth = depth.image();
  r.shadow_lights = 1;
  r.ao_rays = 4;
  const auto share_lit = [&](float bias) {
    r.shadow_bias = bias;
    OcclusionMasks masks;
    tracer.trace_masks(r, masks);
    const auto lit = std::count(masks.lit.begin(), masks.lit.end(), uint8_t{255});
    EXPECT_EQ(lit > 0, std::count(masks.open.begin(), masks.open.end(), uint8_t{255}) > 0);
    return static_cast<double>(lit) / static_cast<double>(masks.lit.size());
  };
  EXPECT_EQ(share_lit(0.0f), 0.0);
  EXPECT_EQ(share_lit(0.02f), 0.0);
  EXPECT_EQ(share_lit(0.08f), 1.0);
}

}  // namespace
}  // namespace sideray::rt
