// Advances a frame's jobs, as a part of the service: readback, trace, upload, the same steps for all jobs.
#include <algorithm>
#include <ctime>
#include <new>

#include "bridge/base/check_inputs.h"
#include "bridge/service/service.h"
#include "bridge/transport/source_checks.h"
#include "gl/resources/state_guard.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint64_t poll_ns = 0;
constexpr float half_pixel = 0.5f;  // a sample may lie anywhere in its pixel

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

// Returns this thread's processor time, since an upload may wait for the host's own drawing.
double busy_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

bool has_ended(const JobRun& run) {
  return run.state == JobRun::State::ended;
}
bool reads_depth(const JobRun& run) {
  return run.state == JobRun::State::waiting || run.state == JobRun::State::tracing;
}

}  // namespace

uint32_t ServiceFrame::finished_jobs() const {
  uint32_t jobs = 0;
  for (size_t i = 0; i < job_count; ++i)
    if (has_ended(runs[i]) && runs[i].status == SIDERAY_OK) jobs |= view->jobs[i]->bit();
  return jobs & jobs_of(inputs);
}

void Service::with_errors_told(const gl::ErrorGuard& errors, const char* what, const std::function<void()>& body,
                               const std::function<void(sideray_status)>& on_failure) {
  try {
    body();
    errors.check(what);
  } catch (...) {
    const GLenum error = errors.take();
    on_failure(status_of(std::current_exception()));
    // These two errors explain any other failure, so they are reported instead of it.
    if (error == GL_CONTEXT_LOST || error == GL_OUT_OF_MEMORY) gl::fail_with(gl_, error, what);
    throw;
  }
}

// Handles errors: a frame that cannot be read leaves the ring with its mapped buffers, and the last good outputs stay.
// Once a frame is read, its jobs fail one by one.
void Service::with_errors_kept(Frame& frame, const char* what, const std::function<void(const gl::ErrorGuard&)>& body) {
  require_context(gl_);
  const gl::ErrorGuard errors(gl_);
  with_errors_told(
      errors, what, [&] { body(errors); },
      [&](sideray_status status) {
        if (frame.state == Frame::State::reading) return drop(frame, status);
        if (std::all_of(frame.runs.begin(), frame.runs.end(), has_ended)) close(frame);
      });
}

// Ends a frame of which no job has been traced.
void Service::drop(Frame& frame, sideray_status status) {
  frame.readback = {};
  for (JobRun& run : frame.runs) run.textures = {};
  for (size_t i = 0; i < job_count; ++i)
    if (!has_ended(frame.runs[i])) end_job(frame, i, status);
  close(frame);
}

ReadbackRequest Service::readback_request(const Frame& frame) const {
  const FrameInputs& in = frame.inputs;
  const bool stencil = std::any_of(frame.view->jobs.begin(), frame.view->jobs.end(), [&](const Job* job) {
    return (jobs_of(in) & job->bit()) && job->reads_stencil(in);
  });
  if (!transport_) return {in.source, policy_of(in), stencil, false};
  return {in.source, policy_of(in), stencil, transport_->persistent_readback, transport_->packer.get()};
}

void Service::start_readback(Frame& frame) {
  const gl::StatePolicy policy = policy_of(frame.inputs);
  if (!transport_) {
    const gl::PixelTransferGuard transfer(gl_, policy);
    const gl::FramebufferGuard framebuffers(gl_, policy);
    const gl::TextureGuard textures(gl_, 0, 1, policy);
    gl_.ActiveTexture(GL_TEXTURE0);
    transport_ = choose_transport(gl_, readback_request(frame), copiers_);
  }
  if (frame.inputs.inspection.timed) gl_.Finish();
  frame.watch = {};
  const gl::PixelTransferGuard transfer(gl_, policy);
  const gl::FramebufferGuard framebuffers(gl_, policy);
  frame.readback.start(gl_, readback_request(frame));
  uint64_t bytes = frame.readback.bytes();
  for (size_t i = 0; i < job_count; ++i) {
    JobRun& run = frame.runs[i];
    TextureReads reads{};
    if (!has_ended(run)) reads = frame.view->jobs[i]->texture_reads(frame.inputs);
    for (size_t k = 0; k < reads.size(); ++k) {
      run.textures[k].start(gl_, reads[k].name, reads[k].texture, rectangle_of(frame.inputs.source), reads[k].texel);
      bytes += run.textures[k].bytes();
    }
  }
  frame.readback.issue_fence(gl_);
  frame.counters.bytes_readback = bytes;
}

