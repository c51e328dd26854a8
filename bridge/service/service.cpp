#include "bridge/service/service.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "bridge/base/check_inputs.h"
#include "bridge/base/local_view.h"
#include "gl/resources/state_guard.h"
#include "model/failure.h"
#include "rt/base/cpus.h"

namespace sideray::bridge {
namespace {

constexpr size_t kept_outcomes = 4 * SIDERAY_MAX_VIEWS;
constexpr uint64_t poll_ns = 0;

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Of all stages together.
uint32_t largest_unit_count(const gl::Functions& gl) {
  GLint count = 0;
  gl.GetIntegerv(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, &count);
  return static_cast<uint32_t>(count);
}

// Vertices are rounded to the nearest of 2^subpixel_bits positions a pixel.
float largest_snap(const gl::Functions& gl) {
  GLint bits = 0;
  gl.GetIntegerv(GL_SUBPIXEL_BITS, &bits);
  return std::ldexp(0.5f, -bits);
}

sideray_status status_of(const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const Failure& failure) {
    return failure.status;
  } catch (const std::bad_alloc&) {
    return SIDERAY_OUT_OF_MEMORY;
  } catch (...) {
    return SIDERAY_INTERNAL;
  }
}

rt::SequenceStep sequence_step(const sideray_frame_inputs& inputs, bool again) {
  if (again) return rt::SequenceStep::again;
  return inputs.continues ? rt::SequenceStep::next : rt::SequenceStep::first;
}

}  // namespace

Service::Service(sideray_tracer* tracer, gl::Functions functions)
    : tracer_(tracer), gl_(std::move(functions)), subpixel_(largest_snap(gl_)), units_(largest_unit_count(gl_)) {
  sideray_tracer_retain(tracer_);
  view_of(0);
  worker_ = std::jthread([this](std::stop_token stop) { work(stop); });
}

Service::~Service() {
  for (Frame* frame : frames_) frame->cancelled = true;
  tracer_->wake();
  worker_.request_stop();
  worker_.join();
  sideray_tracer_release(tracer_);
}

sideray_ticket Service::submit(const sideray_frame_inputs& inputs) {
  check_inputs(inputs);
  check_capabilities(gl_, inputs);
  if (context_lost_) fail(SIDERAY_GL_FAILED, "service: its context was abandoned; destroy it and create another");
  ServiceView& view = view_of(inputs.view_id);
  const auto slot = std::find_if(view.frames.begin(), view.frames.end(),
                                 [](const Frame& f) { return f.state == Frame::State::free; });
  if (slot == view.frames.end()) return 0;
  check_addition(view, inputs);
  auto snapshot = tracer_->committed();
  check_shader(inputs, snapshot->shader);
  Frame& frame = *slot;
  frame.inputs = inputs;
  frame.snapshot = std::move(snapshot);
  frame.light_samples = light_samples_;
  frame.check = check_;
  frame.weights = inputs.match == SIDERAY_MATCH_ID ? weights_ : rt::LayerWeights::unknown;
  frame.drawn = drawn_;
  frame.sequence = sequence_step(inputs, again_);
  frame.stats = {};
  frame.stats.size = sizeof(frame.stats);
  frame.cancelled = false;
  frame.failure = nullptr;
  frame.trace_finished = false;
  view.policy = policy_of(inputs);
  with_errors_kept(frame, "submit", [&](const gl::ErrorGuard&) { start_readback(frame); });
  frame.ticket = ++last_ticket_;
  frame.state = Frame::State::reading;
  if (timed_) with_errors_kept(frame, "submit", [&](const gl::ErrorGuard&) { finish_readback(frame); });
  return frame.ticket;
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

// A frame that fails leaves the ring, with whatever of its buffers is still mapped; the last good outputs stay.
void Service::with_errors_kept(Frame& frame, const char* what, const std::function<void(const gl::ErrorGuard&)>& body) {
  const gl::ErrorGuard errors(gl_);
  try {
    body(errors);
    errors.check(what);
  } catch (...) {
    const GLenum error = errors.take();
    frame.readback = {};
    frame.snapshot.reset();
    if (frame.state != Frame::State::free) close(frame, status_of(std::current_exception()));
    // The cause of whatever else seems to be wrong.
    if (error == GL_CONTEXT_LOST || error == GL_OUT_OF_MEMORY) gl::fail_with(gl_, error, what);
    throw;
  }
}

void Service::start_readback(Frame& frame) {
  if (!transport_) choose_transport(frame.inputs);
  if (timed_) gl_.Finish();
  frame.issued = Clock::now();
  const gl::PixelTransferGuard transfer(gl_, policy_of(frame.inputs));
  const gl::FramebufferGuard framebuffers(gl_, policy_of(frame.inputs));
  frame.readback.start(gl_, frame.inputs, transport_->persistent_readback);
  frame.stats.bytes_readback = frame.readback.bytes();
}

void Service::choose_transport(const sideray_frame_inputs& inputs) {
  const gl::PixelTransferGuard transfer(gl_, policy_of(inputs));
  const gl::FramebufferGuard framebuffers(gl_, policy_of(inputs));
  const gl::TextureGuard textures(gl_, 0, 1, policy_of(inputs));
  gl_.ActiveTexture(GL_TEXTURE0);
  transport_ = bridge::choose_transport(gl_, inputs);
}

void Service::check_addition(const ServiceView& view, const sideray_frame_inputs& in) {
  if (in.adds_to == 0) return;
  if (in.asked_bits == 0 || in.asked_bits > 0xff ||
      ((in.mask == SIDERAY_MASK_STENCIL || in.mask == SIDERAY_MASK_COUNT) && (in.asked_bits & in.stencil_bits)))
    fail(SIDERAY_INVALID_ARGUMENT, "frame asked_bits {:#x}: give 1 to 0xff, outside stencil_bits", in.asked_bits);
  const bool idle =
      std::all_of(view.frames.begin(), view.frames.end(), [](const Frame& f) { return f.state == Frame::State::free; });
  const sideray_frame_outputs& latest = view.latest;
  if (!idle || in.adds_to != latest.ticket || in.adds_to != view.cache_ticket)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame adds_to {}: it is not the newest finished frame of the view, or others are in flight; wait for it, and "
         "submit its "
         "second wave next",
         in.adds_to);
  const bool same = in.mode == SIDERAY_CACHE && latest.mode == SIDERAY_CACHE && in.max_layers == latest.layers &&
                    in.cache_rate == view.latest_inputs.rate && in.x == latest.x && in.y == latest.y &&
                    in.width == latest.width && in.height == latest.height;
  if (!same)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame adds_to {}: mode, rectangle, max_layers or cache_rate differ from that frame's; give the same inputs",
         in.adds_to);
}

