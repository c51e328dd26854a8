// A host that rebuilds its list every frame: a hundred thousand edits leave nothing behind.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

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
  // Names are given out again: no more than were there at once. The pane has one of each.
  EXPECT_LE(largest_instance, surfaces + 1);
  EXPECT_LE(largest_material, surfaces + 2);
}

}  // namespace
}  // namespace sideray::tests
