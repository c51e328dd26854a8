// Runs rays inside a host's frame: takes the jobs of frames through readback, trace and upload, with several frames in
// flight. The worker thread only traces; all OpenGL calls happen on the calling thread, with the host's context
// current.
#pragma once

#include <sideray/sideray.h>

#include <array>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "bridge/base/frame_inputs.h"
#include "bridge/base/handles.h"
#include "bridge/jobs/layers/layer_binding.h"
#include "bridge/service/frame_budget.h"
#include "bridge/service/service_frame.h"
#include "bridge/service/trace_queue.h"
#include "bridge/transport/transport.h"
#include "gl/context/functions.h"
#include "gl/resources/error_guard.h"
#include "rt/tracer.h"

namespace sideray::bridge {

class Service {
 public:
  // Holds a reference to `tracer`.
  Service(sideray_tracer* tracer, gl::Functions functions);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  // Returns 0 where the ring is full. Throws Failure on bad inputs.
  sideray_ticket submit(const FrameInputs& inputs);
  void advance();
  // Returns whether these jobs of the frame (SIDERAY_JOB_*) were uploaded within the time; negative = no limit. Throws
  // Failure where one of them was cancelled or failed.
  bool wait(sideray_ticket ticket, uint32_t jobs, int32_t timeout_ms);
  // Returns which jobs of the frame are uploaded. Calls no OpenGL. Throws Failure where the ticket is unknown.
  uint32_t finished_jobs(sideray_ticket ticket) const;
  void cancel(sideray_ticket ticket);
  // Return the newest finished outputs of a view; false before the first.
  bool layers(uint32_t view_id, sideray_layer_outputs& outputs) const;
  bool masks(uint32_t view_id, sideray_mask_outputs& outputs) const;
  bool irradiance(uint32_t view_id, sideray_irradiance_outputs& outputs) const;
  bool reflections(uint32_t view_id, sideray_reflection_outputs& outputs) const;
  // Returns the instance's world-from-object matrix in the newest outputs of a job; none if they lack the instance.
  std::optional<glm::dmat4x3> placement(uint32_t view_id, uint32_t job, sideray_instance instance) const;
  // `space_origin`: the origin of the program's positions; 0 = world space.
  void bind(uint32_t view_id, uint32_t program, uint32_t first_unit, glm::dvec3 space_origin);
  // Returns the counters of a frame, of all its jobs together. Throws Failure where they have not all ended.
  const rt::Counters& stats(sideray_ticket ticket) const;
  void abandon_context();

  // Return the last traced images of view 0, for the offscreen renderer, whose frames all have that view.
  const rt::LayerCache& cache() const { return views_[0]->layers.cache(); }
  const rt::LayerTruth& truth() const { return views_[0]->layers.truth(); }  // with Inspection::check
  const rt::CompositeImage& composite() const { return views_[0]->layers.composite(); }
  const rt::OcclusionMasks& mask_image() const { return views_[0]->masks.image(); }
  const MaskJob& mask_job() const { return views_[0]->masks; }
  const ReflectionJob& reflection_job() const { return views_[0]->reflections; }
  const LayerJob& layer_job() const { return views_[0]->layers; }

 private:
  using Clock = Stopwatch::Clock;
  using Frame = ServiceFrame;

  // Describes a frame that has left the ring.
  struct Outcome {
    sideray_ticket ticket;
    uint32_t uploaded;  // SIDERAY_JOB_*
    std::array<sideray_status, job_count> statuses;
    rt::Counters counters;
  };
  // Holds the state of some jobs of a frame.
  struct Progress {
    bool ended;             // all of them have ended
    sideray_status status;  // OK where none of them failed
  };

  void check(const FrameInputs& inputs, const ServiceView& view, const model::Snapshot& snapshot) const;
  void begin(Frame& frame, const FrameInputs& inputs, std::shared_ptr<const model::Snapshot> snapshot);
  void issue(Frame& frame);
  static void release(Frame& frame);
  ServiceView& view_of(uint32_t id);
  Frame* find(sideray_ticket ticket) const;
  const Outcome* outcome(sideray_ticket ticket) const;
  std::optional<Progress> progress(sideray_ticket ticket, uint32_t jobs) const;
  void wait_for_progress(Frame& frame, Clock::time_point deadline);

  // Runs `body` and rethrows its failure, or throws OpenGL's error; calls `on_failure` first.
  void with_errors_told(const gl::ErrorGuard& errors, const char* what, const std::function<void()>& body,
                        const std::function<void(sideray_status)>& on_failure);
  void with_errors_kept(Frame& frame, const char* what, const std::function<void(const gl::ErrorGuard&)>& body);
  void start_readback(Frame& frame);
  void finish_readback(Frame& frame);
  void release_readback(Frame& frame);
  ReadbackRequest readback_request(const Frame& frame) const;

  bool needs_context(const Frame& frame) const;
  void move_on(Frame& frame, const gl::ErrorGuard& errors);
  void start_jobs(Frame& frame);
  static bool may_start(const Frame& frame, size_t job);
  void finish_jobs(Frame& frame, const gl::ErrorGuard& errors);
  void finish_job(Frame& frame, size_t job, const gl::ErrorGuard& errors);
  UploadWay upload_way() { return {transport_->persistent_upload, copiers_}; }
  void upload(Frame& frame, size_t job, const gl::ErrorGuard& errors);
  void end_job(Frame& frame, size_t job, sideray_status status);
  void drop(Frame& frame, sideray_status status);
  void close(Frame& frame);

  // Runs on the worker thread.
  void trace(Frame& frame, size_t job);
  rt::ShadingQueue* queue_of(const Frame& frame);

  sideray_tracer* tracer_;
  gl::Functions gl_;
  float subpixel_;  // the most that the rasterizer snaps a vertex, in pixels
  std::vector<CheckedProgram> checked_programs_;
  uint32_t units_;  // number of texture units
  bool context_lost_ = false;
  std::optional<Transport> transport_;  // chosen with the first frame
  rt::Executor copiers_;  // as many threads as the tracer has, beside those that trace another frame meanwhile
  std::array<std::unique_ptr<ServiceView>, SIDERAY_MAX_VIEWS> views_;  // views with submitted frames, and view 0
  std::vector<Frame*> frames_;                                         // of all views, in no order
  sideray_ticket last_ticket_ = 0;
  std::deque<Outcome> outcomes_;  // of the last frames
  FrameBudget budget_;
  std::unique_ptr<TraceQueue> queue_;
};

}  // namespace sideray::bridge
