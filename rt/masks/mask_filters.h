// Denoises a frame's shadow and ambient occlusion masks, within the frame and along a sequence. It holds the history:
// one object a sequence. It works on plain memory. One thread calls it; it uses the executor's. The bits do not depend
// on the number of threads.
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

// Holds what the filters of all lights in a frame share.
struct FilterFrame {
  uint32_t width = 0, height = 0;
  shading::SfView view{};
  std::vector<float> depth;         // along the view axis; 0 = no surface
  std::vector<float> depth_before;  // of the previous frame, if this one follows it
  std::vector<glm::vec2> motion;    // in pixels, for a moving camera; empty: it is at rest
};

shading::SfLight filter_light(const model::Light& light, const FrameCamera& camera);
// Returns parameters that blur ambient occlusion, and the mask of the combined lights, as a light of some size would.
shading::SfLight filter_sky();
// Returns whether a light's mask has noise to filter. `inexact`: some pixel takes a random test.
bool is_filtered(const model::Light& light, bool inexact);
bool is_random(sideray_inexact inexact, uint32_t inexact_bits);

// Keeps the depths and motion of a sequence's frames.
class FilterFrames {
 public:
  // Fills `frame` for the next view; returns false for an orthographic view, which cannot be filtered. `follows`: there
  // is an earlier frame.
  bool next(Executor& executor, const MaskRequest& request, const model::Snapshot& snapshot, FilterFrame& frame);
  // Notes that a frame is not filtered, so that the next one follows none.
  void skip() {
    camera_.reset();
    ++number_;
  }
  const FrameCamera& camera() const { return *camera_; }
  bool follows() const { return before_.has_value(); }
  // Returns whether a light's filter also filtered the previous frame; its mask may have been skipped, and then it has
  // no history. `last` is the number of the frame that it filtered last, 0 = none; it is set to this one.
  bool follows(uint64_t& last, SequenceStep step) const;

 private:
  std::optional<FrameCamera> camera_, before_;
  uint64_t number_ = 0;  // counts frames, except redrawn ones
  glm::dvec3 origin_{0.0};
  uint32_t width_ = 0, height_ = 0;
};

class MaskFilters {
 public:
  // Filters the masks in place, except those that MaskRequest::kept reuses; not to be called if it reuses all.
  // Orthographic views are not filtered. Under a deadline, tiles that show history are filtered already and stay; if
  // they are more than half of the tiles, the others are filtered without history.
  void filter(Executor& executor, const MaskRequest& request, const model::Snapshot& snapshot, OcclusionMasks& masks);

 private:
  class Frame;
  struct MaskFilter {
    ShadowFilter filter;
    uint64_t last_frame = 0;  // for FilterFrames::follows()
  };
  struct LightFilters {
    MaskFilter shadow;
    std::array<MaskFilter, 3> tints;  // the red, green and blue transmittance of translucent surfaces
  };

  FilterFrames frames_;
  FilterFrame frame_;
  std::vector<LightFilters> lights_;  // by light index
  LightFilters combined_;
  MaskFilter unhidden_, open_;
};

}  // namespace sideray::rt
