// Random scenes against the brute-force tracer: which surfaces, in which order, at which distance.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "rt/embree/intersector_fixture.h"

namespace sideray::rt::test {
namespace {

void expect_layers(const model::Snapshot& snapshot, const std::vector<Ray>& rays, uint32_t layers,
                   const std::vector<std::vector<Hit>>& found, double most_ambiguous = 0.2) {
  size_t ambiguous = 0, wrong = 0, compared_hits = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const BruteResult truth = brute_force(snapshot, rays[i], true);
    if (truth.ambiguous) {
      ++ambiguous;
      continue;
    }
    bool same = found[i].size() == std::min<size_t>(layers, truth.hits.size());
    for (size_t k = 0; same && k < found[i].size(); ++k) {
      const Hit& a = found[i][k];
      const BruteHit& b = truth.hits[k];
      same = a.instance == b.instance && a.primitive == b.primitive && a.front == b.front &&
             std::abs(a.distance - b.distance) <= 1e-7 * b.distance;
      ++compared_hits;
    }
    wrong += !same;
  }
  EXPECT_EQ(wrong, 0u) << "of " << rays.size() << " rays, " << layers << " layers";
  EXPECT_LT(static_cast<double>(ambiguous), most_ambiguous * static_cast<double>(rays.size()));
  EXPECT_GT(compared_hits, rays.size() / 4);
}

class SoupLayers : public testing::TestWithParam<uint32_t> {};

TEST_P(SoupLayers, AreThoseOfBruteForce) {
  std::mt19937 random(1);
  const SceneBuilder scene = soup_scene(random, 8, 40, true);
  const std::vector<Ray> rays = random_rays(random, 3000);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  for (const bool coherent : {false, true})
    expect_layers(*scene.snapshot, rays, GetParam(), layers_of(intersector, rays, GetParam(), coherent));
}

TEST_P(SoupLayers, RespectTheRaysEnds) {
  std::mt19937 random(2);
  const SceneBuilder scene = soup_scene(random, 8, 40, true);
  std::vector<Ray> rays = random_rays(random, 3000);
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  for (Ray& ray : rays) {
    const float unit = 5.0f / glm::length(ray.direction);
    ray.t_near = unit * share(random);
    ray.t_far = ray.t_near + unit * share(random);
  }
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  expect_layers(*scene.snapshot, rays, GetParam(), layers_of(intersector, rays, GetParam()));
}

// Rays that begin just before a surface, on it and just behind it: Embree's rounding leaves open whether it counts.
TEST_P(SoupLayers, OfRaysThatBeginAtASurfaceAreThoseFromThereOn) {
  std::mt19937 random(5);
  const SceneBuilder scene = soup_scene(random, 8, 40, true);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  const std::vector<Ray> whole = random_rays(random, 1000);
  const std::vector<std::vector<Hit>> all = layers_of(intersector, whole, 64);
  std::vector<Ray> rays;
  std::vector<std::vector<Hit>> expected;
  for (size_t i = 0; i < whole.size(); ++i)
    for (size_t first = 0; first < all[i].size() && first < 3; ++first)
      for (const float share : {1.0f - 1e-4f, 1.0f - 1e-6f, 1.0f, 1.0f + 1e-6f, 1.0f + 1e-4f}) {
        rays.push_back(whole[i]);
        rays.back().t_near = static_cast<float>(all[i][first].distance) * share;
        std::vector<Hit>& hits = expected.emplace_back();
        for (const Hit& hit : all[i])
          if (static_cast<float>(hit.distance) >= rays.back().t_near && hits.size() < GetParam()) hits.push_back(hit);
      }
  ASSERT_GT(rays.size(), 5000u);
  const std::vector<std::vector<Hit>> found = layers_of(intersector, rays, GetParam());
  for (size_t i = 0; i < rays.size(); ++i)
    ASSERT_TRUE(std::equal(found[i].begin(), found[i].end(), expected[i].begin(), expected[i].end(), same_bits)) << i;
}

TEST_P(SoupLayers, ObeyTheCullRuleAlsoWhereMirrored) {
  std::mt19937 random(3);
  SceneBuilder scene = soup_scene(random, 8, 40, true);
  scene.snapshot->materials[0].cull_back = true;
  scene.add_material(true);
  for (size_t i = 0; i < 8; i += 3) scene.snapshot->instances[i].material = 1;
  const std::vector<Ray> rays = random_rays(random, 3000);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  expect_layers(*scene.snapshot, rays, GetParam(), layers_of(intersector, rays, GetParam(), true));
}

TEST_P(SoupLayers, PassThroughTransparentTexels) {
  std::mt19937 random(4);
  SceneBuilder scene;
  std::vector<uint8_t> alpha;
  for (int i = 0; i < 16 * 16; ++i) alpha.push_back(random() % 2 ? 255 : 0);
  const uint32_t texture = scene.add_texture(16, 16, alpha);
  for (const bool cull : {false, true}) {
    model::Material& material = scene.add_material(true);
    material.desc.base_color_texture.texture = texture;
    material.discards = true;
    material.cull_back = cull;
  }
  for (uint32_t i = 0; i < 8; ++i) {
    const uint32_t mesh = scene.add_mesh(triangle_soup(random, 40, 0.5f, 1.0f));
    scene.add_instance(mesh, i % 2, random_transform(random, 1.0f, 1.0f, i % 3 == 1));
  }
  const std::vector<Ray> rays = random_rays(random, 3000);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  expect_layers(*scene.snapshot, rays, GetParam(), layers_of(intersector, rays, GetParam(), true));
}

INSTANTIATE_TEST_SUITE_P(Layers, SoupLayers, testing::Values(1u, 2u, 4u, 8u, 16u, 64u));

// Compares all_layers() with the nearest 64; returns the most surfaces that a ray has.
size_t expect_all(const Intersector& intersector, const std::vector<Ray>& rays) {
  const std::vector<std::vector<Hit>> expected = layers_of(intersector, rays, 64);
  RaySurfaces found;
  intersector.all_layers(LayerSet::visible_in_layers, rays, found);
  size_t first = 0, wrong = 0, most = 0;
  for (size_t i = 0; i < rays.size(); first = found.ends[i++]) {
    const std::span<const Hit> hits(found.hits.data() + first, found.ends[i] - first);
    most = std::max(most, hits.size());
    wrong += !std::equal(hits.begin(), hits.end(), expected[i].begin(), expected[i].end(), same_bits);
  }
  EXPECT_EQ(wrong, 0u) << "of " << rays.size();
  return most;
}

TEST(AllLayers, AreTheNearestSixtyFour) {
  std::mt19937 random(8);
  SceneBuilder scene = soup_scene(random, 8, 40, true);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  std::vector<Ray> rays = random_rays(random, 3000);
  expect_all(intersector, rays);
  // From a surface on, and up to one.
  const std::vector<std::vector<Hit>> all = layers_of(intersector, rays, 64);
  for (size_t i = 0; i < rays.size(); ++i)
    if (!all[i].empty()) (i % 2 == 0 ? rays[i].t_near : rays[i].t_far) = static_cast<float>(all[i][all[i].size() / 2].distance);
  expect_all(intersector, rays);
}

TEST(AllLayers, OfManyTooAndOfSomeAtOnePlace) {
  for (const int count : {30, 34, 63, 90}) {
    SceneBuilder scene;
    scene.add_material(true);
    for (int i = 0; i < count; ++i)
      scene.add_instance(scene.add_mesh(square(2.0f, 0.1f * static_cast<float>(i / 2 * 2))), 0).surface_id = 1;
    Intersector intersector("");
    intersector.set_scene(scene.snapshot);
    std::vector<Ray> rays;
    for (int i = 0; i < 40; ++i) rays.push_back({{0.03f * static_cast<float>(i), 0.1f, -5.0f}, 0.0f, {0, 0, 1}, 100.0f});
    EXPECT_EQ(expect_all(intersector, rays), static_cast<size_t>(std::min(count, 64)));
  }
}

// Compares with all surfaces of each ray; returns how many rays have several at their nearest place.
size_t expect_places(const Intersector& intersector, const std::vector<Ray>& rays) {
  constexpr uint32_t most = Intersector::most_at_place;
  std::vector<Hit> hits(rays.size() * most);
  std::vector<uint32_t> counts(rays.size());
  std::vector<double> known(rays.size());
  intersector.nearest_places(LayerSet::visible_in_layers, rays, {}, hits.data(), counts.data(), known.data());
  const std::vector<std::vector<Hit>> all = layers_of(intersector, rays, 64);
  size_t several = 0, wrong = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    several += counts[i] > 1;
    bool right = counts[i] <= all[i].size() && (counts[i] > 0) == !all[i].empty();
    for (uint32_t k = 0; right && k < counts[i]; ++k)
      right = same_bits(hits[i * most + k], all[i][k]) && all[i][k].distance <= known[i];
    right = right && (counts[i] > 0 || known[i] == std::numeric_limits<double>::infinity());
    // Others are farther than what is known, but for those that there is no room for.
    if (right && counts[i] < all[i].size()) {
      const double next = all[i][counts[i]].distance;
      right = counts[i] < most ? next > known[i] : next >= known[i];
    }
    wrong += !right;
  }
  EXPECT_EQ(wrong, 0u) << "of " << rays.size();
  return several;
}

