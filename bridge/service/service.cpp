#include "bridge/service/service.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "bridge/base/check_inputs.h"
#include "bridge/transport/source_checks.h"
#include "gl/resources/state_guard.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr size_t kept_outcomes = 4 * SIDERAY_MAX_VIEWS;

// Returns the number of texture units of all stages together.
uint32_t largest_unit_count(const gl::Functions& gl) {
  GLint count = 0;
  gl.GetIntegerv(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, &count);
  return static_cast<uint32_t>(count);
}

// Returns the most that vertices snap, in pixels: half a step of 2^-subpixel_bits.
float largest_snap(const gl::Functions& gl) {
  GLint bits = 0;
  gl.GetIntegerv(GL_SUBPIXEL_BITS, &bits);
  return std::ldexp(0.5f, -bits);
}

[[noreturn]] void fail_abandoned() {
  fail(SIDERAY_GL_FAILED, "service: its context was abandoned; destroy it and create another");
}

}  // namespace

Service::Service(sideray_tracer* tracer, gl::Functions functions)
    : tracer_(tracer), gl_(std::move(functions)), subpixel_(largest_snap(gl_)), units_(largest_unit_count(gl_)),
      copiers_(tracer->tracer.threads()) {
  sideray_tracer_retain(tracer_);
  view_of(0);
  queue_ = std::make_unique<TraceQueue>([this](Frame& frame, size_t job) { trace(frame, job); },
                                        [this] { tracer_->shading.wake(); });
}

Service::~Service() {
  for (Frame* frame : frames_) frame->cancelled = true;
  tracer_->wake();
  queue_.reset();
  sideray_tracer_release(tracer_);
}

sideray_ticket Service::submit(const FrameInputs& inputs) {
  check_frame(inputs);
  if (context_lost_) fail_abandoned();
  ServiceView& view = view_of(inputs.view_id);
  auto snapshot = tracer_->committed();
  check(inputs, view, *snapshot);
  const auto slot = std::find_if(view.frames.begin(), view.frames.end(),
                                 [](const Frame& f) { return f.state == Frame::State::free; });
  if (slot == view.frames.end()) return 0;
  require_context(gl_);
  Frame& frame = *slot;
  begin(frame, inputs, std::move(snapshot));
  view.policy = policy_of(inputs);
  issue(frame);
  if (inputs.inspection.timed)
    with_errors_kept(frame, "submit", [&](const gl::ErrorGuard&) { finish_readback(frame); });
  return frame.ticket;
}

void Service::check(const FrameInputs& inputs, const ServiceView& view, const model::Snapshot& snapshot) const {
  const bool idle =
      std::all_of(view.frames.begin(), view.frames.end(), [](const Frame& f) { return f.state == Frame::State::free; });
  if (is_second_wave(inputs) && !idle)
    fail(SIDERAY_INVALID_ARGUMENT,
         "layers adds_to {}: other frames of the view are in flight; wait for them before a second wave",
         inputs.layers->adds_to);
  for (const Job* job : view.jobs)
    if (jobs_of(inputs) & job->bit()) job->check(gl_, inputs, snapshot);
}

void Service::begin(Frame& frame, const FrameInputs& inputs, std::shared_ptr<const model::Snapshot> snapshot) {
  frame.inputs = inputs;
  frame.snapshot = std::move(snapshot);
  frame.counters = {};
  frame.counters.pixels_total = uint64_t{static_cast<uint32_t>(inputs.source.width)} *
                                static_cast<uint32_t>(inputs.source.height);
  frame.cancelled = false;
  for (size_t i = 0; i < job_count; ++i) {
    JobRun& run = frame.runs[i];
    const bool wanted = (jobs_of(inputs) & frame.view->jobs[i]->bit()) != 0;
    run.state = wanted ? JobRun::State::waiting : JobRun::State::ended;
    run.is_expected = false;
    run.status = SIDERAY_OK;
    run.sequence = sequence_step(inputs);
    run.counters = {};
  }
}

// Puts a frame into the ring; where this fails, the frame was never in it.
void Service::issue(Frame& frame) {
  const gl::ErrorGuard errors(gl_);
  with_errors_told(
      errors, "submit", [&] { start_readback(frame); }, [&](sideray_status) { release(frame); });
  frame.ticket = ++last_ticket_;
  frame.state = Frame::State::reading;
}

