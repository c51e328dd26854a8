#include "rt/masks/occlusion_masks.h"

#include <sideray/diagnostics.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <optional>

#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/base/deadline.h"
#include "rt/base/sampling.h"
#include "rt/history/frame_camera.h"
#include "rt/masks/combined_lights.h"
#include "rt/masks/depth_points.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/mask_rays.h"
#include "rt/masks/older_masks.h"
#include "rt/reach/wanted_tiles.h"
#include "rt/shading/tint_tile.h"
#include "rt/shading/veils.h"

namespace sideray::rt {
namespace {

constexpr uint32_t tile_size = DepthPoints::tile_size;
constexpr uint32_t filter_tile = OcclusionMasks::filter_tile;
constexpr uint32_t filter_across = tile_size / filter_tile;  // of a tile, and as many down
// So many tiles around a pixel's own are filtered for its sake, and traced: a filter takes from those beside it how far it
// reaches, and they from those beside them. In masks of lights one more calms tints, and borders are measured where the next is
// lit. In filter_tile and tile_size.
constexpr uint32_t lights_filtered = 2, sky_filtered = 1, lights_traced = 2, sky_traced = 1;
constexpr uint32_t point_purpose = 31, ao_purpose = 33, combined_purpose = 34;
// Stands for the layer in random numbers; masks of single lights have the numbers below.
constexpr uint32_t combined_dimension = 32;
constexpr uint32_t open_dimension = 64;  // of the first ambient ray
constexpr uint32_t coarse_rays = 4;      // at least, of a sample that stands for many pixels
// Part of the tiles of which nothing is known that are sampled in a frame whatever its budget: a sixteenth of a tile's work each.
constexpr size_t least_sampled = 8;
// Along each side of the pixels that draw from the same bounds of the combined lights.
constexpr uint32_t combined_block = 8;
// Whatever they go to, and be it a point: sixteen rays traced as they come are faster than eight that the traversal
// takes for coherent, and more than eight cannot be (occlusion_width()).
constexpr bool rays_agree = false;

struct MaskLayer {
  RayLight rays;  // not of the combined lights
  bool filtered;
  bool kept;  // stays as it is
};

// A filter looks at the 5x5 pixels around each: a quarter of them tell it enough.
bool is_measured(uint32_t column, uint32_t row) {
  return ((column | row) & 1) == 0;
}

struct TileWorker {
  DepthPoints points;
  TileRays rays;
  CombinedLights::Block drawn;
  std::vector<DepthPoint> block;        // points of a block
  std::vector<uint32_t> block_indices;  // and which they are
  std::vector<Ray> chosen;
  std::vector<uint32_t> of_chosen;  // index of its pixel
  std::array<uint8_t, tile_size * tile_size> occluded;
  std::vector<Hit> hits;
  Veils veils;
  TileTints tints;
  std::vector<Ray> clear;  // those that nothing opaque stops
  std::vector<uint32_t> of_clear;
  std::vector<float> of_clear_weights;
  // Sums over a pixel's rays to the sky: of their weights, and of those that go through.
  std::array<float, tile_size * tile_size> sum, open, unhidden;
  Counters counters;
};

class MaskTracer {
 public:
  MaskTracer(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks)
      : request_(request),
        shading_(scene.shading()),
        snapshot_(*shading_.snapshot),
        intersector_(scene.intersector()),
        view_(request.view, request.width, request.height),
        tinted_(shading_.glass != nullptr),
        veiled_(request.ao_rays > 0 && veils_sky(snapshot_)),
        sky_(request.ao_rays > 0 && request.ao_by_light ? &scene.sky() : nullptr),
        lights_(light_masks_of(request)),
        masks_(masks) {
    const bool random = is_random(request.inexact, request.inexact_bits);
    for (const uint32_t number : lights_of(request.shadow_lights)) {
      const model::Light& light = snapshot_.lights[number];
      const RayLight rays = rays_to(reaching(light, request.least_light));
      layers_.push_back({rays, is_filtered(light, random), is_kept(layers_.size())});
    }
    if (!request.combined_lights) return;
    layers_.push_back({{}, true, is_kept(layers_.size())});
    combined_ = CombinedLights(scene.shading());
  }

  bool traces_lights() const {
    return std::any_of(layers_.begin(), layers_.end(), [](const MaskLayer& layer) { return !layer.kept; });
  }
  // What nothing opaque hides is kept where the sky's mask is.
  bool traces_sky() const { return request_.ao_rays > 0 && !is_kept(masks_.layers); }

