#include "bridge/raster/frame.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "bridge/raster/raster_inputs.h"
#include "bridge/raster/second_wave.h"
#include "rt/layers/layer_check.h"

namespace sideray::bridge {
namespace {

gl::InexactMarks inexact_marks(const FramePlan& plan, const RenderOptions& o) {
  return {.target = o.shadows.inexact_target, .rest = plan.fills_rest, .poses = plan.foliage.poses};
}

// Returns how translucent surfaces are drawn and looked up in the layer cache.
gl::Translucency translucency_pass(const PictureJob& job, Service* service) {
  gl::Translucency pass;
  pass.shadows = job.plan.shadow_maps;
  pass.traced = job.plan.traced;
  pass.oit = job.options.translucency.oit;
  pass.aside = job.plan.layers.refraction;
  if (!job.plan.traces) return pass;
  pass.refracted = job.plan.layers.refraction && job.plan.fills_cache();
  pass.bind_cache = [&job, service](uint32_t program, uint32_t unit) {
    service->bind(0, program, unit, job.snapshot->origin);
  };
  sideray_layer_outputs outputs{};
  if (job.plan.layers.whole_pixels && service->layers(0, outputs))
    pass.whole = {outputs.whole_radiance_texture, outputs.whole_transmittance_texture};
  return pass;
}

class Frame {
 public:
  Frame(const RasterParts& parts, PictureJob& job, const FramePosition& position, FrameTimer& timer, Fragments fragments)
      : parts_(parts),
        job_(job),
        plan_(job.plan),
        options_(job.options),
        raster_(parts.rasterizer),
        service_(parts.service),
        position_(position),
        timer_(timer),
        counts_(fragments == Fragments::counted),
        checks_(counts_ && plan_.checks) {}

  FrameCounters draw() {
    raster_.set_view(position_.view);
    draw_opaque();
    trace_and_draw_shadow_maps();
    wait_for_light();
    light();
    finish_trace();
    composite_traced();
    draw_translucent();
    average();
    return counters_;
  }

 private:
  void draw_opaque();
  void trace_and_draw_shadow_maps();
  void start_trace();
  void draw_shadow_maps();
  void wait_for_light();
  void light();
  void finish_trace();
  void composite_traced();
  void draw_translucent();
  void average();
  gl::OcclusionTextures occlusion() const;