ServiceView& Service::view_of(uint32_t id) {
  auto& view = views_[id];
  if (view) return *view;
  auto made = std::make_unique<ServiceView>();
  frames_.reserve(frames_.size() + made->frames.size());
  for (Frame& frame : made->frames) frames_.push_back(&frame);
  view = std::move(made);
  return *view;
}

void Service::advance() {
  if (context_lost_) return;
  tracer_->shading.serve();
  // Advances the oldest first: once a job is uploaded, the same job of the next frame may start within this call.
  std::sort(frames_.begin(), frames_.end(), [](const Frame* a, const Frame* b) { return a->ticket < b->ticket; });
  for (Frame* frame : frames_) {
    start_jobs(*frame);
    if (needs_context(*frame))
      with_errors_kept(*frame, "advance", [&](const gl::ErrorGuard& errors) { move_on(*frame, errors); });
  }
}

bool Service::wait(sideray_ticket ticket, uint32_t jobs, int32_t timeout_ms) {
  const Clock::time_point deadline =
      timeout_ms < 0 ? Clock::time_point::max() : Clock::now() + std::chrono::milliseconds(timeout_ms);
  for (;;) {
    if (context_lost_) fail_abandoned();
    advance();
    const std::optional<Progress> now = progress(ticket, jobs);
    if (!now)
      fail(SIDERAY_INVALID_ARGUMENT, "ticket {}: unknown, or finished more than {} frames ago", ticket, kept_outcomes);
    if (now->status == SIDERAY_CANCELLED) fail(SIDERAY_CANCELLED, "ticket {}: the frame was cancelled", ticket);
    if (now->status != SIDERAY_OK)
      fail(now->status, "ticket {}: the frame failed, and the call that found it said why; submit another", ticket);
    if (now->ended) return true;
    if (Clock::now() >= deadline) return false;
    wait_for_progress(*find(ticket), deadline);
  }
}

void Service::wait_for_progress(Frame& frame, Clock::time_point deadline) {
  // Waits in short slices, because an older frame in the ring may have to advance first.
  const Clock::time_point slice = std::min(deadline, Clock::now() + std::chrono::milliseconds(5));
  if (frame.state == Frame::State::reading) {
    const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(slice - Clock::now()).count();
    return with_errors_kept(frame, "wait", [&](const gl::ErrorGuard&) {
      frame.readback.ready(static_cast<uint64_t>(std::max<int64_t>(left, 0)));
    });
  }
  tracer_->shading.serve_until(slice, [&] {
    return std::any_of(frames_.begin(), frames_.end(), [&](const Frame* f) {
      return std::any_of(f->runs.begin(), f->runs.end(), [&](const JobRun& run) {
        return run.state == JobRun::State::tracing && queue_->is_traced(run);
      });
    });
  });
}

void Service::cancel(sideray_ticket ticket) {
  Frame* frame = find(ticket);
  if (!frame) fail(SIDERAY_INVALID_ARGUMENT, "ticket {}: it is not in flight", ticket);
  frame->cancelled = true;
  tracer_->wake();
}

Service::Frame* Service::find(sideray_ticket ticket) const {
  for (Frame* frame : frames_)
    if (frame->state != Frame::State::free && frame->ticket == ticket) return frame;
  return nullptr;
}

const Service::Outcome* Service::outcome(sideray_ticket ticket) const {
  for (const Outcome& o : outcomes_)
    if (o.ticket == ticket) return &o;
  return nullptr;
}

std::optional<Service::Progress> Service::progress(sideray_ticket ticket, uint32_t jobs) const {
  Progress now{true, SIDERAY_OK};
  const Frame* frame = find(ticket);
  const Outcome* past = frame ? nullptr : outcome(ticket);
  if (!frame && !past) return std::nullopt;
  for (size_t i = 0; i < job_count; ++i) {
    if (!(jobs & views_[0]->jobs[i]->bit())) continue;
    const bool ended = !frame || frame->runs[i].state == JobRun::State::ended;
    const sideray_status status = !frame ? past->statuses[i] : ended ? frame->runs[i].status : SIDERAY_OK;
    now.ended = now.ended && ended;
    if (now.status == SIDERAY_OK) now.status = status;
  }
  return now;
}

