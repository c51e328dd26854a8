// Makes a Sideray scene of the geoms that MuJoCo draws. They become instances, with the fixed-function lights and
// materials of mjr_render. Follows the list that mjv_updateScene makes for each frame.
#pragma once

#include <mujoco/mujoco.h>
#include <sideray/sideray.hpp>

#include <array>
#include <map>
#include <string>
#include <vector>

// Returns whether a geom is glass that rays draw: its material's name begins with "glass", or its own name or its body's
// is `also`.
bool is_glass(const mjModel& model, const mjvGeom& geom, const std::string& also);

class GlassScene {
 public:
  GlassScene(const mjModel& model, std::string also_glass);
  GlassScene(const GlassScene&) = delete;
  GlassScene& operator=(const GlassScene&) = delete;

  // Copies the changes since the last frame, and commits.
  void update(const mjvScene& drawn);
  const sideray::Scene& scene() const { return scene_; }

 private:
  using MeshKey = std::array<float, 4>;  // type, data, and for capsules the size
  using MaterialKey = std::array<float, 11>;  // the appearance that mjr_render reads from a geom

  sideray_mesh mesh_of(const mjvGeom& geom);
  sideray_texture texture_of(int texture);
  sideray_fixed_material look_of(const mjvGeom& geom, bool glass) const;
  sideray_material material_of(const mjvGeom& geom, bool glass);
  sideray_instance_desc instance_of(const mjvGeom& geom, size_t index);
  void update_lights(const mjvScene& drawn);
  void set_sky();

  const mjModel& model_;
  const std::string also_glass_;
  sideray::Scene scene_ = sideray::Scene::create().value();
  std::map<MeshKey, sideray_mesh> meshes_;
  std::map<MaterialKey, sideray_material> materials_;
  std::map<int, sideray_texture> textures_;
  std::vector<sideray_instance> instances_;
};