TEST(NearestPlaces, HoldAllUpToWhereTheyAreKnown) {
  std::mt19937 random(6);
  const SceneBuilder scene = soup_scene(random, 8, 40, true);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  std::vector<Ray> rays = random_rays(random, 3000);
  for (size_t i = 0; i < rays.size(); i += 2) rays[i].t_near = 2.0f / glm::length(rays[i].direction);
  expect_places(intersector, rays);
}

TEST(NearestPlaces, HoldSurfacesThatTouch) {
  std::mt19937 random(7);
  SceneBuilder scene;
  scene.add_material(true);
  const auto add = [&](float z) { scene.add_instance(scene.add_mesh(square(2.0f, z)), 0).surface_id = 1; };
  // Pairs that are a rounding apart, or many, and six at one place, which is more than there is room for.
  constexpr int pairs = 60;
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  for (int i = 1; i <= pairs; ++i) {
    add(static_cast<float>(i));
    add(static_cast<float>(i) - std::pow(10.0f, -4.0f + 2.0f * uniform(random)));
  }
  for (int i = 0; i < 6; ++i) add(0.0f);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  std::vector<Ray> rays;
  for (int i = 0; i < 2000; ++i) {
    const float start = 0.5f + static_cast<float>(i % (pairs + 1));
    rays.push_back({{uniform(random), uniform(random), start}, 0.0f, {0.1f * uniform(random), 0.0f, -1.0f}, 100.0f});
  }
  const size_t several = expect_places(intersector, rays);
  EXPECT_GT(several, rays.size() / 4);
  EXPECT_LT(several, rays.size() * 3 / 4);
}

