// Tests that rays hit the triangles of sr_wind for moving plants, however their trees were updated.
#include "rt/poses/foliage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "model/wind.h"
#include "rt/base/executor.h"
#include "rt/embree/intersector_fixture.h"
#include "rt/poses/pose_quality.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt::test {
namespace {

sideray_wind_desc breeze() {
  return {.size = sizeof(sideray_wind_desc),
          .direction = {0.6f, 0.0f, 0.8f},
          .amplitude = 0.3f,
          .frequency = 0.4f,
          .height = 1.5f,
          .branch_amplitude = 0.1f,
          .branch_frequency = 0.9f,
          .leaf_amplitude = 0.03f,
          .leaf_frequency = 3.0f,
          .wavelength = 0.7f};
}

// Instances of two plants in a row, each at a phase of its own; the last one stands still.
struct Plants {
  SceneBuilder scene;
  static constexpr uint32_t count = 12;

  explicit Plants(bool translucent = false) {
    std::mt19937 random(5);
    scene.add_material(translucent);
    scene.snapshot->winds.push_back({breeze()});
    const uint32_t meshes[] = {scene.add_mesh(triangle_soup(random, 2000, 0.03f, 1.0f)),
                               scene.add_mesh(triangle_soup(random, 1500, 0.04f, 1.0f))};
    for (uint32_t i = 0; i < count; ++i) {
      model::Instance& instance =
          scene.add_instance(meshes[i % 2], 0, random_transform(random, 0.5f, 3.0f, i % 3 == 0));
      instance.wind = i + 1 < count ? 1 : 0;
      instance.wind_phase = std::uniform_real_distribution<float>(0.0f, 1.0f)(random);
      model::Bounds bounds;
      bounds.add(instance.local_from_object[3] - glm::vec3(1.0f));
      bounds.add(instance.local_from_object[3] + glm::vec3(1.0f));
      instance.bounds = bounds;
    }
  }
  std::shared_ptr<const model::Snapshot> at(double time) const {
    auto result = std::make_shared<model::Snapshot>(*scene.snapshot);
    result->time_s = time;
    return result;
  }
};

glm::vec3 blown(const model::Snapshot& snapshot, glm::vec3 p, float phase) {
  const sideray_wind_desc& d = snapshot.winds[0].desc;
  const glm::vec3 cycles = model::wind_phase(snapshot.winds[0], snapshot.time_s, phase);
  const glm::vec3 direction(d.direction[0], d.direction[1], d.direction[2]);
  return p + shading::sr_wind({direction, d.amplitude, d.height, d.branch_amplitude, d.leaf_amplitude, d.wavelength},
                              {cycles.x, cycles.y, cycles.z}, p);
}

// The snapshot with meshes of its own for every instance, put together here.
std::shared_ptr<const model::Snapshot> posed_by_hand(const model::Snapshot& snapshot,
                                                     const std::vector<float>& phases) {
  auto result = std::make_shared<model::Snapshot>(snapshot);
  for (size_t i = 0; i < snapshot.instances.size(); ++i) {
    if (snapshot.instances[i].wind == 0) continue;
    auto mesh = std::make_shared<model::Mesh>(*snapshot.meshes[snapshot.instances[i].mesh]);
    mesh->bounds = {};
    for (glm::vec3& p : mesh->positions) mesh->bounds.add(p = blown(snapshot, p, phases[i]));
    result->instances[i].mesh = static_cast<uint32_t>(result->meshes.size());
    result->meshes.push_back(std::move(mesh));
  }
  return result;
}

std::vector<float> own_phases(const model::Snapshot& snapshot) {
  std::vector<float> phases;
  for (const model::Instance& i : snapshot.instances) phases.push_back(i.wind_phase);
  return phases;
}

void take(Intersector& intersector, Foliage& foliage, const std::shared_ptr<const model::Snapshot>& snapshot,
          const FoliageOptions& options, Executor& executor) {
  const auto posed = foliage.pose(snapshot, options, executor);
  intersector.set_scene(posed, {.posed = foliage.posed(), .executor = &executor});
}

std::vector<Hit> nearest(const Intersector& intersector, const std::vector<Ray>& rays) {
  std::vector<Hit> hits(rays.size());
  intersector.nearest_opaque(rays, {.set = OpaqueSet::all}, hits.data());
  return hits;
}

void expect_same(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  ASSERT_EQ(a.size(), b.size());
  size_t met = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_TRUE(a[i].instance == b[i].instance && (a[i].instance == no_instance || same_bits(a[i], b[i]))) << i;
    met += a[i].instance != no_instance;
  }
  EXPECT_GT(met, a.size() / 20);
}

