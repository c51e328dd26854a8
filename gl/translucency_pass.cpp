#include <algorithm>
#include <set>
#include <tuple>

#include "gl/raster_state.h"

namespace sideray::gl {

std::vector<Rasterizer::State::TranslucentItem> Rasterizer::State::sorted_translucent() const {
  std::vector<TranslucentItem> items;
  for (const Draw& draw : scene.translucent()) {
    if (is_outside(clip_from_local, draw.bounds)) continue;
    const glm::vec3 offset = draw.bounds.center() - view.eye;
    items.push_back({view.orthographic ? glm::dot(offset, view.forward) : glm::length(offset), &draw});
  }
  const auto key = [](const TranslucentItem& i) { return std::make_tuple(i.distance, i.draw->surface_id, i.draw); };
  std::sort(items.begin(), items.end(),
            [&](const TranslucentItem& a, const TranslucentItem& b) { return key(a) > key(b); });
  return items;
}

// The inner side of a two-sided object first: right for convex ones.
void Rasterizer::State::draw_translucent_object(const Draw& draw) {
  if (!scene.material(draw).cull_back) {
    set_culling(draw, GL_FRONT);
    scene.draw(draw);
  }
  set_culling(draw, GL_BACK);
  scene.draw(draw);
}

void Rasterizer::State::bind_cache(const Program& program, const Translucency& pass) {
  scene.textures().bind_empty_cache();
  program.set("sideray_layers", 0);
  if (pass.bind_cache && pass.traced != TracedSet::none) {
    pass.bind_cache(program.id(), unit::layer_cache);
    program.use();
  }
}

void Rasterizer::State::draw_translucent_items(std::span<const TranslucentItem> items, const Translucency& pass,
                                               FragmentOrder order) {
  std::set<const Program*> prepared;
  const Program* current = nullptr;
  for (const TranslucentItem& item : items) {
    const Draw& draw = *item.draw;
    const Shading shading = scene.shading(draw.material);
    const Program& program = programs.translucent(shading, order);
    if (&program != current) program.use();
    current = &program;
    if (prepared.insert(&program).second) {
      program.set("clip_from_local", clip_from_local);
      set_view_uniforms(program);
      lights.bind(program, scene.textures(), pass.shadows);
      bind_cache(program, pass);
    }
    program.set("traced_surface_id", is_traced(draw, pass.traced) ? draw.surface_id : 0u);
    scene.bind_material(draw.material, shading.maps);
    draw_translucent_object(draw);
  }
}

FragmentCounts Rasterizer::State::draw_translucency(const Translucency& pass) {
  begin_pass({.depth_test = true, .blend_dual_source = true});
  targets.bind_frame();
  // NVIDIA's driver (580.159) passes every depth test here where shadow maps were drawn between the G-buffer and the
  // first use of its depth through this framebuffer, until something is cleared in it. The stencil holds 0 already.
  if (!stencil_cleared) clear_stencil();
  draw_translucent_items(sorted_translucent(), pass, FragmentOrder::blended);
  gl.Disable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ZERO);
  if (!pass.count_fragments || pass.traced == TracedSet::none) return {};
  return {count_fragments(pass, true), count_fragments(pass, false)};
}

uint64_t Rasterizer::State::count_fragments(const Translucency& pass, bool matched) {
  begin_pass({.depth_test = true, .color_write = false});
  targets.bind_frame();
  Query query(gl);
  gl.BeginQuery(GL_SAMPLES_PASSED, query.id());
  for (const bool alpha : {false, true}) {
    const Program* program = nullptr;
    for (const Draw& draw : scene.translucent()) {
      const model::Material& material = scene.material(draw);
      if (material.discards != alpha || !is_traced(draw, pass.traced) || is_outside(clip_from_local, draw.bounds))
        continue;
      if (!program) {
        program = &programs.coverage({.alpha = alpha, .count_matches = true});
        program->use();
        program->set("clip_from_local", clip_from_local);
        program->set("count_matched", static_cast<int>(matched));
        bind_cache(*program, pass);
      }
      program->set("traced_surface_id", draw.surface_id);
      if (alpha) scene.bind_material(draw.material, base_color_map);
      set_culling(draw, material.cull_back ? GL_BACK : 0);
      scene.draw(draw);
    }
  }
  gl.EndQuery(GL_SAMPLES_PASSED);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  // A 32-bit result (OpenGL 3.2 has no wider one) holds 4 G fragments, beyond any picture drawn here.
  GLuint samples = 0;
  gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &samples);
  return samples;
}

}  // namespace sideray::gl
