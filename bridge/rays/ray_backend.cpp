#include "bridge/rays/ray_backend.h"

#include <mutex>
#include <utility>

#include "bridge/base/local_view.h"
#include "bridge/drawing/trace_inputs.h"
#include "model/failure.h"
#include "rt/drawing/blend_translucent.h"
#include "rt/drawing/motion.h"
#include "rt/drawing/opaque_light.h"

namespace sideray::bridge {
namespace {

// Refuses a host's shader that runs in the host's own calls: it would wait for this call to end.
void require_shader_that_answers(const model::Snapshot& snapshot) {
  if (snapshot.shader.shade && snapshot.shader.thread == SIDERAY_SHADE_IN_CALLS)
    fail(SIDERAY_UNSUPPORTED, "shader in calls without OpenGL: the call that draws is the one that traces; let the shader "
                              "be called on any thread");
}

}  // namespace

// Draws one frame, and has the tracer's turn meanwhile.
class RayBackend::Frame {
 public:
  Frame(RayBackend& backend, PictureJob& job, const FramePosition& position, FrameTimer& timer)
      : b_(backend),
        jobs_(*backend.jobs_),
        job_(job),
        plan_(job.plan),
        tracer_(job.tracer->tracer),
        position_(position),
        timer_(timer),
        inputs_(trace_inputs(job, position)),
        view_(local_view(inputs_.view, job.snapshot->origin)),
        turn_(job.tracer->turn) {
    ++jobs_.frames;
    inputs_.resolves = plan_.resolves;
    inputs_.inspection.redraws = std::exchange(job.has_frame, true);
    inputs_.inspection.keeps_masks = job.keeps_masks;
    inputs_.inspection.timed = timer.staged();
  }

  FrameCounters draw() {
    counters_.trace.pixels_total = uint64_t{plan_.width} * plan_.height;
    timer_.stage(SIDERAY_STAGE_GBUFFER, [&] { find_opaque(); });
    if (inputs_.budget_ms > 0.0f) end_ = jobs_.budget.begin(0, inputs_.budget_ms);
    if (plan_.motion) timer_.stage(SIDERAY_STAGE_GBUFFER, [&] { b_.motion_ = tracer_.trace_motion(motion(), b_.pixels_); });
    if (plan_.masks_occlusion()) {
      Textures textures;  // rest poses, which are not needed here, and motion
      if (plan_.motion && inputs_.continues) textures[1] = std::as_bytes(std::span(b_.motion_));
      trace(jobs_.masks, textures);
    }
    if (plan_.bounces) trace(jobs_.irradiance, Textures());
    if (plan_.reflects) trace(jobs_.reflections, Textures{std::as_bytes(std::span(b_.pixels_.normals))});
    if (!plan_.without_color) color();
    timer_.add(counters_.trace);
    return counters_;
  }

 private:
  void color() {
    timer_.stage(SIDERAY_STAGE_LIGHT, [&] { light(); });
    if (plan_.distorts)
      timer_.stage(SIDERAY_STAGE_COMPOSITE, [&] { tracer_.distort(b_.request_, b_.pixels_, b_.picture_); });
    if (plan_.rasters_translucency) timer_.stage(SIDERAY_STAGE_COMPOSITE, [&] { blend(); });
    if (plan_.traces) {
      places_ = tracer_.translucent_places(b_.request_);
      if (!places_.empty()) inputs_.source.mask = SIDERAY_MASK_MEMORY;
      trace(jobs_.layers, Textures());
      timer_.stage(SIDERAY_STAGE_COMPOSITE, [&] { tracer_.composite_over(jobs_.layers.composite(), b_.picture_); });
    }
    if (plan_.averages && !job_.sequence.adds()) timer_.stage(SIDERAY_STAGE_COMPOSITE, [&] { average(); });
  }

  void find_opaque() {
    b_.request_ = {.view = view_,
                   .width = plan_.width,
                   .height = plan_.height,
                   .normals = plan_.reflects};
    counters_.trace += tracer_.trace_opaque(b_.request_, b_.pixels_);
  }

  using Textures = decltype(TraceInput::textures);

