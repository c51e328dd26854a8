// What translucent surfaces leave of each light's colour, beside its shadow maps and with their matrices: red, green and blue
// of the optical depth that a ray from the light gathers, and how far off the first surface is. The thread whose context is
// current calls it.
//
// What it leaves out: surfaces of one texel that lie on both sides of a receiver all tint it, once it lies behind the first;
// where solids overlap, both absorb; light is not bent. A translucent receiver takes its own part off the sum, which of a
// solid is not known: solids are not tinted.
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

  // Returns a map's side, and how many layers of it there are: none where they would take too much memory.
  static uint32_t side_of(uint32_t shadow_map_side);
  static uint32_t layers_of(uint32_t shadow_map_side, uint32_t shadow_map_layers);

  // The next draw() draws anew.
  void forget() { drawn_ = false; }
  // Draws the maps of a plan where the scene has anything that tints light, and there is room for them.
  void draw(RasterScene& scene, RasterPrograms& programs, const ShadowPlan& plan, bool reversed_depth);
  // There are none until the next draw().
  void leave_out();
  bool exist() const { return directional_.texture || local_.texture; }
  // For programs with SR_TINT_MAPS.
  void bind(const Program& program, RasterTextures& textures) const;

 private:
  struct Maps {
    Texture texture;
    uint32_t size = 0, layers = 0;
  };
  void fit(Maps& maps, uint32_t shadow_map_side, uint32_t shadow_map_layers) const;
  void draw_layer(RasterScene& scene, RasterPrograms& programs, const model::Light& light,
                  const glm::mat4& clip_from_local) const;

  const Functions& gl_;
  Framebuffer framebuffer_;
  Maps directional_, local_;
  bool drawn_ = false, reversed_depth_ = false;
};

}  // namespace sideray::gl
