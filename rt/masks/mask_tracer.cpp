#include "rt/masks/mask_tracer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "rt/base/sampling.h"
#include "rt/masks/mask_filters.h"

namespace sideray::rt {
namespace {

constexpr uint32_t point_purpose = 31, ao_purpose = 33, combined_purpose = 34;
// The combined lights' layer in random numbers; single lights have lower numbers.
constexpr uint32_t combined_dimension = 32;
constexpr uint32_t open_dimension = 64;  // of the first ambient ray
constexpr uint32_t coarse_rays = 4;      // at least, for a sample that represents many pixels
// Side in pixels of the blocks that share bounds of the combined lights.
constexpr uint32_t combined_block = 8;
// Even toward a point, packets of sixteen incoherent rays are faster than coherent ones, which hold at most eight rays
// (occlusion_width()).
constexpr bool rays_agree = false;

// A filter reads the 5x5 pixels around each, so a quarter of them suffices.
bool is_measured(uint32_t column, uint32_t row) {
  return ((column | row) & 1) == 0;
}

}  // namespace

MaskTracer::MaskTracer(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks)
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

bool MaskTracer::traces_lights() const {
  return std::any_of(layers_.begin(), layers_.end(), [](const Layer& layer) { return !layer.kept; });
}

void MaskTracer::open_tile(size_t tile) const {
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

void MaskTracer::open_sky(size_t tile) const {
  fill_tile(masks_.open, 0, tile, uint8_t{255});
  if (!masks_.open_distance.empty()) fill_tile(masks_.open_distance, 0, tile, INFINITY);
  if (!request_.unhidden_sky) return;
  fill_tile(masks_.lit, lights_, tile, uint8_t{255});
  if (!masks_.filter_distance.empty()) fill_tile(masks_.filter_distance, lights_, tile, INFINITY);
}

void MaskTracer::trace_shadows(size_t tile, Worker& w) const {
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

void MaskTracer::store_tints(std::span<Worker> workers, std::span<const uint8_t> fresh, Executor& executor) const {
  std::vector<uint32_t> fresh_tiles;
  for (uint32_t tile = 0; tile < tiles(); ++tile)
    if (fresh[tile]) fresh_tiles.push_back(tile);
  std::vector<std::vector<const TintTile*>> found(layers_.size());
  for (const Worker& w : workers)
    for (const TintTile& t : w.tints.found) {
      found[t.layer].resize(tiles());
      found[t.layer][t.tile] = &t;
    }
  for (uint32_t layer = 0; layer < lights_; ++layer)
    if (!found[layer].empty() && masks_.tint_places[layer] == 0) masks_.add_tint(layer, request_.filters != nullptr);
  for (uint32_t layer = 0; layer < lights_; ++layer) {
    const uint32_t place = masks_.tint_places[layer];
    if (place == 0 || layers_[layer].kept) continue;
    bool coloured = fresh_tiles.size() < tiles();
    for (const TintTile* tinted : found[layer])
      coloured = coloured || (tinted && (tinted->left[0] != tinted->left[1] || tinted->left[0] != tinted->left[2]));
    masks_.tint_coloured[place - 1] = coloured;
    executor.run(fresh_tiles.size(), [&](size_t i, uint32_t) {
      const uint32_t tile = fresh_tiles[i];
      masks_.store_tint(place, tile, found[layer].empty() ? nullptr : found[layer][tile]);
    });
  }
}

void MaskTracer::trace_borders(size_t tile, Worker& w) const {
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

void MaskTracer::trace_distances(size_t tile, Worker& w) const {
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

void MaskTracer::trace_open(size_t tile, Worker& w) const {
  open_sky(tile);
  const PointTile& points = w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
  look_at_sky(points, request_.ao_rays, !masks_.open_distance.empty(), w);
  store_open(points, w);
}

void MaskTracer::sample_sky(size_t tile, Worker& w, CoarseSky& sky) const {
  w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
  const PointTile& points = w.points.thin(CoarseSky::step);
  look_at_sky(points, std::max(request_.ao_rays, coarse_rays), false, w);
  sky.start(tile);
  for_each_pixel(points.drawn, [&](uint32_t pixel) {
    if (!(w.sum[pixel] > 0.0f)) return;
    sky.add(tile, column_in_tile(pixel), row_in_tile(pixel), {share(w.open[pixel], w.sum[pixel]), share(w.unhidden[pixel], w.sum[pixel])});
  });
}

std::vector<uint32_t> MaskTracer::turns(OlderMasks::Part part) const {
  if (!is_bounded(request_.work)) return {};
  std::vector<uint32_t> order = order_of_importance(columns(), tile_count(request_.height));
  if (request_.older) order_by_turns(request_.older->turns(part), order);
  return order;
}

void MaskTracer::look_at_sky(const PointTile& points, uint32_t n, bool measures_first, Worker& w) const {
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

size_t MaskTracer::texel(uint32_t layer, uint32_t x, uint32_t y) const {
  return (size_t{layer} * request_.height + y) * request_.width + x;
}

size_t MaskTracer::texel(uint32_t layer, const PointTile& points, uint32_t pixel) const {
  return texel(layer, points.x0 + column_in_tile(pixel), points.y0 + row_in_tile(pixel));
}

template <typename T>
void MaskTracer::fill(std::vector<T>& plane, uint32_t layer, uint32_t x0, uint32_t y0, uint32_t side, T value) const {
  const uint32_t width = std::min(side, request_.width - x0);
  for (uint32_t y = y0; y < std::min(y0 + side, request_.height); ++y)
    std::fill_n(plane.begin() + static_cast<ptrdiff_t>(texel(layer, x0, y)), width, value);
}

template <typename T>
void MaskTracer::fill_tile(std::vector<T>& plane, uint32_t layer, size_t tile, T value) const {
  fill(plane, layer, tile_x(tile), tile_y(tile), tile_size, value);
}

template <typename Work>
void MaskTracer::for_each_filter_tile(size_t tile, const Work& work) const {
  const uint32_t u = tile_x(tile) / filter_tile, v = tile_y(tile) / filter_tile;
  for (uint32_t j = v; j < std::min(v + filter_across, masks_.filter_rows()); ++j)
    for (uint32_t i = u; i < std::min(u + filter_across, masks_.filter_columns()); ++i) work(i, j);
}

bool MaskTracer::has_penumbra(uint32_t layer, size_t tile) const {
  bool any = false;
  for_each_filter_tile(tile, [&](uint32_t u, uint32_t v) { any = any || in_penumbra(layer, u, v); });
  return any;
}

bool MaskTracer::is_dark(uint32_t layer, size_t tile) const {
  bool all = true;
  for_each_filter_tile(tile, [&](uint32_t u, uint32_t v) {
    all = all && masks_.seen[filter_index(layer, u, v)] == OcclusionMasks::seen_dark;
  });
  return all;
}

void MaskTracer::forget_distances(uint32_t layer, uint32_t u, uint32_t v) const {
  if (!request_.filters || !layers_[layer].filtered) return;
  uint8_t& measured = masks_.measured[filter_index(layer, u, v)];
  if (!measured) return;
  measured = 0;
  fill(masks_.filter_distance, layer, u * filter_tile, v * filter_tile, filter_tile, INFINITY);
}

bool MaskTracer::darken(const PointTile& points, uint32_t layer, size_t tile, Worker& w) const {
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

void MaskTracer::pass_glass(uint32_t layer, size_t tile, Worker& w) const {
  const TileSamples samples(random_of(layer), tile_x(tile), tile_y(tile));
  w.tints.begin(shading_, intersector_);
  w.counters.rays_shadow += w.tints.trace({.layer = layer,
                                           .tile = static_cast<uint32_t>(tile),
                                           .rays = w.rays.columns(),
                                           .pixels = w.rays.pixels(),
                                           .blocked = w.occluded.data(),
                                           .orders = samples.keys().order,
                                           .to = is_combined(layer) ? nullptr : &layers_[layer].rays,
                                           .filtered = request_.filters && layers_[layer].filtered});
}

RayRandom MaskTracer::random_of(uint32_t layer) const {
  const uint32_t dimension = is_combined(layer) ? combined_dimension : layer;
  return {request_.seed, point_purpose, dimension, dimension, request_.inexact};
}

void MaskTracer::make_rays(const PointTile& points, uint32_t layer, Worker& w) const {
  const RayRandom random = random_of(layer);
  const TileSamples samples(random, points.x0, points.y0);
  if (!is_combined(layer)) return w.rays.make(layers_[layer].rays, random, samples, points);
  w.rays.clear();
  for (uint32_t block = 0; block < tile_size / combined_block * (tile_size / combined_block); ++block) {
    gather_block(points, block, w);
    if (!w.block.empty()) make_block_rays(random, samples, w);
  }
}

void MaskTracer::gather_block(const PointTile& points, uint32_t block, Worker& w) const {
  constexpr uint32_t across = tile_size / combined_block;
  w.block.clear();
  w.block_indices.clear();
  for_each_pixel(points.drawn, [&](uint32_t pixel) {
    if (row_in_tile(pixel) / combined_block * across + column_in_tile(pixel) / combined_block != block) return;
    w.block.push_back(point_at(points, pixel));
    w.block_indices.push_back(pixel);
  });
}

void MaskTracer::make_block_rays(const RayRandom& random, const TileSamples& samples, Worker& w) const {
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

template <typename Wanted>
void MaskTracer::measure(const PointTile& points, uint32_t layer, std::vector<float>& distances, Worker& w,
             const Wanted& wanted) const {
  choose(w, wanted);
  intersector_.nearest_opaque(w.chosen, {.set = OpaqueSet::casts_shadow, .coherent = rays_agree}, w.hits.data());
  w.counters.rays_shadow += w.chosen.size();
  for (size_t r = 0; r < w.chosen.size(); ++r)
    distances[texel(layer, points, w.of_chosen[r])] = static_cast<float>(w.hits[r].distance);
  if (&distances != &masks_.filter_distance) return;
  for (const uint32_t pixel : w.of_chosen) {
    const uint32_t x = points.x0 + column_in_tile(pixel), y = points.y0 + row_in_tile(pixel);
    masks_.measured[filter_index(layer, x / filter_tile, y / filter_tile)] = 1;
  }
}

void MaskTracer::see_through_veils(const PointTile& points, bool measures, Worker& w) const {
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

void MaskTracer::make_open_rays(const RayLight& to, const RayRandom& random, const TileSamples& samples, const PointTile& points,
                    Worker& w) const {
  if (!sky_ || sky_->black()) return w.rays.make(to, random, samples, points);
  w.rays.make(to, *sky_, random, samples, points);
}

void MaskTracer::store_open(const PointTile& points, const Worker& w) const {
  for_each_pixel(points.drawn, [&](uint32_t pixel) {
    // No ray of such a pixel has weight: the sky sends no light in their directions.
    if (!(w.sum[pixel] > 0.0f)) return;
    masks_.open[texel(0, points, pixel)] = share(w.open[pixel], w.sum[pixel]);
    if (request_.unhidden_sky) masks_.lit[texel(lights_, points, pixel)] = share(w.unhidden[pixel], w.sum[pixel]);
  });
}

void MaskTracer::measure_open(const PointTile& points, Worker& w) const {
  choose(w, [&](uint32_t ray, uint32_t pixel) {
    return w.occluded[ray] != 0 && is_measured(column_in_tile(pixel), row_in_tile(pixel));
  });
  intersector_.nearest_opaque(w.chosen, {.set = OpaqueSet::occludes_sky, .coherent = rays_agree}, w.hits.data());
  w.counters.rays_ao += w.chosen.size();
  const bool measures_unhidden = request_.unhidden_sky && !masks_.filter_distance.empty();
  for (size_t r = 0; r < w.chosen.size(); ++r) {
    const auto distance = static_cast<float>(w.hits[r].distance);
    masks_.open_distance[texel(0, points, w.of_chosen[r])] = distance;
    if (measures_unhidden) masks_.filter_distance[texel(lights_, points, w.of_chosen[r])] = distance;
  }
}

template <typename Wanted>
void MaskTracer::choose(Worker& w, const Wanted& wanted) {
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

}  // namespace sideray::rt
