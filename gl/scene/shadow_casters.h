// Decides which instances a shadow map must hold for the picture of one view. Leaving out the others changes no pixel.
// Plain arithmetic; any thread may call it.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "gl/scene/shadow_plan.h"
#include "model/snapshot.h"

namespace sideray::gl {

// Holds half spaces that contain every visible point: xyz is a unit normal to the inside, where dot(xyz, p) + w >= 0.
struct Receivers {
  std::vector<glm::vec4> planes;
  model::Bounds bounds;
};

// Returns the receivers of a view whose content lies within `bounds`.
Receivers make_receivers(const glm::dmat4& clip_from_local, const model::Bounds& bounds);

// Tests casters for one light's maps: a caster matters where it may lie between the light and a receiver within range.
class ShadowCasters {
 public:
  ShadowCasters(const model::Light& light, const LightShadow& shadow, const Receivers& receivers);
  bool may_matter(const model::Bounds& caster) const;

 private:
  std::vector<glm::vec4> planes_;  // contain light and receivers, and so every shadow ray
  glm::vec3 light_;                // position
  float reach_;                    // the farthest at which a caster matters; infinite for directional lights
};

}  // namespace sideray::gl
