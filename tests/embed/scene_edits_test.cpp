// Tests a host that rebuilds its scene every frame: a hundred thousand edits leak nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <memory>
#include <optional>

#include <sideray/scene_follower.hpp>

#include "embed/hosts/one_pane.h"

namespace sideray::tests {
namespace {

TEST(SceneEdits, AHundredThousandLeaveNothingBehind) {
  constexpr size_t surfaces = 250, frames = 100;
  Scene scene = pane_scene();
  constexpr float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 3, mesh.positions.data = corners;
  std::vector<sideray_instance_desc> descs(surfaces);
  for (size_t i = 0; i < surfaces; ++i) {
    descs[i].mesh = scene.add_mesh(mesh), descs[i].material = scene.add_material(sideray_material_defaults());
    for (const int k : {0, 4, 8}) descs[i].world_from_object[k] = 1.0;
    descs[i].surface_id = static_cast<uint32_t>(i) + 10, descs[i].visibility = SIDERAY_VISIBLE_ALL;
  }
  std::vector<sideray_instance> names = scene.add_instances(descs);
  sideray_instance largest_instance = 0;
  sideray_material largest_material = 0;
  size_t edits = 0;
  const auto start = std::chrono::steady_clock::now();
  for (size_t frame = 0; frame < frames; ++frame) {
    for (size_t i = 0; i < surfaces; ++i) {
      const sideray_material past = descs[i].material;
      descs[i].material = scene.add_material(sideray_material_defaults());
      largest_material = std::max(largest_material, descs[i].material);
      scene.replace_instances({&names[i], 1}, {&descs[i], 1});
      scene.remove_material(past);
      edits += 3;
    }
    scene.remove_instances(std::span(names).first(surfaces / 2));
    const std::vector<sideray_instance> again = scene.add_instances(std::span(descs).first(surfaces / 2));
    std::copy(again.begin(), again.end(), names.begin());
    largest_instance = std::max(largest_instance, *std::max_element(names.begin(), names.end()));
    edits += surfaces;
    scene.commit();
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  RecordProperty("edits_a_second", std::to_string(static_cast<double>(edits) / took.count()));
  std::printf("  %.0f edits a second, a commit every %zu\n", static_cast<double>(edits) / took.count(), edits / frames);
  EXPECT_EQ(edits, 100000u);
  // Handles are reused: they never exceed the number that existed at once. The pane has one of each.
  EXPECT_LE(largest_instance, surfaces + 1);
  EXPECT_LE(largest_material, surfaces + 2);
}

// A leaf of an engine's graph, identified by addresses.
struct Leaf {
  uint64_t shape = 1, pose = 0;
  double x = 0;
  float red = 1;
};

class Following : public testing::Test {
 protected:
  bool follow() {
    follower_.begin();
    for (const auto& leaf : graph) {
      const auto key = reinterpret_cast<uintptr_t>(leaf.get());
      sideray_instance_desc desc{};
      desc.mesh = follower_.mesh(key, leaf->shape, leaf->pose, [&] {
        ++meshes_read;
        positions_[2] = static_cast<float>(leaf->pose);
        sideray_mesh_desc mesh = sideray_mesh_defaults();
        mesh.vertex_count = leaf->shape == 1 ? 3 : 6, mesh.positions.data = positions_;
        return mesh;
      });
      desc.material = follower_.material(key, std::bit_cast<uint32_t>(leaf->red), [&] {
        ++materials_read;
        SceneFollower::Material m;
        m.desc.base_color[0] = leaf->red;
        return m;
      });
      for (const int k : {0, 4, 8}) desc.world_from_object[k] = 1.0;
      desc.world_from_object[9] = leaf->x;
      desc.surface_id = static_cast<uint32_t>(&leaf - graph.data()) + 1, desc.visibility = SIDERAY_VISIBLE_ALL;
      follower_.instance(key, desc);
    }
    return follower_.end();
  }
  // Returns whether a ray down at x hits anything.
  bool is_hit(double x) {
    if (!tracer_) tracer_.emplace(Tracer::create(scene_).value());
    const sideray_ray ray{{x + 0.2, 0.2, 5}, {0, 0, -1}, 0, 100};
    last_ = tracer_->trace(SIDERAY_RAYS_OPAQUE, {&ray, 1}).front();
    return last_.surface_id != 0;
  }

  std::vector<std::unique_ptr<Leaf>> graph;
  int meshes_read = 0, materials_read = 0;
  sideray_hit last_{};

 private:
  float positions_[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 0, 4, 0, 0, 3, 1, 0};
  Scene scene_ = Scene::create().value();
  SceneFollower follower_{scene_};
  std::optional<Tracer> tracer_;
};

TEST_F(Following, AddsMovesReplacesAndSweeps) {
  for (const double x : {0.0, 10.0}) graph.emplace_back(std::make_unique<Leaf>())->x = x;
  EXPECT_TRUE(follow());
  EXPECT_EQ(meshes_read, 2);
  EXPECT_TRUE(is_hit(0) && is_hit(10) && !is_hit(3));
  EXPECT_FALSE(follow()) << "nothing has changed: nothing is committed";
  EXPECT_EQ(meshes_read, 2);
  EXPECT_EQ(materials_read, 2);
  graph[0]->x = 20;
  EXPECT_TRUE(follow());
  EXPECT_EQ(meshes_read, 2) << "it was moved";
  EXPECT_TRUE(!is_hit(0) && is_hit(20));
  graph[0]->pose = 1;
  EXPECT_TRUE(follow());
  EXPECT_TRUE(is_hit(20));
  EXPECT_NEAR(last_.distance, 4.4, 1e-4) << "its corner was lifted";
  graph[0]->shape = 2, graph[0]->pose = 0;
  EXPECT_TRUE(follow());
  EXPECT_TRUE(is_hit(23)) << "it has a second triangle";
  graph[1]->red = 0.5f;
  EXPECT_TRUE(follow());
  EXPECT_EQ(materials_read, 3);
  graph.pop_back();
  EXPECT_TRUE(follow());
  EXPECT_TRUE(!is_hit(10) && is_hit(20));
  graph.clear();
  EXPECT_TRUE(follow());
  EXPECT_FALSE(is_hit(20));
  EXPECT_FALSE(follow());
}

}  // namespace
}  // namespace sideray::tests
