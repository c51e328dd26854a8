// The job that traces what glossy opaque surfaces of a view mirror. Threads: those of Job.
#pragma once

#include "bridge/jobs/job.h"
#include "bridge/jobs/light_texture.h"
#include "rt/history/still_frames.h"
#include "rt/reflections/older_reflections.h"

namespace sideray::bridge {

class ReflectionJob final : public Job {
 public:
  uint32_t bit() const override { return SIDERAY_JOB_REFLECTIONS; }
  void check(const gl::Functions& gl, const FrameInputs& inputs, const model::Snapshot& snapshot) const override;
  bool reads_stencil(const FrameInputs&) const override { return false; }
  TextureReads texture_reads(const FrameInputs& inputs) const override;
  // Half where layers come after it.
  double share_of_time(const FrameInputs& inputs) const override { return inputs.layers ? 0.5 : 1.0; }
  rt::Counters trace(const JobFrame& frame, const TraceInput& input) override;
  void prepare(const gl::Functions& gl, const JobFrame& frame) override;
  uint64_t upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) override;
  void publish(const JobFrame& frame) override;
  uint64_t texture_bytes() const override { return texture_.bytes(); }
  void give_up() override { still_.forget(); }
  void abandon() override;

  const rt::ReflectionImage& image() const { return image_; }
  const sideray_reflection_outputs& outputs() const { return outputs_; }  // ticket 0: none yet

 private:
  LightImage light() const { return {"reflections", image_.width, image_.height, image_.radiance.data()}; }

  rt::ReflectionImage image_;
  rt::StillFrames still_;
  rt::OlderReflections older_;
  LightTexture texture_;
  sideray_reflection_outputs outputs_{};
};

}  // namespace sideray::bridge