  // Makes a tile lit, and its distances infinite.
  void open_tile(size_t tile) const {
    for (uint32_t layer = 0; layer < lights_; ++layer) {
      if (layers_[layer].kept) continue;
      fill_tile(masks_.lit, layer, tile, uint8_t{255});
      for_each_filter_tile(tile, [&](uint32_t u, uint32_t v) {
        masks_.seen[filter_index(layer, u, v)] = OcclusionMasks::seen_lit;
        forget_distances(layer, u, v);
      });
      if (request_.hit_distances) fill_tile(masks_.hit_distance, layer, tile, INFINITY);
    }
  }

  void open_sky(size_t tile) const {
    fill_tile(masks_.open, 0, tile, uint8_t{255});
    if (!masks_.open_distance.empty()) fill_tile(masks_.open_distance, 0, tile, INFINITY);
    if (!request_.unhidden_sky) return;
    fill_tile(masks_.lit, lights_, tile, uint8_t{255});
    if (!masks_.filter_distance.empty()) fill_tile(masks_.filter_distance, lights_, tile, INFINITY);
  }

  void trace_shadows(size_t tile, TileWorker& w) const {
    open_tile(tile);
    const PointTile& points = w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
    for (uint32_t layer = 0; layer < lights_; ++layer) {
      if (layers_[layer].kept) continue;
      make_rays(points, layer, w);
      if (w.rays.size() == 0) continue;
      intersector_.occluded(w.rays.columns(), rays_agree, w.occluded.data());
      w.counters.rays_shadow += w.rays.size();
      if (tinted_) pass_glass(layer, tile, w);
      if (darken(points, layer, tile, w) && request_.filters && layers_[layer].filtered)
        measure(points, layer, masks_.filter_distance, w, [&](uint32_t ray, uint32_t pixel) {
          return w.occluded[ray] != 0 && is_measured(column_in_tile(pixel), row_in_tile(pixel));
        });
    }
  }

  // Puts what the threads found of tints into the masks. `fresh`, of each tile: 1 where it is of this frame, or is lit
  // because it was given up.
  void store_tints(std::span<TileWorker> workers, std::span<const uint8_t> fresh, Executor& executor) const {
    std::vector<std::vector<const TintTile*>> found(layers_.size());
    for (const TileWorker& w : workers)
      for (const TintTile& t : w.tints.found) {
        found[t.layer].resize(tiles());
        found[t.layer][t.tile] = &t;
      }
    for (uint32_t layer = 0; layer < lights_; ++layer)
      if (!found[layer].empty() && masks_.tint_places[layer] == 0) masks_.add_tint(layer, request_.filters != nullptr);
    for (uint32_t layer = 0; layer < lights_; ++layer) {
      const uint32_t place = masks_.tint_places[layer];
      if (place == 0 || layers_[layer].kept) continue;
      bool coloured = !std::ranges::all_of(fresh, [](uint8_t tile) { return tile != 0; });
      for (const TintTile* tinted : found[layer])
        coloured = coloured || (tinted && (tinted->left[0] != tinted->left[1] || tinted->left[0] != tinted->left[2]));
      masks_.tint_coloured[place - 1] = coloured;
      executor.run(tiles(), [&](size_t tile, uint32_t) {
        const TintTile* tinted = found[layer].empty() ? nullptr : found[layer][tile];
        if (fresh[tile]) masks_.store_tint(place, tile, tinted);
      });
    }
  }

  // Measures what trace_shadows() left out: of tiles that are all dark, at whose borders others are lit.
  void trace_borders(size_t tile, TileWorker& w) const {
    const PointTile* points = nullptr;
    for (uint32_t layer = 0; layer < lights_; ++layer) {
      if (!layers_[layer].filtered || layers_[layer].kept) continue;
      if (!is_dark(layer, tile) || !has_penumbra(layer, tile)) continue;
      if (!points) points = &w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
      make_rays(*points, layer, w);
      measure(*points, layer, masks_.filter_distance, w, [&](uint32_t, uint32_t pixel) {
        const uint32_t i = column_in_tile(pixel), j = row_in_tile(pixel);
        return is_measured(i, j) && in_penumbra(layer, (points->x0 + i) / filter_tile, (points->y0 + j) / filter_tile);
      });
    }
  }

  // Measures the distance of every dark pixel where the light is seen in part.
  void trace_distances(size_t tile, TileWorker& w) const {
    const PointTile* points = nullptr;
    for (uint32_t layer = 0; layer < lights_; ++layer) {
      if (!has_penumbra(layer, tile)) continue;
      if (!points) points = &w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
      make_rays(*points, layer, w);
      measure(*points, layer, masks_.hit_distance, w, [&](uint32_t, uint32_t pixel) {
        const uint32_t x = points->x0 + column_in_tile(pixel), y = points->y0 + row_in_tile(pixel);
        return in_penumbra(layer, x / filter_tile, y / filter_tile) && masks_.lit[texel(layer, x, y)] == 0;
      });
    }
  }

