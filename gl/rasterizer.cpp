#include "gl/rasterizer.h"

#include "gl/passes/raster_state.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

const Functions& checked(const Functions& gl) {
  require_renderer(gl);
  return gl;
}

}  // namespace

Rasterizer::State::State(const Functions& functions)
    : gl(checked(functions)),
      programs(functions),
      scene(functions),
      sprites(functions),
      lights(functions),
      targets(functions),
      distortion(functions),
      temporal(functions),
      screen(functions) {}

void Rasterizer::State::require_scene_and_targets() const {
  if (scene.empty() || targets.width() == 0)
    fail(SIDERAY_INTERNAL, "rasterizer: a pass was asked for before set_scene and resize");
}

void Rasterizer::State::begin_pass(const Pipeline& p) {
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
  // SRC1 factors left behind make every draw with several targets an error, blending or not.
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
  scene.forget_bindings();
}

bool Rasterizer::State::is_traced(const Draw& draw, TracedSet set) const {
  if (draw.instance < culled_instances.size() && culled_instances[draw.instance]) return false;
  if (set == TracedSet::all_translucent) return true;
  return set == TracedSet::visible_in_layers && scene.material(draw).traceable && draw.surface_id != 0 &&
         (draw.visibility & SIDERAY_VISIBLE_LAYERS) != 0;
}

