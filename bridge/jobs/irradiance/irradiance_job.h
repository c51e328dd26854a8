// The job that traces what other surfaces throw on the opaque ones of a view. Threads: those of Job.
#pragma once

#include "bridge/jobs/job.h"
#include "bridge/jobs/light_texture.h"
#include "rt/history/still_frames.h"
#include "rt/irradiance/irradiance_history.h"

namespace sideray::bridge {

class IrradianceJob final : public Job {
 public:
  uint32_t bit() const override { return SIDERAY_JOB_IRRADIANCE; }
  void check(const gl::Functions&, const FrameInputs&, const model::Snapshot&) const override {}
  bool reads_stencil(const FrameInputs&) const override { return false; }
  // It takes an equal share of the time that is left with each job behind it.
  double share_of_time(const FrameInputs& inputs) const override {
    return 1.0 / (1.0 + (inputs.reflections ? 1.0 : 0.0) + (inputs.layers ? 1.0 : 0.0));
  }
  rt::Counters trace(const JobFrame& frame, const TraceInput& input) override;
  void prepare(const gl::Functions& gl, const JobFrame& frame) override;
  uint64_t upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) override;
  void publish(const JobFrame& frame) override;
  uint64_t texture_bytes() const override { return texture_.bytes(); }
  void give_up() override { still_.forget(); }
  void abandon() override;

  const rt::IrradianceImage& image() const { return image_; }
  const sideray_irradiance_outputs& outputs() const { return outputs_; }  // ticket 0: none yet

 private:
  LightImage light() const { return {"irradiance", image_.width, image_.height, image_.light.data()}; }

  rt::IrradianceImage image_;
  rt::StillFrames still_;
  rt::IrradianceHistory history_;
  LightTexture texture_;
  sideray_irradiance_outputs outputs_{};
};

}  // namespace sideray::bridge
