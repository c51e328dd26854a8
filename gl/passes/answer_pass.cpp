// Tests which fragments of ray-traced surfaces find an answer in the layer cache: counts them, and masks those without
// one for the second wave.
#include "gl/passes/layer_truth.h"
#include "gl/passes/raster_state.h"

namespace sideray::gl {

void RasterState::draw_located(const Translucency& pass, CountedFragments kind, const LayerTruthTextures* truth) {
  for (const bool alpha : {false, true}) {
    const Program* program = nullptr;
    for (const Draw& draw : scene->translucent()) {
      const model::Material& material = scene->material(draw);
      if (material.discards != alpha || !is_traced(draw, pass.traced) || is_hidden(draw.bounds)) continue;
      const Program& wanted = programs.coverage({.alpha = alpha, .counted = kind, .wind = draw.wind != 0});
      if (program != &wanted) {
        program = &wanted;
        program->use();
        program->set("clip_from_local", clip_from_local);
        if (kind != CountedFragments::all) bind_cache(*program, pass);
        if (truth) {
          program->set("true_columns", static_cast<int>(targets.width()));
          scene->textures().bind_plain(unit::material + 1, GL_TEXTURE_2D, truth->first.id());
          scene->textures().bind_plain(unit::material + 2, GL_TEXTURE_2D, truth->surfaces.id());
        }
      }
      if (kind != CountedFragments::all) program->set("traced_surface_id", draw.surface_id);
      if (alpha) scene->bind_material(draw.material, base_color_map);
      scene->set_wind(*program, draw);
      set_culling(draw, material.cull_back ? GL_BACK : 0);
      scene->draw(draw);
    }
  }
}

FragmentCounts RasterState::count_fragments(const Translucency& pass) {
  FragmentCounts counts;
  counts.matched = count_fragments(pass, CountedFragments::matched, nullptr);
  if (pass.whole.transmittance != 0) counts.matched += count_fragments(pass, CountedFragments::all, nullptr);
  counts.missed = count_fragments(pass, CountedFragments::missed, nullptr);
  if (!pass.truth) return counts;
  const LayerTruthTextures truth(gl, *pass.truth);
  counts.misassigned = count_fragments(pass, CountedFragments::misassigned, &truth);
  return counts;
}

// Counts fragments of traced surfaces: `all` in whole pixels, which take no layers, the other kinds elsewhere.
uint64_t RasterState::count_fragments(const Translucency& pass, CountedFragments kind,
                                      const LayerTruthTextures* truth) {
  begin_pass({.depth_test = true, .color_write = false});
  targets.bind_frame();
  leave_whole_out(pass.whole);
  if (kind == CountedFragments::all)
    gl.StencilFunc(GL_EQUAL, static_cast<GLint>(whole_stencil_bit), whole_stencil_bit);
  Query query(gl);
  gl.BeginQuery(GL_SAMPLES_PASSED, query.id());
  draw_located(pass, kind, truth);
  gl.EndQuery(GL_SAMPLES_PASSED);
  take_whole_in();
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  // A 32-bit result (OpenGL 3.2 has no wider one) holds 4 G fragments, beyond any picture drawn here.
  GLuint samples = 0;
  gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &samples);
  return samples;
}

bool RasterState::draw_asked(const Translucency& pass) {
  begin_pass({.depth_test = true, .color_write = false, .stencil_test = true});
  targets.bind_frame();
  if (!stencil_cleared) clear_stencil();
  gl.StencilMask(asked_stencil_bit);
  gl.StencilFunc(GL_ALWAYS, static_cast<GLint>(asked_stencil_bit), asked_stencil_bit);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  Query query(gl);
  gl.BeginQuery(GL_SAMPLES_PASSED, query.id());
  draw_located(pass, CountedFragments::asking, nullptr);
  gl.EndQuery(GL_SAMPLES_PASSED);
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  GLuint samples = 0;
  gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &samples);
  return samples > 0;
}

}  // namespace sideray::gl
