// The offscreen renderer: a backend that draws frames (bridge/drawing/backend.h), and the state between pictures. One
// thread at a time. A headless OpenGL context is current only during calls; a host's must be current in every call, and
// its state is restored.
#pragma once

#include <sideray/renderer.h>

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridge/base/handles.h"
#include "bridge/drawing/picture_job.h"
#include "gl/context/context.h"
#include "rt/tracer.h"

namespace sideray::bridge {

class Renderer {
 public:
  // Throws Failure (NO_DEVICE, INVALID_ARGUMENT).
  explicit Renderer(const sideray_renderer_desc& desc);
  Renderer(std::unique_ptr<gl::Context> context, rt::TracerConfig tracer_config);
  Renderer(std::unique_ptr<Backend> backend, rt::TracerConfig tracer_config);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  const gl::DeviceInfo& device() const { return backend_->device(); }
  std::unique_ptr<Picture> render(sideray_scene* scene, const sideray_camera& camera, const RenderOptions& options);
  // Returns one picture for each camera, the same as render() would.
  std::vector<std::unique_ptr<Picture>> render_many(sideray_scene* scene, std::span<const sideray_camera> cameras,
                                                    const RenderOptions& options);
  // Ends a picture that another thread draws, whose call then throws Failure (CANCELLED). Any thread.
  void cancel() { cancelled_ = true; }

 private:
  // Draws pictures on one thread beside other helpers.
  struct Helper {
    std::unique_ptr<Backend> backend;
    std::unique_ptr<Sequence> sequence;
    std::unique_ptr<sideray_tracer> tracer;
  };

  struct ReleaseScene {
    void operator()(sideray_scene* scene) const { sideray_scene_release(scene); }
  };
  struct ReleaseTracer {
    void operator()(sideray_tracer* tracer) const { sideray_tracer_release(tracer); }
  };
  struct DrawnScene {
    std::unique_ptr<sideray_scene, ReleaseScene> scene;
    std::unique_ptr<sideray_tracer, ReleaseTracer> tracer;  // created when rays are first needed
    std::vector<Helper> helpers;  // one for each thread, created at their first use
  };

  void set_scene(sideray_scene* scene);
  void change_scene(sideray_scene* scene);
  static bool is_held_elsewhere(const DrawnScene& drawn);
  std::vector<DrawnScene>::iterator forget(std::vector<DrawnScene>::iterator other);
  void prepare_rays(const FramePlan& plan, const sideray_camera& camera, StageTimes& stages);
  void check(std::span<const sideray_camera> cameras, const RenderOptions& options) const;
  std::unique_ptr<Picture> draw_next(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options);
  bool draws_beside(const FramePlan& plan, size_t pictures) const;
  void draw_beside(const FramePlan& plan, std::span<const sideray_camera> cameras, const RenderOptions& options,
                   std::span<std::unique_ptr<Picture>> pictures);

  std::atomic<bool> cancelled_{false};  // for the current pictures
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<Sequence> sequence_;
  rt::TracerConfig tracer_config_;
  DrawnScene drawn_;                // the current scene
  // A few earlier scenes, the latest last: scenes that are drawn in turn are neither rebuilt nor uploaded again.
  std::vector<DrawnScene> others_;
  std::shared_ptr<const model::Snapshot> snapshot_;  // of drawn_
};

}  // namespace sideray::bridge
