// Which instances a shadow map must hold for one picture to be right. What it leaves out changes no pixel. Plain
// arithmetic; any thread.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "gl/scene/shadow_plan.h"
#include "model/snapshot.h"

namespace sideray::gl {

// Half spaces that hold every point a picture shows: xyz unit and inward, inside where dot(xyz, p) + w >= 0.
struct Receivers {
  std::vector<glm::vec4> planes;
  model::Bounds bounds;
};

// Describes a view whose content lies within `bounds`.
Receivers make_receivers(const glm::dmat4& clip_from_local, const model::Bounds& bounds);

// The test for one light's maps: a caster matters where it may lie between the light and a receiver within range.
class ShadowCasters {
 public:
  ShadowCasters(const model::Light& light, const LightShadow& shadow, const Receivers& receivers);
  bool may_matter(const model::Bounds& caster) const;

 private:
  std::vector<glm::vec4> planes_;  // that hold light and receivers, and so every way between them
  glm::vec3 light_;                // position
  float reach_;                    // from the light; infinite where unlimited
};

}  // namespace sideray::gl
