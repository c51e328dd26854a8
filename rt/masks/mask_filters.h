// Denoises a frame's shadow and ambient occlusion masks: within the frame, and along a sequence. Holds the history: one
// object a sequence. Works on plain memory. One thread calls it; it works on the executor's. Same bits for any number
// of threads.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/executor.h"
#include "rt/history/frame_camera.h"
#include "rt/masks/mask_request.h"
#include "rt/masks/shadow_filter.h"

namespace sideray::rt {

// Holds what the filters of all lights share in one frame.
struct FilterFrame {
  uint32_t width = 0, height = 0;
  shading::SfView view{};
  std::vector<float> depth;         // along the view's axis; 0 = nothing
  std::vector<float> depth_before;  // of the previous frame, where this one follows it
  std::vector<glm::vec2> motion;    // pixels, where only the view moved; empty: it stood still
};

shading::SfLight filter_light(const model::Light& light, const FrameCamera& camera);
// Returns the light that blurs ambient occlusion, and the mask of the combined lights, as a light's size blurs its
// shadow.
shading::SfLight filter_sky();
// Returns whether there is noise to filter in a light's mask. `inexact`: some pixel takes a random test.
bool is_filtered(const model::Light& light, bool inexact);
bool is_random(sideray_inexact inexact, uint32_t inexact_bits);

// Keeps depths and motion of a sequence's frames.
class FilterFrames {
 public:
  // Fills `frame` for the next view; returns false where this view, being orthographic, cannot be filtered. `follows`:
  // there is an earlier frame.
  bool next(Executor& executor, const MaskRequest& request, const model::Snapshot& snapshot, FilterFrame& frame);
  // A frame is not filtered: the next one follows none.
  void skip() {
    camera_.reset();
    ++number_;
  }
  const FrameCamera& camera() const { return *camera_; }
  bool follows() const { return before_.has_value(); }
  // Returns whether the frame follows the one that a light's filter filtered last: a light's masks need not be
  // requested in every frame, and a filter that skipped a frame has no history. `last` holds the number of that frame,
  // 0 where there is none, and becomes this one's.
  bool follows(uint64_t& last, SequenceStep step) const;

 private:
  std::optional<FrameCamera> camera_, before_;
  uint64_t number_ = 0;  // counts the frames, without redrawn ones
  glm::dvec3 origin_{0.0};
  uint32_t width_ = 0, height_ = 0;
};

class MaskFilters {
 public:
  // Filters the masks in place, except those that MaskRequest::kept reuses; not to be called if it reuses all.
  // Orthographic views stay as they are. Under a deadline history is filtered already, and stays; if it is more than
  // half of the tiles, the others are filtered within the frame alone.
  void filter(Executor& executor, const MaskRequest& request, const model::Snapshot& snapshot, OcclusionMasks& masks);

 private:
  struct Frame;  // of all filters
  // Of a mask: ShadowFilterInput's.
  struct Tiles {
    std::span<const uint8_t> seen, unfiltered;
  };
  struct LightFilter {
    ShadowFilter filter;
    uint64_t last_frame = 0;  // as FilterFrames::follows() keeps it
  };

  void add(const shading::SfLight& light, std::span<uint8_t> mask, std::span<const float> hit_distance,
           const Tiles& tiles, LightFilter& light_filter, const MaskRequest& request, Frame& frame) const;
  void keep(LightFilter& light_filter, const MaskRequest& request) const;
  void run(Executor& executor, const MaskRequest& request, Frame& frame) const;

  FilterFrames frames_;
  FilterFrame frame_;
  std::vector<LightFilter> shadows_;  // by index of the light
  LightFilter combined_, unhidden_, open_;
  // Of what translucent surfaces leave of red, green and blue: by index of the light, and of the combined ones.
  std::vector<std::array<LightFilter, 3>> tints_;
  std::array<LightFilter, 3> combined_tint_;
};

}  // namespace sideray::rt
