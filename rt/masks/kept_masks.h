// Finds the masks of a frame that need no rays because nothing has changed since earlier frames: depth, view, the
// geometry that rays hit, the light and the options. One object a sequence, whose masks stay in one OcclusionMasks. One
// thread calls it; it uses the executor's. A mask without random samples, or with the same ones, is reused at once,
// with the same bits. If samples differ between frames, the mask is a mean over frames and is reused once it has
// converged, when its content from before the view came to rest weighs less than half a step of 8 bits. From then on it
// does not change. A view that repeats the same jittered positions, as for temporal anti-aliasing, counts as at rest
// too: each position has its own masks.
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
  static constexpr uint32_t longest_cycle = 8;  // the longest period of a view's jitter, in frames

  // Returns after how many frames the earlier content of a mean over `history` frames weighs less than 1/512.
  static uint32_t frames_to_settle(uint32_t history);

  // Begins the next frame and decides which of its masks are reused. If a view has returned to a jittered position,
  // copies that position's masks to `masks`. Throws Failure if the matrices describe no view.
  void begin(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks);
  // Ends the frame, after the other masks are traced and filtered. `whole`: no ray was skipped.
  void end(const OcclusionMasks& masks, bool whole);
  // Makes the next frame reuse no mask.
  void forget() { complete_ = false; }

  // Return which masks begin() decided to reuse: those of lights by layer, then the sky's, if there is one.
  bool keeps(uint32_t layer) const { return layers_[layer].kept; }
  bool keeps_all() const;
  // Returns whether reused masks may be from a frame before the last one.
  bool brings_back() const { return cycle_ > 1; }

 private:
  // Holds the inputs that all masks of a frame depend on. Pictures are compared by their hashes.
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
    bool hashed = false;
    PictureHash depth{}, rest{};
    bool operator==(const Frame&) const = default;
  };
  struct Layer {
    std::vector<model::Light> lights;  // lights that the mask also depends on
    uint64_t veils = 0;                // number of the scene (scene_) if translucent surfaces affect the mask; 0: they
                                       // do not
    std::shared_ptr<const model::Environment> sky;  // the sky that its rays sample; null: they go to lights
    bool random = false, filtered = false;
    uint32_t settles = 0;  // frames until it has converged, while nothing changes
    uint32_t still = 0;    // frames in a row in which nothing has changed
    bool kept = false;
    bool kept_at_first = false;  // `kept` when a redrawn frame was first drawn
    bool depends_as(const Layer& other) const {
      return lights == other.lights && veils == other.veils && sky == other.sky;
    }
  };
  // The masks of one jittered position, by layer; empty if there are none.
  using Place = std::vector<std::vector<uint8_t>>;

  // `hashed`: pictures are compared too; a frame without hashes equals none with them.
  static Frame frame_of(const MaskRequest& request, TracedScene& scene, bool hashed);
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

  bool complete_ = false;                    // the masks hold the last frame
  std::shared_ptr<const model::Snapshot> committed_;  // the last frame's
  uint64_t scene_ = 0;                       // incremented by each commit that changes anything except the wind
  std::vector<Frame> frames_;                // the last frames, oldest first, up to the longest cycle
  std::vector<Layer> layers_;                // of the last frame; the sky's layer is last
  SequenceStep step_ = SequenceStep::first;  // of the last frame that was not redrawn
  uint32_t seed_ = 0;                        // of the last frame
  uint32_t cycle_ = 0;                       // period of the jitter in frames; 0: none
  uint32_t turn_ = 0;                        // the frame's index in the cycle
  std::array<Place, longest_cycle> places_;  // used if the cycle has several
};

}  // namespace sideray::rt
