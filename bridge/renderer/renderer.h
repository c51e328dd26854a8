// The offscreen tier: a headless context, the built-in rasterizer and the service, drawing whole pictures. One thread
// at a time; the context is made current in every call and released after it.
#pragma once

#include <sideray/sideray.h>

#include <memory>
#include <string>

#include "bridge/base/handles.h"
#include "bridge/plan/frame_plan.h"
#include "bridge/renderer/frame_timer.h"
#include "bridge/renderer/picture.h"
#include "bridge/service/service.h"
#include "gl/context/context.h"
#include "gl/rasterizer.h"

namespace sideray::bridge {

// Offset from the pixel centre of sample i of n, in pixels. One sample is the centre itself.
glm::vec2 sample_jitter(uint32_t i, uint32_t samples);

class Renderer {
 public:
  // Throws Failure (NO_DEVICE, INVALID_ARGUMENT).
  explicit Renderer(const sideray_renderer_desc& desc);
  Renderer(std::unique_ptr<gl::Context> context, rt::TracerConfig tracer_config);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  const gl::DeviceInfo& device() const { return context_->info(); }
  std::unique_ptr<Picture> render(sideray_scene* scene, const sideray_camera& camera,
                                  const RenderOptions& options);

 private:
  struct FrameResult {
    gl::FragmentCounts fragments;
    uint64_t duplicated = 0;
    rt::Counters trace;
  };

  void set_scene(sideray_scene* scene);
  void build(const FramePlan& plan, const sideray_camera& camera, Picture& picture);
  void draw_opaque(const FramePlan& plan, const RenderOptions& options, FrameTimer& timer);
  FrameResult draw_frame(const FramePlan& plan, const gl::RasterView& view, const RenderOptions& options,
                         FrameTimer& timer, bool count);
  rt::Counters finish_trace(sideray_ticket ticket, FrameTimer& timer);
  void draw_translucency(const FramePlan& plan, const RenderOptions& options, FrameTimer& timer, bool count,
                         bool check, FrameResult& result);
  gl::OcclusionTextures occlusion(const FramePlan& plan) const;
  gl::Translucency translucency(const FramePlan& plan, const RenderOptions& options) const;
  void trace_second_wave(const FramePlan& plan, const gl::RasterView& view, const RenderOptions& options,
                         sideray_ticket first, FrameTimer& timer, rt::Counters& sum);
  FrameInputs trace_inputs(const FramePlan& plan, const gl::RasterView& view, const RenderOptions& options) const;
  void set_weights(const FramePlan& plan, const RenderOptions& options, Offscreen& offscreen) const;
  sideray_ticket start_trace(const FramePlan& plan, const gl::RasterView& view, const RenderOptions& options, bool check,
                             bool timed);
  void draw_picture(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options,
                    FrameTimer& timer, Picture& picture);
  void draw_timed(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options,
                  Picture& picture);
  static void add_counters(const FrameResult& frame, sideray_render_stats& stats);
  void draw_reference(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options,
                      Picture& picture);
  void add_reference_aovs(const rt::ReferenceImage& image, const gl::RasterView& view, uint32_t aovs,
                          Picture& picture) const;
  void describe_tracer(sideray_render_stats& stats) const;
  void add_aovs(const FramePlan& plan, const gl::RasterView& view, const RenderOptions& options,
                Picture& picture);
  void add_mask_count(const FramePlan& plan, const RenderOptions& options, Picture& picture);
  void measure(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options,
               Picture& picture);
  void count(const FramePlan& plan, const std::vector<gl::RasterView>& views, const RenderOptions& options,
             Picture& picture);
  void describe_scene(Picture& picture) const;
  void forget_before(const FramePlan& plan, const RenderOptions& options);
  void keep_frame(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options);
  glm::vec2 jitter(const FramePlan& plan, const RenderOptions& options, uint32_t sample) const;
  void require_no_gl_errors();

  std::unique_ptr<gl::Context> context_;
  std::unique_ptr<gl::Rasterizer> rasterizer_;
  rt::TracerConfig tracer_config_;
  sideray_tracer* tracer_ = nullptr;  // of the last scene; made when rays are first needed
  std::unique_ptr<Service> service_;
  sideray_scene* scene_ = nullptr;  // one reference held
  std::shared_ptr<const model::Snapshot> snapshot_;
  bool drawn_ = false;                  // of this picture: a frame
  gl::FrameBefore before_;  // that this picture continues
  glm::uvec2 size_before_{0};
  uint32_t averaged_ = 0;  // pictures in a row before this one
};

}  // namespace sideray::bridge
