// Finds where the opaque surface of each pixel was in the previous frame: the camera moves, and surfaces stand still.
// The history of masks and reflections is reprojected by it. One object a sequence. One thread begins a frame; any may
// look back.
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

  // Begins a frame of the sequence. `origin`: of the local space of its view. `follows`: there is an earlier frame, of
  // the same size. Throws Failure where the view is none.
  void begin(const TraceView& view, const DepthImage& depth, glm::uvec2 size, glm::dvec3 origin, bool follows,
             Executor& executor);
  // Returns whether the view equals the previous one, to a thousandth of a pixel.
  bool same_view() const { return same_view_; }
  const FrameCamera& camera() const { return *camera_; }
  // Returns the frame's depths along the camera's axis, as fill_depths() does.
  const std::vector<float>& depths() const { return depth_; }

  // Pixels of a row that lie in one tile: where each was in the previous frame, as y * width + x, or nowhere.
  using Row = std::array<uint32_t, frame_tile_size>;
  // Finds them for `count` pixels from (x, y) on. In a view at rest a pixel was where it is, or showed another surface.
  void look_back(uint32_t x, uint32_t y, uint32_t count, Row& from) const;

 private:
  struct Terms {  // of clip coordinates in pixels and, in w, the depth; linear in depth, x and y
    glm::vec4 origin, origin_x, origin_y, ray, ray_x, ray_y;
  };
  void find_way();
  uint32_t search(glm::vec2 at, float depth) const;
  bool was_there(glm::ivec2 at, float depth) const;
  uint32_t index(glm::ivec2 at) const { return static_cast<uint32_t>(at.y) * width_ + static_cast<uint32_t>(at.x); }

  uint32_t width_ = 0, height_ = 0;
  uint32_t number_ = 0;  // of the frame
  bool same_view_ = false;
  glm::dvec3 origin_{0.0};
  std::optional<FrameCamera> camera_, before_;
  std::vector<float> depth_, depth_before_;
  Terms was_{};
  glm::vec2 rounding_{0.5f};  // of reprojected places; it varies, so that slow movement is not lost
};

}  // namespace sideray::rt