uint32_t Service::finished_jobs(sideray_ticket ticket) const {
  if (const Frame* frame = find(ticket)) return frame->finished_jobs();
  if (const Outcome* past = outcome(ticket)) return past->uploaded;
  fail(SIDERAY_INVALID_ARGUMENT, "ticket {}: unknown, or finished more than {} frames ago", ticket, kept_outcomes);
}

bool Service::layers(uint32_t view_id, sideray_layer_outputs& outputs) const {
  check_view_id(view_id);
  if (!views_[view_id] || views_[view_id]->layers.outputs().ticket == 0) return false;
  outputs = views_[view_id]->layers.outputs();
  return true;
}

bool Service::masks(uint32_t view_id, sideray_mask_outputs& outputs) const {
  check_view_id(view_id);
  if (!views_[view_id] || views_[view_id]->masks.outputs().ticket == 0) return false;
  outputs = views_[view_id]->masks.outputs();
  return true;
}

bool Service::reflections(uint32_t view_id, sideray_reflection_outputs& outputs) const {
  check_view_id(view_id);
  if (!views_[view_id] || views_[view_id]->reflections.outputs().ticket == 0) return false;
  outputs = views_[view_id]->reflections.outputs();
  return true;
}

bool Service::irradiance(uint32_t view_id, sideray_irradiance_outputs& outputs) const {
  check_view_id(view_id);
  if (!views_[view_id] || views_[view_id]->irradiance.outputs().ticket == 0) return false;
  outputs = views_[view_id]->irradiance.outputs();
  return true;
}

std::optional<glm::dmat4x3> Service::placement(uint32_t view_id, uint32_t job, sideray_instance instance) const {
  check_view_id(view_id);
  const auto now = tracer_->committed();
  const uint32_t index = model::find_name(now->instance_names, now->instances.size(), instance);
  if (index == model::no_index)
    fail(SIDERAY_INVALID_ARGUMENT, "placement: the committed scene has no instance {}; give one that was added and not removed",
         instance);
  for (size_t i = 0; i < job_count; ++i) {
    if (job != views_[0]->jobs[i]->bit()) continue;
    const model::Snapshot* shown = views_[view_id] ? views_[view_id]->shown[i].get() : nullptr;
    if (!shown) return std::nullopt;
    const uint32_t then = model::find_name(shown->instance_names, shown->instances.size(), now->instance_names[index]);
    if (then == model::no_index) return std::nullopt;
    glm::dmat4x3 world_from_object(shown->instances[then].local_from_object);
    world_from_object[3] += shown->origin;
    return world_from_object;
  }
  fail(SIDERAY_INVALID_ARGUMENT, "placement: job {:#x}: give one of SIDERAY_JOB_*", job);
}

const rt::Counters& Service::stats(sideray_ticket ticket) const {
  const Outcome* result = outcome(ticket);
  if (!result)
    fail(SIDERAY_INVALID_ARGUMENT, "ticket {}: not finished, or finished more than {} frames ago", ticket,
         kept_outcomes);
  return result->counters;
}

void Service::abandon_context() {
  context_lost_ = true;
  for (Frame* frame : frames_) frame->cancelled = true;
  tracer_->wake();
  queue_->wait_until_idle();  // the worker reads mapped memory
  for (const auto& view : views_)
    if (view) view->abandon();
  if (transport_ && transport_->packer) transport_->packer->abandon();
}

void Service::close(Frame& frame) {
  Outcome result{frame.ticket, frame.finished_jobs(), {}, frame.counters};
  for (size_t i = 0; i < job_count; ++i) result.statuses[i] = frame.runs[i].status;
  outcomes_.push_back(result);
  if (outcomes_.size() > kept_outcomes) outcomes_.pop_front();
  frame.snapshot.reset();
  frame.state = Frame::State::free;
}

void Service::release(Frame& frame) {
  frame.readback = {};
  for (JobRun& run : frame.runs) run = {};
  frame.snapshot.reset();
}

}  // namespace sideray::bridge
