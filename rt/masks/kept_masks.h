// Finds the masks of a sequence's frame that need no rays because nothing has changed: depth, view, the geometry that
// rays hit, the light and the options are those of earlier frames. One object a sequence, where the same masks stay in
// one OcclusionMasks from frame to frame. One thread calls it; it works on the executor's.  A mask without random
// samples, and one with the same samples as before, is reused at once: the bits are the same. One whose samples differ
// from frame to frame is a mean over frames. It is reused once it has converged: what it held before the view stood
// still weighs less than half a step of a mask's 8 bits. From then on it does not change. A view that repeats the same
// jittered positions, as for temporal anti-aliasing, stands still too: each position has masks of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"
#include "rt/history/picture_hash.h"
#include "rt/masks/mask_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class KeptMasks {
 public:
  static constexpr uint32_t longest_cycle = 8;  // frames after which a view may come back to the same place

  // Returns for how many frames a mean over `history` frames goes on until what it held before weighs less than 1/512.
  static uint32_t frames_to_settle(uint32_t history);

  // Begins the next frame and decides which of its masks are reused. If a view has returned to a jittered position,
  // that position's masks are put into `masks`. Throws Failure where the view is none.
  void begin(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks);
  // Call when the others are traced and filtered. `whole`: no ray was skipped.
  void end(const OcclusionMasks& masks, bool whole);
  // Makes the next frame keep none.
  void forget() { complete_ = false; }

  // What begin() decided of the masks of lights, by their layer, and of the sky's, behind them where there is one.
  bool keeps(uint32_t layer) const { return layers_[layer].kept; }
  bool keeps_all() const;
  // Returns whether reused masks are of an earlier frame the last.
  bool brings_back() const { return cycle_ > 1; }

 private:
  // What all masks of a frame depend on. Pictures are compared by their hashes.
  struct Frame {
    struct Inputs : sideray_mask_inputs {
      bool operator==(const Inputs& other) const { return ask_alike(*this, other); }
    };
    Inputs inputs{};
    uint32_t width = 0, height = 0;
    bool filters = false, reversed = false, zero_to_one = false, glass_shadows = false;
    DepthFormat format = DepthFormat::d32f;
    float subpixel = 0;
    glm::dmat4 clip_from_local{1.0}, local_from_clip{1.0};
    glm::dvec3 origin{0.0};
    uint64_t opaque_revision = 0;
    PictureHash depth{}, rest{};
    bool operator==(const Frame&) const = default;
  };
  struct Layer {
    std::vector<model::Light> lights;  // that it depends on besides
    uint64_t veils = 0;                // and which translucent surfaces, as scene_ numbers them; 0: none
    std::shared_ptr<const model::Environment> sky;  // where its rays go; null: to lights
    bool random = false, filtered = false;
    uint32_t settles = 0;  // frames for which it is made while nothing changes
    uint32_t still = 0;    // frames in a row in which nothing has changed
    bool kept = false;
    bool kept_at_first = false;  // where the frame is drawn again: what it was when it was drawn first
    bool depends_as(const Layer& other) const {
      return lights == other.lights && veils == other.veils && sky == other.sky;
    }
  };
  // The masks of one position in the pixel, by layer; empty where there is none.
  using Place = std::vector<std::vector<uint8_t>>;

  static Frame frame_of(const MaskRequest& request, TracedScene& scene);
  std::vector<Layer> layers_of(const MaskRequest& request, const ShadingScene& scene) const;

  void begin_first(const Frame& frame, const MaskRequest& request, std::vector<Layer>& layers);
  void begin_next(const Frame& frame, const MaskRequest& request, TracedScene& scene, std::vector<Layer>& layers);
  void begin_again(const Frame& frame, const MaskRequest& request, std::vector<Layer>& layers);
  void restart(const Frame& frame);
  uint32_t find_cycle(const Frame& frame, size_t layers) const;
  bool is_last(const Frame& frame) const { return complete_ && !frames_.empty() && frames_.back() == frame; }
  uint32_t frames_made(const Layer& layer) const { return std::max(layer.settles, cycle_ > 1 ? cycle_ : 0); }
  bool may_stay(const Layer& layer, size_t index, const MaskRequest& request) const;
  Place& place() { return places_[turn_ % longest_cycle]; }

  bool complete_ = false;                    // the masks are those of the last frame
  std::shared_ptr<const model::Snapshot> committed_;  // that of the last frame
  uint64_t scene_ = 0;                       // grows with each commit that changes anything except the wind
  std::vector<Frame> frames_;                // the last ones, oldest first, up to the longest cycle
  std::vector<Layer> layers_;                // of the last frame; the sky's is the last
  SequenceStep step_ = SequenceStep::first;  // of the last frame that was not drawn again
  uint32_t seed_ = 0;                        // of the last frame
  uint32_t cycle_ = 0;                       // period of the jitter in frames; 0: none
  uint32_t turn_ = 0;                        // of the frame in the cycle
  std::array<Place, longest_cycle> places_;  // where the cycle has several
};

}  // namespace sideray::rt