  void trace_open(size_t tile, TileWorker& w) const {
    open_sky(tile);
    const PointTile& points = w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
    look_at_sky(points, request_.ao_rays, !masks_.open_distance.empty(), w);
    store_open(points, w);
  }

  // Samples the sky of a tile for pixels that have no rays of their own yet.
  void sample_sky(size_t tile, TileWorker& w, CoarseSky& sky) const {
    w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
    const PointTile& points = w.points.thin(CoarseSky::step);
    look_at_sky(points, std::max(request_.ao_rays, coarse_rays), false, w);
    sky.start(tile);
    for_each_pixel(points.drawn, [&](uint32_t pixel) {
      if (!(w.sum[pixel] > 0.0f)) return;
      sky.add(tile, column_in_tile(pixel), row_in_tile(pixel), {share(w.open[pixel], w.sum[pixel]), share(w.unhidden[pixel], w.sum[pixel])});
    });
  }

  size_t tiles() const { return size_t{columns()} * tile_count(request_.height); }
  // Which tile is traced in which turn; empty = as they are numbered.
  std::vector<uint32_t> turns(OlderMasks::Part part) const {
    if (!is_bounded(request_.work)) return {};
    std::vector<uint32_t> order = order_of_importance(columns(), tile_count(request_.height));
    if (request_.older) order_by_turns(request_.older->turns(part), order);
    return order;
  }

 private:
  // Sums up what n rays of each point find.
  void look_at_sky(const PointTile& points, uint32_t n, bool measures_first, TileWorker& w) const {
    w.open.fill(0.0f);
    w.unhidden.fill(0.0f);
    w.sum.fill(0.0f);
    RayRandom random{request_.seed, ao_purpose, 0, open_dimension, request_.inexact};
    const TileSamples samples(random, points.x0, points.y0);
    for (uint32_t k = 0; k < n; ++k, ++random.dimension) {
      make_open_rays(rays_to_the_sky(request_.ao_distance, n, k), random, samples, points, w);
      intersector_.occluded(w.rays.columns(), rays_agree, w.occluded.data(), OpaqueSet::occludes_sky);
      w.counters.rays_ao += w.rays.size();
      const bool measures = k == 0 && measures_first;
      for (uint32_t r = 0; r < w.rays.size(); ++r) {
        const uint32_t pixel = w.rays.pixel(r);
        const float weight = w.rays.weight(r), unhidden = w.occluded[r] ? 0.0f : weight;
        w.sum[pixel] += weight;
        w.open[pixel] += unhidden;
        w.unhidden[pixel] += unhidden;
      }
      if (measures) measure_open(points, w);
      if (veiled_) see_through_veils(points, measures, w);
    }
  }

  static uint8_t share(float open, float sum) { return static_cast<uint8_t>(std::clamp(open * (255.0f / sum) + 0.5f, 0.0f, 255.0f)); }

  bool is_kept(size_t layer) const { return request_.kept && request_.kept->keeps(static_cast<uint32_t>(layer)); }
  bool is_combined(uint32_t layer) const { return request_.combined_lights && layer + 1 == layers_.size(); }
  static uint32_t tile_count(uint32_t pixels) { return (pixels + tile_size - 1) / tile_size; }
  uint32_t columns() const { return tile_count(request_.width); }
  uint32_t tile_x(size_t tile) const { return static_cast<uint32_t>(tile % columns()) * tile_size; }
  uint32_t tile_y(size_t tile) const { return static_cast<uint32_t>(tile / columns()) * tile_size; }
  size_t texel(uint32_t layer, uint32_t x, uint32_t y) const {
    return (size_t{layer} * request_.height + y) * request_.width + x;
  }
  size_t texel(uint32_t layer, const PointTile& points, uint32_t pixel) const {
    return texel(layer, points.x0 + column_in_tile(pixel), points.y0 + row_in_tile(pixel));
  }

  template <typename T>
  void fill(std::vector<T>& plane, uint32_t layer, uint32_t x0, uint32_t y0, uint32_t side, T value) const {
    const uint32_t width = std::min(side, request_.width - x0);
    for (uint32_t y = y0; y < std::min(y0 + side, request_.height); ++y)
      std::fill_n(plane.begin() + static_cast<ptrdiff_t>(texel(layer, x0, y)), width, value);
  }
  template <typename T>
  void fill_tile(std::vector<T>& plane, uint32_t layer, size_t tile, T value) const {
    fill(plane, layer, tile_x(tile), tile_y(tile), tile_size, value);
  }

