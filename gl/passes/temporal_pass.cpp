// Anti-aliases the finished picture over time. Translucent surfaces are part of it; their motion is taken to be that of
// the opaque surface behind them.
#include "gl/passes/raster_state.h"

namespace sideray::gl {
namespace {

// Returns the row that gives a clip-space position's distance along the axis of `view`, times w of its local position.
glm::vec4 distance_along(const RasterView& view, const glm::dmat4& view_from_local) {
  return glm::vec4(-glm::transpose(view_from_local * view.local_from_clip)[2]);
}

}  // namespace

void RasterState::draw_temporal(const FrameBefore& before) {
  temporal.fit(targets);
  begin_pass({});
  temporal.bind(targets);
  const Program& program = programs.temporal();
  program.use();
  const bool has_history = before.snapshot && temporal.has_past();
  program.set("least_pictures", temporal.least_pictures());
  program.set("has_history", static_cast<int>(has_history));
  program.set("reversed_depth", static_cast<int>(view.reversed_depth));
  program.set("clip_z_from_depth", view.zero_to_one_depth ? glm::vec2(1, 0) : glm::vec2(2, -1));
  program.set("share", glm::vec4(glm::transpose(view.local_from_clip)[3]));
  program.set("distance_now", distance_along(view, view.view_from_local));
  if (has_history) {
    glm::dmat4 moved(1.0);
    moved[3] = glm::dvec4(scene->snapshot().origin - before.snapshot->origin, 1.0);
    program.set("distance_before", distance_along(view, before.view.view_from_local * moved));
  }
  scene->textures().bind_plain(unit::material, GL_TEXTURE_2D, targets.color());
  scene->textures().bind_plain(unit::material + 1, GL_TEXTURE_2D, targets.motion());
  scene->textures().bind_plain(unit::material + 2, GL_TEXTURE_2D, has_history ? temporal.past_picture() : 0);
  scene->textures().bind_plain(unit::material + 3, GL_TEXTURE_2D, has_history ? temporal.past_state() : 0);
  scene->textures().bind_plain(unit::material + 7, GL_TEXTURE_2D, targets.depth_stencil());
  draw_screen();
  if (has_history) temporal.copy_to(targets);
}

}  // namespace sideray::gl