void Service::advance() {
  if (context_lost_) return;
  tracer_->shading.serve();
  // Oldest first: when it has been uploaded, the next may use the result images at once.
  std::sort(frames_.begin(), frames_.end(), [](const Frame* a, const Frame* b) { return a->ticket < b->ticket; });
  for (Frame* frame : frames_)
    if (!is_idle(*frame))
      with_errors_kept(*frame, "advance", [&](const gl::ErrorGuard& errors) { move_on(*frame, errors); });
}

// Nothing to be done with OpenGL.
bool Service::is_idle(const Frame& frame) {
  if (frame.state == Frame::State::free) return true;
  if (frame.state != Frame::State::tracing) return false;
  const std::lock_guard lock(mutex_);
  return !frame.trace_finished;
}

void Service::move_on(Frame& frame, const gl::ErrorGuard& errors) {
  if (frame.state == Frame::State::reading && frame.cancelled) return give_up_reading(frame);
  if (frame.state == Frame::State::reading && frame.readback.ready(poll_ns)) finish_readback(frame);
  if (frame.state == Frame::State::read) start_trace(frame);
  if (frame.state == Frame::State::tracing) take_trace(frame);
  if (frame.state == Frame::State::traced) upload(frame, errors);
}

// At once, so that a fence that never comes cannot hold a place in the ring.
void Service::give_up_reading(Frame& frame) {
  frame.readback = {};
  frame.view->sequence_broken = true;
  close(frame, SIDERAY_CANCELLED);
}

bool Service::wait(sideray_ticket ticket, int32_t timeout_ms) {
  const Clock::time_point deadline =
      timeout_ms < 0 ? Clock::time_point::max() : Clock::now() + std::chrono::milliseconds(timeout_ms);
  for (;;) {
    advance();
    Frame* frame = find(ticket);
    if (!frame) break;
    if (Clock::now() >= deadline) return false;
    wait_for_progress(*frame, deadline);
  }
  const Outcome* result = outcome(ticket);
  if (!result)
    fail(SIDERAY_INVALID_ARGUMENT, "ticket {}: unknown, or finished more than {} frames ago", ticket, kept_outcomes);
  if (result->status == SIDERAY_CANCELLED) fail(SIDERAY_CANCELLED, "ticket {}: the frame was cancelled", ticket);
  if (result->status != SIDERAY_OK)
    fail(result->status, "ticket {}: the frame failed, and the call that met it told why; submit another", ticket);
  return true;
}

