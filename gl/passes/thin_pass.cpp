// Draws lines and points one pixel wide, whatever the host has set.
#include "gl/passes/raster_state.h"

namespace sideray::gl {
namespace {

// Saves the state that sets the width of lines and points, in a context that may be a host's, and restores it.
class WidthGuard {
 public:
  explicit WidthGuard(const Functions& gl) : gl_(gl) {
    gl.GetFloatv(GL_LINE_WIDTH, &line_width_);
    gl.GetFloatv(GL_POINT_SIZE, &point_size_);
    sizes_points_ = gl.IsEnabled(GL_PROGRAM_POINT_SIZE) == GL_TRUE;
    smooths_lines_ = gl.IsEnabled(GL_LINE_SMOOTH) == GL_TRUE;
    gl.LineWidth(1.0f);
    gl.PointSize(1.0f);
    gl.Disable(GL_PROGRAM_POINT_SIZE);
    gl.Disable(GL_LINE_SMOOTH);
  }
  ~WidthGuard() {
    gl_.LineWidth(line_width_);
    gl_.PointSize(point_size_);
    if (sizes_points_) gl_.Enable(GL_PROGRAM_POINT_SIZE);
    if (smooths_lines_) gl_.Enable(GL_LINE_SMOOTH);
  }
  WidthGuard(const WidthGuard&) = delete;
  WidthGuard& operator=(const WidthGuard&) = delete;

 private:
  const Functions& gl_;
  float line_width_ = 1.0f, point_size_ = 1.0f;
  bool sizes_points_ = false, smooths_lines_ = false;
};

}  // namespace

void RasterState::draw_thin(bool marks_inexact) {
  const WidthGuard widths(gl);
  if (marks_inexact) gl.StencilFunc(GL_ALWAYS, 0, inexact_stencil_bit);
  for (const Draw& draw : scene->thin()) {
    if (is_outside(clip_from_local, draw.bounds)) continue;
    const Shading shading = scene->shading(draw);
    const Program& program = programs.gbuffer(shading, scene->material(draw).discards);
    program.use();
    program.set("clip_from_local", clip_from_local);
    if (shading.lobes & (lobe::film | lobe::anisotropy)) set_view_uniforms(program);
    scene->bind_material(draw.material, shading.maps);
    set_culling(draw, 0);
    scene->draw(draw);
  }
}

}  // namespace sideray::gl