  const RasterParts& parts_;
  PictureJob& job_;
  const FramePlan& plan_;
  const RenderOptions& options_;
  gl::Rasterizer& raster_;
  Service* service_;  // null where nothing is traced
  const FramePosition& position_;
  FrameTimer& timer_;
  const bool counts_, checks_;
  sideray_ticket ticket_ = 0;
  FrameCounters counters_;
};

void Frame::draw_opaque() {
  const bool marks_in_gbuffer = plan_.marks_inexact && options_.shadows.inexact_target == SIDERAY_TARGET_BIT;
  timer_.stage(SIDERAY_STAGE_GBUFFER, [&] { raster_.gbuffer(marks_in_gbuffer); });
  if (plan_.motion) timer_.stage(SIDERAY_STAGE_GBUFFER, [&] { raster_.motion(job_.sequence.before()); });
  if (plan_.draws_mask)
    timer_.stage(SIDERAY_STAGE_MASK,
                 [&] { raster_.mask(plan_.mask_kind, plan_.traced, plan_.layers.particles, plan_.layers.whole_pixels); });
  if (plan_.marks_inexact)
    timer_.stage(SIDERAY_STAGE_MASK, [&] { raster_.mark_inexact(inexact_marks(plan_, options_)); });
}

// Draws the shadow maps while rays are traced, as no ray needs them, unless stages are timed separately.
void Frame::trace_and_draw_shadow_maps() {
  if (timer_.staged()) draw_shadow_maps();
  start_trace();
  if (!timer_.staged()) draw_shadow_maps();
}

// Lets the service advance after each light: depth is read back by then, and tracing need not wait for the last map.
void Frame::draw_shadow_maps() {
  if (!plan_.shadow_maps) return;
  const bool traces = ticket_ != 0;
  timer_.stage(SIDERAY_STAGE_SHADOW_MAP, [&] {
    raster_.shadow_maps(plan_.tint_maps(), [&] {
      if (traces) service_->advance();
    });
  });
}

void Frame::start_trace() {
  if (!plan_.uses_rays()) return;
  FrameInputs inputs = raster_inputs(parts_, job_, position_);
  inputs.inspection.check = checks_;
  inputs.inspection.redraws = std::exchange(job_.has_frame, true);
  inputs.inspection.keeps_masks = job_.keeps_masks;
  inputs.inspection.timed = timer_.staged();
  ticket_ = service_->submit(inputs);
}

// Waits for all that lights opaque pixels, but for layers only where stages are timed separately.
void Frame::wait_for_light() {
  if (!plan_.uses_rays()) return;
  const uint32_t jobs = timer_.staged()           ? uint32_t{SIDERAY_JOB_ALL}
                        : plan_.lights_by_rays() ? SIDERAY_JOB_MASKS | SIDERAY_JOB_IRRADIANCE | SIDERAY_JOB_REFLECTIONS
                                                 : 0u;
  if (jobs != 0) wait_for(*service_, job_, ticket_, jobs);
}

void Frame::light() {
  if (!plan_.without_color) timer_.stage(SIDERAY_STAGE_LIGHT, [&] { raster_.light(plan_.shadow_maps, occlusion()); });
  if (plan_.distorts) timer_.stage(SIDERAY_STAGE_COMPOSITE, [&] { raster_.distort(); });
}

gl::OcclusionTextures Frame::occlusion() const {
  gl::OcclusionTextures textures;
  sideray_mask_outputs masks{};
  if (plan_.masks_occlusion() && service_->masks(0, masks)) {
    textures.shadow = masks.shadow_texture;
    textures.shadow_lights = masks.shadow_lights;
    textures.combined_lights = masks.combined_lights != 0;
    textures.open = masks.ao_texture;
    textures.answers = masks.answer_texture;
    textures.tint = masks.tint_texture;
    std::copy(std::begin(masks.tint_layers), std::end(masks.tint_layers), textures.tint_layers);
    if (plan_.masks.unhidden_sky) textures.unhidden_layer = static_cast<int>(plan_.shadow_masks());
  }
  sideray_irradiance_outputs irradiance{};
  if (plan_.bounces && service_->irradiance(0, irradiance)) textures.bounced = irradiance.irradiance_texture;
  sideray_reflection_outputs reflections{};
  if (plan_.reflects && service_->reflections(0, reflections))
    textures.mirrored = reflections.reflection_texture;
  return textures;
}

void Frame::finish_trace() {
  if (!plan_.uses_rays()) return;
  wait_for(*service_, job_, ticket_, SIDERAY_JOB_ALL);
  counters_.trace = service_->stats(ticket_);
  timer_.add(counters_.trace);
  if (plan_.second_wave)
    counters_.trace += trace_second_wave(parts_, job_, position_, {ticket_, translucency_pass(job_, service_)}, timer_);
}

void Frame::composite_traced() {
  if (!plan_.composites()) return;
  sideray_layer_outputs outputs{};
  service_->layers(0, outputs);
  timer_.stage(SIDERAY_STAGE_COMPOSITE,
               [&] { raster_.composite_traced(outputs.radiance_texture, outputs.distance_texture); });
}

void Frame::draw_translucent() {
  if (!plan_.rasters_translucency) return;
  gl::Translucency pass = translucency_pass(job_, service_);
  pass.count_fragments = counts_;
  gl::LayerTruth truth;
  if (checks_) {
    const rt::LayerTruth& traced = service_->truth();
    truth = {traced.first, traced.surfaces};
    pass.truth = &truth;
    counters_.duplicated = rt::count_duplicated(service_->cache(), traced);
  }
  timer_.stage(SIDERAY_STAGE_COMPOSITE, [&] { counters_.fragments = raster_.translucency(pass); });
}

void Frame::average() {
  if (plan_.averages && !job_.sequence.adds())
    timer_.stage(SIDERAY_STAGE_COMPOSITE, [&] { raster_.average(job_.sequence.before()); });
}

}  // namespace

FrameCounters draw_frame(const RasterParts& parts, PictureJob& job, const FramePosition& position, FrameTimer& timer,
                         Fragments fragments) {
  return Frame(parts, job, position, timer, fragments).draw();
}

}  // namespace sideray::bridge