void Service::wait_for_progress(Frame& frame, Clock::time_point deadline) {
  // Short slices, because an older frame in the ring may have to be moved on first.
  const Clock::time_point slice = std::min(deadline, Clock::now() + std::chrono::milliseconds(5));
  if (frame.state == Frame::State::reading) {
    const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(slice - Clock::now()).count();
    return with_errors_kept(frame, "wait", [&](const gl::ErrorGuard&) {
      frame.readback.ready(static_cast<uint64_t>(std::max<int64_t>(left, 0)));
    });
  }
  tracer_->shading.serve_until(slice, [&] {
    const std::lock_guard lock(mutex_);
    return std::any_of(frames_.begin(), frames_.end(),
                       [](const Frame* f) { return f->state == Frame::State::tracing && f->trace_finished; });
  });
}

void Service::cancel(sideray_ticket ticket) {
  Frame* frame = find(ticket);
  if (!frame) fail(SIDERAY_INVALID_ARGUMENT, "ticket {}: it is not in flight", ticket);
  frame->cancelled = true;
  tracer_->wake();
}

Service::Frame* Service::find(sideray_ticket ticket) {
  for (Frame* frame : frames_)
    if (frame->state != Frame::State::free && frame->ticket == ticket) return frame;
  return nullptr;
}

const Service::Outcome* Service::outcome(sideray_ticket ticket) const {
  for (const Outcome& o : outcomes_)
    if (o.ticket == ticket) return &o;
  return nullptr;
}

void Service::finish_readback(Frame& frame) {
  const gl::PixelTransferGuard transfer(gl_, policy_of(frame.inputs));
  frame.depth = frame.readback.map(gl_);
  frame.stats.readback_ms = ms_since(frame.issued);
  frame.state = Frame::State::read;
}

void Service::start_trace(Frame& frame) {
  ServiceView& view = *frame.view;
  const std::lock_guard lock(mutex_);
  const bool busy = std::any_of(view.frames.begin(), view.frames.end(), [](const Frame& f) {
    return f.state == Frame::State::tracing || f.state == Frame::State::traced;
  });
  if (busy) return;
  if (std::exchange(view.sequence_broken, false)) frame.sequence = rt::SequenceStep::first;
  if (frame.inputs.mode == SIDERAY_CACHE && !frame.inputs.layers_off) view.cache_ticket = frame.ticket;
  frame.state = Frame::State::tracing;
  work_.push_back(&frame);
  work_ready_.notify_one();
}

void Service::take_trace(Frame& frame) {
  std::exception_ptr failure;
  {
    const std::lock_guard lock(mutex_);
    if (!frame.trace_finished) return;
    failure = frame.failure;
  }
  {
    const gl::PixelTransferGuard transfer(gl_, policy_of(frame.inputs));
    frame.readback.finish(gl_);
  }
  frame.state = Frame::State::traced;
  if (failure) std::rethrow_exception(failure);
  if (frame.cancelled) close(frame, SIDERAY_CANCELLED);
}

void Service::close(Frame& frame, sideray_status status) {
  outcomes_.push_back({frame.ticket, frame.stats, status});
  if (outcomes_.size() > kept_outcomes) outcomes_.pop_front();
  // Tiles that were traced but not uploaded must not be taken for unchanged.
  if (status != SIDERAY_OK) frame.view->cache_textures.invalidate(), frame.view->composite_textures.invalidate();
  frame.snapshot.reset();
  frame.state = Frame::State::free;
}

void Service::work(std::stop_token stop) {
  rt::run_on_all_cpus();
  for (;;) {
    Frame* frame = nullptr;
    {
      std::unique_lock lock(mutex_);
      if (!work_ready_.wait(lock, stop, [&] { return !work_.empty(); })) return;
      frame = work_.front();
      work_.pop_front();
    }
    std::exception_ptr failure;
    try {
      trace(*frame);
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      frame->failure = failure;
      frame->trace_finished = true;
      trace_done_.notify_all();
    }
    tracer_->shading.wake();
  }
}

void Service::trace(Frame& frame) {
  if (!tracer_->turn.lock_unless(frame.cancelled)) return;
  const std::lock_guard turn(tracer_->turn, std::adopt_lock);
  tracer_->use(frame.snapshot);
  set_deadlines(frame);
  if (has_masks(frame.inputs)) trace_masks(frame);
  if (!frame.inputs.layers_off) trace_layers(frame);
  if (has_reflections(frame.inputs)) trace_reflections(frame);
}

