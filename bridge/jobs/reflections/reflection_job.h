// Traces the reflections of glossy opaque surfaces of a view. Threads: those of Job.
#pragma once

#include "bridge/jobs/light_job.h"
#include "rt/reflections/older_reflections.h"

namespace sideray::bridge {

class ReflectionJob final : public LightJob<sideray_reflection_outputs, rt::OlderReflections> {
 public:
  uint32_t bit() const override { return SIDERAY_JOB_REFLECTIONS; }
  void check(const gl::Functions& gl, const FrameInputs& inputs, const model::Snapshot& snapshot) const override;
  TextureReads texture_reads(const FrameInputs& inputs) const override;
  // Returns half of the remaining time if layers are traced after this job.
  double share_of_time(const FrameInputs& inputs) const override { return inputs.layers ? 0.5 : 1.0; }
  rt::Counters trace(const JobFrame& frame, const TraceInput& input) override;

  const rt::ReflectionImage& image() const { return image_; }
  // Returns the same as OlderReflections::answers(); empty: all reflections were traced in the last frame.
  std::vector<uint8_t> answers() const { return looks_back_ ? history_.answers() : std::vector<uint8_t>(); }

 private:
  LightImage light() const override {
    return {"reflections", image_.width, image_.height, image_.radiance.data(), image_.changed};
  }

  rt::ReflectionImage image_;
  bool looks_back_ = false;  // the last frame may show history
};

}  // namespace sideray::bridge
