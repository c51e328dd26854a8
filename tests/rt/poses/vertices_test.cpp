// Tests meshes that get other vertices: rays hit them like new meshes, and their trees are reused.
#include <gtest/gtest.h>

#include "rt/base/executor.h"
#include "rt/embree/embree_scene.h"
#include "rt/embree/intersector_fixture.h"

namespace sideray::rt::test {
namespace {

constexpr uint32_t moving = 0, still = 1;

SceneBuilder two_meshes(bool translucent) {
  std::mt19937 random(23);
  SceneBuilder scene;
  scene.add_material(translucent);
  for (const uint32_t triangles : {2000u, 500u})
    scene.add_instance(scene.add_mesh(triangle_soup(random, triangles, 0.05f, 1.0f)), 0,
                       random_transform(random, 1.0f, 1.0f, triangles == 500));
  scene.add_instance(moving, 0, random_transform(random, 0.6f, 2.0f, true));
  return scene;
}

// The first mesh with its triangles swinging, `far` from each other where asked.
std::shared_ptr<const model::Snapshot> at(const SceneBuilder& scene, double time, bool far = false) {
  auto result = std::make_shared<model::Snapshot>(*scene.snapshot);
  auto mesh = std::make_shared<model::Mesh>(*scene.snapshot->meshes[moving]);
  mesh->bounds = {};
  for (size_t i = 0; i < mesh->positions.size(); ++i) {
    const double phase = far ? 7.0 * static_cast<double>(i / 3) : 3.0 * static_cast<double>(mesh->positions[i].y);
    mesh->positions[i].x += static_cast<float>((far ? 1.0 : 0.1) * std::sin(time + phase));
    mesh->bounds.add(mesh->positions[i]);
  }
  result->meshes[moving] = std::move(mesh);
  return result;
}

void expect_as_built_anew(const Intersector& kept, const std::shared_ptr<const model::Snapshot>& snapshot,
                          const std::vector<Ray>& rays) {
  Intersector fresh("");
  fresh.set_scene(snapshot);
  std::vector<Hit> a(rays.size()), b(rays.size());
  kept.nearest_opaque(rays, {.set = OpaqueSet::all}, a.data());
  fresh.nearest_opaque(rays, {.set = OpaqueSet::all}, b.data());
  const auto layers_a = layers_of(kept, rays, 4, false, LayerSet::all_translucent);
  const auto layers_b = layers_of(fresh, rays, 4, false, LayerSet::all_translucent);
  size_t met = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(a[i].instance == b[i].instance && (a[i].instance == no_instance || same_bits(a[i], b[i]))) << i;
    ASSERT_EQ(layers_a[i].size(), layers_b[i].size());
    for (size_t k = 0; k < layers_a[i].size(); ++k) ASSERT_TRUE(same_bits(layers_a[i][k], layers_b[i][k]));
    met += a[i].instance != no_instance || !layers_a[i].empty();
  }
  EXPECT_GT(met, rays.size() / 20);
}

TEST(Vertices, RaysMeetThemAsIfTheMeshWereNew) {
  std::mt19937 random(17);
  const std::vector<Ray> rays = random_rays(random, 3000);
  Executor executor(2);
  for (const bool translucent : {false, true}) {
    const SceneBuilder scene = two_meshes(translucent);
    Intersector kept("");
    kept.set_scene(scene.snapshot, {.executor = &executor});
    for (int frame = 0; frame < 6; ++frame) {
      const auto snapshot = at(scene, 0.4 * frame, frame >= 4);
      kept.set_scene(snapshot, {.executor = &executor});
      expect_as_built_anew(kept, snapshot, rays);
    }
    kept.set_scene(scene.snapshot);
    expect_as_built_anew(kept, scene.snapshot, rays);
  }
}

TEST(Vertices, ATreeIsMadeForMovingOnceAndThenKept) {
  const SceneBuilder scene = two_meshes(false);
  const DeviceHandle device = open_device("");
  const auto scenes_of = [&](const std::shared_ptr<const model::Snapshot>& snapshot, const MeshScenes& before) {
    return build_meshes(device.get(), *snapshot, {}, before);
  };
  const auto tree = [](const MeshScenes& scenes, const model::Snapshot& snapshot, uint32_t mesh) {
    return scenes.at(snapshot.meshes[mesh].get());
  };
  const MeshScenes first = scenes_of(scene.snapshot, {});
  const auto one = at(scene, 0.0), two = at(scene, 0.5);
  const MeshScenes second = scenes_of(one, first), third = scenes_of(two, second);
  EXPECT_NE(tree(second, *one, moving), tree(first, *scene.snapshot, moving));
  EXPECT_EQ(tree(third, *two, moving), tree(second, *one, moving));
  EXPECT_EQ(tree(third, *two, moving)->version, 1u);
  EXPECT_EQ(tree(third, *two, moving)->mesh, two->meshes[moving]);
  EXPECT_EQ(tree(third, *two, still), tree(first, *scene.snapshot, still));
  // Other triangles at the same place are another mesh.
  auto other = std::make_shared<model::Snapshot>(*two);
  auto mesh = std::make_shared<model::Mesh>(*two->meshes[moving]);
  mesh->triangles.pop_back();
  other->meshes[moving] = std::move(mesh);
  EXPECT_NE(tree(scenes_of(other, third), *other, moving), tree(third, *two, moving));
}

}  // namespace
}  // namespace sideray::rt::test
