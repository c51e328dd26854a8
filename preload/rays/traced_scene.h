// The scene that rays see, in eye space: what the program has drawn in this frame. Meshes, textures and materials stay from
// frame to frame by what they hold.
#pragma once

#include <sideray/sideray.hpp>

#include <array>
#include <map>
#include <tuple>
#include <vector>

#include "preload/base/rules.h"
#include "preload/capture/geometry.h"
#include "preload/capture/textures.h"
#include "preload/rays/looks.h"
#include "preload/rays/surface_names.h"

namespace sideray::run {

// A draw as the scene takes it.
struct SceneDraw {
  const Geometry* geometry = nullptr;
  uint64_t hash = 0;  // of the geometry
  const DrawState* state = nullptr;
  const Texture* textures[2] = {};  // of layers 0 and 1
  float tint[4] = {1, 1, 1, 1};
};

class TracedScene {
 public:
  TracedScene();
  // Empties the frame. Meshes, materials and textures that were not drawn for a while are dropped.
  void begin_frame();
  void add_opaque(const SceneDraw& draw);
  // A sheet of the sky, which is moved out to where it hides nothing.
  void add_sky(const SceneDraw& draw);
  // What reflects. Returns its surface id, which it had in the frame before too; 0 = it is no surface that rays can hit.
  uint32_t add_mirror(const SceneDraw& draw);
  void set_background(const std::array<float, 3>& color);
  // Frames that were submitted before keep what they had.
  void commit();

  const Tracer& tracer() const { return tracer_; }
  size_t instances() const { return wanted_.size(); }
  size_t meshes() const { return meshes_.size(); }
  const std::vector<sideray_instance_desc>& frame() const { return wanted_; }

 private:
  struct Mesh {
    sideray_mesh name = 0;
    uint64_t first_frame = 0, last_frame = 0;
    // Vertices that the program makes anew for each frame are not kept for long.
    bool is_old(uint64_t now) const { return now - last_frame > (last_frame > first_frame ? 60u : 2u); }
  };
  template <typename Name>
  struct Kept {
    Name name = 0;
    uint64_t last_frame = 0;
  };
  using MaterialKey = std::tuple<uint64_t, uint64_t, bool, float>;
  bool place(const SceneDraw& draw, float scale, sideray_instance_desc& instance);
  sideray_mesh mesh(const SceneDraw& draw);
  sideray_texture texture(const Texture& texture);
  sideray_material material(const SceneDraw& draw, bool mirrors);
  void drop_old();
  void set_looks();

  Scene scene_;
  Tracer tracer_;
  Looks looks_;
  uint64_t frame_ = 0;
  SurfaceNames names_;
  int sheets_ = 0;
  std::array<float, 3> background_ = {-1, -1, -1};
  std::map<uint64_t, Mesh> meshes_;
  std::map<uint64_t, Kept<sideray_texture>> textures_;
  std::map<MaterialKey, Kept<sideray_material>> materials_;
  std::vector<sideray_instance_desc> wanted_;  // of this frame
  std::vector<sideray_instance> held_;         // in the scene
};

}  // namespace sideray::run
