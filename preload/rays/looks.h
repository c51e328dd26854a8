// How the program's surfaces look where rays hit them: the lighting of the fixed function, textures, colours and fog.
#pragma once

#include <vector>

#include "preload/capture/draw_state.h"
#include "preload/rays/fixed_lighting.h"

namespace sideray::run {

// The looks of a frame's draws; sideray_instance_desc::user is the place of one.
class Looks {
 public:
  void clear() { looks_.clear(); }
  // `tint`: multiplied onto it.
  uint64_t add(const DrawState& state, const float tint[4]);
  // Of glass, water and mirrors: a layer holds what they reflect, and nothing else. The shader that draws them weights it. Behind
  // bent glass they reflect this share, which grows to 1 at grazing angles where it is below 1.
  uint64_t add_mirror(const DrawState& state, const float tint[4], float reflectance);
  // Of a surface that is seen through alone.
  uint64_t add_clear();

  // A sideray_shade; `user` is a Looks that nobody changes meanwhile.
  static void shade(void* user, const sideray_shading_point* points, size_t count, sideray_shading_result* results);

 private:
  struct Look {
    std::shared_ptr<const Lighting> lighting;  // null = not lit
    DrawMaterial material;
    Fog fog;
    float tint[3] = {1, 1, 1};
    bool second_texture = false, mirrors = false, clear = false;
    float reflectance = 1;  // of mirrors behind bent glass
  };
  static Look look_of(const DrawState& state, const float tint[4]);
  static void shade(const Look& look, const sideray_shading_point& point, sideray_shading_result& result);

  std::vector<Look> looks_;
};

}  // namespace sideray::run
