// Bad rays, odd scenes, instruction sets, batches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "model/failure.h"
#include "rt/embree/intersector_fixture.h"

namespace sideray::rt::test {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

// Every set that this processor has; each has a native packet width of its own.
std::vector<std::string> instruction_sets() {
  std::vector<std::string> result;
  for (const char* isa : {"sse2", "sse4.2", "avx", "avx2", "avx512"}) {
    try {
      Intersector intersector(isa);
      result.emplace_back(isa);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.status, SIDERAY_UNSUPPORTED);
    }
  }
  return result;
}

// Triangles in front of and behind the unit square, both kinds.
SceneBuilder two_squares() {
  SceneBuilder scene;
  scene.add_material(true);
  scene.add_material(false);
  scene.add_instance(scene.add_mesh(square(1.0f, 0.0f)), 0);
  scene.add_instance(scene.add_mesh(square(1.0f, -1.0f)), 1);
  return scene;
}

class EveryInstructionSet : public testing::TestWithParam<std::string> {};

TEST_P(EveryInstructionSet, RefusesBadRaysHarmlessly) {
  const SceneBuilder scene = two_squares();
  Intersector intersector(GetParam());
  intersector.set_scene(scene.snapshot);
  const glm::vec3 o(0.1f, 0.3f, 5.0f), d(0, 0, -1);
  std::vector<Ray> bad{{o, 0, {0, 0, 0}, 9},
                       {o, -1, d, 9},
                       {o, 0, d, 0},
                       {o, 5.5f, d, 5.4f},
                       {o, not_a_number, d, 9},
                       {o, 0, d, not_a_number},
                       {o, infinity, d, infinity},
                       {o, 0, d, -infinity},
                       {{1e20f, 0, 0}, 0, d, 9},
                       {o, 0, {0, 0, -infinity}, 9},
                       {{0, 0, -1e30f}, 0, d, 9},
                       {o, 3e38f, d, infinity}};
  for (int i = 0; i < 3; ++i)
    for (const float value : {not_a_number, infinity, -infinity}) {
      bad.push_back({o, 0, d, 9});
      bad.back().origin[i] = value;
      bad.push_back({o, 0, d, 9});
      bad.back().direction[i] = value;
    }
  // Good rays in between: each alone in a packet, at its end, and among others.
  std::vector<Ray> rays;
  for (const Ray& ray : bad) rays.insert(rays.end(), {ray, Ray{o, 0, d, 9}});
  for (const bool coherent : {false, true}) {
    const auto hits = layers_of(intersector, rays, 3, coherent);
    std::vector<Hit> opaque(rays.size());
    std::vector<uint8_t> occluded(rays.size(), 7);
    std::vector<float> t_far(rays.size());
    intersector.nearest_opaque(rays, {.coherent = coherent}, opaque.data());
    intersector.occluded(rays, coherent, occluded.data());
    intersector.raw_intersect(LayerSet::all_translucent, rays, coherent, t_far.data());
    for (size_t i = 0; i < rays.size(); ++i) {
      const bool good = i % 2 == 1;
      EXPECT_EQ(hits[i].size(), good ? 1u : 0u) << i / 2;
      EXPECT_EQ(opaque[i].instance, good ? 1u : no_instance) << i / 2;
      EXPECT_EQ(occluded[i], good ? 1 : 0) << i / 2;
      if (good) {
        EXPECT_FLOAT_EQ(t_far[i], 5.0f);
      }
    }
  }
}

TEST_P(EveryInstructionSet, TakesDirectionsOfAnyLength) {
  const SceneBuilder scene = two_squares();
  Intersector intersector(GetParam());
  intersector.set_scene(scene.snapshot);
  std::vector<Ray> rays;
  for (const float length : {1e-30f, 1e-6f, 1e-3f, 1.0f, 1e3f, 1e6f, 1e30f})
    rays.push_back({{0.1f, 0.3f, 5.0f}, 0, {0, 0, -length}, infinity});
  const auto hits = layers_of(intersector, rays, 2);
  std::vector<uint8_t> occluded(rays.size());
  intersector.occluded(rays, false, occluded.data());
  for (size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(hits[i].size(), 1u) << i;
    EXPECT_FLOAT_EQ(static_cast<float>(hits[i][0].distance), 5.0f / -rays[i].direction.z);
    EXPECT_EQ(occluded[i], 1) << i;
  }
}