// Where both are wanted, masks may take half of the time that is left, so that layers get the other half.
void Service::set_deadlines(Frame& frame) {
  frame.deadline = frame.mask_deadline = rt::Deadline::max();
  if (frame.inputs.deadline_ms == 0.0f) return;
  const auto allowed = std::chrono::duration<float, std::milli>(frame.inputs.deadline_ms);
  frame.deadline = frame.mask_deadline = frame.issued + std::chrono::duration_cast<Clock::duration>(allowed);
  const Clock::time_point now = Clock::now();
  if (!frame.inputs.layers_off && frame.deadline > now) frame.mask_deadline = now + (frame.deadline - now) / 2;
}

rt::ShadingQueue* Service::queue_of(const Frame& frame) {
  return frame.snapshot->shader.thread == SIDERAY_SHADE_IN_CALLS ? &tracer_->shading : nullptr;
}

void Service::trace_layers(Frame& frame) {
  ServiceView& view = *frame.view;
  const sideray_frame_inputs& in = frame.inputs;
  const rt::FrameRequest request{.view = local_view(in.view, frame.snapshot->origin),
                                 .width = static_cast<uint32_t>(in.width),
                                 .height = static_cast<uint32_t>(in.height),
                                 .depth = frame.depth,
                                 .mask = in.mask,
                                 .stencil_bits = in.stencil_bits,
                                 .mask_bytes = frame.readback.mask(),
                                 .max_layers = in.max_layers,
                                 .all_translucent = in.all_translucent != 0,
                                 .shadows = in.shadows != 0,
                                 .light_samples = frame.light_samples,
                                 .step = in.step,
                                 .cache_rate = in.mode == SIDERAY_CACHE ? in.cache_rate : SIDERAY_RATE_FULL,
                                 .sequence = frame.sequence,
                                 .history = &view.history,
                                 .asked_bits = in.adds_to ? in.asked_bits : 0,
                                 .denoise = in.denoise != 0,
                                 .layer_threshold = in.layer_threshold,
                                 .weights = frame.weights,
                                 .drawn = frame.drawn,
                                 .refraction = in.mode == SIDERAY_COMPOSITE && in.refraction != 0,
                                 .particles = in.particles != 0,
                                 .seed = in.seed,
                                 .cancelled = &frame.cancelled,
                                 .deadline = frame.deadline,
                                 .shading_queue = queue_of(frame)};
  if (in.mode == SIDERAY_CACHE && rt::temporal_period(in.cache_rate) == 0) view.history = {};
  const Clock::time_point start = Clock::now();
  const rt::TraceCounters counters = in.mode == SIDERAY_CACHE
                                         ? tracer_->tracer.trace_cache(request, view.cache)
                                         : tracer_->tracer.trace_composite(request, view.composite);
  frame.stats.denoise_ms += counters.denoise_ms;
  frame.stats.trace_ms = ms_since(start) - counters.denoise_ms;
  if (frame.check && in.mode == SIDERAY_CACHE) {
    rt::FrameRequest all = request;  // whatever the rate
    all.cache_rate = SIDERAY_RATE_FULL;
    view.truth = tracer_->tracer.trace_truth(all);
  }
  frame.stats.rays_primary = counters.rays_primary;
  frame.stats.rays_reflection = counters.rays_reflection;
  frame.stats.rays_shadow += counters.rays_shadow;
  frame.stats.pixels_total = counters.pixels_total;
  frame.stats.pixels_masked = counters.pixels_masked;
  frame.stats.layers_requested = counters.layers_requested;
  frame.stats.layers_found = counters.layers_found;
  frame.stats.traversals_wasted = counters.traversals_wasted;
  frame.stats.rays_spared = counters.rays_skipped;
  frame.stats.layers_skipped = counters.layers_skipped;
  frame.stats.points_shaded += counters.points_shaded;
  frame.stats.points_not_finite += counters.points_not_finite;
  frame.stats.pixels_late = counters.pixels_late;
  frame.stats.dropped_particles = counters.dropped_particles;
}

sideray_frame_stats Service::stats(sideray_ticket ticket) const {
  const Outcome* result = outcome(ticket);
  if (!result)
    fail(SIDERAY_INVALID_ARGUMENT, "ticket {}: not finished, or finished more than {} frames ago", ticket,
         kept_outcomes);
  return result->stats;
}

void Service::abandon_context() {
  context_lost_ = true;
  for (Frame* frame : frames_) frame->cancelled = true;
  tracer_->wake();
  {
    // The worker reads what is mapped.
    std::unique_lock lock(mutex_);
    trace_done_.wait(lock, [&] {
      return std::none_of(frames_.begin(), frames_.end(),
                          [](const Frame* f) { return f->state == Frame::State::tracing && !f->trace_finished; });
    });
  }
  for (const auto& view : views_)
    if (view) view->abandon();
}

}  // namespace sideray::bridge