void Rasterizer::State::draw_screen() const {
  gl.BindVertexArray(screen.id());
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

void Rasterizer::State::set_culling(const Draw& draw, uint32_t culled) const {
  gl.FrontFace(draw.mirrored ? GL_CW : GL_CCW);
  if (culled == 0) {
    gl.Disable(GL_CULL_FACE);
    return;
  }
  gl.Enable(GL_CULL_FACE);
  gl.CullFace(culled);
}

void Rasterizer::State::set_view_uniforms(const Program& program) const {
  program.set("eye", view.eye);
  program.set("toward_eye", -view.forward);
  program.set("orthographic", static_cast<int>(view.orthographic));
}

void Rasterizer::State::draw_gbuffer(bool marks_inexact) {
  begin_pass({.depth_test = true, .depth_write = true, .stencil_test = marks_inexact});
  targets.set_lobes(scene.opaque_lobes());
  stencil_cleared = false;
  stencil_marked = marks_inexact;
  targets.bind_gbuffer();
  targets.clear_gbuffer();
  gl.ClearBufferfi(GL_DEPTH_STENCIL, 0, view.reversed_depth ? 0.0f : 1.0f, 0);
  gl.StencilMask(marks_inexact ? inexact_stencil_bit : 0xff);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  const Program* current = nullptr;
  for (const Draw& draw : scene.opaque()) {
    if (is_outside(clip_from_local, draw.bounds)) continue;
    const bool takes = marks_inexact && takes_inexact(scene.material(draw), draw.wind, SIDERAY_TARGET_BIT);
    if (marks_inexact) gl.StencilFunc(GL_ALWAYS, takes ? inexact_stencil_bit : 0, inexact_stencil_bit);
    const Shading shading = scene.shading(draw);
    const Program& program = programs.gbuffer(shading);
    if (&program != current) {
      program.use();
      program.set("clip_from_local", clip_from_local);
      current = &program;
    }
    scene.bind_material(draw.material, shading.maps);
    scene.set_wind(program, draw);
    set_culling(draw, scene.material(draw).cull_back ? GL_BACK : 0);
    draw_visible(draw);
  }
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
}

void Rasterizer::State::clear_stencil() {
  const GLint none = 0;
  gl.StencilMask(stencil_marked ? 0xff & ~inexact_stencil_bit : 0xff);
  gl.ClearBufferiv(GL_STENCIL, 0, &none);
  gl.StencilMask(0xff);
  stencil_cleared = true;
}

void Rasterizer::State::draw_mask(MaskKind kind, TracedSet set, bool with_sprites) {
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
  const Program* current = nullptr;
  for (const Draw& draw : scene.translucent()) {
    if (!is_traced(draw, set) || is_hidden(draw.bounds)) continue;
    const model::Material& material = scene.material(draw);
    const Program& program = programs.coverage({.alpha = material.discards, .wind = draw.wind != 0});
    if (&program != current) {
      program.use();
      program.set("clip_from_local", clip_from_local);
      current = &program;
    }
    if (material.discards) scene.bind_material(draw.material, base_color_map);
    scene.set_wind(program, draw);
    set_culling(draw, material.cull_back ? GL_BACK : 0);
    scene.draw(draw);
  }
  if (with_sprites && has_sprites()) draw_sprite_outlines();
  gl.Disable(GL_STENCIL_TEST);
  gl.StencilMask(0xff);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void Rasterizer::State::draw_light(bool shadows, const OcclusionTextures& masks) {
  begin_pass({});
  targets.bind_resolve();
  const Program& program =
      programs.light(scene.opaque_lobes(), masks.shadow != 0 || masks.open != 0 || masks.mirrored != 0);
  program.use();
  lights.bind(program, scene.textures(), shadows);
  set_view_uniforms(program);
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
  for (uint32_t i = 0; i < RasterTargets::floating_targets; ++i)
    scene.textures().bind_plain(unit::material + i, GL_TEXTURE_2D, targets.gbuffer_texture(i));
  for (uint32_t i = 0; i < lobe::count; ++i)
    scene.textures().bind_plain(unit::material + 4 + i, GL_TEXTURE_2D, targets.lobe_texture(i));
  scene.textures().bind_plain(unit::material + 7, GL_TEXTURE_2D, targets.depth_stencil());
  scene.textures().bind_plain(unit::layer_cache, GL_TEXTURE_2D_ARRAY, masks.shadow);
  scene.textures().bind_plain(unit::layer_cache + 1, GL_TEXTURE_2D, masks.open);
  scene.textures().bind_plain(unit::layer_cache + 2, GL_TEXTURE_2D, masks.mirrored);
  program.set("mirrored_on", static_cast<int>(masks.mirrored != 0));
  program.set("shadow_mask_lights", masks.shadow ? masks.shadow_lights : 0u);
  program.set("open_mask_on", static_cast<int>(masks.open != 0));
  draw_screen();
}

void Rasterizer::State::draw_composite(uint32_t radiance_texture, uint32_t transmittance_texture) {
  begin_pass({.blend_dual_source = true});
  targets.bind_resolve();
  const Program& program = programs.composite();
  program.use();
  scene.textures().bind_plain(unit::material, GL_TEXTURE_2D, radiance_texture);
  scene.textures().bind_plain(unit::material + 1, GL_TEXTURE_2D, transmittance_texture);
  draw_screen();
  gl.Disable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ZERO);
}

Rasterizer::Rasterizer(const Functions& gl) : state_(std::make_unique<State>(gl)) {}
Rasterizer::~Rasterizer() = default;

void Rasterizer::set_scene(std::shared_ptr<const model::Snapshot> snapshot) {
  if (!snapshot) fail(SIDERAY_INVALID_ARGUMENT, "rasterizer: no scene; commit one first");
  if (!state_->scene.empty() && &state_->scene.snapshot() == snapshot.get()) return;
  state_->culled_instances.clear();
  state_->scene.set_snapshot(std::move(snapshot));
  state_->lights.set_scene(state_->scene);
}

void Rasterizer::set_culled(std::span<const uint8_t> culled) {
  state_->culled_instances.assign(culled.begin(), culled.end());
}

void Rasterizer::resize(uint32_t width, uint32_t height) {
  state_->targets.resize(width, height);
}

RasterView Rasterizer::make_view(const sideray_camera& camera, glm::vec2 jitter) const {
  state_->require_scene_and_targets();
  return make_raster_view(
      camera, jitter,
      {state_->targets.width(), state_->targets.height(), state_->scene.snapshot().origin, state_->gl.clip_control});
}

void Rasterizer::set_view(const RasterView& view) {
  state_->view = view;
  state_->clip_from_local = glm::mat4(view.clip_from_local);
}

void Rasterizer::gbuffer(bool marks_inexact) {
  state_->draw_gbuffer(marks_inexact);
}
void Rasterizer::shadow_maps() {
  state_->require_scene_and_targets();
  state_->lights.draw_shadow_maps(state_->scene, state_->programs, state_->view.clip_from_local);
}
void Rasterizer::mask(MaskKind kind, TracedSet set, bool sprites) {
  state_->draw_mask(kind, set, sprites);
}
void Rasterizer::light(bool shadows, const OcclusionTextures& masks) {
  state_->draw_light(shadows, masks);
}
void Rasterizer::distort() {
  state_->draw_distortion();
}
FragmentCounts Rasterizer::translucency(const Translucency& pass) {
  return state_->draw_translucency(pass);
}
std::vector<uint32_t> Rasterizer::places_of_objects() const {
  std::vector<uint32_t> places(state_->scene.snapshot().instances.size(), 0);
  uint32_t place = 0;
  for (const State::TranslucentItem& item : state_->sorted_objects()) places[item.draw->instance] = ++place;
  return places;
}
bool Rasterizer::mask_asked(const Translucency& pass) {
  return state_->draw_asked(pass);
}
void Rasterizer::composite_traced(uint32_t radiance_texture, uint32_t transmittance_texture) {
  state_->draw_composite(radiance_texture, transmittance_texture);
}

bool Rasterizer::leaves_textures_out() const {
  return state_->scene.leaves_textures_out();
}

uint32_t Rasterizer::normal_texture() const {
  return state_->targets.gbuffer_texture(1);
}
uint32_t Rasterizer::framebuffer() const {
  return state_->targets.frame();
}
const Functions& Rasterizer::functions() const {
  return state_->gl;
}

std::vector<glm::vec4> Rasterizer::read_color() const {
  return state_->targets.read_color();
}
std::vector<float> Rasterizer::read_depth() const {
  return state_->targets.read_depth();
}
std::vector<uint8_t> Rasterizer::read_stencil() const {
  return state_->targets.read_stencil();
}
Rasterizer::GBufferImages Rasterizer::read_gbuffer() const {
  return {state_->targets.read_gbuffer(0), state_->targets.read_gbuffer(1), state_->targets.read_ids()};
}

}  // namespace sideray::gl