TEST_P(EveryInstructionSet, FindsTheSame) {
  std::mt19937 random(7);
  SceneBuilder scene = soup_scene(random, 8, 40, true);
  scene.add_material(false);
  for (size_t i = 5; i < 8; ++i) scene.snapshot->instances[i].material = 1;
  scene.snapshot->materials[0].cull_back = true;
  const std::vector<Ray> rays = random_rays(random, 4000);
  Intersector best(""), pinned(GetParam());
  EXPECT_EQ(pinned.isa(), GetParam());
  best.set_scene(scene.snapshot);
  pinned.set_scene(scene.snapshot);
  std::vector<Hit> opaque_a(rays.size()), opaque_b(rays.size());
  best.nearest_opaque(rays, {}, opaque_a.data());
  pinned.nearest_opaque(rays, {.coherent = true}, opaque_b.data());
  for (const uint32_t layers : {1u, 4u, 16u}) {
    const auto a = layers_of(best, rays, layers), b = layers_of(pinned, rays, layers, true);
    size_t different = 0, ambiguous = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      bool same = a[i].size() == b[i].size() && same_bits(opaque_a[i], opaque_b[i]);
      for (size_t k = 0; same && k < a[i].size(); ++k) same = same_bits(a[i][k], b[i][k]);
      if (same) continue;
      // Rays within rounding of an edge may differ.
      const bool edge = brute_force(*scene.snapshot, rays[i], true).ambiguous ||
                        brute_force(*scene.snapshot, rays[i], false).ambiguous;
      (edge ? ambiguous : different) += 1;
    }
    EXPECT_EQ(different, 0u);
    EXPECT_LT(ambiguous, rays.size() / 100);
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, EveryInstructionSet, testing::ValuesIn(instruction_sets()), [](const auto& test) {
  std::string name = test.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(InstructionSet, UnknownNamesAreRefusedWithTheAcceptedOnes) {
  for (const char* name : {"avx3", "AVX2", "avx2,threads=1", " "}) {
    try {
      Intersector intersector(name);
      ADD_FAILURE() << name;
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.status, SIDERAY_INVALID_ARGUMENT);
      for (const char* accepted : {"sse2", "sse4.2", "avx2", "avx512", name})
        EXPECT_THAT(failure.what(), testing::HasSubstr(accepted));
    }
  }
}

TEST(InstructionSet, IsReported) {
  const Intersector best("");
  EXPECT_THAT(best.isa(), testing::AnyOf("avx512", "avx2", "avx", "sse4.2", "sse2"));
  EXPECT_EQ(best.packet_width(), best.isa() == "avx512" ? 16u : best.isa().starts_with("avx") ? 8u : 4u);
  EXPECT_THAT(best.version(), testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
}

TEST(Batches, HowRaysAreSplitDoesNotMatter) {
  std::mt19937 random(8);
  const SceneBuilder scene = soup_scene(random, 8, 40, true);
  const std::vector<Ray> rays = random_rays(random, 1000);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  for (const uint32_t layers : {1u, 3u}) {
    const auto whole = layers_of(intersector, rays, layers, true);
    for (const size_t size : {1u, 5u, 16u, 33u})
      for (size_t first = 0; first < rays.size(); first += size) {
        const auto begin = rays.begin() + static_cast<std::ptrdiff_t>(first);
        const std::vector<Ray> part(begin, begin + static_cast<std::ptrdiff_t>(std::min(size, rays.size() - first)));
        const auto found = layers_of(intersector, part, layers, size != 5);
        for (size_t i = 0; i < part.size(); ++i) {
          ASSERT_EQ(found[i].size(), whole[first + i].size());
          for (size_t k = 0; k < found[i].size(); ++k) ASSERT_TRUE(same_bits(found[i][k], whole[first + i][k]));
        }
      }
  }
}

void expect_nothing(const Intersector& intersector) {
  const std::vector<Ray> rays(20, Ray{{0.1f, 0.3f, 5.0f}, 0, {0, 0, -1}, infinity});
  std::vector<Hit> opaque(rays.size());
  std::vector<uint8_t> occluded(rays.size(), 7);
  intersector.nearest_opaque(rays, {.coherent = true}, opaque.data());
  intersector.occluded(rays, true, occluded.data());
  for (const std::vector<Hit>& hits : layers_of(intersector, rays, 4)) EXPECT_TRUE(hits.empty());
  for (const Hit& hit : opaque) EXPECT_EQ(hit.instance, no_instance);
  EXPECT_THAT(occluded, testing::Each(0));
  EXPECT_FALSE(intersector.has_translucent(LayerSet::all_translucent));
}

TEST(OddScenes, EmptyOnesHaveNothing) {
  Intersector intersector("");
  expect_nothing(intersector);
  intersector.set_scene(std::make_shared<model::Snapshot>());
  expect_nothing(intersector);
  SceneBuilder scene;
  scene.add_material(true);
  scene.add_instance(scene.add_mesh({}), 0);
  intersector.set_scene(scene.snapshot);
  expect_nothing(intersector);
}

TEST(OddScenes, TrianglesWithoutAreaAndFlatInstancesAreNotMet) {
  SceneBuilder scene = two_squares();
  const glm::vec3 p(0.1f, 0.3f, 1.0f), q(0.1f, 0.3f, 2.0f);
  scene.add_instance(scene.add_mesh({p, p, p, p, q, p, p, q, glm::mix(p, q, 0.5f)}), 0);
  const uint32_t pane = scene.add_mesh(square(1.0f, 3.0f));
  scene.add_instance(pane, 0, glm::mat4x3(0.0f));
  glm::mat4x3 tiny = SceneBuilder::identity * 1e-30f;
  scene.add_instance(pane, 0, tiny);
  glm::mat4x3 broken = SceneBuilder::identity;
  broken[2].z = not_a_number;
  scene.add_instance(pane, 0, broken);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  const std::vector<Ray> rays(5, Ray{{0.1f, 0.3f, 5.0f}, 0, {0, 0, -1}, infinity});
  for (const std::vector<Hit>& hits : layers_of(intersector, rays, 4)) {
    ASSERT_EQ(hits.size(), 1u);
    EXPECT_EQ(hits[0].instance, 0u);
  }
}

TEST(OddScenes, FarOriginsAndTinyObjectsStayInEmbreesRange) {
  // Debian's Embree aborts on a ray out of its range, in any object's space: this test passes by ending.
  for (const float scale : {1e-12f, 1e-6f, 1e6f, 1e12f}) {
    SceneBuilder scene;
    scene.add_material(true);
    glm::mat4x3 m = SceneBuilder::identity * scale;
    scene.add_instance(scene.add_mesh(square(1.0f / scale, 0.0f)), 0, m);
    Intersector intersector("");
    intersector.set_scene(scene.snapshot);
    std::vector<Ray> rays;
    for (const float distance : {1e-6f, 1.0f, 1e6f, 1e12f, 1e17f, 3e18f, 1e30f, 3e38f})
      rays.push_back({{0.1f, 0.3f, distance}, 0, {0, 0, -1}, infinity});
    const auto hits = layers_of(intersector, rays, 1);
    ASSERT_EQ(hits[1].size(), 1u) << scale;
    EXPECT_NEAR(hits[1][0].distance, 1.0, 1e-6);
  }
}

TEST(SetScene, ReplacesTheSceneAndKeepsWhatIsShared) {
  SceneBuilder scene = two_squares();
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  const std::vector<Ray> rays{{{0.1f, 0.3f, 5.0f}, 0, {0, 0, -1}, infinity}};
  ASSERT_EQ(layers_of(intersector, rays, 4)[0][0].distance, 5.0);
  for (const float z : {1.0f, 2.5f, -0.5f}) {
    auto moved = std::make_shared<model::Snapshot>(*scene.snapshot);
    moved->instances[0].local_from_object[3].z = z;
    intersector.set_scene(moved);
    ASSERT_EQ(layers_of(intersector, rays, 4)[0][0].distance, static_cast<double>(5.0f - z));
  }
  // The snapshot is the intersector's own from here on.
  std::weak_ptr<model::Snapshot> gone = scene.snapshot;
  scene.snapshot.reset();
  EXPECT_TRUE(gone.expired());
  EXPECT_EQ(layers_of(intersector, rays, 4)[0].size(), 1u);
}

}  // namespace
}  // namespace sideray::rt::test
