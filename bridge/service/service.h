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

#include "bridge/base/handles.h"
#include "bridge/service/service_frame.h"
#include "bridge/transport/transport.h"
#include "gl/context/functions.h"
#include "gl/resources/error_guard.h"

namespace sideray::bridge {

class Service {
 public:
  // Keeps one reference to `tracer`.
  Service(sideray_tracer* tracer, gl::Functions functions);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  // 0 where the ring is full. Throws Failure on bad inputs.
  sideray_ticket submit(const sideray_frame_inputs& inputs);
  void advance();
  // Whether the frame was finished within the time; negative = no limit. Throws Failure (CANCELLED) for a cancelled
  // one.
  bool wait(sideray_ticket ticket, int32_t timeout_ms);
  void cancel(sideray_ticket ticket);
  bool latest(uint32_t view_id, sideray_frame_outputs& outputs) const;
  // `space_origin`: where the program's positions are measured from; 0 = world space.
  void bind(uint32_t view_id, uint32_t program, uint32_t first_unit, glm::dvec3 space_origin);
  sideray_frame_stats stats(sideray_ticket ticket) const;
  void abandon_context();
  // Chosen with the first frame.
  std::optional<Transport> transport() const { return transport_; }

  // For the offscreen tier, whose frames are all of view 0: wait for the GPU around readback and upload, so that their
  // times stand alone.
  void set_timed(bool timed) { timed_ = timed; }
  const rt::LayerCache& cache() const { return views_[0]->cache; }
  const rt::OcclusionMasks& masks() const { return views_[0]->masks; }
  const rt::CompositeImage& composite() const { return views_[0]->composite; }
  // Of the frames submitted from now on: above 0, COMPOSITE shades surfaces as the reference does.
  void set_light_samples(uint32_t samples) { light_samples_ = samples; }
  // Of the frames submitted from now on: CACHE also traces what its layers are checked against.
  void set_check(bool check) { check_ = check; }
  // Later frames' masks tell the distance of every occluder near a shadow's edge.
  void set_hit_distances(bool wanted) { hit_distances_ = wanted; }
  // Later frames' masks and reflections start where rays meet what the pixel shows, not where its depth has it.
  void set_exact_points(bool exact) { exact_points_ = exact; }
  // Of the frames submitted from now on: what is known of how CACHE's layers are blended, for layer_threshold. `drawn`:
  // rt::FrameRequest::drawn.
  void set_weights(rt::LayerWeights weights, std::vector<uint32_t> drawn) {
    weights_ = weights, drawn_ = std::move(drawn);
  }
  const rt::LayerTruth& truth() const { return views_[0]->truth; }
  // Of the next frame submitted: it is the last one once more, for its time or for another sample position. Temporal
  // rates start from what was known before that frame.
  void set_again(bool again) { again_ = again; }

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