  void trace(Job& job, const Textures& textures) {
    rt::PiecesLeft pieces(inputs_.budget_pieces);
    rt::WorkTime work = time_of(job, inputs_, watch_.start());
    // Layers are traced without a bound, since nothing else shows translucent surfaces.
    const bool is_bounded = &job != &jobs_.layers;
    const size_t index = &job == &jobs_.masks ? 0 : &job == &jobs_.irradiance ? 1 : 2;
    FrameBudget::Turn turn{};
    if (inputs_.budget_ms > 0.0f && is_bounded) {
      turn = jobs_.budget.start(0, index, {false, index < 1 && plan_.bounces, index < 2 && plan_.reflects, false}, end_);
      work = turn.work();
    }
    if (inputs_.budget_pieces > 0 && is_bounded) work.pieces = &pieces;
    rt::Counters counters = job.trace({inputs_, 0, *job_.snapshot, sequence_step(inputs_), false},
                                      {.tracer = tracer_,
                                       .depth = b_.pixels_.depth(),
                                       .mask_bytes = places_,
                                       .textures = textures,
                                       .subpixel = 0.0f,
                                       .cancelled = job_.cancelled,
                                       .work = work,
                                       .frame = {&jobs_.trail, jobs_.frames},
                                       .shading_queue = nullptr});
    if (inputs_.budget_ms > 0.0f && is_bounded) {
      jobs_.budget.finish(0, index, turn, counters);
      counters.jobs_starved = turn.starved;
    }
    counters.pixels_total = 0;  // the frame counts them
    counters_.trace += counters;
  }

  void light() {
    rt::OpaqueLightRequest request{.view = view_, .pixels = &b_.pixels_};
    if (plan_.masks_occlusion()) request.masks = &jobs_.masks.image();
    request.shadow_lights = plan_.masks.shadow_lights;
    request.combined_lights = plan_.masks.combined_lights != 0;
    request.sky = plan_.masks.ao_rays != 0;
    request.unhidden_sky = plan_.masks.unhidden_sky != 0;
    if (plan_.bounces) request.bounced = &jobs_.irradiance.image();
    if (plan_.reflects) request.mirrored = &jobs_.reflections.image();
    request.shadows = plan_.casts_shadows;
    counters_.trace += tracer_.light_opaque(request, b_.picture_);
  }

  // Draws the translucent surfaces that OpenGL would rasterize.
  void blend() {
    const std::vector<uint8_t> places = tracer_.translucent_places(b_.request_);
    const rt::BlendRequest request{.view = view_,
                                   .pixels = &b_.pixels_,
                                   .places = places,
                                   .aside = plan_.layers.refraction != 0,
                                   .shadows = plan_.casts_shadows};
    counters_.trace += tracer_.blend(request, b_.picture_);
  }

  static glm::dmat4 without_jitter(const gl::RasterView& view) {
    glm::dmat4 moved(1.0);
    moved[3] = glm::dvec4(-view.jitter, 0.0, 1.0);
    return moved * view.clip_from_local;
  }

  rt::MotionRequest motion() const {
    const gl::FrameBefore& before = job_.sequence.before();
    rt::MotionRequest request{.view = view_, .jitter = position_.view.jitter, .before = before.snapshot.get()};
    request.clip_from_local_before = without_jitter(before.view);
    request.sky_stays = position_.view.orthographic || before.view.orthographic;
    return request;
  }

  // Returns the row that gives a clip-space position's distance along an axis, times w of its local position.
  glm::dvec4 distance_along(const glm::dmat4& view_from_local) const {
    return -glm::transpose(view_from_local * position_.view.local_from_clip)[2];
  }

  void average() {
    const gl::FrameBefore& before = job_.sequence.before();
    rt::AverageRequest request{.view = view_, .follows = before.snapshot != nullptr};
    request.share = glm::transpose(position_.view.local_from_clip)[3];
    request.distance_now = distance_along(position_.view.view_from_local);
    if (before.snapshot) {
      glm::dmat4 moved(1.0);
      moved[3] = glm::dvec4(job_.snapshot->origin - before.snapshot->origin, 1.0);
      request.distance_before = distance_along(before.view.view_from_local * moved);
    }
    tracer_.average(request, b_.pixels_, b_.motion_, b_.average_, b_.picture_);
  }

