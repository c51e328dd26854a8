// Traces the translucent surfaces of a view: layers of a cache, or their composite. Threads: those of Job.
#pragma once

#include "bridge/jobs/job.h"
#include "bridge/jobs/layers/layer_textures.h"
#include "rt/cache/older_layers.h"
#include "rt/history/still_frames.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/masks/mask_request.h"

namespace sideray::bridge {

class LayerJob final : public Job {
 public:
  // Holds the parameters of lookups in the newest outputs, for binding.
  struct Lookup {
    sideray_match match = SIDERAY_MATCH_ID;
    float threshold = 0.0f;
    sideray_cache_rate rate = SIDERAY_RATE_FULL;
    bool refracts = false;
    bool older = false;  // some layers were reprojected from earlier frames
    bool multisampled = false;
    bool float_ids = false;
  };

  // Refers to the view's masks and irradiance: what glass shows of the picture has their light. The caller keeps both alive.
  LayerJob(const rt::OcclusionMasks& masks, const rt::IrradianceImage& irradiance) : masks_(masks), irradiance_(irradiance) {}

  uint32_t bit() const override { return SIDERAY_JOB_LAYERS; }
  void check(const gl::Functions& gl, const FrameInputs& inputs, const model::Snapshot& snapshot) const override;
  bool reads_stencil(const FrameInputs& inputs) const override;
  rt::Counters trace(const JobFrame& frame, const TraceInput& input) override;
  void prepare(const gl::Functions& gl, const JobFrame& frame) override;
  uint64_t upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) override;
  void publish(const JobFrame& frame) override;
  uint64_t texture_bytes() const override;
  void give_up() override;
  void abandon() override;

  const rt::LayerCache& cache() const { return cache_; }
  const rt::LayerTruth& truth() const { return truth_; }
  const rt::CompositeImage& composite() const { return composite_; }
  // Returns the same as OlderLayers::answers(); empty: all layers were traced in the last frame.
  std::vector<uint8_t> answers() const { return looks_back_ ? older_.answers() : std::vector<uint8_t>(); }
  const sideray_layer_outputs& outputs() const { return outputs_; }  // ticket 0: none yet
  const Lookup& lookup() const { return lookup_; }

 private:
  void check_second_wave(const FrameInputs& inputs) const;
  rt::PixelLight pixel_light(const FrameInputs& inputs) const;
  void fill(rt::LayerRequest& request, const JobFrame& frame, const TraceInput& input) const;
  rt::CacheRequest cache_request(const JobFrame& frame, const TraceInput& input);
  rt::Counters trace_cache(const JobFrame& frame, const TraceInput& input);
  rt::Counters trace_composite(const JobFrame& frame, const TraceInput& input);

  const rt::OcclusionMasks& masks_;
  const rt::IrradianceImage& irradiance_;
  rt::LayerCache cache_;
  rt::CompositeImage composite_;
  rt::LayerTruth truth_;
  rt::StillFrames still_;
  rt::OlderLayers older_;
  sideray_ticket cache_ticket_ = 0;  // the frame whose answers the cache holds, or is about to
  CacheTextures cache_textures_;
  CompositeTextures composite_textures_;
  bool caches_ = true;  // the last upload filled the cache's textures
  bool looks_back_ = false;  // the cache may hold history
  bool float_ids_ = false;  // the textures hold float ids
  sideray_layer_outputs outputs_{};
  Lookup lookup_;
};

}  // namespace sideray::bridge
