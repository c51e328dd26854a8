// A job whose output is one texture of light for a view's opaque pixels. Threads: those of Job.
#pragma once

#include <concepts>
#include <span>
#include <vector>

#include "bridge/jobs/job.h"
#include "bridge/jobs/light_texture.h"
#include "model/stopwatch.h"
#include "rt/history/still_frames.h"
#include "rt/opaque/light_request.h"

namespace sideray::bridge {

// Returns the part of the request that all jobs of light share.
rt::LightRequest light_request(const JobFrame& frame, const TraceInput& input, std::span<const rt::OpaquePoint> points,
                               bool denoise, rt::StillFrames& still);

// Returns the points that rays find, if rays also found the inputs' depth; otherwise none.
std::vector<rt::OpaquePoint> exact_points(const JobFrame& frame, const TraceInput& input);

// `Outputs` is the public struct; `History` holds the results of earlier frames.
template <typename Outputs, typename History>
class LightJob : public Job {
 public:
  bool reads_stencil(const FrameInputs&) const override { return false; }
  void prepare(const gl::Functions& gl, const JobFrame&) override { texture_.prepare(gl, light()); }
  uint64_t upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) override {
    const LightImage image = light();
    return image.changed ? texture_.upload(gl, image, frame.inputs.inspection.wanted_light.get(), way) : 0;
  }
  void publish(const JobFrame& frame) override {
    const sideray_frame_source& source = frame.inputs.source;
    outputs_ = {sizeof(outputs_), frame.ticket, frame.inputs.view, source.x,
                source.y,         source.width, source.height,     texture_.id()};
  }
  uint64_t texture_bytes() const override { return texture_.bytes(); }
  void give_up() override { still_.forget(); }
  void abandon() override {
    still_.forget();
    texture_.abandon();
    outputs_ = {};
  }

  const Outputs& outputs() const { return outputs_; }  // ticket 0: none yet

 protected:
  virtual LightImage light() const = 0;

  // Fills the image by `trace`, which returns counters, and times it. No frame follows a cancelled one.
  rt::Counters fill(const TraceInput& input, const std::invocable auto& trace) {
    const Stopwatch watch;
    rt::Counters counters = trace();
    counters.trace_ms = watch.ms() - counters.denoise_ms;
    if (input.cancelled) still_.forget(), history_.forget();
    return counters;
  }

  rt::StillFrames still_;
  History history_;

 private:
  LightTexture texture_;
  Outputs outputs_{};
};

}  // namespace sideray::bridge
