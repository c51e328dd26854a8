// Makes random edits of a scene and of a simple model of its content, for tests of edits.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <glm/glm.hpp>
#include <iterator>
#include <map>
#include <random>
#include <vector>

#include "model/failure.h"
#include "model/material.h"
#include "model/scene.h"

namespace sideray::model::test {

class RandomEdits {
 public:
  explicit RandomEdits(uint32_t seed) : random_(seed) {}

  // One edit of a kind chosen at random; some are refused.
  void step() {
    switch (random(14)) {
      case 0: return add_mesh();
      case 1: return replace_mesh();
      case 2: return remove_mesh();
      case 3: return add_texture();
      case 4: return replace_texture();
      case 5: return remove_texture();
      case 6: return add_material();
      case 7: return replace_material();
      case 8: return remove_material();
      case 9: return replace_instance();
      case 10: return remove_instances();
      case 11: return renumber_instances();
      default: return add_instances();
    }
  }

  // Adds what the scene should hold to an empty one, by ascending names.
  void build(Scene& fresh) const {
    std::map<uint32_t, uint32_t> mesh_of, texture_of, material_of;
    for (const auto& [name, positions] : meshes_) mesh_of[name] = fresh.add_mesh(desc_of(positions), nullptr);
    for (const auto& [name, texels] : textures_)
      texture_of[name] = fresh.add_texture(2, 2, SIDERAY_RGBA8, texels.data());
    for (const auto& [name, material] : materials_) {
      sideray_material_desc desc = material;
      uint32_t& texture = desc.base_color_texture.texture;
      if (texture != 0) texture = texture_of.at(texture);
      material_of[name] = fresh.add_material(desc);
    }
    for (const auto& [name, instance] : instances_) {
      sideray_instance_desc desc = instance;
      desc.mesh = mesh_of.at(desc.mesh);
      desc.material = material_of.at(desc.material);
      fresh.add_instances(&desc, 1);
    }
  }

  Scene& scene() { return scene_; }
  const std::map<uint32_t, sideray_instance_desc>& instances() const { return instances_; }
  const std::map<uint32_t, sideray_material_desc>& materials() const { return materials_; }
  size_t things() const { return meshes_.size() + textures_.size() + materials_.size() + instances_.size(); }
  size_t refused() const { return refused_; }

 private:
  using Positions = std::vector<glm::vec3>;
  using Texels = std::array<uint8_t, 16>;

  uint32_t random(uint32_t below) { return static_cast<uint32_t>(random_() % below); }
  float unit() { return static_cast<float>(random_() % 1024) / 1024.0f; }

  template <typename T>
  uint32_t any_of(const std::map<uint32_t, T>& things) {
    return std::next(things.begin(), random(static_cast<uint32_t>(things.size())))->first;
  }

  template <typename T>
  static uint32_t lowest_free(const std::map<uint32_t, T>& things) {
    uint32_t name = 1;
    while (things.contains(name)) ++name;
    return name;
  }

  static sideray_mesh_desc desc_of(const Positions& positions) {
    sideray_mesh_desc desc{};
    desc.size = sizeof(desc);
    desc.vertex_count = static_cast<uint32_t>(positions.size());
    desc.positions = {&positions[0].x, 0};
    return desc;
  }

  Positions random_positions() {
    Positions positions(3 * (1 + random(4)));
    for (glm::vec3& p : positions) p = glm::vec3(unit(), unit(), unit()) * 2.0f - 1.0f;
    return positions;
  }

  Texels random_texels() {
    Texels texels;
    for (uint8_t& t : texels) t = static_cast<uint8_t>(random(256));
    return texels;
  }

  sideray_material_desc random_material() {
    sideray_material_desc desc = default_material();
    for (float& c : desc.base_color) c = 0.25f + 0.5f * unit();
    desc.alpha_mode = static_cast<sideray_alpha_mode>(random(3));
    desc.double_sided = 1;
    if (!textures_.empty() && random(2) == 0) desc.base_color_texture.texture = any_of(textures_);
    return desc;
  }

  sideray_instance_desc random_instance() {
    sideray_instance_desc desc{};
    desc.mesh = any_of(meshes_);
    desc.material = any_of(materials_);
    for (int i = 0; i < 3; ++i) desc.world_from_object[4 * i] = 0.5 + double{unit()};
    for (int i = 9; i < 12; ++i) desc.world_from_object[i] = 4.0 * double{unit()} - 2.0;
    desc.surface_id = next_id_++;
    desc.visibility = SIDERAY_VISIBLE_ALL;
    desc.user = random_();
    return desc;
  }

