#include "gl/passes/raster_state.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "elementary/functions.h"
#include "model/failure.h"
#include "model/material.h"

namespace sideray::gl {
namespace {

const Functions& checked(const Functions& gl) {
  require_renderer(gl);
  return gl;
}

// Returns the distance from the eye to a box in steps of half an octave. Half the box's radius is added, since walls
// around the eye are mostly behind what they enclose.
float octave_half(glm::vec3 eye, const model::Bounds& bounds) {
  const glm::vec3 nearest = glm::clamp(eye, bounds.minimum, bounds.maximum);
  const float distance = glm::length(nearest - eye) + 0.5f * bounds.radius();
  return std::floor(2.0f * elementary::log2(std::max(distance, 1e-30f)));
}

}  // namespace

RasterState::RasterState(const Functions& functions)
    : gl(checked(functions)),
      programs(functions),
      scene(std::make_unique<RasterScene>(functions)),
      sprites(functions),
      lights(std::make_unique<RasterLights>(functions)),
      targets(functions),
      distortion(functions),
      opaque_levels(functions),
      temporal(functions),
      screen(functions) {}

void RasterState::require_scene_and_targets() const {
  if (scene->empty() || targets.width() == 0)
    fail(SIDERAY_INTERNAL, "rasterizer: a pass was asked for before set_scene and resize");
}

void RasterState::begin_pass(const Pipeline& p) {
  require_scene_and_targets();
  const auto enable = [&](GLenum capability, bool on) { on ? gl.Enable(capability) : gl.Disable(capability); };
  if (gl.clip_control) gl.ClipControl(GL_LOWER_LEFT, view.zero_to_one_depth ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
  enable(GL_DEPTH_TEST, p.depth_test);
  gl.DepthFunc(view.reversed_depth ? GL_GREATER : GL_LESS);
  gl.DepthMask(p.depth_write);
  const GLboolean color = p.color_write;
  gl.ColorMask(color, color, color, color);
  enable(GL_BLEND, p.blend_dual_source);
  gl.BlendEquation(GL_FUNC_ADD);
  // SRC1 factors that remain set make every draw with several targets an error, blending or not.
  if (p.blend_dual_source)
    gl.BlendFuncSeparate(GL_ONE, GL_SRC1_COLOR, GL_ONE, GL_SRC1_ALPHA);
  else
    gl.BlendFunc(GL_ONE, GL_ZERO);
  enable(GL_STENCIL_TEST, p.stencil_test);
  gl.StencilMask(0xff);
  gl.Disable(GL_SCISSOR_TEST);
  gl.Disable(GL_POLYGON_OFFSET_FILL);
  gl.Disable(GL_CULL_FACE);
  gl.FrontFace(GL_CCW);
  scene->forget_bindings();
}

bool RasterState::is_traced(const Draw& draw, TracedSet set) const {
  if (draw.instance < culled_instances.size() && culled_instances[draw.instance]) return false;
  if (set == TracedSet::all_translucent) return true;
  return set == TracedSet::visible_in_layers && scene->material(draw).traceable && draw.surface_id != 0 &&
         (draw.visibility & SIDERAY_VISIBLE_LAYERS) != 0;
}

void RasterState::draw_screen() const {
  gl.BindVertexArray(screen.id());
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

void RasterState::set_culling(const Draw& draw, uint32_t culled) const {
  gl.FrontFace(draw.mirrored ? GL_CW : GL_CCW);
  if (culled == 0) {
    gl.Disable(GL_CULL_FACE);
    return;
  }
  gl.Enable(GL_CULL_FACE);
  gl.CullFace(culled);
}

void RasterState::set_view_uniforms(const Program& program) const {
  program.set("eye", view.eye);
  program.set("toward_eye", -view.forward);
  program.set("orthographic", static_cast<int>(view.orthographic));
}

// Returns the opaque draws in sight, the nearest first, since fragments behind drawn ones are not shaded: in the
// built-in bistro 1.3 fragments a pixel instead of 2.6. Draws about equally far away stay in the scene's order, which
// keeps programs and materials together, and decides which of several coinciding surfaces is seen.
std::vector<const Draw*> RasterState::opaque_in_sight() const {
  std::vector<std::pair<float, const Draw*>> keyed;
  for (const Draw& draw : scene->opaque())
    if (!is_outside(clip_from_local, draw.bounds)) keyed.emplace_back(octave_half(view.eye, draw.bounds), &draw);
  std::ranges::stable_sort(keyed, {}, &std::pair<float, const Draw*>::first);
  std::vector<const Draw*> draws;
  draws.reserve(keyed.size());
  for (const auto& [octave, draw] : keyed) draws.push_back(draw);
  return draws;
}

void RasterState::draw_gbuffer(bool marks_inexact) {
  begin_pass({.depth_test = true, .depth_write = true, .stencil_test = marks_inexact});
  targets.set_lobes(scene->opaque_lobes() & (lobe::in_targets | lobe::anisotropy));
  stencil_cleared = false;
  stencil_marked = marks_inexact;
  targets.bind_gbuffer();
  targets.clear_gbuffer();
  gl.ClearBufferfi(GL_DEPTH_STENCIL, 0, view.reversed_depth ? 0.0f : 1.0f, 0);
  gl.StencilMask(marks_inexact ? inexact_stencil_bit : 0xff);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  const Program* current = nullptr;
  for (const Draw* in_sight : opaque_in_sight()) {
    const Draw& draw = *in_sight;
    const bool takes = marks_inexact && model::takes_inexact(scene->material(draw), draw.wind, SIDERAY_TARGET_BIT);
    if (marks_inexact) gl.StencilFunc(GL_ALWAYS, takes ? inexact_stencil_bit : 0, inexact_stencil_bit);
    const Shading shading = scene->shading(draw);
    const Program& program = programs.gbuffer(shading, scene->material(draw).discards);
    if (&program != current) {
      program.use();
      program.set("clip_from_local", clip_from_local);
      if (shading.lobes & (lobe::film | lobe::anisotropy)) set_view_uniforms(program);
      current = &program;
    }
    scene->bind_material(draw.material, shading.maps);
    scene->set_wind(program, draw);
    set_culling(draw, scene->material(draw).cull_back ? GL_BACK : 0);
    draw_visible(draw);
  }
  if (!scene->thin().empty()) draw_thin(marks_inexact);
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
}

void RasterState::clear_stencil() {
  const GLint none = 0;
  gl.StencilMask(stencil_marked ? 0xff & ~inexact_stencil_bit : 0xff);
  gl.ClearBufferiv(GL_STENCIL, 0, &none);
  gl.StencilMask(0xff);
  stencil_cleared = true;
}

template <typename Takes>
void RasterState::draw_coverage(const Takes& takes) {
  const Program* current = nullptr;
  for (const Draw& draw : scene->translucent()) {
    if (!takes(draw)) continue;
    const model::Material& material = scene->material(draw);
    const Program& program = programs.coverage({.alpha = material.discards, .wind = draw.wind != 0});
    if (&program != current) {
      program.use();
      program.set("clip_from_local", clip_from_local);
      current = &program;
    }
    if (material.discards) scene->bind_material(draw.material, base_color_map);
    scene->set_wind(program, draw);
    set_culling(draw, material.cull_back ? GL_BACK : 0);
    scene->draw(draw);
  }
}

void RasterState::draw_mask(MaskKind kind, TracedSet set, bool with_sprites, bool marks_others) {
  begin_pass({.depth_test = true, .color_write = false, .stencil_test = true});
  targets.bind_frame();
  clear_stencil();
  gl.StencilMask(mask_stencil_bits);
  if (kind == MaskKind::count) {
    // INCR saturates at 255 and wraps under a narrower write mask, so values at the top are left alone.
    gl.StencilFunc(GL_NOTEQUAL, static_cast<GLint>(mask_stencil_bits), mask_stencil_bits);
    gl.StencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  } else {
    gl.StencilFunc(GL_ALWAYS, 1, mask_stencil_bits);
    gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  }
  draw_coverage([&](const Draw& draw) { return is_traced(draw, set) && !is_hidden(draw.bounds); });
  if (with_sprites && has_sprites()) draw_sprite_outlines();
  if (marks_others) mark_others(set, !with_sprites);
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

// Also marks surfaces that are too small to be drawn, because rays may hit them.
void RasterState::mark_others(TracedSet set, bool with_sprites) {
  gl.StencilMask(others_stencil_bit);
  gl.StencilFunc(GL_ALWAYS, static_cast<GLint>(others_stencil_bit), others_stencil_bit);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  draw_coverage([&](const Draw& draw) {
    return !is_outside(clip_from_local, draw.bounds) && (!is_traced(draw, set) || is_hidden(draw.bounds));
  });
  if (with_sprites && has_sprites()) draw_sprite_outlines();
}

void RasterState::draw_light(bool shadows, const OcclusionTextures& masks) {
  begin_pass({});
  targets.bind_resolve();
  const bool tint_maps = masks.shadow == 0 && lights->has_tint_maps(shadows);
  const bool occluded = masks.shadow != 0 || masks.open != 0 || masks.mirrored != 0 || masks.bounced != 0;
  const Program& program = programs.light(scene->opaque_lobes(), {.masks = occluded,
                                                                 .answers = masks.answers != 0,
                                                                 .tints = masks.tint != 0,
                                                                 .tint_maps = tint_maps});
  program.use();
  lights->bind(program, scene->textures(), shadows);
  if (tint_maps) lights->bind_tint_maps(program, scene->textures());
  set_view_uniforms(program);
  set_ray_uniforms(program);
  bind_gbuffer();
  bind_masks(program, masks);
  draw_screen();
}

// Sets how a fragment finds the point that it lights from its depth.
void RasterState::set_ray_uniforms(const Program& program) const {
  const ViewRays rays = make_view_rays(view);
  program.set("ray_origin", rays.origin);
  program.set("ray_origin_x", rays.origin_x);
  program.set("ray_origin_y", rays.origin_y);
  program.set("ray", rays.ray);
  program.set("ray_x", rays.ray_x);
  program.set("ray_y", rays.ray_y);
  program.set("along_from_depth", rays.along_from_depth);
  program.set("depth_of_nothing", view.reversed_depth ? 0.0f : 1.0f);
  program.set("pixel_size",
              glm::vec2(2.0f / static_cast<float>(targets.width()), 2.0f / static_cast<float>(targets.height())));
}

void RasterState::bind_gbuffer() const {
  for (uint32_t i = 0; i < RasterTargets::floating_targets; ++i)
    scene->textures().bind_plain(unit::material + i, GL_TEXTURE_2D, targets.gbuffer_texture(i));
  for (uint32_t i = 0; i < lobe::count; ++i)
    scene->textures().bind_plain(unit::material + 4 + i, GL_TEXTURE_2D, targets.lobe_texture(i));
  scene->textures().bind_plain(unit::material + 7, GL_TEXTURE_2D, targets.depth_stencil());
  if (scene->opaque_lobes() & lobe::anisotropy)
    scene->textures().bind_plain(unit::material + 8, GL_TEXTURE_2D,
                                targets.gbuffer_texture(RasterTargets::floating_targets));
}

void RasterState::bind_masks(const Program& program, const OcclusionTextures& masks) const {
  scene->textures().bind_plain(unit::layer_cache, GL_TEXTURE_2D_ARRAY, masks.shadow);
  scene->textures().bind_plain(unit::layer_cache + 1, GL_TEXTURE_2D, masks.open);
  scene->textures().bind_plain(unit::layer_cache + 2, GL_TEXTURE_2D, masks.mirrored);
  scene->textures().bind_plain(unit::material + 11, GL_TEXTURE_2D, masks.bounced);
  program.set("bounced_on", static_cast<int>(masks.bounced != 0));
  program.set("mirrored_on", static_cast<int>(masks.mirrored != 0));
  program.set("shadow_mask_lights", masks.shadow ? masks.shadow_lights : 0u);
  program.set("combined_mask_layer", masks.shadow && masks.combined_lights ? std::popcount(masks.shadow_lights) : -1);
  if (masks.tint != 0) {
    scene->textures().bind_plain(unit::material + 9, GL_TEXTURE_2D_ARRAY, masks.tint);
    program.set("tint_layers", std::span<const int>(masks.tint_layers));
  }
  if (masks.answers != 0) scene->textures().bind_plain(unit::material + 10, GL_TEXTURE_2D, masks.answers);
  program.set("open_mask_on", static_cast<int>(masks.open != 0));
  program.set("unhidden_mask_layer", masks.unhidden_layer);
}

// Draws the whole pixels and marks them in the stencil. The frame must be bound.
void RasterState::draw_whole(const WholeTextures& whole) {
  begin_pass({.blend_dual_source = true, .stencil_test = true});
  const GLint none = 0;
  gl.StencilMask(whole_stencil_bit);
  gl.ClearBufferiv(GL_STENCIL, 0, &none);
  gl.StencilFunc(GL_ALWAYS, static_cast<GLint>(whole_stencil_bit), whole_stencil_bit);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  programs.whole().use();
  scene->textures().bind_plain(unit::material, GL_TEXTURE_2D, whole.radiance);
  scene->textures().bind_plain(unit::material + 1, GL_TEXTURE_2D, whole.transmittance);
  draw_screen();
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
}

// Skips fragments at whole pixels. Drivers test the stencil before they shade, as long as it is not written.
void RasterState::leave_whole_out(const WholeTextures& whole) const {
  if (whole.transmittance == 0) return;
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilMask(0);
  gl.StencilFunc(GL_NOTEQUAL, static_cast<GLint>(whole_stencil_bit), whole_stencil_bit);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
}

void RasterState::take_whole_in() const {
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
}

void RasterState::draw_composite(uint32_t radiance_texture, uint32_t transmittance_texture) {
  begin_pass({.blend_dual_source = true});
  targets.bind_resolve();
  const Program& program = programs.composite();
  program.use();
  scene->textures().bind_plain(unit::material, GL_TEXTURE_2D, radiance_texture);
  scene->textures().bind_plain(unit::material + 1, GL_TEXTURE_2D, transmittance_texture);
  draw_screen();
  gl.Disable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ZERO);
}

}  // namespace sideray::gl
