// Draws frames by OpenGL: a context, the built-in rasterizer, and the service that traces beside it. One thread at a
// time. A headless context is current only during calls; a host's must be current in every call, and its state is
// restored.
#pragma once

#include <map>
#include <memory>

#include "bridge/raster/raster_parts.h"

namespace sideray::bridge {

class RasterBackend final : public Backend {
 public:
  explicit RasterBackend(std::unique_ptr<gl::Context> context);
  ~RasterBackend() override;

  const gl::DeviceInfo& device() const override { return context_->info(); }
  Drawing drawing() const override { return Drawing::raster; }
  void begin_call() override;
  void end_call() override { context_->release_current(); }
  void require_no_errors() override;
  void change_scene(const sideray_scene* scene) override;
  void forget_scene(const sideray_scene* scene) override { others_.erase(scene); }
  void set_tracer(sideray_tracer* tracer) override;
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot) override;
  void set_culled(std::span<const uint8_t> culled) override { rasterizer_->set_culled(culled); }
  void resize(uint32_t width, uint32_t height) override { rasterizer_->resize(width, height); }
  gl::RasterView make_view(const sideray_camera& camera, glm::vec2 jitter) const override;
  FrameCounters draw(PictureJob& job, const FramePosition& position, FrameTimer& timer, Fragments fragments) override;
  void finish() override { context_->functions().Finish(); }
  void forget_shadow_maps() override { rasterizer_->forget_shadow_maps(); }
  bool draws_parts() const override { return true; }
  void average(const gl::FrameBefore& before) override { rasterizer_->average(before); }
  void keep_average() override { rasterizer_->keep_average(); }
  void forget_averages() override { rasterizer_->forget_averages(); }
  void replace_average(const std::vector<glm::vec4>& picture) override { rasterizer_->replace_average(picture); }
  std::vector<glm::vec4> read_color() override { return rasterizer_->read_color(); }
  std::vector<float> read_depth() override { return rasterizer_->read_depth(); }
  std::vector<uint8_t> read_stencil() override { return rasterizer_->read_stencil(); }
  rt::OpaqueMaterials read_gbuffer() override;
  std::vector<glm::vec2> read_motion() override { return rasterizer_->read_motion(); }
  std::vector<uint8_t> count_translucent(const PictureJob& job) override;
  std::vector<uint8_t> read_shadows(size_t bytes) override;
  const rt::OcclusionMasks& masks() const override { return service_->mask_image(); }
  const rt::LayerCache& read_layers(const PictureJob&) override { return service_->cache(); }
  const rt::CompositeImage& composite() const override { return service_->composite(); }
  std::vector<uint8_t> answers(AnswerOf of) const override;

 private:
  void require_context();

  std::unique_ptr<gl::Context> context_;
  std::unique_ptr<gl::Rasterizer> rasterizer_;
  std::unique_ptr<Service> service_;  // traces with the scene's tracer
  const sideray_scene* scene_ = nullptr;
  struct OtherScene {
    gl::SceneOnGpu on_gpu;
    std::unique_ptr<Service> service;
  };
  std::map<const sideray_scene*, OtherScene> others_;  // scenes drawn before
};

}  // namespace sideray::bridge