  void add_mesh() {
    Positions positions = random_positions();
    const uint32_t name = scene_.add_mesh(desc_of(positions), nullptr);
    ASSERT_EQ(name, lowest_free(meshes_));
    meshes_[name] = std::move(positions);
  }
  void replace_mesh() {
    if (meshes_.empty()) return;
    const uint32_t name = any_of(meshes_);
    // As many vertices as before, half of the time: what is traced may then be refitted.
    Positions positions = random_positions();
    if (random(2) == 0)
      for (positions = meshes_[name]; glm::vec3& p : positions) p += 0.125f * unit();
    scene_.replace_mesh(name, desc_of(positions), nullptr);
    meshes_[name] = std::move(positions);
  }
  void remove_mesh() {
    if (meshes_.empty()) return;
    const uint32_t name = any_of(meshes_);
    const bool used = uses(instances_, [&](const sideray_instance_desc& d) { return d.mesh == name; });
    if (removed(used, [&] { scene_.remove_mesh(name); })) meshes_.erase(name);
  }

  void add_texture() {
    const Texels texels = random_texels();
    const uint32_t name = scene_.add_texture(2, 2, SIDERAY_RGBA8, texels.data());
    ASSERT_EQ(name, lowest_free(textures_));
    textures_[name] = texels;
  }
  void replace_texture() {
    if (textures_.empty()) return;
    const uint32_t name = any_of(textures_);
    textures_[name] = random_texels();
    scene_.replace_texture(name, 2, 2, SIDERAY_RGBA8, textures_[name].data());
  }
  void remove_texture() {
    if (textures_.empty()) return;
    const uint32_t name = any_of(textures_);
    const bool used =
        uses(materials_, [&](const sideray_material_desc& d) { return d.base_color_texture.texture == name; });
    if (removed(used, [&] { scene_.remove_texture(name); })) textures_.erase(name);
  }

  void add_material() {
    const sideray_material_desc desc = random_material();
    const uint32_t name = scene_.add_material(desc);
    ASSERT_EQ(name, lowest_free(materials_));
    materials_[name] = desc;
  }
  void replace_material() {
    if (materials_.empty()) return;
    const uint32_t name = any_of(materials_);
    const sideray_material_desc desc = random_material();
    scene_.replace_material(name, desc);
    materials_[name] = desc;
  }
  void remove_material() {
    if (materials_.empty()) return;
    const uint32_t name = any_of(materials_);
    const bool used = uses(instances_, [&](const sideray_instance_desc& d) { return d.material == name; });
    if (removed(used, [&] { scene_.remove_material(name); })) materials_.erase(name);
  }

  void add_instances() {
    if (meshes_.empty() || materials_.empty()) return;
    std::vector<sideray_instance_desc> descs(1 + random(3));
    for (sideray_instance_desc& d : descs) d = random_instance();
    std::vector<uint32_t> names(descs.size());
    scene_.add_instances(descs.data(), descs.size(), names.data());
    for (size_t i = 0; i < descs.size(); ++i) {
      ASSERT_EQ(names[i], lowest_free(instances_));
      instances_[names[i]] = descs[i];
    }
  }
  void replace_instance() {
    if (instances_.empty()) return;
    const uint32_t name = any_of(instances_);
    instances_[name] = random_instance();
    scene_.replace_instances(&name, &instances_[name], 1);
  }
  void remove_instances() {
    if (instances_.empty()) return;
    std::vector<uint32_t> names;
    for (const auto& [name, desc] : instances_)
      if (names.size() < 4 && random(4) == 0) names.push_back(name);
    scene_.remove_instances(names.data(), names.size());
    for (const uint32_t name : names) instances_.erase(name);
  }
  void renumber_instances() {
    if (instances_.size() < 2) return;
    const uint32_t names[] = {instances_.begin()->first, instances_.rbegin()->first};
    const uint32_t ids[] = {instances_[names[1]].surface_id, instances_[names[0]].surface_id};
    scene_.renumber_instances(names, 2, ids);
    for (int i = 0; i < 2; ++i) instances_[names[i]].surface_id = ids[i];
  }

  template <typename T, typename Uses>
  static bool uses(const std::map<uint32_t, T>& things, const Uses& does) {
    for (const auto& [name, thing] : things)
      if (does(thing)) return true;
    return false;
  }
  // Removes something; only the removal of something in use may be refused.
  template <typename Remove>
  bool removed(bool used, const Remove& remove) {
    try {
      remove();
    } catch (const Failure& failure) {
      EXPECT_TRUE(used) << failure.what();
      ++refused_;
      return false;
    }
    EXPECT_FALSE(used);
    return true;
  }

  std::mt19937 random_;
  Scene scene_;
  std::map<uint32_t, Positions> meshes_;
  std::map<uint32_t, Texels> textures_;
  std::map<uint32_t, sideray_material_desc> materials_;
  std::map<uint32_t, sideray_instance_desc> instances_;
  uint32_t next_id_ = 1;
  size_t refused_ = 0;
};

}  // namespace sideray::model::test