TEST(NearestOpaque, IsThatOfBruteForceAndShadowRaysAgree) {
  std::mt19937 random(5);
  SceneBuilder scene = soup_scene(random, 8, 40, false);
  std::vector<uint8_t> alpha;
  for (int i = 0; i < 16 * 16; ++i) alpha.push_back(static_cast<uint8_t>(random() % 256));
  const uint32_t texture = scene.add_texture(16, 16, alpha);
  for (const bool cut_outs : {false, true}) {
    if (cut_outs) {
      model::Material& material = scene.add_material(false);
      material.desc.alpha_mode = SIDERAY_MASK;
      material.desc.alpha_cutoff = 0.5f;
      material.desc.base_color_texture.texture = texture;
      material.discards = true;
      for (uint32_t i = 0; i < 8; ++i) {
        const uint32_t mesh = scene.add_mesh(triangle_soup(random, 40, 0.5f, 1.0f));
        scene.add_instance(mesh, scene.last_material(), random_transform(random, 1.0f, 1.0f, i % 3 == 1));
      }
    }
    std::vector<Ray> rays = random_rays(random, 3000);
    for (size_t i = 0; i < rays.size(); i += 2) rays[i].t_far = 4.5f / glm::length(rays[i].direction);
    Intersector intersector("");
    intersector.set_scene(scene.snapshot);
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> occluded(rays.size());
    intersector.nearest_opaque(rays, {}, hits.data());
    intersector.occluded(rays, false, occluded.data());
    size_t wrong = 0, found = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const BruteResult truth = brute_force(*scene.snapshot, rays[i], false);
      if (truth.ambiguous) continue;
      if (truth.hits.empty()) {
        wrong += hits[i].instance != no_instance || occluded[i] != 0;
        continue;
      }
      const BruteHit& b = truth.hits.front();
      wrong += hits[i].instance != b.instance || hits[i].primitive != b.primitive || hits[i].front != b.front ||
               std::abs(hits[i].distance - b.distance) > 1e-7 * b.distance || occluded[i] != 1;
      ++found;
    }
    EXPECT_EQ(wrong, 0u) << "cut-outs: " << cut_outs;
    EXPECT_GT(found, 1000u);
    EXPECT_LT(found, 2990u);
  }
}

}  // namespace
}  // namespace sideray::rt::test
