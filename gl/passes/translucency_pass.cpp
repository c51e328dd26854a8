#include <algorithm>
#include <set>
#include <tuple>

#include "gl/passes/layer_truth.h"
#include "gl/passes/raster_state.h"
#include "model/material.h"

namespace sideray::gl {

std::vector<RasterState::TranslucentItem> RasterState::sorted_objects() const {
  std::vector<TranslucentItem> items;
  for (const Draw& draw : scene->translucent()) {
    if (is_hidden(draw.bounds)) continue;
    const glm::vec3 offset = draw.bounds.center() - view.eye;
    items.push_back({view.orthographic ? glm::dot(offset, view.forward) : glm::length(offset), &draw});
  }
  const auto key = [](const TranslucentItem& i) { return std::make_tuple(i.distance, i.draw->surface_id, i.draw); };
  std::sort(items.begin(), items.end(),
            [&](const TranslucentItem& a, const TranslucentItem& b) { return key(a) > key(b); });
  return items;
}

// Orders sprites by depth, which is exact in every pixel, since they lie in planes parallel to the picture. An object
// is placed among them by the depth of its centre, but objects keep their own order.
std::vector<RasterState::TranslucentItem> RasterState::sorted_translucent() {
  const std::vector<TranslucentItem> objects = sorted_objects();
  if (!has_sprites()) return objects;
  const std::span<const PlacedSprite> placed = sprites.place(scene->snapshot(), view);
  std::vector<TranslucentItem> items;
  uint32_t next = 0;
  const auto add_sprites_behind = [&](float depth) {
    for (; next < placed.size() && placed[next].depth > depth; ++next) {
      const PlacedSprite& sprite = placed[next];
      const bool joins = !items.empty() && !items.back().draw && items.back().sprites.system == sprite.system;
      if (!joins) items.push_back({sprite.depth, nullptr, {sprite.system, next, 0}});
      ++items.back().sprites.count;
    }
  };
  for (const TranslucentItem& object : objects) {
    add_sprites_behind(glm::dot(object.draw->bounds.center() - view.eye, view.forward));
    items.push_back(object);
  }
  add_sprites_behind(-INFINITY);
  return items;
}

bool RasterState::has_sprites() const {
  const std::vector<model::ParticleSystem>& systems = scene->snapshot().particles;
  return std::any_of(systems.begin(), systems.end(), [](const model::ParticleSystem& s) { return !s.sprites.empty(); });
}

// Draws the inner side of a two-sided object first, which is right for convex ones.
void RasterState::draw_translucent_object(const Draw& draw, FragmentOrder order) {
  const bool two_sided = !scene->material(draw).cull_back;
  if (order != FragmentOrder::blended) {
    set_culling(draw, two_sided ? 0 : GL_BACK);
    scene->draw(draw);
    return;
  }
  if (two_sided) {
    set_culling(draw, GL_FRONT);
    scene->draw(draw);
  }
  set_culling(draw, GL_BACK);
  scene->draw(draw);
}

void RasterState::bind_cache(const Program& program, const Translucency& pass) {
  scene->textures().bind_empty_cache();
  program.set("sideray_layers", 0);
  if (pass.bind_cache && pass.traced != TracedSet::none) {
    pass.bind_cache(program.id(), unit::layer_cache);
    program.use();
  }
}

// Returns false on drivers with too few texture units: they draw what is straight behind the surface.
bool RasterState::bends_aside(const Draw& draw, const Translucency& pass) const {
  return pass.aside && gl.texture_units > static_cast<int>(unit::opaque_levels) &&
         model::bends_light(scene->material(draw).desc);
}

const Program& RasterState::program_of(const TranslucentItem& item, const Translucency& pass, FragmentOrder order) {
  if (item.draw)
    return programs.translucent(
        scene->shading(*item.draw), order,
        {.aside = bends_aside(*item.draw, pass), .tint_maps = lights->has_tint_maps(pass.shadows)});
  const model::ParticleSystem& system = scene->snapshot().particles[item.sprites.system];
  return programs.sprites({system.desc.lit != 0, is_soft(system), pass.refracted}, order);
}

void RasterState::prepare_translucent(const Program& program, const Translucency& pass, bool for_sprites) {
  program.set("clip_from_local", clip_from_local);
  set_view_uniforms(program);
  if (for_sprites) RasterSprites::set_view(program, view, targets.height());
  if (program.uniform("light_count") >= 0) lights->bind(program, scene->textures(), pass.shadows);
  if (!for_sprites && lights->has_tint_maps(pass.shadows)) lights->bind_tint_maps(program, scene->textures());
  if (!for_sprites || pass.refracted) bind_cache(program, pass);
}

void RasterState::draw_sprites(const Program& program, const SpriteRun& run) {
  RasterSprites::set_system(program, scene->snapshot(), run.system, scene->textures());
  if (is_soft(scene->snapshot().particles[run.system]))
    scene->textures().bind_plain(unit::material + 1, GL_TEXTURE_2D, targets.depth_copy());
  scene->forget_bindings();
  sprites.draw(run);
}

void RasterState::draw_sprite_outlines() {
  const std::span<const PlacedSprite> placed = sprites.place(scene->snapshot(), view);
  const Program& program = programs.sprite_coverage();
  program.use();
  RasterSprites::set_view(program, view, targets.height());
  sprites.draw({0, 0, static_cast<uint32_t>(placed.size())});
}

void RasterState::draw_translucent_items(Items items, const Translucency& pass, FragmentOrder order) {
  std::set<const Program*> prepared;
  const Program* current = nullptr;
  for (const TranslucentItem& item : items) {
    const Program& program = program_of(item, pass, order);
    if (&program != current) program.use();
    current = &program;
    if (prepared.insert(&program).second) {
      prepare_translucent(program, pass, !item.draw);
      if (order != FragmentOrder::blended) set_order_uniforms(program);
    }
    program.set("first_number", item.first_number);
    if (!item.draw) {
      draw_sprites(program, item.sprites);
      continue;
    }
    const Draw& draw = *item.draw;
    program.set("traced_surface_id", is_traced(draw, pass.traced) ? draw.surface_id : 0u);
    const model::Instance& instance = scene->snapshot().instances[draw.instance];
    program.set("tints_light", static_cast<int>(model::tints_light(scene->material(draw), instance)));
    scene->bind_material(draw.material, scene->shading(draw).maps);
    scene->set_wind(program, draw);
    draw_translucent_object(draw, order);
  }
}

void RasterState::draw_in_order(const Translucency& pass) {
  if (pass.oit != SIDERAY_OIT_PEEL) slices.reset();
  if (pass.oit != SIDERAY_OIT_ABUFFER) lists.reset();
  const std::vector<TranslucentItem> items = sorted_translucent();
  switch (pass.oit) {
    case SIDERAY_OIT_SORTED:
      begin_pass({.depth_test = true, .blend_dual_source = true});
      targets.bind_frame();
      leave_whole_out(pass.whole);
      draw_translucent_items(items, pass, FragmentOrder::blended);
      return take_whole_in();
    case SIDERAY_OIT_ABUFFER:
      return draw_listed(numbered(items), pass);
    case SIDERAY_OIT_PEEL:
      return draw_peeled(numbered(items), pass);
  }
}

// Copies the opaque picture where a surface in view shows it bent or blurred.
void RasterState::copy_opaque(const Translucency& pass) {
  const std::vector<Draw>& draws = scene->translucent();
  const bool needed = std::any_of(draws.begin(), draws.end(), [&](const Draw& draw) {
    return bends_aside(draw, pass) && !is_hidden(draw.bounds);
  });
  if (!needed) return opaque_levels.release();
  opaque_levels.copy(targets);
  scene->textures().bind_plain(unit::opaque_levels, GL_TEXTURE_2D, opaque_levels.texture());
}

FragmentCounts RasterState::draw_translucency(const Translucency& pass) {
  require_scene_and_targets();
  copy_opaque(pass);
  targets.bind_frame();
  // NVIDIA's driver (580.159) passes every depth test here where shadow maps were drawn between the G-buffer and the
  // first use of its depth through this framebuffer, until something is cleared in it. The stencil holds 0 already.
  if (!stencil_cleared) clear_stencil();
  if (has_soft_sprites(scene->snapshot())) targets.copy_depth();
  if (pass.whole.transmittance != 0) draw_whole(pass.whole);
  draw_in_order(pass);
  gl.Disable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ZERO);
  if (!pass.count_fragments || pass.traced == TracedSet::none) return {};
  return count_fragments(pass);
}

}  // namespace sideray::gl
