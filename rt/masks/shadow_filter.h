// Denoises the shadow of one light from its noisy visibility and hit distances and the picture's depth
// (shaders/light/shadow_filter.h). It stores the history: one object a light and sequence. One thread calls it; it uses
// the executor's. The bits do not depend on the thread count.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/masks/kernels/shadow_kernels.h"
#include "rt/masks/zeroed_floats.h"
#include "shaders/light/shadow_filter_cpp.h"

namespace sideray::rt {

// Refers to images of width * height, row by row. They must not change until the frame has been filtered.
struct ShadowFilterInput {
  uint32_t width = 0, height = 0;
  std::span<const float> visibility;    // 0 .. 1: share of the samples that reached the light
  std::span<const float> hit_distance;  // along the shadow ray to the nearest occluder; infinite: none
  std::span<const float> depth;         // along the view axis; 0 or infinite: no surface, and the visibility is not
                                        // filtered
  std::span<const glm::vec2> motion;    // in pixels: position now minus position before; empty: nothing moved
  shading::SfView view{};
  shading::SfLight light{};
  std::span<const uint8_t> mask;  // replaces the visibility if set: 255 = 1
  // By tile, row by row: bits of OcclusionMasks::Seen, so 1 = all 0 and 2 = all 1. Empty: unknown.
  std::span<const uint8_t> seen;
  // By tile, row by row: 0 if its pixels are filtered already and must not change. Empty: none are.
  std::span<const uint8_t> unfiltered = {};
};

class ShadowFilter {
 public:
  explicit ShadowFilter(const ShadowKernels& kernels = shadow_kernels()) : kernels_(&kernels) {}

  // Filters within the frame. `result` has the images' size. Throws Failure (INVALID_ARGUMENT) if sizes differ.
  void spatial(Executor& executor, const ShadowFilterInput& input, std::span<float> result);
  // Does the same for several filters of one size at once; store() stores their results. Filters that name the same
  // depth share what is computed from it. Consecutive masks that name the same hit distances, as the colours of one
  // light do, share their reach. `whole`: computes what temporal() needs, too; otherwise skips tiles that stay equal.
  static void spatial(Executor& executor, std::span<ShadowFilter* const> filters,
                      std::span<const ShadowFilterInput> inputs, bool whole);
  // Writes the results of spatial(), or of temporal() if `accumulated`, to the masks (255 = 1) where they differ.
  static void store(Executor& executor, std::span<ShadowFilter* const> filters, std::span<uint8_t* const> masks,
                    bool accumulated);
  // Averages with earlier frames, after spatial() of the same input. `again`: replaces the last call's frame.
  void temporal(Executor& executor, const ShadowFilterInput& input, std::span<float> result, bool again = false);
  void temporal(Executor& executor, const ShadowFilterInput& input, bool again = false);
  // Makes the next frame start without history.
  void reset() { follows_ = false; }
  // Makes the next frame continue the last one, even if only spatial() filtered that. `depth` is the last frame's.
  void follow(const shading::SfLight& light, std::span<const float> depth);

  // Returns how many tiles of 16 x 16 pixels were filtered in the last frame: those that, with their neighbours, are
  // neither all lit nor all in shadow.
  uint32_t active_tiles() const;
  uint32_t tiles() const { return static_cast<uint32_t>(tiles_.size()); }

 private:
  struct Tile {
    float least, most;  // smallest and largest visibility
    float distances, hits;
    float reach;  // the longest reach
    bool active;
    bool loaded;  // its part of the planes is of this frame; false: all its pixels are `least`
  };
  struct ShadowRow;
  // Holds the surfaces of a frame; filters of the same depth share it.
  struct Guide {
    ZeroedFloats inverse, slope_x, slope_y;
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> needed;  // tiles that some filter reads; others keep their old content
  };
  // Says whether any tile in a row is loaded, or active. Under a deadline few are.
  struct RowState {
    bool loaded, active;
  };
  static constexpr size_t most_sharing = 3;
  struct Sharing {
    ShadowFilter* filter;
    std::span<const uint8_t> mask;
  };
  enum Plane { visibility, filtered, nearness, reach, plane_count };
  enum HistoryPlane { value, frames, inverse_then, history_plane_count };

  void fit(const ShadowFilterInput& input);
  void fit_history();
  static void share_reach(std::span<ShadowFilter* const> filters, std::span<const ShadowFilterInput> inputs);
  static std::vector<size_t> share_guides(std::span<ShadowFilter* const> filters,
                                          std::span<const ShadowFilterInput> inputs);
  static void fill_guides(Executor& executor, std::span<ShadowFilter* const> filters,
                          std::span<const ShadowFilterInput> inputs);
  void choose(const ShadowFilterInput& input, uint32_t tile_y);
  void invert(std::span<const float> depth, uint32_t tile_y, std::span<const uint8_t> needed, float* inverse) const;
  void slope(uint32_t tile_y, std::span<const uint8_t> needed);
  int seen_around(const ShadowFilterInput& input, uint32_t x, uint32_t y) const;
  bool may_change(const ShadowFilterInput& input, uint32_t x, uint32_t y) const;
  bool is_needed(const ShadowFilterInput& input, uint32_t x, uint32_t y) const;
  void load(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row);
  const float* darkest_row(uint32_t x, uint32_t y, float (&copy)[shadow_tile]) const;
  // Sums up a tile and its neighbours.
  Tile around(uint32_t tile_x, uint32_t tile_y) const;
  void classify(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row);
  void find_active(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row);
  void find_reach(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row);
  static bool reaches(const Tile& tile, int32_t step);
  void blur(uint32_t tile_y, int32_t step);
  void accumulate(const ShadowSequence& sequence, std::span<const glm::vec2> moved, uint32_t tile_y);
  void store(Executor& executor, const float* plane, std::span<float> result);
  void store_row(uint8_t* mask, bool accumulated, uint32_t tile_row) const;
  int32_t at(uint32_t x, uint32_t y) const;
  ShadowPlanes planes();
  ShadowHistoryPlanes history(uint32_t which);

  const ShadowKernels* kernels_;
  uint32_t width_ = 0, height_ = 0, tiles_x_ = 0, tiles_y_ = 0;
  int32_t stride_ = 0;
  uint32_t current_ = 0;
  bool follows_ = false, whole_ = true;
  std::vector<Tile> tiles_;
  std::vector<RowState> row_states_;
  std::shared_ptr<Guide> own_guide_, guide_;  // the latter may be another filter's
  // For this frame: the filter whose reach this one uses; in a leader, all filters that use its reach, itself first.
  ShadowFilter* leader_ = nullptr;
  std::vector<Sharing> sharing_;
  ZeroedFloats planes_[plane_count], history_[2][history_plane_count];
};

}  // namespace sideray::rt