void Service::finish_readback(Frame& frame) {
  const gl::PixelTransferGuard transfer(gl_, policy_of(frame.inputs));
  for (JobRun& run : frame.runs)
    for (TextureReadback& texture : run.textures) texture.map(gl_);
  frame.depth = frame.readback.map(gl_);
  frame.counters.readback_ms = frame.watch.ms();
  frame.state = Frame::State::mapped;
  const FrameInputs& in = frame.inputs;
  if (in.budget_ms <= 0.0f) return;
  frame.end = budget_.begin(in.view_id, in.budget_ms);
  for (size_t i = 0; i < job_count; ++i)
    if (!has_ended(frame.runs[i])) {
      budget_.expect(in.view_id, i);
      frame.runs[i].is_expected = true;
    }
}

void Service::release_readback(Frame& frame) {
  const gl::PixelTransferGuard transfer(gl_, policy_of(frame.inputs));
  for (JobRun& run : frame.runs)
    for (TextureReadback& texture : run.textures) texture.finish(gl_);
  frame.readback.finish(gl_);
}

bool Service::needs_context(const Frame& frame) const {
  if (frame.state == Frame::State::free) return false;
  if (frame.state == Frame::State::reading) return true;
  const auto can_move = [&](const JobRun& run) {
    return run.state == JobRun::State::traced || (run.state == JobRun::State::tracing && queue_->is_traced(run));
  };
  return std::any_of(frame.runs.begin(), frame.runs.end(), can_move) ||
         std::all_of(frame.runs.begin(), frame.runs.end(), has_ended);
}

void Service::move_on(Frame& frame, const gl::ErrorGuard& errors) {
  // Drops a cancelled frame at once, so that a fence that never signals cannot block a place in the ring.
  if (frame.state == Frame::State::reading && frame.cancelled) return drop(frame, SIDERAY_CANCELLED);
  if (frame.state == Frame::State::reading && frame.readback.ready(poll_ns)) finish_readback(frame);
  if (frame.state != Frame::State::mapped) return;
  start_jobs(frame);
  finish_jobs(frame, errors);
}

void Service::start_jobs(Frame& frame) {
  if (frame.state != Frame::State::mapped) return;
  for (size_t i = 0; i < job_count; ++i) {
    JobRun& run = frame.runs[i];
    if (run.state != JobRun::State::waiting) continue;
    if (frame.cancelled) {
      end_job(frame, i, SIDERAY_CANCELLED);
      continue;
    }
    if (!may_start(frame, i)) return;
    if (std::exchange(frame.view->broken[i], false)) run.sequence = rt::SequenceStep::first;
    run.state = JobRun::State::tracing;
    queue_->push(frame, i);
  }
}

// Returns whether a job may start: a view's frames are traced in the order of their tickets, and a job's image must be
// uploaded before it is overwritten.
bool Service::may_start(const Frame& frame, size_t job) {
  return std::none_of(frame.view->frames.begin(), frame.view->frames.end(), [&](const Frame& other) {
    if (&other == &frame || other.state == Frame::State::free) return false;
    const JobRun& same = other.runs[job];
    if (same.state == JobRun::State::tracing || same.state == JobRun::State::traced) return true;
    return other.ticket < frame.ticket &&
           std::any_of(other.runs.begin(), other.runs.end(),
                       [](const JobRun& run) { return run.state == JobRun::State::waiting; });
  });
}

void Service::finish_jobs(Frame& frame, const gl::ErrorGuard& errors) {
  for (JobRun& run : frame.runs)
    if (run.state == JobRun::State::tracing && queue_->is_traced(run)) {
      run.state = JobRun::State::traced;
      run.counters.pixels_total = 0;  // the frame counts them
      frame.counters += run.counters;
    }
  if (std::none_of(frame.runs.begin(), frame.runs.end(), reads_depth)) release_readback(frame);
  for (size_t i = 0; i < job_count; ++i) {
    JobRun& run = frame.runs[i];
    if (run.state != JobRun::State::traced) continue;
    with_errors_told(
        errors, "advance", [&] { finish_job(frame, i, errors); },
        [&](sideray_status status) {
          if (!has_ended(run)) end_job(frame, i, status);
        });
  }
  if (std::all_of(frame.runs.begin(), frame.runs.end(), has_ended)) close(frame);
}

void Service::finish_job(Frame& frame, size_t job, const gl::ErrorGuard& errors) {
  if (frame.runs[job].failure) std::rethrow_exception(frame.runs[job].failure);
  if (frame.cancelled) return end_job(frame, job, SIDERAY_CANCELLED);
  upload(frame, job, errors);
  end_job(frame, job, SIDERAY_OK);
}