  // Calls work(column, row) for each of the filters' tiles within a tile.
  template <typename Work>
  void for_each_filter_tile(size_t tile, const Work& work) const {
    const uint32_t u = tile_x(tile) / filter_tile, v = tile_y(tile) / filter_tile;
    for (uint32_t j = v; j < std::min(v + filter_across, masks_.filter_rows()); ++j)
      for (uint32_t i = u; i < std::min(u + filter_across, masks_.filter_columns()); ++i) work(i, j);
  }
  size_t filter_index(uint32_t layer, uint32_t u, uint32_t v) const { return masks_.filter_index(layer, u, v); }
  bool in_penumbra(uint32_t layer, uint32_t u, uint32_t v) const { return masks_.in_penumbra(layer, u, v); }

  bool has_penumbra(uint32_t layer, size_t tile) const {
    bool any = false;
    for_each_filter_tile(tile, [&](uint32_t u, uint32_t v) { any = any || in_penumbra(layer, u, v); });
    return any;
  }
  bool is_dark(uint32_t layer, size_t tile) const {
    bool all = true;
    for_each_filter_tile(tile, [&](uint32_t u, uint32_t v) {
      all = all && masks_.seen[filter_index(layer, u, v)] == OcclusionMasks::seen_dark;
    });
    return all;
  }

  // Makes the distances of one of the filters' tiles infinite again, where an earlier frame set some.
  void forget_distances(uint32_t layer, uint32_t u, uint32_t v) const {
    if (!request_.filters || !layers_[layer].filtered) return;
    uint8_t& measured = masks_.measured[filter_index(layer, u, v)];
    if (!measured) return;
    measured = 0;
    fill(masks_.filter_distance, layer, u * filter_tile, v * filter_tile, filter_tile, INFINITY);
  }

  // Writes what is occluded, and what the filters' tiles see; returns whether there is some, and not all, in shadow.
  bool darken(const PointTile& points, uint32_t layer, size_t tile, TileWorker& w) const {
    uint32_t dark[filter_across * filter_across] = {}, sum = 0, pixels = 0;
    for (uint32_t r = 0; r < w.rays.size(); ++r) {
      if (!w.occluded[r]) continue;
      const uint32_t pixel = w.rays.pixel(r), i = column_in_tile(pixel), j = row_in_tile(pixel);
      masks_.lit[texel(layer, points.x0 + i, points.y0 + j)] = 0;
      ++dark[j / filter_tile * filter_across + i / filter_tile];
    }
    for_each_filter_tile(tile, [&](uint32_t u, uint32_t v) {
      const uint32_t width = std::min(filter_tile, request_.width - u * filter_tile);
      const uint32_t height = std::min(filter_tile, request_.height - v * filter_tile);
      const uint32_t count = dark[v % filter_across * filter_across + u % filter_across];
      const int seen =
          (count > 0 ? OcclusionMasks::seen_dark : 0) | (count < width * height ? OcclusionMasks::seen_lit : 0);
      masks_.seen[filter_index(layer, u, v)] = static_cast<uint8_t>(seen);
      sum += count;
      pixels += width * height;
    });
    return sum > 0 && sum < pixels;
  }

  // Finds what translucent surfaces leave of the rays that nothing opaque stops.
  void pass_glass(uint32_t layer, size_t tile, TileWorker& w) const {
    w.tints.begin(shading_, intersector_);
    w.counters.rays_shadow += w.tints.trace({.layer = layer,
                                             .tile = static_cast<uint32_t>(tile),
                                             .rays = w.rays.columns(),
                                             .pixels = w.rays.pixels(),
                                             .blocked = w.occluded.data(),
                                             .filtered = request_.filters && layers_[layer].filtered,
                                             .seed = request_.seed});
  }

  RayRandom random_of(uint32_t layer) const {
    const uint32_t dimension = is_combined(layer) ? combined_dimension : layer;
    return {request_.seed, point_purpose, dimension, dimension, request_.inexact};
  }

  void make_rays(const PointTile& points, uint32_t layer, TileWorker& w) const {
    const RayRandom random = random_of(layer);
    const TileSamples samples(random, points.x0, points.y0);
    if (!is_combined(layer)) return w.rays.make(layers_[layer].rays, random, samples, points);
    w.rays.clear();
    for (uint32_t block = 0; block < tile_size / combined_block * (tile_size / combined_block); ++block) {
      gather_block(points, block, w);
      if (!w.block.empty()) make_block_rays(random, samples, w);
    }
  }

  // Finds the points that draw lights from the same bounds.
  void gather_block(const PointTile& points, uint32_t block, TileWorker& w) const {
    constexpr uint32_t across = tile_size / combined_block;
    w.block.clear();
    w.block_indices.clear();
    for_each_pixel(points.drawn, [&](uint32_t pixel) {
      if (row_in_tile(pixel) / combined_block * across + column_in_tile(pixel) / combined_block != block) return;
      w.block.push_back(point_at(points, pixel));
      w.block_indices.push_back(pixel);
    });
  }

