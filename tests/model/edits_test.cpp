// Tests that after any edits a commit equals that of a new scene with the same content.
#include <gmock/gmock.h>

#include <cstring>
#include <functional>
#include <string>

#include "model/random_edits.h"

namespace sideray::model {
namespace {

using test::RandomEdits;
using ::testing::HasSubstr;

void expect_same_content(const Snapshot& a, const Snapshot& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.bounds.minimum, b.bounds.minimum);
  EXPECT_EQ(a.bounds.maximum, b.bounds.maximum);
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i]->positions, b.meshes[i]->positions);
    EXPECT_EQ(a.meshes[i]->triangles, b.meshes[i]->triangles);
  }
  ASSERT_EQ(a.textures.size(), b.textures.size());
  for (size_t i = 0; i < a.textures.size(); ++i)
    EXPECT_EQ(a.textures[i]->levels[0].rgba, b.textures[i]->levels[0].rgba);
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (size_t i = 0; i < a.materials.size(); ++i) {
    EXPECT_EQ(std::memcmp(&a.materials[i].desc, &b.materials[i].desc, sizeof(sideray_material_desc)), 0);
    EXPECT_EQ(a.materials[i].translucent, b.materials[i].translucent);
    EXPECT_EQ(a.materials[i].discards, b.materials[i].discards);
  }
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (size_t i = 0; i < a.instances.size(); ++i) {
    const Instance &x = a.instances[i], &y = b.instances[i];
    EXPECT_EQ(x.mesh, y.mesh);
    EXPECT_EQ(x.material, y.material);
    EXPECT_EQ(x.local_from_object, y.local_from_object);
    EXPECT_EQ(x.surface_id, y.surface_id);
    EXPECT_EQ(x.user, y.user);
    EXPECT_EQ(x.bounds.minimum, y.bounds.minimum);
  }
}

TEST(Edits, CommitWhatASceneBuiltFromNothingCommits) {
  size_t refused = 0, removed_and_added = 0;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    RandomEdits edits(seed);
    for (int commit = 0; commit < 12; ++commit) {
      for (int i = 0; i < 25; ++i) edits.step();
      edits.scene().commit();
      const auto edited = edits.scene().snapshot();
      Scene fresh;
      edits.build(fresh);
      fresh.commit();
      expect_same_content(*edited, *fresh.snapshot());
      size_t i = 0;
      for (const auto& [name, desc] : edits.instances()) {
        EXPECT_EQ(edited->instance_names[i].name, name);
        EXPECT_EQ(find_name(edited->instance_names, edited->instances.size(), edited->instance_names[i]), i);
        removed_and_added += edited->instance_names[i++].reuse != 0;
      }
      i = 0;
      for (const auto& [name, desc] : edits.materials()) EXPECT_EQ(edited->material_names[i++].name, name);
      if (HasFatalFailure()) return;
    }
    refused += edits.refused();
  }
  EXPECT_GT(refused, 100u);
  EXPECT_GT(removed_and_added, 100u);
}

sideray_mesh_desc one_triangle() {
  static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  sideray_mesh_desc desc{};
  desc.size = sizeof(desc);
  desc.vertex_count = 3;
  desc.positions.data = positions;
  return desc;
}

sideray_instance_desc instance_of(uint32_t mesh, uint32_t material) {
  sideray_instance_desc desc{};
  desc.mesh = mesh;
  desc.material = material;
  for (const int i : {0, 4, 8}) desc.world_from_object[i] = 1.0;
  return desc;
}

std::string refusal(const std::function<void()>& edit) {
  try {
    edit();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_INVALID_ARGUMENT);
    return failure.what();
  }
  return "";
}

