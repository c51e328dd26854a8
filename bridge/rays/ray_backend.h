// Draws frames without OpenGL: rays find the opaque surface of each pixel, the service's jobs trace masks, reflections
// and translucent surfaces from there, and the picture is composed in memory. One thread at a time; no OpenGL library
// is opened.
#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <string>

#include "bridge/drawing/picture_job.h"
#include "bridge/jobs/layers/layer_job.h"
#include "bridge/jobs/masks/mask_job.h"
#include "bridge/jobs/irradiance/irradiance_job.h"
#include "bridge/jobs/reflections/reflection_job.h"
#include "bridge/service/frame_budget.h"
#include "rt/drawing/opaque_pixels.h"
#include "rt/drawing/temporal_average.h"

namespace sideray::bridge {

class RayBackend final : public Backend {
 public:
  // `reason`: why OpenGL is not used; empty: it was not requested.
  explicit RayBackend(std::string reason);

  const gl::DeviceInfo& device() const override { return info_; }
  Drawing drawing() const override { return Drawing::rays; }
  void begin_call() override {}
  void end_call() override {}
  void require_no_errors() override {}
  void change_scene(const sideray_scene* scene) override;
  void forget_scene(const sideray_scene* scene) override { others_.erase(scene); }
  void set_tracer(sideray_tracer* tracer) override { tracer_ = tracer; }
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot) override { snapshot_ = std::move(snapshot); }
  void set_culled(std::span<const uint8_t>) override {}
  void resize(uint32_t width, uint32_t height) override;
  gl::RasterView make_view(const sideray_camera& camera, glm::vec2 jitter) const override;
  FrameCounters draw(PictureJob& job, const FramePosition& position, FrameTimer& timer, Fragments fragments) override;
  void finish() override {}
  void forget_shadow_maps() override {}
  bool draws_parts() const override { return false; }
  void average(const gl::FrameBefore&) override {}
  void keep_average() override { average_.keep(); }
  void forget_averages() override { average_.forget(); }
  void replace_average(const std::vector<glm::vec4>& picture) override { average_.replace(picture); }
  std::vector<glm::vec4> read_color() override { return picture_; }
  std::vector<float> read_depth() override { return pixels_.depths; }
  // Returns zeros: no pixel is marked.
  std::vector<uint8_t> read_stencil() override { return std::vector<uint8_t>(pixels_.depths.size(), 0); }
  rt::OpaqueMaterials read_gbuffer() override;
  std::vector<glm::uvec2> read_ids() override;
  std::vector<glm::vec2> read_motion() override { return motion_; }
  std::vector<uint8_t> count_translucent(const PictureJob& job) override;
  std::vector<uint8_t> read_shadows(size_t bytes) override;
  const rt::OcclusionMasks& masks() const override { return jobs_->masks.image(); }
  const rt::LayerCache& read_layers(const PictureJob& job) override;
  const rt::CompositeImage& composite() const override { return jobs_->layers.composite(); }
  std::vector<uint8_t> answers(AnswerOf of) const override;

 private:
  class Frame;

  gl::DeviceInfo info_;
  sideray_tracer* tracer_ = nullptr;
  std::shared_ptr<const model::Snapshot> snapshot_;
  uint32_t width_ = 0, height_ = 0;
  // Holds the jobs of a scene with their history.
  struct Jobs {
    MaskJob masks;
    IrradianceJob irradiance;
    ReflectionJob reflections;
    LayerJob layers{masks.image(), irradiance.image()}, shown_layers{masks.image(), irradiance.image()};
    FrameBudget budget;
    rt::PixelTrail trail;
    uint64_t frames = 0;
  };
  std::unique_ptr<Jobs> jobs_ = std::make_unique<Jobs>();
  const sideray_scene* scene_ = nullptr;
  std::map<const sideray_scene*, std::unique_ptr<Jobs>> others_;  // of scenes that were drawn before
  FramePosition position_;  // of the last frame, like the next four
  rt::OpaqueRequest request_;
  rt::OpaquePixels pixels_;
  std::vector<glm::vec2> motion_;
  std::vector<glm::vec4> picture_;
  rt::TemporalAverage average_;
};

}  // namespace sideray::bridge
