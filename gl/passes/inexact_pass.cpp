// Marks in the stencil the pixels whose shadow rays take the inexact test: docs/foliage.md.
#include "gl/passes/raster_state.h"
#include "model/material.h"

namespace sideray::gl {

// Shades nothing: with the same vertex shader, an invariant position and the depth test EQUAL it hits exactly the
// pixels where the G-buffer shows the surface, cut-outs included.
void RasterState::draw_inexact_marks(const InexactMarks& marks) {
  const bool marked = stencil_marked && marks.target == SIDERAY_TARGET_BIT;
  if (marked && !marks.rest) return;
  begin_pass({.depth_test = true, .color_write = marks.rest, .stencil_test = !marked});
  targets.bind_frame();
  if (!stencil_cleared) clear_stencil();
  if (marks.rest) targets.bind_rest();
  gl.DepthFunc(GL_EQUAL);
  gl.StencilMask(inexact_stencil_bit);
  gl.StencilFunc(GL_ALWAYS, inexact_stencil_bit, inexact_stencil_bit);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  const Program* current = nullptr;
  for (const Draw& draw : scene->opaque()) {
    const model::Material& material = scene->material(draw);
    if (!model::takes_inexact(material, draw.wind, marks.target) || is_outside(clip_from_local, draw.bounds)) continue;
    const Program& program =
        programs.coverage({.alpha = material.discards, .wind = draw.wind != 0, .rest = marks.rest});
    if (&program != current) {
      program.use();
      program.set("clip_from_local", clip_from_local);
      program.set("rest_poses", marks.poses);
      current = &program;
    }
    if (material.discards) scene->bind_material(draw.material, base_color_map);
    scene->set_wind(program, draw);
    set_culling(draw, material.cull_back ? GL_BACK : 0);
    draw_visible(draw);
  }
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

}  // namespace sideray::gl