std::vector<Ray> some_rays() {
  std::mt19937 random(17);
  return random_rays(random, 4000);
}

constexpr FoliageOptions all_poses{.poses = SIDERAY_POSES_ALL};

TEST(Foliage, RaysMeetTheTrianglesWhereTheWindPutsThem) {
  const Plants plants;
  Executor executor(2);
  Foliage foliage;
  Intersector posed(""), by_hand("");
  const std::vector<Ray> rays = some_rays();
  size_t clear = 0;
  for (const double time : {0.0, 0.31, 0.37, 5.0}) {
    const auto snapshot = plants.at(time);
    take(posed, foliage, snapshot, all_poses, executor);
    const auto expected = posed_by_hand(*snapshot, own_phases(*snapshot));
    by_hand.set_scene(expected);
    const std::vector<Hit> hits = nearest(posed, rays);
    expect_same(hits, nearest(by_hand, rays));
    for (size_t i = 0; i < 60; ++i) {
      const BruteResult brute = brute_force(*expected, rays[i], false);
      if (brute.ambiguous) continue;
      ++clear;
      ASSERT_EQ(hits[i].instance != no_instance, !brute.hits.empty());
      if (brute.hits.empty()) continue;
      EXPECT_EQ(hits[i].instance, brute.hits[0].instance);
      EXPECT_EQ(hits[i].primitive, brute.hits[0].primitive);
    }
  }
  EXPECT_GT(clear, 50u);
}

TEST(Foliage, NothingIsPosedAtRestOrWithoutWind) {
  const Plants plants;
  Executor executor(1);
  Foliage foliage;
  const auto snapshot = plants.at(1.0);
  EXPECT_EQ(foliage.pose(snapshot, {}, executor), snapshot);
  EXPECT_TRUE(foliage.posed().empty());
  auto calm = std::make_shared<model::Snapshot>(*snapshot);
  for (model::Instance& i : calm->instances) i.wind = 0;
  EXPECT_EQ(foliage.pose(calm, all_poses, executor), calm);
}

TEST(Foliage, ARefitTreeAnswersAsOneBuiltAnew) {
  const Plants plants;
  Executor executor(2);
  Foliage kept;
  Intersector refit("");
  const std::vector<Ray> rays = some_rays();
  size_t refits = 0, rebuilds = 0;
  for (int frame = 0; frame < 8; ++frame) {
    auto snapshot = std::make_shared<model::Snapshot>(*plants.at(0.05 * frame));
    // A gale at last: nothing that was grouped stays together.
    if (frame >= 6) snapshot->winds[0].desc.leaf_amplitude = 2.0f, snapshot->winds[0].desc.wavelength = 0.05f;
    take(refit, kept, snapshot, all_poses, executor);
    const Foliage::Counts counts = kept.counts();
    EXPECT_EQ(counts.poses, Plants::count - 1);
    EXPECT_EQ(counts.refits + counts.rebuilds, counts.poses);
    if (frame > 0) refits += counts.refits, rebuilds += counts.rebuilds;
    Foliage fresh;
    Intersector rebuilt("");
    take(rebuilt, fresh, snapshot, all_poses, executor);
    expect_same(nearest(refit, rays), nearest(rebuilt, rays));
  }
  EXPECT_GT(refits, 0u);
  EXPECT_GT(rebuilds, 0u);
}

TEST(Foliage, ForcedRefitAndForcedRebuildAgree) {
  const Plants plants;
  Executor executor(1);
  Foliage foliage;
  const auto before = foliage.pose(plants.at(0.0), all_poses, executor);
  std::vector<PosedMesh> first(foliage.posed().begin(), foliage.posed().end());
  Intersector refit(""), rebuilt("");
  refit.set_scene(before, {.posed = first});
  rebuilt.set_scene(before, {.posed = first});
  const auto after = foliage.pose(plants.at(0.7), all_poses, executor);
  std::vector<PosedMesh> second(foliage.posed().begin(), foliage.posed().end());
  for (PosedMesh& p : second) p.change = PoseChange::refit;
  refit.set_scene(after, {.posed = second});
  for (PosedMesh& p : second) p.change = PoseChange::rebuild;
  rebuilt.set_scene(after, {.posed = second});
  const std::vector<Ray> rays = some_rays();
  expect_same(nearest(refit, rays), nearest(rebuilt, rays));
}

