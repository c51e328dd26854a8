// Draws frames as a deferred engine with sorted translucency does. The context must be current in every call. A frame:
// set_view, gbuffer, mask, shadow_maps, light, distort, then one of the composites, then read back.
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
#include "gl/scene/shadow_plan.h"
#include "model/snapshot.h"

namespace sideray::gl {

class RasterLights;
class RasterScene;
struct RasterState;

// Holds a scene on the GPU: its surfaces, and its lights with their shadow maps. Its destructor needs the context.
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
  // Makes `next` the scene that is drawn (which may hold nothing yet), and returns the one before. Call set_scene()
  // with one of its snapshots next.
  SceneOnGpu exchange_scene(SceneOnGpu next);
  // Sets the instances (1) that no ray hits, so that no traced set holds them. Empty, as after a change of scene: rays
  // hit all.
  void set_culled(std::span<const uint8_t> culled);
  void resize(uint32_t width, uint32_t height);
  // Returns whether some textures of materials are not drawn, because the driver has too few units; their factors are.
  bool leaves_textures_out() const;

  // `jitter` is in pixels from the pixel centre, each in -0.5..0.5.
  RasterView make_view(const sideray_camera& camera, glm::vec2 jitter) const;
  void set_view(const RasterView& view);

  // Draws opaque and masked surfaces: depth, material, normal, ids; clears the stencil. `marks_inexact`: also sets
  // inexact_stencil_bit as SIDERAY_TARGET_BIT does, so that mark_inexact only has to fill rest_texture().
  void gbuffer(bool marks_inexact = false);
  // Draws the shadow maps of all lights as far as this view needs them, except for casters that a map holds and that
  // have not moved. `tinted`: for which translucent surfaces cast coloured shadows. `between`, where given, is called
  // after each light; it may call OpenGL, but must leave all state as it was.
  void shadow_maps(TintedLights tinted = TintedLights::all, const std::function<void()>& between = {});
  void forget_shadow_maps();  // makes the next shadow_maps() draw everything
  // Draws the mask of translucent surfaces into the stencil; needs gbuffer. `sprites`: includes the outlines of
  // sprites. `marks_others`: sets others_stencil_bit where a translucent surface is drawn that is not in the mask.
  void mask(MaskKind kind, TracedSet set, bool sprites = false, bool marks_others = false);
  // Resolves the G-buffer into colour, and draws the sky where it is empty.
  void light(bool shadows, const OcclusionTextures& masks);

  void light(bool shadows) { light(shadows, {}); }

  // Returns the world-space shading normal and perceptual roughness that gbuffer() drew; 0 where it drew nothing.
  uint32_t normal_texture() const;

  // Sets inexact_stencil_bit where a surface that takes the inexact test is visible. Needs gbuffer, and comes after
  // mask.
  void mark_inexact(const InexactMarks& marks);
  uint32_t rest_texture() const;  // sideray_frame_inputs::rest_texture, filled by the last mark_inexact with `rest`

  // Fills motion_texture(): RG32F in pixels, x to the right and y up, the position of a pixel's opaque surface or sky
  // minus its position in the frame before, without jitter. Without a frame before, all values are 0. Instances
  // correspond where index and mesh are equal; those that `before` lacks count as still, and so do their vertices.
  // Needs gbuffer.
  void motion(const FrameBefore& before);
  uint32_t motion_texture() const;
  std::vector<glm::vec2> read_motion() const;

  // Shifts the lit picture behind visible translucent surfaces with `distortion`: a pixel takes the colour at an offset
  // that is the sum of distortion * view-space (x, y) of their shading normals, in picture heights. Needs light.
  void distort();

  // Draws translucency over the lit picture. Calls `bind_cache`, where set, once for each program that looks up the
  // layer cache, with the program in use; it binds textures from unit `first_unit` on and sets the snippet's uniforms.
  FragmentCounts translucency(const Translucency& pass);

  // Sets asked_stencil_bit where sideray_asks() of the snippet requests the second wave; returns false where nothing
  // does. Call it after light() and before translucency(), with the same pass.
  bool mask_asked(const Translucency& pass);

  // Computes colour = radiance + colour * transmittance from two RGBA16F textures of the frame's size.
  void composite_traced(uint32_t radiance_texture, uint32_t transmittance_texture);

  // Averages the finished picture with the history, reprojected by the motion, where there is a frame before; pictures
  // whose jitter differs become anti-aliased. Needs motion(), with the same frame before. The average becomes the
  // history once it is kept; until then the frame may be drawn again.
  void average(const FrameBefore& before);
  void keep_average();
  void forget_averages();
  // Makes `picture`, of the targets' size and bottom row first, the history in place of the last average kept, which
  // must exist.
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
