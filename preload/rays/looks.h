// Shades hits on the program's surfaces: the fixed function's lighting, textures, colours and fog.
#pragma once

#include <vector>

#include "preload/capture/draw_state.h"
#include "preload/rays/fixed_lighting.h"

namespace sideray::run {

// Holds the looks of a frame's draws; sideray_instance_desc::user is the index of a look.
class Looks {
 public:
  void clear() { looks_.clear(); }
  // `tint` multiplies the colour.
  uint64_t add(const DrawState& state, const float tint[4]);
  // Adds the look of glass, water or a mirror: its layer holds the full reflection alone, which the shader that draws
  // it weights. Behind refracting glass it reflects the share `reflectance`, which grows to 1 at grazing angles.
  uint64_t add_mirror(const DrawState& state, const float tint[4], float reflectance);
  // Adds the look of a surface that only refracts.
  uint64_t add_clear();

  // Implements sideray_shade; `user` is a Looks that must not change meanwhile.
  static void shade(void* user, const sideray_shading_point* points, size_t count, sideray_shading_result* results);

 private:
  struct Look {
    std::shared_ptr<const Lighting> lighting;  // null = not lit
    DrawMaterial material;
    Fog fog;
    float tint[3] = {1, 1, 1};
    bool second_texture = false, mirrors = false, clear = false;
    float reflectance = 1;  // of mirrors behind refracting glass
  };
  static Look look_of(const DrawState& state, const float tint[4]);
  static void shade(const Look& look, const sideray_shading_point& point, sideray_shading_result& result);

  std::vector<Look> looks_;
};

}  // namespace sideray::run
