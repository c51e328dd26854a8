#include "bridge/raster/raster_backend.h"

#include <utility>

#include "bridge/raster/frame.h"
#include "model/failure.h"

namespace sideray::bridge {

RasterBackend::RasterBackend(std::unique_ptr<gl::Context> context) : context_(std::move(context)) {
  context_->make_current();
  try {
    rasterizer_ = std::make_unique<gl::Rasterizer>(context_->functions());
  } catch (...) {
    context_->release_current();
    throw;
  }
  context_->release_current();
}

// The display may have been terminated elsewhere in the process, or the context lost: all its objects are gone then,
// and deleting them without a context does nothing.
RasterBackend::~RasterBackend() {
  try {
    context_->make_current();
  } catch (const Failure&) {
    if (service_) service_->abandon_context();
    for (auto& [scene, other] : others_)
      if (other.service) other.service->abandon_context();
  }
  others_.clear();
  service_.reset();
  rasterizer_.reset();
  context_->release_current();
}

void RasterBackend::begin_call() {
  context_->make_current();
  try {
    context_->require_drawable();
    context_->take_errors();
    require_context();
  } catch (...) {
    context_->release_current();
    throw;
  }
}

void RasterBackend::require_context() {
  if (context_->is_lost())
    fail(SIDERAY_GL_FAILED,
         "OpenGL driver {}: it has lost the context, as where a GPU is reset; create another renderer",
         context_->info().renderer);
}

void RasterBackend::require_no_errors() {
  require_context();
  const std::vector<std::string> errors = context_->take_errors();
  if (!errors.empty())
    fail(SIDERAY_GL_FAILED, "OpenGL driver {}: {}; please report this with the driver's version ({})",
         context_->info().renderer, errors.front(), context_->info().version);
}

void RasterBackend::change_scene(const sideray_scene* scene) {
  OtherScene next;
  if (auto known = others_.extract(scene)) next = std::move(known.mapped());
  next.on_gpu = rasterizer_->exchange_scene(std::move(next.on_gpu));
  std::swap(next.service, service_);
  if (scene_) others_[scene_] = std::move(next);
  scene_ = scene;
}

void RasterBackend::set_tracer(sideray_tracer* tracer) {
  if (!service_) service_ = std::make_unique<Service>(tracer, context_->functions());
}

void RasterBackend::set_scene(std::shared_ptr<const model::Snapshot> snapshot) {
  rasterizer_->set_scene(std::move(snapshot));
}

gl::RasterView RasterBackend::make_view(const sideray_camera& camera, glm::vec2 jitter) const {
  return rasterizer_->make_view(camera, jitter);
}

FrameCounters RasterBackend::draw(PictureJob& job, const FramePosition& position, FrameTimer& timer,
                                  Fragments fragments) {
  return draw_frame({*rasterizer_, service_.get()}, job, position, timer, fragments);
}

rt::OpaqueMaterials RasterBackend::read_gbuffer() {
  gl::Rasterizer::GBufferImages images = rasterizer_->read_gbuffer();
  return {std::move(images.albedo_metallic), std::move(images.normal_roughness), std::move(images.ids)};
}

// Counts the traced surfaces. If none are traced, counts those that may have layers (hybrid) or all translucent ones.
std::vector<uint8_t> RasterBackend::count_translucent(const PictureJob& job) {
  const FramePlan& plan = job.plan;
  if (!plan.draws_mask || plan.mask_kind != gl::MaskKind::count) {
    const bool hybrid = job.options.is_hybrid();
    const gl::TracedSet untraced = hybrid ? gl::TracedSet::visible_in_layers : gl::TracedSet::all_translucent;
    rasterizer_->gbuffer();  // clears the stencil
    rasterizer_->mask(gl::MaskKind::count, plan.traces ? plan.traced : untraced);
  }
  return rasterizer_->read_stencil();
}

// Returns the masks as fragments look them up, from the texture.
std::vector<uint8_t> RasterBackend::read_shadows(size_t bytes) {
  std::vector<uint8_t> lit(bytes);
  sideray_mask_outputs outputs{};
  if (!service_->masks(0, outputs) || bytes == 0) return lit;
  const gl::Functions& gl = context_->functions();
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, outputs.shadow_texture);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RED, GL_UNSIGNED_BYTE, lit.data());
  return lit;
}

std::vector<uint8_t> RasterBackend::answers(AnswerOf of) const {
  switch (of) {
    case AnswerOf::lights: return service_->mask_job().answers(rt::OlderMasks::of_lights);
    case AnswerOf::sky: return service_->mask_job().answers(rt::OlderMasks::of_sky);
    case AnswerOf::reflections: return service_->reflection_job().answers();
    case AnswerOf::layers: return service_->layer_job().answers();
  }
  return {};
}

}  // namespace sideray::bridge
