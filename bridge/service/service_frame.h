// What the service keeps of a frame in flight, and of a view from frame to frame. GL thread, but for what the worker
// has while a frame is in state tracing.
#pragma once

#include <sideray/sideray.h>

#include <array>
#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <vector>

#include "bridge/results/mask_denoiser.h"
#include "bridge/results/mask_textures.h"
#include "bridge/results/reflection_texture.h"
#include "bridge/results/result_textures.h"
#include "bridge/transport/readback.h"
#include "gl/resources/state_guard.h"
#include "rt/base/counters.h"
#include "rt/composite/composite_image.h"
#include "rt/layers/layer_request.h"
#include "rt/layers/temporal_history.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/mask_request.h"
#include "rt/reflections/reflection_request.h"

namespace sideray::bridge {

struct ServiceView;

struct ServiceFrame {
  enum class State { free, reading, read, tracing, traced };
  State state = State::free;
  ServiceView* view = nullptr;  // whose place it has
  sideray_ticket ticket = 0;
  sideray_frame_inputs inputs{};
  std::shared_ptr<const model::Snapshot> snapshot;  // the scene as it was when the frame was submitted
  uint32_t light_samples = 0;
  bool check = false;
  rt::LayerWeights weights = rt::LayerWeights::covers;
  std::vector<uint32_t> drawn;
  rt::SequenceStep sequence = rt::SequenceStep::first;
  Readback readback;
  rt::DepthImage depth{};
  std::chrono::steady_clock::time_point issued;
  rt::Deadline deadline, mask_deadline;
  std::atomic<bool> cancelled{false};
  bool trace_finished = false;  // guarded by the service's mutex, like the next
  std::exception_ptr failure;
  sideray_frame_stats stats{};
};

struct ServiceView {
  ServiceView() {
    for (ServiceFrame& frame : frames) frame.view = this;
  }

  std::array<ServiceFrame, 3> frames;
  gl::StatePolicy policy = gl::StatePolicy::restore;  // of the last frame submitted
  bool sequence_broken = false;                       // the next frame to be traced follows none
  sideray_ticket cache_ticket = 0;                    // whose answers the cache holds, or is about to

  // Results: written by the worker while one of the frames is in state tracing, read by the GL thread otherwise.
  rt::LayerCache cache;
  rt::CompositeImage composite;
  rt::OcclusionMasks masks;
  rt::ReflectionImage reflections;
  rt::LayerTruth truth;
  rt::LayerHistory history;  // the worker's, like the next
  rt::MaskFilters mask_filters;

  CacheTextures cache_textures;
  CompositeTextures composite_textures;
  MaskTextures mask_textures;
  MaskDenoiser mask_denoiser;
  ReflectionTexture reflection_texture;

  // The newest finished frame: what hosts are told, and what its binding needs besides.
  sideray_frame_outputs latest{};
  struct {
    sideray_match match;
    float threshold;
    sideray_cache_rate rate;
  } latest_inputs{};

  // Without OpenGL.
  void abandon() {
    for (ServiceFrame& frame : frames) frame.readback.abandon();
    cache_textures.abandon(), composite_textures.abandon();
    mask_textures.abandon(), mask_denoiser.abandon();
    reflection_texture.abandon();
    latest = {};
  }
};

}  // namespace sideray::bridge