  // Makes one ray a point, to the light that it draws.
  void make_block_rays(const RayRandom& random, const TileSamples& samples, TileWorker& w) const {
    w.drawn.begin(combined_, w.block);
    for (size_t i = 0; i < w.block.size(); ++i) {
      const DepthPoint& p = w.block[i];
      const uint32_t key = random_key({request_.seed, combined_purpose, uint32_t{p.y} << 16 | p.x});
      const std::optional<uint32_t> light = w.drawn.draw(p, key);
      Ray ray;
      if (light && make_ray(rays_to(snapshot_.lights[*light]), random, samples, p, ray))
        w.rays.push_back(ray, w.block_indices[i]);
    }
  }

  // Measures how far the rays go that wanted(ray, pixel) names.
  template <typename Wanted>
  void measure(const PointTile& points, uint32_t layer, std::vector<float>& distances, TileWorker& w,
               const Wanted& wanted) const {
    choose(w, wanted);
    intersector_.nearest_opaque(w.chosen, rays_agree, w.hits.data(), OpaqueSet::casts_shadow);
    w.counters.rays_shadow += w.chosen.size();
    for (size_t r = 0; r < w.chosen.size(); ++r)
      distances[texel(layer, points, w.of_chosen[r])] = static_cast<float>(w.hits[r].distance);
    if (&distances != &masks_.filter_distance) return;
    for (const uint32_t pixel : w.of_chosen) {
      const uint32_t x = points.x0 + column_in_tile(pixel), y = points.y0 + row_in_tile(pixel);
      masks_.measured[filter_index(layer, x / filter_tile, y / filter_tile)] = 1;
    }
  }

  // Takes away what translucent surfaces keep of the rays that nothing opaque stops.
  void see_through_veils(const PointTile& points, bool measures, TileWorker& w) const {
    w.clear.clear();
    w.of_clear.clear();
    w.of_clear_weights.clear();
    const RayColumns rays = w.rays.columns();
    for (uint32_t r = 0; r < w.rays.size(); ++r) {
      if (w.occluded[r]) continue;
      w.clear.push_back(rays[r]);
      w.of_clear.push_back(w.rays.pixel(r));
      w.of_clear_weights.push_back(w.rays.weight(r));
    }
    if (w.clear.empty()) return;
    w.counters.rays_ao += w.clear.size();
    w.veils.meet(shading_, intersector_, w.clear, rays_agree);
    for (size_t i = 0; i < w.clear.size(); ++i) {
      const float through = w.veils.through(i);
      if (through == 1.0f) continue;
      const uint32_t pixel = w.of_clear[i];
      w.open[pixel] += (through - 1.0f) * w.of_clear_weights[i];
      if (measures && is_measured(column_in_tile(pixel), row_in_tile(pixel)))
        masks_.open_distance[texel(0, points, pixel)] = w.veils.distance(i);
    }
  }

  void make_open_rays(const RayLight& to, const RayRandom& random, const TileSamples& samples, const PointTile& points,
                      TileWorker& w) const {
    if (!sky_ || sky_->black()) return w.rays.make(to, random, samples, points);
    w.rays.make(to, *sky_, random, samples, points);
  }

  void store_open(const PointTile& points, const TileWorker& w) const {
    for_each_pixel(points.drawn, [&](uint32_t pixel) {
      // No ray of such a pixel goes to where light comes from.
      if (!(w.sum[pixel] > 0.0f)) return;
      masks_.open[texel(0, points, pixel)] = share(w.open[pixel], w.sum[pixel]);
      if (request_.unhidden_sky) masks_.lit[texel(lights_, points, pixel)] = share(w.unhidden[pixel], w.sum[pixel]);
    });
  }

  // A pixel's neighbours tell the filter the rest.
  void measure_open(const PointTile& points, TileWorker& w) const {
    choose(w, [&](uint32_t ray, uint32_t pixel) {
      return w.occluded[ray] != 0 && is_measured(column_in_tile(pixel), row_in_tile(pixel));
    });
    intersector_.nearest_opaque(w.chosen, rays_agree, w.hits.data(), OpaqueSet::occludes_sky);
    w.counters.rays_ao += w.chosen.size();
    const bool measures_unhidden = request_.unhidden_sky && !masks_.filter_distance.empty();
    for (size_t r = 0; r < w.chosen.size(); ++r) {
      const auto distance = static_cast<float>(w.hits[r].distance);
      masks_.open_distance[texel(0, points, w.of_chosen[r])] = distance;
      if (measures_unhidden) masks_.filter_distance[texel(lights_, points, w.of_chosen[r])] = distance;
    }
  }

  template <typename Wanted>
  static void choose(TileWorker& w, const Wanted& wanted) {
    w.chosen.clear();
    w.of_chosen.clear();
    const RayColumns rays = w.rays.columns();
    for (uint32_t r = 0; r < w.rays.size(); ++r) {
      if (!wanted(r, w.rays.pixel(r))) continue;
      w.chosen.push_back(rays[r]);
      w.of_chosen.push_back(w.rays.pixel(r));
    }
    w.hits.resize(w.chosen.size());
  }