  RayBackend& b_;
  Jobs& jobs_;
  PictureJob& job_;
  const FramePlan& plan_;
  rt::Tracer& tracer_;
  const FramePosition& position_;
  FrameTimer& timer_;
  FrameInputs inputs_;
  const rt::TraceView view_;
  const std::lock_guard<TracerTurn> turn_;
  const Stopwatch watch_;
  std::vector<uint8_t> places_;  // where rays look for translucent surfaces; empty: everywhere
  FrameBudget::Time end_{};      // when a frame with a budget must end
  FrameCounters counters_;
};

RayBackend::RayBackend(std::string reason) {
  info_.id = "none";
  info_.platform = gl::Platform::none;
  info_.renderer = "rays alone";
  info_.usable = true;
  info_.reason = std::move(reason);
}

// Exchanges the jobs with the scene: they recognize their history by the scene's revision, which two scenes may share.
void RayBackend::change_scene(const sideray_scene* scene) {
  std::unique_ptr<Jobs> next;
  if (auto known = others_.extract(scene)) next = std::move(known.mapped());
  if (!next) next = std::make_unique<Jobs>();
  std::swap(next, jobs_);
  if (scene_) others_[scene_] = std::move(next);
  scene_ = scene;
  tracer_ = nullptr;
}

void RayBackend::resize(uint32_t width, uint32_t height) {
  width_ = width;
  height_ = height;
}

gl::RasterView RayBackend::make_view(const sideray_camera& camera, glm::vec2 jitter) const {
  return gl::make_raster_view(camera, jitter, {width_, height_, snapshot_->origin, true});
}

FrameCounters RayBackend::draw(PictureJob& job, const FramePosition& position, FrameTimer& timer, Fragments) {
  if (job.plan.traces) require_shader_that_answers(*job.snapshot);
  position_ = position;
  return Frame(*this, job, position, timer).draw();
}

rt::OpaqueMaterials RayBackend::read_gbuffer() {
  const std::lock_guard turn(tracer_->turn);
  return tracer_->tracer.opaque_materials(request_, pixels_);
}

std::vector<glm::uvec2> RayBackend::read_ids() {
  const std::lock_guard turn(tracer_->turn);
  return tracer_->tracer.opaque_ids(pixels_);
}

std::vector<uint8_t> RayBackend::count_translucent(const PictureJob& job) {
  const std::lock_guard turn(tracer_->turn);
  return tracer_->tracer.count_translucent(request_, pixels_, job.plan.layers.particles != 0, gl::mask_stencil_bits);
}

// Traces layers only to show them, since the picture uses the composite.
const rt::LayerCache& RayBackend::read_layers(const PictureJob& job) {
  const std::lock_guard turn(tracer_->turn);
  FrameInputs inputs = trace_inputs(job, position_);
  inputs.layers = job.plan.shown_layers;
  const std::vector<uint8_t> places = tracer_->tracer.translucent_places(request_);
  if (!places.empty()) inputs.source.mask = SIDERAY_MASK_MEMORY;
  jobs_->shown_layers.trace({inputs, 0, *job.snapshot, rt::SequenceStep::first, false},
                      {.tracer = tracer_->tracer,
                       .depth = pixels_.depth(),
                       .mask_bytes = places,
                       .textures = {},
                       .subpixel = 0.0f,
                       .cancelled = job.cancelled,
                       .work = {},
                       .frame = {},
                       .shading_queue = nullptr});
  return jobs_->shown_layers.cache();
}

std::vector<uint8_t> RayBackend::read_shadows(size_t bytes) {
  std::vector<uint8_t> lit = jobs_->masks.image().lit;
  lit.resize(bytes);
  return lit;
}

std::vector<uint8_t> RayBackend::answers(AnswerOf of) const {
  switch (of) {
    case AnswerOf::lights: return jobs_->masks.answers(rt::OlderMasks::of_lights);
    case AnswerOf::sky: return jobs_->masks.answers(rt::OlderMasks::of_sky);
    case AnswerOf::reflections: return jobs_->reflections.answers();
    case AnswerOf::layers: return jobs_->layers.answers();
  }
  return {};
}

}  // namespace sideray::bridge
