// Draws views. Each way of drawing has a renderer of its own, and with it a history. One thread, except for cancel().
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "viewer/drawing/machine.h"
#include "viewer/drawing/view.h"

namespace sideray::viewer {

// Says how a picture of a view is drawn, besides what the view says.
struct Effort {
  uint32_t width = 0, height = 0;
  bool is_preview = false;
  bool is_draft = false;   // options that are not set are fast ones, except for refraction
  float budget_ms = 0;     // 0: the view's own
};

class Painter {
 public:
  explicit Painter(Machine& machine) : machine_(machine) {}

  // Draws the next picture of a side. For a view at rest it has one more position. Throws Error.
  std::shared_ptr<Frame> paint(const View& view, Way way, const Effort& effort);
  // Cancels the picture that is being drawn, if there is one: paint() throws Error (CANCELLED). Any thread.
  void cancel();

 private:
  // Holds the sums of a reference's pictures so far.
  struct Refined {
    uint64_t number = 0;
    uint32_t width = 0, height = 0, positions = 0;
    std::array<std::vector<double>, 3> sums;
    bool is_of(const View& view, const Effort& effort) const {
      return number == view.number && width == effort.width && height == effort.height;
    }
  };

  Renderer& renderer_for(const View& view, Way way, bool needs_rasterizer);
  Picture draw_anyhow(const View& view, Way way, const Effort& effort, uint32_t position);
  Picture draw(const View& view, Way way, const Effort& effort, uint32_t position);
  Picture render(Renderer& renderer, const Scene& scene, const sideray_camera& camera, const sideray_render_options& options);
  void refine(const Picture& picture, const View& view, const Effort& effort);
  std::array<std::vector<float>, 3> refined() const;

  Machine& machine_;
  std::weak_ptr<SceneFile> scene_;  // the scene that the renderers hold
  struct Drawing {
    std::optional<Renderer> renderer;
    bool rasterizes = false;
  };
  std::array<Drawing, way_count> drawings_;
  Refined refined_;
  std::mutex mutex_;
  Renderer* drawing_ = nullptr;  // under the mutex; null between pictures
};

}  // namespace sideray::viewer
