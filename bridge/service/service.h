// The ray-tracing service inside a host's frame: readback, trace, upload, as a ring of frames in flight. The worker
// thread only traces; every GL call happens on the thread that calls in, with the host's context current.
#pragma once

#include <sideray/sideray.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "bridge/base/frame_inputs.h"
#include "bridge/base/handles.h"
#include "bridge/service/service_frame.h"
#include "bridge/transport/transport.h"
#include "gl/resources/error_guard.h"
#include "gl/context/functions.h"
#include "rt/tracer.h"

namespace sideray::bridge {

class Service {
 public:
  // Keeps one reference to `tracer`.
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
  // Which jobs of the frame are uploaded. Without OpenGL.
  uint32_t finished_jobs(sideray_ticket ticket) const;
  void cancel(sideray_ticket ticket);
  // The newest finished outputs of a view. False before the first.
  bool layers(uint32_t view_id, sideray_layer_outputs& outputs) const;
  bool masks(uint32_t view_id, sideray_mask_outputs& outputs) const;
  bool reflections(uint32_t view_id, sideray_reflection_outputs& outputs) const;
  // `space_origin`: where the program's positions are measured from; 0 = world space.
  void bind(uint32_t view_id, uint32_t program, uint32_t first_unit, glm::dvec3 space_origin);
  sideray_frame_stats stats(sideray_ticket ticket) const;
  void abandon_context();
  // Chosen with the first frame.
  std::optional<Transport> transport() const { return transport_; }

  // What the jobs of view 0 have traced last, for the offscreen tier, whose frames are all of that view.
  const rt::LayerCache& cache() const;
  const rt::LayerTruth& truth() const;  // Offscreen::check
  const rt::CompositeImage& composite() const;
  const rt::OcclusionMasks& mask_image() const;

 private:
  using Clock = std::chrono::steady_clock;

  using Frame = ServiceFrame;

  struct Outcome {
    sideray_ticket ticket;
    sideray_frame_stats stats;
    sideray_status status;
  };

  void choose_transport(const sideray_frame_inputs& inputs);
  ServiceView& view_of(uint32_t id);
  Frame* find(sideray_ticket ticket);
  const Outcome* outcome(sideray_ticket ticket) const;
  void with_errors_kept(Frame& frame, const char* what, const std::function<void(const gl::ErrorGuard&)>& body);
  void start_readback(Frame& frame);
  bool is_idle(const Frame& frame);
  void move_on(Frame& frame, const gl::ErrorGuard& errors);
  void give_up_reading(Frame& frame);
  void finish_readback(Frame& frame);
  static void check_addition(const ServiceView& view, const sideray_frame_inputs& inputs);
  void start_trace(Frame& frame);
  void take_trace(Frame& frame);
  void upload(Frame& frame, const gl::ErrorGuard& errors);
  void prepare_upload(Frame& frame);
  void move_texels(Frame& frame);
  uint64_t bytes_cached(const Frame& frame) const;
  void publish(const Frame& frame);
  MaskDenoiser::Input denoiser_input(const Frame& frame) const;
  void denoise_masks(Frame& frame);
  void set_layer_uniforms(uint32_t program, const ServiceView& view, glm::dvec3 space_origin) const;
  void set_deadlines(Frame& frame);
  void trace_layers(Frame& frame);
  rt::ShadingQueue* queue_of(const Frame& frame);
  static bool is_shaded_by_host(const Frame& frame) { return frame.snapshot->shader.shade != nullptr; }
  void trace_masks(Frame& frame);
  void trace_reflections(Frame& frame);
  std::vector<rt::OpaquePoint> exact_points(const Frame& frame);
  void close(Frame& frame, sideray_status status);
  void wait_for_progress(Frame& frame, Clock::time_point deadline);
  void work(std::stop_token stop);
  void trace(Frame& frame);

  sideray_tracer* tracer_;
  gl::Functions gl_;
  float subpixel_;  // by how much of a pixel the rasterizer moves a vertex, at most
  uint32_t units_;  // that textures can be bound to
  bool context_lost_ = false, timed_ = false, again_ = false;
  uint32_t light_samples_ = 0;
  bool check_ = false;
  bool hit_distances_ = false, exact_points_ = false;
  rt::LayerWeights weights_ = rt::LayerWeights::covers;
  std::vector<uint32_t> drawn_;
  std::optional<Transport> transport_;

  std::array<std::unique_ptr<ServiceView>, SIDERAY_MAX_VIEWS> views_;  // those that frames were submitted of, and 0
  std::vector<Frame*> frames_;                                         // of all of them, in no order
  sideray_ticket last_ticket_ = 0;
  std::deque<Outcome> outcomes_;  // of the last finished frames

  std::mutex mutex_;
  std::condition_variable_any work_ready_, trace_done_;
  std::deque<Frame*> work_;  // guarded by mutex_: at most one of each view, traced one by one
  std::jthread worker_;
};

}  // namespace sideray::bridge
