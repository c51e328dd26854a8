// Keeps a snapshot's lights and their shadow maps on the GPU. The context must be current.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/raster_programs.h"
#include "gl/scene/kept_casters.h"
#include "gl/scene/raster_scene.h"
#include "gl/scene/shadow_casters.h"
#include "gl/scene/shadow_plan.h"
#include "gl/scene/tint_maps.h"

namespace sideray::gl {

class RasterLights {
 public:
  explicit RasterLights(const Functions& gl);

  // Plans the maps and uploads the lights; maps are allocated at their first draw. A light for which the driver has no
  // layers left has no map, and casts no shadows. Throws Failure (UNSUPPORTED) where the driver cannot hold so many
  // lights.
  void set_scene(const RasterScene& scene);
  // Draws what the maps lack for the picture of one view. `tinted`, `between`: as in Rasterizer::shadow_maps.
  void draw_shadow_maps(RasterScene& scene, RasterPrograms& programs, const glm::dmat4& clip_from_local,
                        TintedLights tinted, const std::function<void()>& between);

  // Makes the next call draw everything anew.
  void forget_shadow_maps();

  // Returns whether there are more lights than uniform blocks hold, so that programs read them from a texture.
  bool are_many() const { return light_count_ > most_in_blocks; }
  // Binds lights and shadow maps and sets the uniforms of a program with raster_lighting.glsl, which must be in use.
  void bind(const Program& program, RasterTextures& textures, bool shadows) const;
  // Returns whether there are maps of the light that translucent surfaces let pass. bind_tint_maps() binds them.
  bool has_tint_maps(bool shadows) const { return shadows && drawn_ && tints_.exist(); }
  void bind_tint_maps(const Program& program, RasterTextures& textures) const { tints_.bind(program, textures); }

 private:
  static constexpr size_t most_in_blocks = 256;  // as in shaders/light/raster_lighting.glsl
  struct Maps {
    Texture texture;
    Framebuffer framebuffer;
    uint32_t size = 0, layers = 0;
    std::vector<LayerCasters> casters;  // one for each layer
  };
  void upload_blocks(const std::vector<model::Light>& lights);
  void upload_texture(const std::vector<model::Light>& lights);
  void allocate(Maps& maps, uint32_t size, uint32_t layers);
  struct Pass {
    RasterScene& scene;
    RasterPrograms& programs;
    Receivers receivers;
    const std::function<void()>& between;
  };
  struct Layer {
    uint32_t index;
    const model::Light& light;
    const ShadowCasters& casters;
    const glm::mat4& clip_from_local;
  };
  void draw_into(Maps& maps, ShadowMap kind, const Pass& pass);
  // `order`: the casters in the order for a layer that is drawn anew; filled at the light's first such layer.
  void draw_layer(const Maps& maps, LayerCasters& held, const Pass& pass, const Layer& layer,
                  std::vector<const Draw*>& order);
  template <typename Begin>
  void draw_casters(LayerCasters& held, const Pass& pass, const Layer& layer, std::span<const Draw* const> order,
                    const Begin& begin);
  void follow_casters(const RasterScene& scene);
  void begin_pass() const;

  const Functions& gl_;
  ShadowPlan plan_;
  ShadowLimits limits_;
  uint32_t light_count_ = 0;
  bool drawn_ = false;                                // the maps belong to the plan
  std::optional<std::vector<model::Light>> planned_;  // the lights of the plan and the blocks
  Buffer lights_, shadows_;
  Texture texels_;  // the texture of many lights
  Maps directional_, local_;
  TintMaps tints_;
  // False where lists of the instances in every layer would take too much memory; maps are then always drawn.
  bool keeps_ = false;
  LayerCasters once_;
  CasterChanges changes_;
  std::vector<const Draw*> casters_;  // the scene's, in drawing order
};

}  // namespace sideray::gl
