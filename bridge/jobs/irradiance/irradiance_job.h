// The job that traces what other surfaces throw on the opaque ones of a view. Threads: those of Job.
#pragma once

#include "bridge/jobs/light_job.h"
#include "rt/irradiance/irradiance_history.h"

namespace sideray::bridge {

class IrradianceJob final : public LightJob<sideray_irradiance_outputs, rt::IrradianceHistory> {
 public:
  uint32_t bit() const override { return SIDERAY_JOB_IRRADIANCE; }
  void check(const gl::Functions&, const FrameInputs&, const model::Snapshot&) const override {}
  // It takes an equal share of the time that is left with each job behind it.
  double share_of_time(const FrameInputs& inputs) const override {
    return 1.0 / (1.0 + (inputs.reflections ? 1.0 : 0.0) + (inputs.layers ? 1.0 : 0.0));
  }
  rt::Counters trace(const JobFrame& frame, const TraceInput& input) override;

  const rt::IrradianceImage& image() const { return image_; }

 private:
  LightImage light() const override {
    return {"irradiance", image_.width, image_.height, image_.light.data(), image_.changed};
  }

  rt::IrradianceImage image_;
};

}  // namespace sideray::bridge
