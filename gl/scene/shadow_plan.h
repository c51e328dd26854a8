// Plans the shadow maps of a scene's lights: their sizes, and the matrices that draw and look them up. Plain
// arithmetic; any thread may call it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "model/snapshot.h"

namespace sideray::gl {

enum class ShadowMap { none = 0, directional = 1, frustum = 2, faces = 3 };

// Says which lights have maps of the colours that translucent surfaces let pass.
enum class TintedLights { none, directional, all };

struct LightShadow {
  ShadowMap map = ShadowMap::none;
  uint32_t first_layer = 0;
  float texel = 0;                         // world units; of local lights, per unit of distance along the axis
  glm::mat4 shadow_from_local{0.0f};       // as shaders/light/raster_lighting.glsl takes it
  std::vector<glm::mat4> clip_from_local;  // one for each layer
};

struct ShadowPlan {
  std::vector<LightShadow> lights;  // one for each light of the snapshot
  uint32_t directional_size = 0, directional_layers = 0;
  uint32_t local_size = 0, local_layers = 0;
};

struct ShadowLimits {
  bool reversed_depth = false;  // with clip z in 0..w
  uint32_t largest_layers = 256, largest_side = 2048;
};

// Returns the bounds of every instance that casts shadows, those that tint light included.
std::vector<model::Bounds> shadow_casters(const model::Snapshot& snapshot);

ShadowPlan plan_shadow_maps(const std::vector<model::Light>& lights, const std::vector<model::Bounds>& casters,
                            const ShadowLimits& limits);

}  // namespace sideray::gl
