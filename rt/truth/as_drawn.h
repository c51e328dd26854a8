// Makes rays hit the scene as it is drawn, for as long as it lives: plants in their swaying poses, nothing culled.
// Afterwards it restores the previous options and rebuilds their poses if they differ.
#pragma once

#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class AsDrawn {
 public:
  explicit AsDrawn(TracedScene& scene) : scene_(scene), before_(scene.foliage()) {
    FoliageOptions drawn = before_;
    drawn.cull_angle_deg = 0.0f;
    if (scene.committed() && !scene.committed()->winds.empty()) drawn.poses = SIDERAY_POSES_ALL;
    scene.set_foliage(drawn);
  }
  ~AsDrawn() { scene_.set_foliage(before_); }
  AsDrawn(const AsDrawn&) = delete;
  AsDrawn& operator=(const AsDrawn&) = delete;

 private:
  TracedScene& scene_;
  const FoliageOptions before_;
};

}  // namespace sideray::rt