TEST(Edits, RefuseToRemoveWhatIsUsedAndNameTheUser) {
  Scene scene;
  const uint32_t mesh = scene.add_mesh(one_triangle(), nullptr);
  const uint8_t texels[4] = {255, 255, 255, 255};
  const uint32_t texture = scene.add_texture(1, 1, SIDERAY_RGBA8, texels);
  sideray_material_desc desc = default_material();
  desc.normal_texture.texture = texture;
  const uint32_t material = scene.add_material(desc);
  const sideray_instance_desc instance = instance_of(mesh, material);
  uint32_t names[2];
  for (uint32_t& name : names) scene.add_instances(&instance, 1, &name);
  scene.remove_instances(&names[0], 1);
  EXPECT_THAT(refusal([&] { scene.remove_mesh(mesh); }), HasSubstr("instance 2 uses it"));
  EXPECT_THAT(refusal([&] { scene.remove_material(material); }), HasSubstr("instance 2 uses it"));
  EXPECT_THAT(refusal([&] { scene.remove_texture(texture); }), HasSubstr("material 1 has it as normal_texture"));
  const uint32_t twice[] = {names[1], names[1]}, gone[] = {names[1], names[0]};
  EXPECT_THAT(refusal([&] { scene.remove_instances(twice, 2); }), HasSubstr("twice"));
  EXPECT_THAT(refusal([&] { scene.remove_instances(gone, 2); }), HasSubstr("instances[1]: there is no instance 1"));
  scene.commit();
  EXPECT_EQ(scene.snapshot()->instances.size(), 1u) << "refused edits change nothing";
  scene.remove_instances(&names[1], 1);
  scene.remove_material(material);
  scene.remove_texture(texture);
  scene.remove_mesh(mesh);
  EXPECT_THAT(refusal([&] { scene.add_instances(&instance, 1); }), HasSubstr("there is no mesh 1"));
  scene.commit();
  EXPECT_TRUE(scene.snapshot()->materials.empty());
}

TEST(Edits, GiveTheirMemoryBack) {
  Scene scene;
  const uint8_t texels[4] = {1, 2, 3, 4};
  size_t slots = 0;
  for (int i = 0; i < 10000; ++i) {
    const uint32_t mesh = scene.add_mesh(one_triangle(), nullptr);
    const uint32_t texture = scene.add_texture(1, 1, SIDERAY_RGBA8, texels);
    sideray_material_desc desc = default_material();
    desc.base_color_texture.texture = texture;
    const uint32_t material = scene.add_material(desc);
    const sideray_instance_desc instance = instance_of(mesh, material);
    uint32_t name = 0;
    scene.add_instances(&instance, 1, &name);
    if (i % 1000 == 0) scene.commit();
    scene.remove_instances(&name, 1);
    scene.remove_material(material);
    scene.remove_texture(texture);
    scene.remove_mesh(mesh);
    if (i == 0) slots = scene.slot_count();
  }
  EXPECT_EQ(scene.slot_count(), slots);
  EXPECT_EQ(slots, 4u);
}

TEST(Edits, WhatIsUnchangedIsTheSameMemoryInTheNextSnapshot) {
  RandomEdits edits(5);
  for (int i = 0; i < 300; ++i) edits.step();
  edits.scene().commit();
  const auto before = edits.scene().snapshot();
  const uint32_t name = edits.instances().begin()->first;
  edits.scene().remove_instances(&name, 1);
  edits.scene().commit();
  EXPECT_EQ(edits.scene().snapshot()->meshes, before->meshes);
  EXPECT_EQ(edits.scene().snapshot()->textures, before->textures);
}

TEST(Edits, AReplacedTextureDecidesAnewWhatIsDiscarded) {
  Scene scene;
  const uint8_t clear[4] = {255, 255, 255, 0}, solid[4] = {255, 255, 255, 255};
  const uint32_t texture = scene.add_texture(1, 1, SIDERAY_RGBA8, solid);
  sideray_material_desc desc = default_material();
  desc.alpha_mode = SIDERAY_BLEND;
  desc.base_color_texture.texture = texture;
  scene.add_material(desc);
  scene.commit();
  EXPECT_FALSE(scene.snapshot()->materials[0].discards);
  scene.replace_texture(texture, 1, 1, SIDERAY_RGBA8, clear);
  scene.commit();
  EXPECT_TRUE(scene.snapshot()->materials[0].discards);
}

}  // namespace
}  // namespace sideray::model