// Does everything that can fail before it changes texels: a job that fails leaves its last good outputs as they are.
void Service::upload(Frame& frame, size_t index, const gl::ErrorGuard& errors) {
  Job& job = *frame.view->jobs[index];
  const JobFrame job_frame = frame.job_frame(frame.runs[index]);
  const gl::StatePolicy policy = policy_of(frame.inputs);
  const bool timed = frame.inputs.inspection.timed;
  if (timed) gl_.Finish();
  const Stopwatch watch;
  const double busy = busy_ms();
  {
    const gl::PixelTransferGuard transfer(gl_, policy);
    const gl::TextureGuard textures(gl_, 0, 1, policy);
    gl_.ActiveTexture(GL_TEXTURE0);
    job.prepare(gl_, job_frame);
  }
  errors.check("upload");
  {
    const gl::PixelTransferGuard transfer(gl_, policy);
    const gl::TextureGuard textures(gl_, 0, 1, policy);
    gl_.ActiveTexture(GL_TEXTURE0);
    frame.counters.bytes_upload += job.upload(gl_, job_frame, upload_way());
  }
  if (timed) gl_.Finish();
  frame.counters.upload_ms += watch.ms();
  if (frame.inputs.budget_ms > 0.0f) budget_.uploaded(frame.inputs.view_id, index, busy_ms() - busy);
  frame.counters.bytes_cache += job.texture_bytes();
  job.publish(job_frame);
  frame.view->shown[index] = frame.snapshot;
}

void Service::end_job(Frame& frame, size_t job, sideray_status status) {
  JobRun& run = frame.runs[job];
  if (status != SIDERAY_OK) {
    if (run.is_expected && run.state == JobRun::State::waiting) budget_.drop(frame.inputs.view_id, job);
    frame.view->broken[job] = true;
    if (run.state == JobRun::State::traced) frame.view->jobs[job]->give_up();
  }
  run.state = JobRun::State::ended;
  run.status = status;
}

rt::ShadingQueue* Service::queue_of(const Frame& frame) {
  return frame.snapshot->shader.thread == SIDERAY_SHADE_IN_CALLS ? &tracer_->shading : nullptr;
}

void Service::trace(Frame& frame, size_t index) {
  const FrameInputs& in = frame.inputs;
  if (!tracer_->turn.lock_unless(frame.cancelled)) {
    if (in.budget_ms > 0.0f) budget_.drop(in.view_id, index);
    return;
  }
  const std::lock_guard turn(tracer_->turn, std::adopt_lock);
  Job& job = *frame.view->jobs[index];
  JobRun& run = frame.runs[index];
  rt::WorkTime work = time_of(job, in, frame.watch.start());
  rt::PiecesLeft pieces(in.budget_pieces);
  FrameBudget::Turn budgeted{};
  if (in.budget_ms > 0.0f) {
    std::array<bool, job_count> later{};
    for (size_t i = index + 1; i < job_count; ++i) later[i] = (jobs_of(in) & frame.view->jobs[i]->bit()) != 0;
    budgeted = budget_.start(in.view_id, index, later, frame.end);
    work = budgeted.work();
  }
  if (in.budget_pieces > 0) work.pieces = &pieces;
  tracer_->use(frame.snapshot);
  std::array<std::span<const std::byte>, most_textures_read> textures;
  std::array<bool, most_textures_read> are_halfs{};
  for (size_t i = 0; i < textures.size(); ++i) {
    textures[i] = run.textures[i].texels<std::byte>();
    are_halfs[i] = run.textures[i].are_halfs();
  }
  run.counters = job.trace(frame.job_frame(run), {.tracer = tracer_->tracer,
                                                  .depth = frame.depth,
                                                  .mask_bytes = frame.readback.mask(),
                                                  .textures = textures,
                                                  .are_halfs = are_halfs,
                                                  .subpixel = subpixel_ + (frame.readback.multisampled() ? half_pixel : 0.0f),
                                                  .cancelled = frame.cancelled,
                                                  .work = work,
                                                  .frame = {&frame.view->trail, frame.ticket},
                                                  .shading_queue = queue_of(frame)});
  if (in.budget_ms <= 0.0f) return;
  budget_.finish(in.view_id, index, budgeted, run.counters);
  run.counters.jobs_starved = budgeted.starved;
}

}  // namespace sideray::bridge
