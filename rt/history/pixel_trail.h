// Finds where the opaque surface of each pixel was in the previous frame, assuming that only the camera moves. The
// histories of masks, reflections and bounced light are reprojected by it; the histories of a view share one trail. One
// object per sequence. One thread begins a frame; any thread may read.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/base/pixels.h"
#include "rt/history/frame_camera.h"

namespace sideray::rt {

// Tells where surfaces were in the previous frame: clip coordinates in pixels and, in w, the depth. All are linear in
// depth, x and y.
struct TrailTerms {
  glm::vec4 origin, origin_x, origin_y, ray, ray_x, ray_y;
};

struct TrailFrame {
  const TraceView& view;
  const DepthImage& depth;
  glm::uvec2 size;
  glm::dvec3 origin;                   // of the view's local space
  bool follows;                        // the previous frame may be looked back to, if it has the same size
  uint64_t number = 0;                 // or 0; histories that share the trail may each begin the frame of a number
  std::span<const float> depths = {};  // what depths() will return, if it is known
};

class PixelTrail {
 public:
  static constexpr uint32_t nowhere = UINT32_MAX;

  // Begins a frame of the sequence. Throws Failure if the view is invalid.
  void begin(const TrailFrame& frame, Executor& executor);
  // Returns the number of frames begun; follows() tells whether the history of such a frame reaches this one.
  uint64_t step() const { return step_; }
  bool follows(uint64_t step) const { return before_ && step + 1 == step_; }
  // Returns whether the view equals the previous one, to a thousandth of a pixel.
  bool same_view() const { return same_view_; }
  // Returns whether mirrors at rest show the same as in the previous frame; the view may turn and zoom.
  bool same_lines() const { return same_lines_; }
  const FrameCamera& camera() const { return *camera_; }
  // Returns the frame's depths along the camera's axis, as fill_depths() does.
  const std::vector<float>& depths() const { return depth_; }

  // Returns where the pixels of a row, from (x, y) on, were in the previous frame: y * width + x, or nowhere. In a view
  // at rest that is the pixel itself, or nowhere if it showed another surface.
  const uint32_t* from(uint32_t x, uint32_t y) const { return &from_[size_t{y} * width_ + x]; }
  // Bounds the tiles in which a tile's pixels were. `first` lies behind `last` if all were nowhere.
  struct Tiles {
    glm::uvec2 first, last;
  };
  const Tiles& tiles_from(size_t tile) const { return tiles_from_[tile]; }

 private:
  void find_way();
  void look_back(size_t tile);
  void look_back(uint32_t x, uint32_t y, uint32_t count, Tiles& found);
  glm::ivec2 search(glm::vec2 at, float depth) const;
  bool was_there(glm::ivec2 at, float depth) const;
  uint32_t index(glm::ivec2 at) const { return static_cast<uint32_t>(at.y) * width_ + static_cast<uint32_t>(at.x); }

  uint32_t width_ = 0, height_ = 0;
  uint64_t frame_ = 0, step_ = 0;
  uint32_t number_ = 0;  // frames since the last one without a previous frame
  bool same_view_ = false, same_lines_ = false;
  glm::dvec3 origin_{0.0};
  std::optional<FrameCamera> camera_, before_;
  std::vector<float> depth_, depth_before_;
  std::vector<uint32_t> from_;
  std::vector<Tiles> tiles_from_;
  TrailTerms was_{};
  glm::vec2 rounding_{0.5f};  // of reprojected positions; it varies, so that slow movement is not lost
};

// Calls work(first, count, from) for parts of a row of pixels that were side by side in the previous frame, from `from`
// on, or had no place in it.
template <typename Work>
void for_runs(const uint32_t* from, uint32_t count, const Work& work) {
  for (uint32_t first = 0, end = 1; first < count; first = end++) {
    const uint32_t step = from[first] == PixelTrail::nowhere ? 0 : 1;
    while (end < count && from[end] == from[end - 1] + step) ++end;
    work(first, end - first, from[first]);
  }
}

// Names a frame of the trail that a view's histories share. Without a trail a history uses its own.
struct ViewFrame {
  PixelTrail* trail = nullptr;
  uint64_t number = 0;
};

}  // namespace sideray::rt
