// Builds a Sideray scene from the objects that MuJoCo draws: geoms become instances; lights and materials follow the
// fixed function that mjr_render uses. Follows the list that mjv_updateScene creates for each frame.
#pragma once

#include <mujoco/mujoco.h>
#include <sideray/sideray.hpp>

#include <array>
#include <map>
#include <string>
#include <vector>

// Returns whether rays draw a geom as glass: its material's name begins with "glass", or its own name or its body's is
// `also`.
bool is_glass(const mjModel& model, const mjvGeom& geom, const std::string& also);

class GlassScene {
 public:
  GlassScene(const mjModel& model, std::string also_glass);
  GlassScene(const GlassScene&) = delete;
  GlassScene& operator=(const GlassScene&) = delete;

  // Updates the scene to the frame's list, and commits.
  void update(const mjvScene& drawn);
  const sideray::Scene& scene() const { return scene_; }

 private:
  using MeshKey = std::array<float, 4>;  // type, data, and the size of capsules
  using MaterialKey = std::array<float, 11>;  // every value that mjr_render uses for a geom's look

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
