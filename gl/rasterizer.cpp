#include "gl/rasterizer.h"

#include <utility>

#include "gl/passes/raster_state.h"
#include "model/failure.h"

namespace sideray::gl {

SceneOnGpu::SceneOnGpu() = default;
SceneOnGpu::~SceneOnGpu() = default;
SceneOnGpu::SceneOnGpu(SceneOnGpu&&) noexcept = default;
SceneOnGpu& SceneOnGpu::operator=(SceneOnGpu&&) noexcept = default;

Rasterizer::Rasterizer(const Functions& gl) : state_(std::make_unique<RasterState>(gl)) {}
Rasterizer::~Rasterizer() = default;

void Rasterizer::set_scene(std::shared_ptr<const model::Snapshot> snapshot) {
  if (!snapshot) fail(SIDERAY_INVALID_ARGUMENT, "rasterizer: no scene; commit one first");
  if (!state_->scene->empty() && &state_->scene->snapshot() == snapshot.get()) return;
  state_->culled_instances.clear();
  state_->scene->set_snapshot(std::move(snapshot));
  state_->lights->set_scene(*state_->scene);
  state_->programs.set_many_lights(state_->lights->are_many());
}

SceneOnGpu Rasterizer::exchange_scene(SceneOnGpu next) {
  if (!next.surfaces) next.surfaces = std::make_unique<RasterScene>(state_->gl);
  if (!next.lights) next.lights = std::make_unique<RasterLights>(state_->gl);
  state_->culled_instances.clear();
  std::swap(state_->scene, next.surfaces);
  std::swap(state_->lights, next.lights);
  state_->programs.set_many_lights(state_->lights->are_many());
  return next;
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
      {state_->targets.width(), state_->targets.height(), state_->scene->snapshot().origin, state_->gl.clip_control});
}

void Rasterizer::set_view(const RasterView& view) {
  state_->view = view;
  state_->clip_from_local = glm::mat4(view.clip_from_local);
}

void Rasterizer::gbuffer(bool marks_inexact) {
  state_->draw_gbuffer(marks_inexact);
}
void Rasterizer::shadow_maps(TintedLights tinted, const std::function<void()>& between) {
  state_->require_scene_and_targets();
  state_->lights->draw_shadow_maps(*state_->scene, state_->programs, state_->view.clip_from_local, tinted, between);
}
void Rasterizer::forget_shadow_maps() {
  state_->lights->forget_shadow_maps();
}
void Rasterizer::mask(MaskKind kind, TracedSet set, bool sprites, bool marks_others) {
  state_->draw_mask(kind, set, sprites, marks_others);
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
bool Rasterizer::mask_asked(const Translucency& pass) {
  return state_->draw_asked(pass);
}
void Rasterizer::composite_traced(uint32_t radiance_texture, uint32_t transmittance_texture) {
  state_->draw_composite(radiance_texture, transmittance_texture);
}

bool Rasterizer::leaves_textures_out() const {
  return state_->scene->leaves_textures_out();
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

void Rasterizer::mark_inexact(const InexactMarks& marks) {
  state_->draw_inexact_marks(marks);
}

uint32_t Rasterizer::rest_texture() const {
  return state_->targets.rest();
}

void Rasterizer::motion(const FrameBefore& before) {
  state_->draw_motion(before);
}

uint32_t Rasterizer::motion_texture() const {
  return state_->targets.motion();
}

std::vector<glm::vec2> Rasterizer::read_motion() const {
  return state_->targets.read_motion();
}

void Rasterizer::average(const FrameBefore& before) {
  state_->draw_temporal(before);
}

void Rasterizer::keep_average() {
  state_->temporal.keep();
}

void Rasterizer::forget_averages() {
  state_->temporal.forget();
}

void Rasterizer::replace_average(const std::vector<glm::vec4>& picture) {
  state_->temporal.replace(picture);
}

}  // namespace sideray::gl
