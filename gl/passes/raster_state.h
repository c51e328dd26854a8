// Declares the passes of the rasterizer and what they share; raster_state.cpp implements the plain passes, *_pass.cpp
// and order_*.cpp the others. The context must be current.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gl/passes/pass_inputs.h"
#include "gl/resources/objects.h"
#include "gl/resources/raster_programs.h"
#include "gl/scene/raster_lights.h"
#include "gl/scene/raster_scene.h"
#include "gl/scene/raster_sprites.h"
#include "gl/scene/raster_view.h"
#include "gl/targets/distortion_targets.h"
#include "gl/targets/opaque_levels.h"
#include "gl/targets/order_targets.h"
#include "gl/targets/raster_targets.h"
#include "gl/targets/temporal_targets.h"

namespace sideray::gl {

struct LayerTruthTextures;

struct RasterState {
  explicit RasterState(const Functions& functions);

  // Holds the OpenGL state that a pass's result depends on, besides programs and bindings; each pass sets all of it.
  struct Pipeline {
    bool depth_test = false, depth_write = false, color_write = true, blend_dual_source = false, stencil_test = false;
  };
  void begin_pass(const Pipeline& pipeline);
  void require_scene_and_targets() const;
  bool is_traced(const Draw& draw, TracedSet set) const;
  void draw_screen() const;
  // Returns whether the passes of this view skip a box, because it is outside or too small.
  bool is_hidden(const model::Bounds& bounds) const {
    return is_outside(clip_from_local, bounds) || is_too_small(view, targets.height(), bounds);
  }
  std::vector<const Draw*> opaque_in_sight() const;
  // Draws the instances of a draw that are not hidden.
  void draw_visible(const Draw& draw) {
    scene->draw_where(
        draw, [&](const model::Bounds& around) { return !is_outside(clip_from_local, around); },
        [&](const model::Bounds& b) { return !is_hidden(b); });
  }
  // Sets the winding of `draw`, and which sides are culled: 0, GL_FRONT or GL_BACK.
  void set_culling(const Draw& draw, uint32_t culled) const;
  void set_view_uniforms(const Program& program) const;

  void draw_gbuffer(bool marks_inexact);
  void draw_thin(bool marks_inexact);  // draws lines and points into the G-buffer, within draw_gbuffer()
  void clear_stencil();  // keeps the marks of the G-buffer pass; the frame must be bound
  void draw_mask(MaskKind kind, TracedSet set, bool with_sprites, bool marks_others);
  // Draws the translucent surfaces that `takes` accepts into the stencil.
  template <typename Takes>
  void draw_coverage(const Takes& takes);
  void mark_others(TracedSet set, bool with_sprites);
  void draw_sprite_outlines();
  void draw_light(bool shadows, const OcclusionTextures& masks);
  void set_ray_uniforms(const Program& program) const;
  void bind_gbuffer() const;
  void bind_masks(const Program& program, const OcclusionTextures& masks) const;
  void draw_inexact_marks(const InexactMarks& marks);
  void draw_temporal(const FrameBefore& before);
  void draw_motion(const FrameBefore& before);
  struct MotionMatrices {  // clip space without jitter, of this frame and of the one before
    glm::dmat4 still_from_local, before_from_local;
  };
  void draw_motion_of_view(const MotionMatrices& matrices, const RasterView& before);
  void draw_motion_of_instances(const MotionMatrices& matrices, const model::Snapshot& before);
  const Program& motion_program(const Draw& draw, const MotionMatrices& matrices, double time_before_s);
  FragmentCounts draw_translucency(const Translucency& pass);
  void draw_distortion();
  std::vector<const Draw*> visible_distorting() const;
  void draw_offsets(std::span<const Draw* const> surfaces);
  void draw_composite(uint32_t radiance_texture, uint32_t transmittance_texture);
  void draw_whole(const WholeTextures& whole);
  // Exclude whole pixels from the draws that follow, and include them again.
  void leave_whole_out(const WholeTextures& whole) const;
  void take_whole_in() const;

  // Describes what the translucent pass draws in one step.
  struct TranslucentItem {
    float distance;    // from the eye: to an object's centre; of sprites, to the first one along the view axis
    const Draw* draw;  // null: sprites
    SpriteRun sprites{};
    uint32_t first_number = 0;  // number of its first primitive; 0 where the order does not need it
  };
  using Items = std::span<const TranslucentItem>;
  // Returns the items farthest first; equally far ones are in the reverse of the order in which rays would hit them.
  // Fills the buffer that their sprites are drawn from.
  std::vector<TranslucentItem> sorted_translucent();
  std::vector<TranslucentItem> sorted_objects() const;
  bool has_sprites() const;
  // Draws the items in their order into what is bound, with the blend state of `order`.
  void draw_translucent_items(Items items, const Translucency& pass, FragmentOrder order);
  const Program& program_of(const TranslucentItem& item, const Translucency& pass, FragmentOrder order);
  void prepare_translucent(const Program& program, const Translucency& pass, bool for_sprites);
  void draw_sprites(const Program& program, const SpriteRun& run);
  void draw_translucent_object(const Draw& draw, FragmentOrder order);

  // Passes of the orders that do not depend on how objects are sorted (order_*.cpp).
  std::vector<TranslucentItem> numbered(std::vector<TranslucentItem> items) const;
  void set_order_uniforms(const Program& program) const;
  void draw_in_order(const Translucency& pass);
  void draw_peeled(Items items, const Translucency& pass);
  void draw_listed(Items items, const Translucency& pass);
  uint32_t fill_lists(Items items, const Translucency& pass, uint32_t first, uint32_t rows);
  void resolve_lists(uint32_t first, uint32_t rows);
  void limit_rows(uint32_t first, uint32_t rows) const;
  // Does one step of peeling: finds in each pixel the next fragment in front of slice `before`, and writes it to
  // `slice`. Returns false where no pixel has one.
  bool peel(Items items, const Translucency& pass, uint32_t before, uint32_t slice);
  void draw_slice(Items items, const Translucency& pass, uint32_t slice);
  void need_slices();
  FragmentCounts count_fragments(const Translucency& pass);
  uint64_t count_fragments(const Translucency& pass, CountedFragments kind, const LayerTruthTextures* truth);
  void draw_located(const Translucency& pass, CountedFragments kind, const LayerTruthTextures* truth);
  bool draw_asked(const Translucency& pass);
  void bind_cache(const Program& program, const Translucency& pass);
  void copy_opaque(const Translucency& pass);
  bool bends_aside(const Draw& draw, const Translucency& pass) const;

  const Functions& gl;
  RasterPrograms programs;
  std::unique_ptr<RasterScene> scene;  // this and `lights` hold the scene that is drawn (SceneOnGpu)
  RasterSprites sprites;
  std::unique_ptr<RasterLights> lights;
  RasterTargets targets;
  DistortionTargets distortion;
  OpaqueLevels opaque_levels;
  TemporalTargets temporal;
  std::unique_ptr<PeelSlices> slices;  // exist only while they are used, like `lists`
  std::unique_ptr<FragmentLists> lists;
  VertexArray screen;                     // empty: core profiles draw nothing without a vertex array
  std::vector<uint8_t> culled_instances;  // 1 = no ray hits it; by instance of the snapshot
  RasterView view;
  bool stencil_marked = false;   // the G-buffer pass has set inexact_stencil_bit
  bool stencil_cleared = false;  // through the frame's own framebuffer, since the G-buffer was drawn
  glm::mat4 clip_from_local{1.0f};
};

}  // namespace sideray::gl
