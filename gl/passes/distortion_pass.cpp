// Distorts in screen space, as engines do: surfaces with distortion shift the opaque picture that is seen through them.
// Runs after the opaque picture is lit, before anything is blended over it.
#include <vector>

#include "gl/passes/raster_state.h"

namespace sideray::gl {
namespace {

constexpr uint32_t normal_map = 0x0004;
constexpr uint32_t distortion_maps = base_color_map | normal_map;

}  // namespace

// Keeps the order of the snapshot, so that sums of offsets do not depend on the view.
std::vector<const Draw*> RasterState::visible_distorting() const {
  std::vector<const Draw*> found;
  for (const Draw& draw : scene->translucent())
    if (scene->material(draw).desc.distortion > 0.0f && !is_hidden(draw.bounds)) found.push_back(&draw);
  return found;
}

void RasterState::draw_distortion() {
  require_scene_and_targets();
  const std::vector<const Draw*> surfaces = visible_distorting();
  if (surfaces.empty()) {
    distortion.release();
    return;
  }
  distortion.fit(targets);
  draw_offsets(surfaces);
  distortion.copy(targets);
  begin_pass({});
  targets.bind_resolve();
  const Program& program = programs.distort_picture();
  program.use();
  program.set("reversed_depth", static_cast<int>(view.reversed_depth));
  scene->textures().bind_plain(unit::material, GL_TEXTURE_2D, distortion.offsets());
  scene->textures().bind_plain(unit::material + 1, GL_TEXTURE_2D, distortion.picture());
  scene->textures().bind_plain(unit::material + 7, GL_TEXTURE_2D, targets.depth_stencil());
  draw_screen();
}

void RasterState::draw_offsets(std::span<const Draw* const> surfaces) {
  begin_pass({.depth_test = true});
  distortion.bind_offsets();
  const float none[4] = {};
  gl.ClearBufferfv(GL_COLOR, 0, none);
  gl.Enable(GL_BLEND);
  gl.BlendEquationSeparate(GL_FUNC_ADD, GL_MAX);
  gl.BlendFunc(GL_ONE, GL_ONE);
  const glm::dmat3 view_from_local(view.view_from_local);
  const glm::dmat3 local_from_view = glm::inverse(view_from_local);
  const Program* current = nullptr;
  for (const Draw* draw : surfaces) {
    const Program& program = programs.distort(distortion_maps, draw->wind != 0);
    if (&program != current) {
      program.use();
      program.set("clip_from_local", clip_from_local);
      program.set("reversed_depth", static_cast<int>(view.reversed_depth));
      program.set("view_right", glm::vec3(glm::normalize(local_from_view[0])));
      program.set("view_up", glm::vec3(glm::normalize(local_from_view[1])));
      current = &program;
    }
    scene->set_wind(program, *draw);
    const model::Material& material = scene->material(*draw);
    program.set("distortion", material.desc.distortion);
    scene->bind_material(draw->material, distortion_maps);
    set_culling(*draw, material.cull_back ? GL_BACK : 0);
    scene->draw(*draw);
  }
  gl.Disable(GL_BLEND);
  gl.BlendEquation(GL_FUNC_ADD);
  gl.BlendFunc(GL_ONE, GL_ZERO);
}

}  // namespace sideray::gl