  const MaskRequest& request_;
  const ShadingScene& shading_;
  const model::Snapshot& snapshot_;
  const Intersector& intersector_;
  ViewRays view_;
  bool tinted_, veiled_;
  const SkyDirections* sky_;  // where rays go there; null: by the cosine
  uint32_t lights_;           // masks of them; the one of what is not hidden is behind
  std::vector<MaskLayer> layers_;
  CombinedLights combined_;
  OcclusionMasks& masks_;
};

void check(const MaskRequest& r, const model::Snapshot& snapshot) {
  if (r.width == 0 || r.height == 0 || r.width > 65535 || r.height > 65535)
    fail(SIDERAY_INVALID_ARGUMENT, "masks of {}x{}: each side must be 1 to 65535", r.width, r.height);
  if (!r.depth.texels) fail(SIDERAY_INVALID_ARGUMENT, "masks: no depth; give a depth buffer");
  const uint32_t lights = static_cast<uint32_t>(std::min<size_t>(snapshot.lights.size(), 32));
  if (lights < 32 && (r.shadow_lights >> lights) != 0)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow_lights {:#x}: the scene has {} lights; clear the bits beyond", r.shadow_lights,
         snapshot.lights.size());
  if (!(r.shadow_bias >= 0.0f) || !std::isfinite(r.shadow_bias))
    fail(SIDERAY_INVALID_ARGUMENT, "shadow_bias {}: give a finite length of 0 or more", r.shadow_bias);
  if (!(r.inexact_bias >= 0.0f) || !std::isfinite(r.inexact_bias))
    fail(SIDERAY_INVALID_ARGUMENT, "inexact_bias {}: give a finite length of 0 or more", r.inexact_bias);
  if (r.inexact != SIDERAY_EXACT && r.inexact_bits != 0 && !has_stencil(r.depth.format))
    fail(SIDERAY_INVALID_ARGUMENT, "inexact_bits: the depth buffer has no stencil; attach one or clear inexact_bits");
  if (!r.rest_offsets.empty() && r.rest_offsets.size() != size_t{r.width} * r.height)
    fail(SIDERAY_INTERNAL, "masks: {} rest offsets for {}x{} pixels", r.rest_offsets.size(), r.width, r.height);
  if (r.ao_rays > 256 || (r.ao_rays > 0 && !(r.ao_distance > 0.0f)))
    fail(SIDERAY_INVALID_ARGUMENT, "ao_rays {}, ao_distance {}: give 0 to 256 and more than 0", r.ao_rays,
         r.ao_distance);
  if (r.unhidden_sky && r.ao_rays == 0) fail(SIDERAY_INTERNAL, "masks: unhidden without ambient occlusion");
}

// Makes the masks as large as the request asks; what they held last counts where their size stays.
void fit(const MaskRequest& r, OcclusionMasks& masks) {
  const size_t pixels = size_t{r.width} * r.height;
  const uint32_t layers = mask_layers_of(r);
  const bool same = masks.width == r.width && masks.height == r.height && masks.layers == layers;
  masks.width = r.width;
  masks.height = r.height;
  masks.layers = layers;
  const size_t filter_tiles = size_t{masks.filter_columns()} * masks.filter_rows() * layers;
  const size_t distances = r.filters ? pixels * layers : 0;
  if (!same || masks.filter_distance.size() != distances) {
    masks.filter_distance.assign(distances, INFINITY);
    masks.measured.assign(filter_tiles, 0);
  }
  if (!same || (masks.tints > 0 && masks.tint_distance.empty() != (r.filters == nullptr))) masks.forget_tints();
  masks.seen.resize(filter_tiles);
  masks.lit.resize(pixels * layers);
  masks.hit_distance.resize(r.hit_distances ? pixels * layers : 0);
  masks.open.resize(r.ao_rays > 0 ? pixels : 0);
  masks.open_distance.resize(r.ao_rays > 0 && r.filters ? pixels : 0);
}

// For hosts that look masks up by the places of surfaces.
void find_depth(const MaskRequest& r, Executor& executor, OcclusionMasks& masks) {
  if (!r.moving) {
    masks.depth.clear();
    return;
  }
  fill_depths(executor, r.depth, FrameCamera(r.view, r.width, r.height), masks.depth);
  masks.depth_step = r.depth.format == DepthFormat::d16 ? 0x1p-16f : 0x1p-24f;
}

// The masks of the sky come behind those of lights, and get half of the time.
WorkTime half_of(WorkTime work) {
  const Deadline now = Deadline::clock::now();
  if (has_deadline(work.deadline) && work.deadline > now) work.deadline = now + (work.deadline - now) / 2;
  return work;
}

// Whether some mask of a position was not traced yet since it began.
bool waits(const MaskRequest& r, const Counters& counters) {
  return r.position_frames > 0 && (counters.mask_pixels_late > 0 || counters.frames_waiting >= r.position_frames);
}

// Fills `masks`, but for those that the request keeps.
Counters trace_unfiltered(const MaskRequest& r, TracedScene& scene, OcclusionMasks& masks) {
  check(r, *scene.shading().snapshot);
  Executor& executor = scene.executor();
  const Stopwatch looking;
  if (r.kept) r.kept->begin(r, scene, masks);
  Counters sum;
  (light_masks_of(r) > 0 ? sum.trace_shadow_ms : sum.trace_ao_ms) = looking.ms();
  fit(r, masks);
  OlderMasks* older = has_older(r) ? r.older : nullptr;
  if (r.older && !older) r.older->forget();
  if (older) older->begin(r, scene, masks);
  const MaskTracer tracer(r, scene, masks);
  std::vector<TileWorker> workers(executor.threads());
  std::atomic<bool> whole{true};
  std::vector<uint8_t> fresh(tracer.tiles(), 1);  // tiles of lights that do not show older masks
  const std::vector<uint8_t> for_lights = traced_tiles(r.wanted, r.width, lights_traced);
  const std::vector<uint8_t> for_sky = traced_tiles(r.wanted, r.width, sky_traced);
  if (!for_lights.empty()) fresh = for_lights;
  TileReach* reach = r.wanted ? r.wanted->reach.get() : nullptr;
  if (reach) reach->fit(r.view, r.width, r.height, r.depth);
  const auto trace_tile = [&](const std::vector<uint8_t>& traced, size_t tile, TileWorker& w, const auto& work) {
    if (!traced.empty() && !traced[tile]) return;
    Following rays(r.wanted && r.wanted->has(tile) ? reach : nullptr, Following::Rays::of_masks);
    work(tile, w);
    rays.add_to(tile);
  };
  const auto is_cancelled = [&] { return r.cancelled && r.cancelled->load(); };
  // Traces a part of the masks, tile by tile; what is given up is opened, unless it was seen before.
  const auto run = [&](OlderMasks::Part part, const WorkTime& time, auto work, auto open) {
    const Stopwatch watch;
    const std::vector<uint32_t> turns = tracer.turns(part);
    WorkClock clock(time);
    std::atomic<size_t> next{0};
    // Threads have parts of the numbers each: where the order counts, whoever is free takes the next.
    executor.run(tracer.tiles(), [&](size_t numbered, uint32_t thread) {
      const size_t number = turns.empty() ? numbered : next++, tile = turns.empty() ? numbered : turns[number];
      if (is_cancelled() || !clock.run(number, [&] {
            trace_tile(part == OlderMasks::of_sky ? for_sky : for_lights, tile, workers[thread], work);
          })) {
        whole = false;
        const bool is_older = older && older->knows(part);
        if (!is_older) open(tile);
        if (older) older->leave(r, part, tile, masks, workers[thread].counters);
        if (is_older && part == OlderMasks::of_lights) fresh[tile] = 0;
        return;
      }
      if (older) older->traced(r, part, tile);
    });
    if (older && !is_cancelled()) older->end(part);
    return watch.ms();
  };
  const auto run_after = [&](auto work) {
    const Stopwatch watch;
    executor.run(tracer.tiles(), [&](size_t tile, uint32_t thread) {
      if (!is_cancelled() && !has_passed(r.work.deadline)) trace_tile(for_lights, tile, workers[thread], work);
    });
    return watch.ms();
  };
  // Tiles of which nothing is known see the sky by a few samples first.
  const auto sample_sky = [&] {
    const Stopwatch watch;
    std::vector<uint32_t> lacking = tracer.turns(OlderMasks::of_sky);
    std::erase_if(lacking, [&](uint32_t tile) { return !older->lacks_sky(tile); });
    WorkTime time = half_of(r.work);
    time.least_pieces = lacking.size() / least_sampled + 1;
    PiecesLeft pieces{r.work.pieces ? r.work.pieces->load() * CoarseSky::across * CoarseSky::across : 0};
    if (r.work.pieces) time.pieces = &pieces, time.least_pieces = 0;
    WorkClock clock(time);
    std::atomic<size_t> next{0};
    executor.run(lacking.size(), [&](size_t, uint32_t thread) {
      const size_t number = next++;
      if (!is_cancelled()) clock.run(number, [&] { tracer.sample_sky(lacking[number], workers[thread], older->coarse_sky()); });
    });
    return watch.ms();
  };
  if (older && tracer.traces_sky() && r.position_frames == 0) sum.trace_ao_ms += sample_sky();
  if (tracer.traces_lights()) {
    PiecesLeft pieces{r.work.pieces ? r.work.pieces->load() : 0};  // those of the sky are as many
    WorkTime time = tracer.traces_sky() ? half_of(r.work) : r.work;
    if (r.work.pieces) time.pieces = &pieces;
    sum.trace_shadow_ms += run(OlderMasks::of_lights, time,
                               [&](size_t tile, TileWorker& w) { tracer.trace_shadows(tile, w); },
                               [&](size_t tile) { tracer.open_tile(tile); });
    if (masks.tints > 0 || scene.shading().glass) {
      const Stopwatch storing;
      tracer.store_tints(workers, fresh, executor);
      sum.trace_shadow_ms += storing.ms();
    }
    // Borders are those of whole masks.
    const bool later = std::ranges::any_of(workers, [&](const TileWorker& w) { return waits(r, w.counters); });
    if (r.filters && !later)
      sum.trace_shadow_ms += run_after([&](size_t tile, TileWorker& w) { tracer.trace_borders(tile, w); });
    if (r.hit_distances)
      sum.trace_shadow_ms += run_after([&](size_t tile, TileWorker& w) { tracer.trace_distances(tile, w); });
  }
  if (tracer.traces_sky())
    sum.trace_ao_ms += run(OlderMasks::of_sky, r.work, [&](size_t tile, TileWorker& w) { tracer.trace_open(tile, w); },
                           [&](size_t tile) { tracer.open_sky(tile); });
  masks.whole = whole;
  for (const TileWorker& w : workers) sum += w.counters;
  sum.pixels_total = size_t{r.width} * r.height;
  return sum;
}

// Returns the filters' tiles in the tiles that are wanted, and up to `around` beside them.
std::vector<uint8_t> filter_tiles_of(const WantedTiles& wanted, const OcclusionMasks& masks, uint32_t around) {
  const uint32_t columns = tile_count(masks.width);
  std::vector<uint8_t> result;
  for (uint32_t v = 0; v < masks.filter_rows(); ++v)
    for (uint32_t u = 0; u < masks.filter_columns(); ++u)
      result.push_back(wanted.has(size_t{v / filter_across} * columns + u / filter_across));
  return grown(result, masks.filter_columns(), around);
}

// Older masks know the frame's depths already, and what is filtered.
void filter(const MaskRequest& r, TracedScene& scene, OcclusionMasks& masks) {
  MaskRequest filtered = r;
  std::vector<uint8_t> of_lights, of_sky;
  TracedTiles traced;
  if (has_older(r)) filtered.view_depths = r.older->depths();
  if (r.position_frames > 0) filtered.sequence = SequenceStep::first;
  if (has_older(r) && !masks.whole && r.position_frames == 0) {
    of_lights = r.older->new_tiles(masks, OlderMasks::of_lights);
    of_sky = r.older->new_tiles(masks, OlderMasks::of_sky);
    traced = {of_lights, of_sky, r.older->most_are_new()};
    filtered.traced = &traced;
  }
  if (r.wanted && !r.wanted->tiles.empty()) {
    of_lights = filter_tiles_of(*r.wanted, masks, lights_filtered);
    of_sky = filter_tiles_of(*r.wanted, masks, sky_filtered);
    traced = {of_lights, of_sky, false};
    filtered.traced = &traced;
  }
  r.filters->filter(scene.executor(), filtered, *scene.shading().snapshot, masks);
  if (has_older(r)) r.older->filtered();
}

}  // namespace

Counters trace_masks(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks) {
  const bool is_done = request.position_frames > 1 && has_older(request) && request.sequence == SequenceStep::next &&
                       request.older->is_complete();
  if (is_done) return {};
  masks.answers.clear();
  Counters counters = trace_unfiltered(request, scene, masks);
  find_depth(request, scene.executor(), masks);
  if (request.cancelled && *request.cancelled) return counters;
  if (request.wanted && request.wanted->none()) {
    if (request.kept) request.kept->end(masks, false);
    return counters;
  }
  const bool later = waits(request, counters);
  if (request.filters && !later && !(request.kept && request.kept->keeps_all())) {
    const Stopwatch watch;
    filter(request, scene, masks);
    counters.denoise_ms = watch.ms();
  }
  masks.find_tinted(scene.executor());
  if (has_older(request)) request.older->end_frame(request, masks, scene.executor());
  if (has_older(request)) request.older->tell_answers(request, scene.executor(), masks);
  if (has_older(request) && request.position_frames > 0 && !later) request.older->complete();
  const bool all = !request.wanted || request.wanted->tiles.empty();
  if (request.kept) request.kept->end(masks, masks.whole && all);
  return counters;
}

}  // namespace sideray::rt
