// Denoises the shadow of one light from its noisy visibility, hit distances and the picture's depth alone
// (shaders/light/shadow_filter.h). Stores the history: one object a light and sequence. One thread calls it; it works
// on the executor's. Same bits for any thread count.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/masks/kernels/shadow_kernels.h"
#include "shaders/light/shadow_filter_cpp.h"

namespace sideray::rt {

// Images are width * height, row by row. They stay as they are until the frame has been filtered.
struct ShadowFilterInput {
  uint32_t width = 0, height = 0;
  std::span<const float> visibility;    // 0 .. 1: the share of its samples that reached the light
  std::span<const float> hit_distance;  // along the shadow ray to the nearest occluder; infinite: none
  std::span<const float> depth;         // along the view's axis; 0 or infinite: no surface, and the visibility stays
  std::span<const glm::vec2> motion;    // pixels: where it is minus where it was; empty: nothing moved
  shading::SfView view{};
  shading::SfLight light{};
  std::span<const uint8_t> mask;  // instead of the visibility: 255 = 1
  // A tile, row by row: OcclusionMasks::Seen of its pixels; 1 all 0, 2 all 1. Empty: unknown.
  std::span<const uint8_t> seen;
  // One value a tile, row by row: 0 if its pixels are filtered already and must not change. Empty: no tile is filtered.
  std::span<const uint8_t> unfiltered = {};
};

class ShadowFilter {
 public:
  explicit ShadowFilter(const ShadowKernels& kernels = shadow_kernels()) : kernels_(&kernels) {}

  // Filters within the frame. `result` is as large as the images. Throws Failure (INVALID_ARGUMENT) where sizes differ.
  void spatial(Executor& executor, const ShadowFilterInput& input, std::span<float> result);
  // Does the same for several filters of one size at once, each of which stores its result in store(); what depends on
  // the depth is computed once for all that name the same images, and masks in a row that name the same hit distances,
  // colours of one light, look equally far. `whole`: what temporal() needs, too; otherwise tiles that cannot change are
  // left out.
  static void spatial(Executor& executor, std::span<ShadowFilter* const> filters,
                      std::span<const ShadowFilterInput> inputs, bool whole);
  // Writes what spatial() or, `accumulated`, temporal() made of the mask, 255 = 1, where it differs.
  static void store(Executor& executor, std::span<ShadowFilter* const> filters, std::span<uint8_t* const> masks,
                    bool accumulated);
  // Averages with earlier frames, after spatial() of the same input. `again`: in place of the last call's frame.
  void temporal(Executor& executor, const ShadowFilterInput& input, std::span<float> result, bool again = false);
  void temporal(Executor& executor, const ShadowFilterInput& input, bool again = false);
  // Makes the next frame follow none.
  void reset() { follows_ = false; }
  // Makes the next frame follow the last one, even where that was filtered by spatial() alone. `depth`: that frame's.
  void follow(const shading::SfLight& light, std::span<const float> depth);

  // Returns how many tiles of 16 x 16 pixels of the last frame were filtered: those that are not all lit or all in
  // shadow together with their neighbours.
  uint32_t active_tiles() const;
  uint32_t tiles() const { return static_cast<uint32_t>(tiles_.size()); }

 private:
  struct Tile {
    float least, most;  // least and most visibility
    float distances, hits;
    float reach;  // the longest reach
    bool active;
    bool loaded;  // its part of the planes is of this frame; otherwise its pixels are all `least`
  };
  struct ShadowRow;
  // The surfaces of a frame, which filters of the same depth share.
  struct Guide {
    std::vector<float> inverse, slope_x, slope_y;
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> needed;  // tiles that some filter looks at: the others hold what they held
  };
  // Of a row of tiles: whether any is loaded, or active. Under a deadline few are.
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
  static bool reaches(const Tile& tile, int32_t step);
  void blur(uint32_t tile_y, int32_t step);
  void accumulate(const ShadowTerms& terms, const ShadowFilterInput& input, uint32_t tile_y);
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
  // Of the frame: whose reach holds here; and of a leader all whom its reach holds for, itself first.
  ShadowFilter* leader_ = nullptr;
  std::vector<Sharing> sharing_;
  std::vector<float> planes_[plane_count], history_[2][history_plane_count];
};

}  // namespace sideray::rt
