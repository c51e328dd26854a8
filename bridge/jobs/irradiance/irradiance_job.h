// Traces the light that other surfaces reflect onto the opaque surfaces of a view. Threads: those of Job.
#pragma once

#include "bridge/jobs/light_job.h"
#include "rt/irradiance/irradiance_history.h"

namespace sideray::bridge {

class IrradianceJob final : public LightJob<sideray_irradiance_outputs, rt::IrradianceHistory> {
 public:
  uint32_t bit() const override { return SIDERAY_JOB_IRRADIANCE; }
  void check(const gl::Functions&, const FrameInputs&, const model::Snapshot&) const override {}
  // Shares the remaining time equally with the jobs behind it.
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
