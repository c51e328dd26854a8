// Draws frames as a deferred engine with sorted translucency does. The thread whose context is current calls it. A
// frame: set_view, gbuffer, mask, shadow_maps, light, distort, then one of the composites, then read back.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "gl/context/functions.h"
#include "gl/passes/pass_inputs.h"
#include "gl/scene/raster_view.h"
#include "model/snapshot.h"

namespace sideray::gl {

class RasterLights;
class RasterScene;
struct RasterState;

// What the GPU has of a scene: its surfaces, and its lights with their shadow maps. Ends with the context current.
struct SceneOnGpu {
  SceneOnGpu();
  ~SceneOnGpu();
  SceneOnGpu(SceneOnGpu&&) noexcept;
  SceneOnGpu& operator=(SceneOnGpu&&) noexcept;

  std::unique_ptr<RasterScene> surfaces;
  std::unique_ptr<RasterLights> lights;
};

class Rasterizer {
 public:
  explicit Rasterizer(const Functions& gl);
  ~Rasterizer();
  Rasterizer(const Rasterizer&) = delete;
  Rasterizer& operator=(const Rasterizer&) = delete;

  // Uploads what changed since the last snapshot. Throws Failure (OUT_OF_MEMORY, GL_FAILED).
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot);
  // Puts what the GPU has of another scene, or nothing yet, in place of the one that is drawn, and returns that.
  // set_scene() of one of its snapshots is to follow.
  SceneOnGpu exchange_scene(SceneOnGpu next);
  // Sets the instances of the scene (1) that no ray hits: no traced set holds them, whatever else is true of them.
  // Empty, as after a change of scene: rays hit all.
  void set_culled(std::span<const uint8_t> culled);
  void resize(uint32_t width, uint32_t height);
  // Returns whether textures of the scene's materials are not drawn (their factors are), since the driver has too few
  // units.
  bool leaves_textures_out() const;

  // `jitter` is in pixels from the pixel centre, each in -0.5..0.5.
  RasterView make_view(const sideray_camera& camera, glm::vec2 jitter) const;
  void set_view(const RasterView& view);

  // Draws opaque and masked surfaces: depth, material, normal, ids; clears the stencil. `marks_inexact`: also sets
  // inexact_stencil_bit where SIDERAY_TARGET_BIT does, so that mark_inexact has nothing left to do but rest_texture().
  void gbuffer(bool marks_inexact = false);
  // Draws the maps of all lights, as far as this view needs them, and keeps what they hold of casters that have not moved.
  // `tints`: what is translucent throws coloured shadows. `between`, where given, is called after each light's; it may call
  // OpenGL where it leaves all state as it was.
  void shadow_maps(bool tints = true, const std::function<void()>& between = {});
  void forget_shadow_maps();  // makes the next shadow_maps() draw everything
  // Draws the mask of translucent surfaces into the stencil; needs gbuffer. `sprites`: they are in it too, by their
  // outlines. `marks_others`: others_stencil_bit is set where something translucent is drawn that is not in the
  // mask.
  void mask(MaskKind kind, TracedSet set, bool sprites = false, bool marks_others = false);
  // Resolves the G-buffer into colour; the sky is drawn where nothing is.
  void light(bool shadows, const OcclusionTextures& masks);

  void light(bool shadows) { light(shadows, {}); }

  // Returns the world-space shading normal and perceptual roughness of what gbuffer() drew; 0 where nothing is.
  uint32_t normal_texture() const;

  // Sets inexact_stencil_bit where a surface that takes the inexact test is visible. Needs gbuffer, and mask where
  // there is one.
  void mark_inexact(const InexactMarks& marks);
  uint32_t rest_texture() const;  // sideray_frame_inputs::rest_texture, made by the last mark_inexact with `rest`

  // Fills motion_texture(): RG32F, pixels, x to the right and y up, where the opaque surface or the sky that a pixel
  // shows is minus where it was in the frame before; jitter excluded. Without a frame before, all values are 0.
  // Instances are the same that have the same index and mesh; what `before` does not have stood still, as vertices did.
  // Needs gbuffer.
  void motion(const FrameBefore& before);
  uint32_t motion_texture() const;
  std::vector<glm::vec2> read_motion() const;

  // Moves the lit picture where visible translucent surfaces have `distortion`: a pixel takes the colour found at the
  // sum of distortion * view-space (x, y) of their shading normals away from it, in picture heights. Needs light.
  void distort();

  // Draws sorted translucency over the lit picture. `bind_cache`, where set, is called once with each program that
  // looks up the layer cache, in use, to bind textures and set the snippet's uniforms from texture unit `first_unit`
  // on.
  FragmentCounts translucency(const Translucency& pass);

  // Sets asked_stencil_bit where sideray_asks() of the snippet requests the second wave; returns false where nothing
  // does. Is called after light() and before translucency(), with the same pass.
  bool mask_asked(const Translucency& pass);

  // Computes colour = radiance + colour * transmittance; both are RGBA16F textures of the frame's size.
  void composite_traced(uint32_t radiance_texture, uint32_t transmittance_texture);

  // Averages the finished picture with the last one kept, along the motion, where there is a frame before; drawn from
  // another place in the pixel each, they are anti-aliased. Needs motion(), of the same frame before. The average is
  // the past of the next picture once it is kept; until then the frame may be drawn again.
  void average(const FrameBefore& before);
  void keep_average();
  void forget_averages();
  // Makes `picture`, of the targets' size and bottom row first, what the next average continues, in place of the last one
  // kept. Not where none is kept.
  void replace_average(const std::vector<glm::vec4>& picture);

  uint32_t framebuffer() const;  // its depth-stencil attachment is what the service reads
  const Functions& functions() const;

  // Read the frame back, bottom row first. Colour is RGBA float; A = 1 - product of transmittances over the background.
  std::vector<glm::vec4> read_color() const;
  std::vector<float> read_depth() const;  // window depth as stored
  std::vector<uint8_t> read_stencil() const;
  struct GBufferImages {
    std::vector<glm::vec4> albedo_metallic, normal_roughness;
    std::vector<glm::uvec2> ids;  // surface id, primitive + 1; 0 = nothing
  };
  GBufferImages read_gbuffer() const;

 private:
  std::unique_ptr<RasterState> state_;
};

}  // namespace sideray::gl
