// The editable scene: checks what comes in, and commits it into an immutable snapshot. One thread at a time.
#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "model/mesh.h"
#include "model/snapshot.h"

namespace sideray::model {

// Throws Failure where a scene cannot have so many lights.
void check_light_count(size_t count);

// The functions mirror sideray_scene_*; each throws Failure and then has changed nothing. Indices are the API's (from
// 1).
class Scene {
 public:
  uint32_t add_mesh(const sideray_mesh_desc& desc, uint32_t* dropped);
  void set_vertices(uint32_t mesh, const sideray_mesh_desc& desc);
  uint32_t add_texture(uint32_t width, uint32_t height, sideray_texel_format format, const void* texels);
  uint32_t add_material(const sideray_material_desc& desc);
  // Writes the names to `instances`, where it is not null.
  void add_instances(const sideray_instance_desc* descs, size_t count, uint32_t* instances = nullptr);
  void move_instances(const uint32_t* instances, size_t count, const double* world_from_object);
  void set_visibility(uint32_t instance, uint32_t visibility);
  uint32_t add_particles(const sideray_particles_desc& desc);
  void set_sprites(uint32_t particles, const sideray_sprite* sprites, size_t count);
  uint32_t add_wind(const sideray_wind_desc& desc);
  void set_time(double time_s, double previous_time_s);
  void set_lights(const sideray_light* lights, size_t count);
  void set_environment(uint32_t width, uint32_t height, const float* rgb, float scale, float rotation_deg);
  void set_shader(const sideray_shader_desc* shader);  // null: the built-in model

  void commit();
  // The last committed snapshot; null before the first commit. May be called while another thread edits.
  std::shared_ptr<const Snapshot> snapshot() const;

 private:
  const std::shared_ptr<const Environment>& environment();
  bool is_solid(const std::shared_ptr<const Mesh>& mesh, const Material& material);

  std::vector<std::shared_ptr<const Mesh>> meshes_;
  std::vector<MeshForm> forms_;  // of each
  std::vector<std::shared_ptr<const Texture>> textures_;
  std::vector<Material> materials_;
  std::vector<sideray_instance_desc> instances_;
  struct Particles {
    sideray_particles_desc desc;
    std::vector<sideray_sprite> sprites;
  };
  std::vector<Particles> particles_;
  std::vector<Wind> winds_;
  double time_s_ = 0, previous_time_s_ = 0;
  std::vector<sideray_light> lights_;
  std::shared_ptr<const Environment> environment_;
  sideray_shader_desc shader_{};
  std::unordered_map<const Mesh*, bool> closed_;  // of the meshes that had to be looked at
  uint64_t revision_ = 0;
  mutable std::mutex snapshot_mutex_;
  std::shared_ptr<const Snapshot> snapshot_;
};

}  // namespace sideray::model
