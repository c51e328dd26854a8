// Holds the editable scene: checks input, and commits it into an immutable snapshot. One thread at a time may edit.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "model/mesh.h"
#include "model/placement.h"
#include "model/slots.h"
#include "model/snapshot.h"

namespace sideray::model {

// Throws Failure for more lights than a scene can have.
void check_light_count(size_t count);

// Its functions mirror sideray_scene_*; one that throws Failure has changed nothing. Names are the API's. An edit costs
// as much as its input; a commit costs as much as the scene has instances.
class Scene {
 public:
  uint32_t add_mesh(const sideray_mesh_desc& desc, uint32_t* dropped);
  void replace_mesh(uint32_t mesh, const sideray_mesh_desc& desc, uint32_t* dropped);
  void remove_mesh(uint32_t mesh);
  void set_vertices(uint32_t mesh, const sideray_mesh_desc& desc);

  uint32_t add_texture(uint32_t width, uint32_t height, sideray_texel_format format, const void* texels);
  void replace_texture(uint32_t texture, uint32_t width, uint32_t height, sideray_texel_format format,
                       const void* texels);
  void remove_texture(uint32_t texture);

  uint32_t add_material(const sideray_material_desc& desc);
  void replace_material(uint32_t material, const sideray_material_desc& desc);
  void remove_material(uint32_t material);

  // Writes the names to `instances`, if it is not null.
  void add_instances(const sideray_instance_desc* descs, size_t count, uint32_t* instances = nullptr);
  void replace_instances(const uint32_t* instances, const sideray_instance_desc* descs, size_t count);
  void remove_instances(const uint32_t* instances, size_t count);
  void move_instances(const uint32_t* instances, size_t count, const double* world_from_object);
  void renumber_instances(const uint32_t* instances, size_t count, const uint32_t* surface_ids);
  void set_visibility(uint32_t instance, uint32_t visibility);

  uint32_t add_particles(const sideray_particles_desc& desc);
  void set_sprites(uint32_t particles, const sideray_sprite* sprites, size_t count);
  uint32_t add_wind(const sideray_wind_desc& desc);
  void set_time(double time_s, double previous_time_s);
  void set_lights(const sideray_light* lights, size_t count);
  void set_environment(uint32_t width, uint32_t height, const float* rgb, float scale, float rotation_deg);
  void set_shader(const sideray_shader_desc* shader);  // null: the built-in model
  // Null: the built-in model, and for a material, its default.
  void set_fixed_function(const FixedDesc* model);
  void set_fixed_material(uint32_t material, const sideray_fixed_material* fixed);

  void commit();
  // Returns the last committed snapshot; null before the first commit. May be called while another thread edits.
  std::shared_ptr<const Snapshot> snapshot() const;

  // Returns the number of slots that edits have taken, as a measure of memory: meshes, textures, materials, instances.
  size_t slot_count() const;

 private:
  struct SceneMesh {
    std::shared_ptr<const Mesh> mesh;
    MeshForm form;
    std::optional<bool> closed;  // known once it was needed
    size_t users = 0;            // instances
  };
  struct SceneTexture {
    std::shared_ptr<const Texture> texture;
    size_t users = 0;  // slots of materials, and particles
  };
  struct SceneMaterial {
    sideray_material_desc desc;
    size_t users = 0;  // instances
    std::optional<sideray_fixed_material> fixed;
  };
  struct SceneParticles {
    sideray_particles_desc desc;
    std::vector<sideray_sprite> sprites;
  };
  // Maps names to indices in the snapshot that is being made.
  struct Places {
    std::vector<uint32_t> meshes, textures, materials;
  };

  SceneMesh& mesh_named(uint32_t mesh);
  SceneTexture& texture_named(uint32_t texture);
  SceneMaterial& material_named(uint32_t material);
  sideray_instance_desc& instance_named(uint32_t instance);
  void check_names(const uint32_t* instances, size_t count) const;
  void check_instance(const sideray_instance_desc& desc, size_t index) const;
  void check_textures(const sideray_material_desc& desc) const;
  // Adds `change` to the users of everything that an instance or a material refers to.
  void count_users(const sideray_instance_desc& desc, int change);
  void count_users(const sideray_material_desc& desc, int change);

  const std::shared_ptr<const Environment>& environment();
  bool is_closed_glass(SceneMesh& mesh, const sideray_material_desc& material);
  Material placed_material(const SceneMaterial& material, const Places& places) const;
  void commit_shading(Snapshot& snapshot);
  void commit_instances(const Places& places, Snapshot& snapshot);
  void commit_thin(const sideray_instance_desc& desc, const Places& places, Snapshot& snapshot,
                   std::map<std::pair<uint32_t, bool>, uint32_t>& materials) const;
  void commit_particles(const Places& places, Snapshot& snapshot) const;

  Slots<SceneMesh> meshes_;
  Slots<SceneTexture> textures_;
  Slots<SceneMaterial> materials_;
  Slots<sideray_instance_desc> instances_;
  std::vector<SceneParticles> particles_;
  std::vector<Wind> winds_;
  double time_s_ = 0, previous_time_s_ = 0;
  std::vector<sideray_light> lights_;
  std::shared_ptr<const Environment> environment_;
  std::shared_ptr<const Environment> encoded_, encoded_from_;  // for the fixed function
  sideray_radiance_space encoded_space_{};
  sideray_shader_desc shader_{};
  std::shared_ptr<const void> shader_use_;
  std::optional<FixedDesc> fixed_;
  uint64_t revision_ = 0;
  mutable std::mutex snapshot_mutex_;
  std::shared_ptr<const Snapshot> snapshot_;
};

}  // namespace sideray::model