TEST(Foliage, LayersOfPosedInstancesKeepTheirOrder) {
  const Plants plants(true);
  Executor executor(2);
  Foliage foliage;
  Intersector posed(""), by_hand("");
  const std::vector<Ray> rays = some_rays();
  for (const double time : {0.0, 0.4}) {
    const auto snapshot = plants.at(time);
    take(posed, foliage, snapshot, all_poses, executor);
    by_hand.set_scene(posed_by_hand(*snapshot, own_phases(*snapshot)));
    const auto a = layers_of(posed, rays, 4, false, LayerSet::all_translucent);
    const auto b = layers_of(by_hand, rays, 4, false, LayerSet::all_translucent);
    for (size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(a[i].size(), b[i].size());
      for (size_t k = 0; k < a[i].size(); ++k) ASSERT_TRUE(same_bits(a[i][k], b[i][k]));
    }
  }
}

TEST(Foliage, SharedPosesAreAtTheirShareOfTheCycle) {
  EXPECT_EQ(nearest_pose(0.0f, 4), 0u);
  EXPECT_EQ(nearest_pose(0.124f, 4), 0u);
  EXPECT_EQ(nearest_pose(0.126f, 4), 1u);
  EXPECT_EQ(nearest_pose(0.9f, 4), 0u);
  EXPECT_EQ(nearest_pose(1.0f, 4), 0u);
  EXPECT_EQ(nearest_pose(-0.25f, 4), 3u);
  EXPECT_EQ(nearest_pose(0.7f, 1), 0u);
  const Plants plants;
  Executor executor(2);
  const std::vector<Ray> rays = some_rays();
  for (const uint32_t shared_poses : {1u, 3u, 16u}) {
    Foliage foliage;
    Intersector shared(""), by_hand("");
    for (const double time : {0.2, 0.5}) {
      const auto snapshot = plants.at(time);
      std::vector<float> phases;
      std::set<std::pair<uint32_t, uint32_t>> kinds;
      for (const model::Instance& i : snapshot->instances) {
        const uint32_t pose = nearest_pose(i.wind_phase, shared_poses);
        phases.push_back(static_cast<float>(pose) / static_cast<float>(shared_poses));
        if (i.wind != 0) kinds.insert({i.mesh, pose});
      }
      const FoliageOptions options{.poses = shared_poses};
      take(shared, foliage, snapshot, options, executor);
      EXPECT_EQ(foliage.counts().poses, kinds.size());
      by_hand.set_scene(posed_by_hand(*snapshot, phases));
      expect_same(nearest(shared, rays), nearest(by_hand, rays));
    }
  }
}

TEST(Foliage, ASnapshotThatIsStillReadDoesNotMove) {
  const Plants plants;
  Executor executor(1);
  Foliage foliage;
  std::vector<std::shared_ptr<const model::Snapshot>> kept;
  std::vector<std::vector<glm::vec3>> positions;
  for (int frame = 0; frame < 4; ++frame) {
    kept.push_back(foliage.pose(plants.at(0.3 * frame), all_poses, executor));
    positions.push_back(kept.back()->meshes.back()->positions);
  }
  for (size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i]->meshes.back()->positions, positions[i]);
  EXPECT_NE(positions[0], positions[1]);
}

TEST(Foliage, AnyNumberOfThreadsPosesTheSameBits) {
  const Plants plants;
  Executor one(1), two(2);
  Foliage a, b;
  for (const double time : {0.0, 0.1, 2.0}) {
    const auto x = a.pose(plants.at(time), all_poses, one), y = b.pose(plants.at(time), all_poses, two);
    ASSERT_EQ(x->meshes.size(), y->meshes.size());
    for (size_t i = 0; i < x->meshes.size(); ++i) EXPECT_EQ(x->meshes[i]->positions, y->meshes[i]->positions);
    EXPECT_EQ(a.counts().rebuilds, b.counts().rebuilds);
  }
}

TEST(PoseQuality, GrowsWhereNeighboursPartAndNotWhereAllMoveAlike) {
  std::mt19937 random(3);
  model::Mesh mesh;
  mesh.positions = triangle_soup(random, 500, 0.05f, 1.0f);
  for (uint32_t i = 0; i < mesh.positions.size(); i += 3) mesh.triangles.emplace_back(i, i + 1, i + 2);
  for (const glm::vec3& p : mesh.positions) mesh.bounds.add(p);
  PoseQuality quality;
  EXPECT_EQ(quality.growth(mesh), INFINITY);
  quality.build(mesh);
  EXPECT_EQ(quality.growth(mesh), 1.0);
  model::Mesh moved = mesh;
  for (glm::vec3& p : moved.positions) p += glm::vec3(2.0f, 0.5f, -1.0f);
  EXPECT_NEAR(quality.growth(moved), 1.0, 1e-4);
  for (size_t i = 0; i < moved.positions.size(); ++i)
    if (i / 3 % 2 == 1) moved.positions[i] = -mesh.positions[i];
  EXPECT_GT(quality.growth(moved), PoseQuality::worst_growth);
}

}  // namespace
}  // namespace sideray::rt::test
