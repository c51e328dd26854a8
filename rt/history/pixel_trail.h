// Finds where the opaque surface of each pixel was in the previous frame, for a moving camera and static surfaces. It
// reprojects the history of masks and reflections. One object a sequence. One thread begins a frame; any thread may
// call look_back().
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/pixels.h"
#include "rt/history/frame_camera.h"

namespace sideray::rt {

class PixelTrail {
 public:
  static constexpr uint32_t nowhere = UINT32_MAX;

  // Begins a frame of the sequence. `origin` is that of the view's local space. `follows`: there is an earlier frame of
  // the same size. Throws Failure if the matrices describe no view.
  void begin(const TraceView& view, const DepthImage& depth, glm::uvec2 size, glm::dvec3 origin, bool follows,
             Executor& executor);
  // Returns whether the view equals the previous one, to a thousandth of a pixel.
  bool same_view() const { return same_view_; }
  const FrameCamera& camera() const { return *camera_; }
  // Returns the frame's depths along the camera's axis, as fill_depths() does.
  const std::vector<float>& depths() const { return depth_; }

  // For pixels of a row in one tile: each one's position in the previous frame as y * width + x, or nowhere.
  using Row = std::array<uint32_t, frame_tile_size>;
  // Fills in `from` for `count` pixels from (x, y) on. In a view at rest a pixel either keeps its position or showed
  // another surface.
  void look_back(uint32_t x, uint32_t y, uint32_t count, Row& from) const;

 private:
  struct Terms {  // clip coordinates in pixels and, in w, the depth; all linear in depth, x and y
    glm::vec4 origin, origin_x, origin_y, ray, ray_x, ray_y;
  };
  void find_way();
  uint32_t search(glm::vec2 at, float depth) const;
  bool was_there(glm::ivec2 at, float depth) const;
  uint32_t index(glm::ivec2 at) const { return static_cast<uint32_t>(at.y) * width_ + static_cast<uint32_t>(at.x); }

  uint32_t width_ = 0, height_ = 0;
  uint32_t number_ = 0;  // the frame's number
  bool same_view_ = false;
  glm::dvec3 origin_{0.0};
  std::optional<FrameCamera> camera_, before_;
  std::vector<float> depth_, depth_before_;
  Terms was_{};
  glm::vec2 rounding_{0.5f};  // of reprojected positions; it varies, so that slow movement is not lost
};

}  // namespace sideray::rt
