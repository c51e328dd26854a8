// Holds a frame in flight with its jobs, and what a view keeps from frame to frame. GL thread, except for the worker's
// part while a job is in state tracing.
#pragma once

#include <sideray/sideray.h>

#include <array>
#include <atomic>
#include <exception>
#include <memory>

#include "bridge/base/frame_inputs.h"
#include "bridge/jobs/irradiance/irradiance_job.h"
#include "bridge/jobs/job.h"
#include "bridge/jobs/layers/layer_job.h"
#include "bridge/jobs/masks/mask_job.h"
#include "bridge/jobs/reflections/reflection_job.h"
#include "bridge/transport/readback.h"
#include "gl/resources/state_guard.h"
#include "model/stopwatch.h"
#include "rt/tracer.h"

namespace sideray::bridge {

struct ServiceView;

inline constexpr size_t job_count = 4;

// Holds the progress of one job of a frame.
struct JobRun {
  enum class State {
    ended,    // with `status`, or the frame has no such job
    waiting,  // for the frame's depth, or for the job's image
    tracing,  // owned by the worker, or about to be
    traced    // ready for upload
  };
  State state = State::ended;
  bool is_expected = false;            // by the budget, until the worker takes it
  sideray_status status = SIDERAY_OK;  // once ended: OK = uploaded
  rt::SequenceStep sequence = rt::SequenceStep::first;
  std::array<TextureReadback, most_textures_read> textures;
  rt::Counters counters;  // owned by the worker in state tracing, like the next
  std::exception_ptr failure;
  bool trace_finished = false;  // guarded by the queue's mutex
};

struct ServiceFrame {
  enum class State { free, reading, mapped };
  State state = State::free;
  ServiceView* view = nullptr;  // the view that it belongs to
  sideray_ticket ticket = 0;
  FrameInputs inputs;
  std::shared_ptr<const model::Snapshot> snapshot;  // the scene as it was when the frame was submitted
  Readback readback;
  rt::DepthImage depth{};
  Stopwatch watch;  // since readback was issued
  std::atomic<bool> cancelled{false};
  rt::Deadline end;  // when a frame with a budget must end
  std::array<JobRun, job_count> runs;  // in the order of ServiceView::jobs
  rt::Counters counters;

  // Returns which of its jobs are uploaded.
  uint32_t finished_jobs() const;
  JobFrame job_frame(const JobRun& run) const { return {inputs, ticket, *snapshot, run.sequence, readback.multisampled()}; }
};

struct ServiceView {
  ServiceView() {
    for (ServiceFrame& frame : frames) frame.view = this;
  }
  ServiceView(const ServiceView&) = delete;
  ServiceView& operator=(const ServiceView&) = delete;

  std::array<ServiceFrame, 3> frames;
  gl::StatePolicy policy = gl::StatePolicy::restore;  // of the last frame submitted
  MaskJob masks;
  IrradianceJob irradiance;
  LayerJob layers{masks.image(), irradiance.image()};
  ReflectionJob reflections;
  const std::array<Job*, job_count> jobs{&masks, &irradiance, &reflections, &layers};  // in tracing order
  std::array<std::shared_ptr<const model::Snapshot>, job_count> shown;  // the scene of each job's newest outputs
  rt::PixelTrail trail;  // where each pixel was in the previous frame, for all jobs; used by the worker thread alone
  std::array<bool, job_count> broken{};  // the next frame of the job starts a new history

  // Drops all OpenGL objects without calling OpenGL.
  void abandon() {
    for (ServiceFrame& frame : frames) {
      frame.readback.abandon();
      for (JobRun& run : frame.runs)
        for (TextureReadback& texture : run.textures) texture.abandon();
    }
    for (Job* job : jobs) job->abandon();
    shown = {};
  }
};

}  // namespace sideray::bridge
