// Keeps maps of the light that translucent surfaces let pass, beside the shadow maps and with their matrices: optical
// depth in red, green and blue along a ray from the light, and the distance of the first surface. The context must be
// current.
//
// Limits: where a texel has surfaces on both sides of a receiver that is behind the first, all of them tint it; where
// solids overlap, both absorb; light is not bent. A translucent receiver subtracts its own optical depth from the sum.
// The depth of a solid is unknown, so solids are not tinted.
#pragma once

#include <cstdint>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/raster_programs.h"
#include "gl/scene/raster_scene.h"
#include "gl/scene/shadow_plan.h"

namespace sideray::gl {

class TintMaps {
 public:
  explicit TintMaps(const Functions& gl) : gl_(gl) {}

  // Returns the side of the maps beside so many shadow maps: half of theirs, or less where memory limits it.
  static uint32_t side_of(uint32_t shadow_map_side, uint32_t layers);

  // Makes the next draw() draw anew.
  void forget() { drawn_ = false; }
  struct Wanted {
    TintedLights lights = TintedLights::none;
    bool reversed_depth = false;
    bool operator==(const Wanted&) const = default;
  };
  // Draws the maps of a plan where something in the scene tints light, and removes those of other lights.
  void draw(RasterScene& scene, RasterPrograms& programs, const ShadowPlan& plan, const Wanted& wanted);
  bool exist() const { return directional_.texture || local_.texture; }
  // Binds the maps for a program with SR_TINT_MAPS.
  void bind(const Program& program, RasterTextures& textures) const;

 private:
  struct Maps {
    Texture texture;
    uint32_t size = 0, layers = 0;
  };
  void fit(Maps& maps, uint32_t shadow_map_side, uint32_t layers) const;
  void draw_layer(RasterScene& scene, RasterPrograms& programs, const model::Light& light,
                  const glm::mat4& clip_from_local) const;

  const Functions& gl_;
  Framebuffer framebuffer_;
  Maps directional_, local_;
  Wanted wanted_;
  bool drawn_ = false;
};

}  // namespace sideray::gl
