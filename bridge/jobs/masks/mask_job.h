// Traces the visible share of lights and sky in the opaque pixels of a view, and filters it. Threads: those of Job.
#pragma once

#include "bridge/jobs/job.h"
#include "bridge/jobs/masks/mask_textures.h"
#include "rt/history/frame_camera.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/older_masks.h"

namespace sideray::bridge {

class MaskJob final : public Job {
 public:
  uint32_t bit() const override { return SIDERAY_JOB_MASKS; }
  void check(const gl::Functions& gl, const FrameInputs& inputs, const model::Snapshot& snapshot) const override;
  bool reads_stencil(const FrameInputs& inputs) const override;
  TextureReads texture_reads(const FrameInputs& inputs) const override;
  double share_of_time(const FrameInputs& inputs) const override;
  rt::Counters trace(const JobFrame& frame, const TraceInput& input) override;
  void prepare(const gl::Functions& gl, const JobFrame& frame) override;
  uint64_t upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) override;
  void publish(const JobFrame& frame) override;
  uint64_t texture_bytes() const override { return textures_.bytes(); }
  void give_up() override { kept_.forget(); }
  void abandon() override;

  const rt::OcclusionMasks& image() const { return image_; }
  // Returns the same as OlderMasks::answers(); empty: all masks were traced in the last frame.
  std::vector<uint8_t> answers(rt::OlderMasks::Part part) const {
    return looks_back_ ? older_.answers(part) : std::vector<uint8_t>();
  }
  const sideray_mask_outputs& outputs() const { return outputs_; }  // ticket 0: none yet
  // Error bound of a depth d of outputs().depth_texture: x * d * d + y.
  glm::vec2 depth_error(const rt::FrameCamera& camera) const;

 private:
  bool is_held(uint32_t layer) const;

  rt::OcclusionMasks image_;
  rt::MaskFilters filters_;
  rt::KeptMasks kept_;
  rt::OlderMasks older_;
  MaskTextures textures_;
  sideray_mask_outputs outputs_{};
  float depth_step_ = 0;  // of the outputs' depth
  bool shows_ = true;     // the image is to be uploaded
  bool looks_back_ = false;  // the last frame may show history
  bool lacks_some_ = false;  // some uploaded pixels have no answer
};

}  // namespace sideray::bridge
