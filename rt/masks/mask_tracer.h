// Traces a frame's masks tile by tile: finds which rays from its points to lights and sky are occluded. Threads trace
// different tiles, each with its own Worker.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/base/view_rays.h"
#include "rt/masks/coarse_sky.h"
#include "rt/masks/combined_lights.h"
#include "rt/masks/depth_points.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_rays.h"
#include "rt/masks/mask_request.h"
#include "rt/masks/older_masks.h"
#include "rt/scene/traced_scene.h"
#include "rt/light/tint_tile.h"
#include "rt/light/veils.h"

namespace sideray::rt {

class MaskTracer {
 public:
  static constexpr uint32_t tile_size = DepthPoints::tile_size;
  static constexpr uint32_t filter_tile = OcclusionMasks::filter_tile;
  static constexpr uint32_t filter_across = tile_size / filter_tile;  // filter tiles per tile, across and down

  // Is the scratch memory of one thread.
  struct Worker {
    DepthPoints points;
    TileRays rays;
    CombinedLights::Block drawn;
    std::vector<DepthPoint> block;        // points of a block
    std::vector<uint32_t> block_indices;  // their indices in the tile
    std::vector<Ray> chosen;
    std::vector<uint32_t> of_chosen;  // pixel of each chosen ray
    std::array<uint8_t, tile_size * tile_size> occluded;
    std::vector<Hit> hits;
    Veils veils;
    TileTints tints;
    std::vector<Ray> clear;  // rays without an opaque occluder
    std::vector<uint32_t> of_clear;
    std::vector<float> of_clear_weights;
    // Sums over a pixel's rays to the sky: of all weights, of unoccluded ones, and of those without an opaque occluder.
    std::array<float, tile_size * tile_size> sum, open, unhidden;
    Counters counters;
  };

  // All arguments must outlive the object. `masks` must have the request's size.
  MaskTracer(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks);

  bool traces_lights() const;
  // Returns whether the sky is traced, which also stores the unhidden share.
  bool traces_sky() const { return request_.ao_rays > 0 && !is_kept(masks_.layers); }

  // Makes a tile lit, with infinite distances.
  void open_tile(size_t tile) const;

  void open_sky(size_t tile) const;

  void trace_shadows(size_t tile, Worker& w) const;

  // Copies the threads' tints to the masks. `fresh`, by tile: 1 if it was traced in this frame, or is lit because it
  // was skipped.
  void store_tints(std::span<Worker> workers, std::span<const uint8_t> fresh, Executor& executor) const;

  // Measures the hit distances that trace_shadows() left out: in all-dark tiles beside lit ones.
  void trace_borders(size_t tile, Worker& w) const;

  // Measures the distance of every dark pixel in penumbrae.
  void trace_distances(size_t tile, Worker& w) const;

  void trace_open(size_t tile, Worker& w) const;

  // Samples the sky of a tile, for pixels that have no rays of their own yet.
  void sample_sky(size_t tile, Worker& w, CoarseSky& sky) const;

  size_t tiles() const { return size_t{columns()} * tile_count(request_.height); }
  // Returns the order in which tiles are traced; empty = by number.
  std::vector<uint32_t> turns(OlderMasks::Part part) const;

 private:
  struct Layer {
    RayLight rays;  // unused for the combined lights
    bool filtered;
    bool kept;  // reused, not traced
  };

  // Adds up the results of n rays of each point.
  void look_at_sky(const PointTile& points, uint32_t n, bool measures_first, Worker& w) const;

  static uint8_t share(float open, float sum) { return static_cast<uint8_t>(std::clamp(open * (255.0f / sum) + 0.5f, 0.0f, 255.0f)); }

  bool is_kept(size_t layer) const { return request_.kept && request_.kept->keeps(static_cast<uint32_t>(layer)); }
  bool is_combined(uint32_t layer) const { return request_.combined_lights && layer + 1 == layers_.size(); }
  static uint32_t tile_count(uint32_t pixels) { return (pixels + tile_size - 1) / tile_size; }
  uint32_t columns() const { return tile_count(request_.width); }
  uint32_t tile_x(size_t tile) const { return static_cast<uint32_t>(tile % columns()) * tile_size; }
  uint32_t tile_y(size_t tile) const { return static_cast<uint32_t>(tile / columns()) * tile_size; }
  size_t texel(uint32_t layer, uint32_t x, uint32_t y) const;
  size_t texel(uint32_t layer, const PointTile& points, uint32_t pixel) const;

  template <typename T>
  void fill(std::vector<T>& plane, uint32_t layer, uint32_t x0, uint32_t y0, uint32_t side, T value) const;
  template <typename T>
  void fill_tile(std::vector<T>& plane, uint32_t layer, size_t tile, T value) const;

  // Calls work(column, row) for each filter tile of a tile.
  template <typename Work>
  void for_each_filter_tile(size_t tile, const Work& work) const;
  size_t filter_index(uint32_t layer, uint32_t u, uint32_t v) const { return masks_.filter_index(layer, u, v); }
  bool in_penumbra(uint32_t layer, uint32_t u, uint32_t v) const { return masks_.in_penumbra(layer, u, v); }

  bool has_penumbra(uint32_t layer, size_t tile) const;
  bool is_dark(uint32_t layer, size_t tile) const;

  // Resets the distances of a filter tile to infinite, if an earlier frame set some.
  void forget_distances(uint32_t layer, uint32_t u, uint32_t v) const;

  // Writes occluded pixels and the filter tiles' Seen bits; returns whether the tile is partly in shadow.
  bool darken(const PointTile& points, uint32_t layer, size_t tile, Worker& w) const;

  // Finds the transmittance of translucent surfaces for rays without an opaque occluder.
  void pass_glass(uint32_t layer, size_t tile, Worker& w) const;

  RayRandom random_of(uint32_t layer) const;

  void make_rays(const PointTile& points, uint32_t layer, Worker& w) const;

  // Finds the points of a block, which sample lights from the same bounds.
  void gather_block(const PointTile& points, uint32_t block, Worker& w) const;

  // Makes one ray a point, to its sampled light.
  void make_block_rays(const RayRandom& random, const TileSamples& samples, Worker& w) const;

  // Measures the hit distances of the rays for which wanted(ray, pixel) is true.
  template <typename Wanted>
  void measure(const PointTile& points, uint32_t layer, std::vector<float>& distances, Worker& w,
               const Wanted& wanted) const;

  // Subtracts what translucent surfaces absorb from rays without an opaque occluder.
  void see_through_veils(const PointTile& points, bool measures, Worker& w) const;

  void make_open_rays(const RayLight& to, const RayRandom& random, const TileSamples& samples, const PointTile& points,
                      Worker& w) const;

  void store_open(const PointTile& points, const Worker& w) const;

  // Measures only some pixels; the filter uses neighbours for the others.
  void measure_open(const PointTile& points, Worker& w) const;

  template <typename Wanted>
  static void choose(Worker& w, const Wanted& wanted);

  const MaskRequest& request_;
  const ShadingScene& shading_;
  const model::Snapshot& snapshot_;
  const Intersector& intersector_;
  ViewRays view_;
  bool tinted_, veiled_;
  const SkyDirections* sky_;  // of ray directions; null: by the cosine
  uint32_t lights_;           // number of light masks; the unhidden sky's mask follows
  std::vector<Layer> layers_;
  CombinedLights combined_;
  OcclusionMasks& masks_;
};

}  // namespace sideray::rt
