#include "rt/masks/occlusion_masks.h"

#include <sideray/diagnostics.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/base/deadline.h"
#include "rt/base/sampling.h"
#include "rt/masks/combined_lights.h"
#include "rt/masks/depth_points.h"
#include "rt/masks/mask_filters.h"

namespace sideray::rt {
namespace {

constexpr float farthest_ray = 1e15f;
constexpr uint32_t filter_tile = 16;  // half of a tile of DepthPoints
constexpr uint32_t point_purpose = 31, bias_purpose = 32, ao_purpose = 33, combined_purpose = 34;
// Of random numbers, in place of the layer: masks of single lights have those below.
constexpr uint32_t combined_dimension = 32;
// Along each side of the pixels that draw from the same bounds of the combined lights.
constexpr uint32_t combined_block = 8;
// Half angle, in radians, up to which a light's rays go the same way for a packet.
constexpr float coherent_angle = 0.03f;

// A point set over each 8x8 block of a tile's pixels, so that neighbours' samples are stratified: what a spatial filter
// needs.
class TileSamples {
 public:
  TileSamples(uint32_t seed, uint32_t purpose, uint32_t layer, uint32_t x0, uint32_t y0) {
    for (uint32_t j = 0; j < across; ++j)
      for (uint32_t i = 0; i < across; ++i)
        blocks_[j * across + i] = PointSet(random_key({seed, purpose, layer, (y0 / side + j) << 16 | (x0 / side + i)}));
  }
  glm::vec2 at(const DepthPoint& p, uint32_t sample, uint32_t samples) const {
    const uint32_t x = p.x % DepthPoints::tile_size, y = p.y % DepthPoints::tile_size;
    return blocks_[y / side * across + x / side][(y % side * side + x % side) * samples + sample];
  }

 private:
  static constexpr uint32_t side = 8, across = DepthPoints::tile_size / side;
  std::array<PointSet, across * across> blocks_;
};

glm::mat3 frame_about(glm::vec3 z) {
  const glm::vec3 side = std::abs(z.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 x = glm::normalize(glm::cross(side, z));
  return {x, glm::cross(z, x), z};
}

// What the rays of all points to one light have in common.
struct LightRays {
  const model::Light* light;
  glm::mat3 frame;  // directional: z is the way to the light
  float aperture;
  bool samples, coherent;  // its area, or what it shows of it is one point; rays go the same way
  bool filtered;
};

LightRays light_rays(const model::Light& light, bool filtered) {
  if (light.type != SIDERAY_LIGHT_DIRECTIONAL)
    return {&light, {}, 0.0f, light.radius > 0.0f, light.radius == 0.0f, filtered};
  return {&light,
          frame_about(-light.direction),
          cone_aperture(light.angular_radius),
          light.angular_radius > 0.0f,
          light.angular_radius < coherent_angle,
          filtered};
}

// A filter looks at the 5x5 pixels around each: a quarter of them tell it enough.
bool is_measured(const DepthPoint& p) {
  return ((p.x | p.y) & 1) == 0;
}

struct TileWorker {
  DepthPoints points;
  CombinedLights::Block drawn;
  std::vector<DepthPoint> block;        // points of a block
  std::vector<uint32_t> block_indices;  // and which they are
  std::vector<Ray> rays;
  std::vector<uint32_t> of_ray;  // index of its point
  std::vector<uint8_t> occluded;
  std::vector<Hit> hits;
  Counters counters;
};

class MaskTracer {
 public:
  MaskTracer(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks)
      : request_(request),
        snapshot_(*scene.shading().snapshot),
        intersector_(scene.intersector()),
        view_(request.view, request.width, request.height),
        masks_(masks) {
    const bool random = is_random(request.inexact, request.inexact_bits);
    for (const uint32_t light : lights_of(request.lights))
      lights_.push_back(light_rays(snapshot_.lights[light], is_filtered(snapshot_.lights[light], random)));
    if (request.combined_lights) combined_ = CombinedLights(scene.shading());
  }

  void trace_shadows(size_t tile, TileWorker& w) const {
    const auto& points = w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
    for (uint32_t layer = 0; layer < masks_.layers; ++layer) {
      make_rays(points, tile, layer, w);
      w.occluded.resize(w.rays.size());
      intersector_.occluded(w.rays, is_coherent(layer), w.occluded.data());
      w.counters.rays_shadow += w.rays.size();
      for (size_t r = 0; r < w.rays.size(); ++r)
        if (w.occluded[r]) masks_.lit[texel(layer, points[w.of_ray[r]])] = 0;
    }
  }

  // Nearest hits where a filter reads their distance.
  // `all`: of every such pixel, otherwise of those that the filters' neighbourhoods need, of lights that are filtered.
  void trace_distances(size_t tile, const std::vector<uint8_t>& penumbra, bool all, TileWorker& w) const {
    if (!has_penumbra(tile, penumbra)) return;
    std::vector<float>& distances = all ? masks_.hit_distance : masks_.filter_distance;
    const auto& points = w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
    for (uint32_t layer = 0; layer < masks_.layers; ++layer) {
      if (!all && !is_filtered_layer(layer)) continue;
      make_rays(points, tile, layer, w);
      keep_dark(points, layer, penumbra, all, w);
      w.hits.resize(w.rays.size());
      intersector_.nearest_opaque(w.rays, is_coherent(layer), w.hits.data(), OpaqueSet::casts_shadow);
      w.counters.rays_shadow += w.rays.size();
      for (size_t r = 0; r < w.rays.size(); ++r)
        distances[texel(layer, points[w.of_ray[r]])] = static_cast<float>(w.hits[r].distance);
    }
  }

  void trace_open(size_t tile, TileWorker& w) const {
    const auto& points = w.points.gather(request_, view_, tile_x(tile), tile_y(tile));
    const uint32_t n = request_.ao_rays;
    const TileSamples samples(request_.seed, ao_purpose, 0, tile_x(tile), tile_y(tile));
    w.rays.clear();
    for (const DepthPoint& p : points) {
      const glm::mat3 frame = frame_about(p.normal);
      for (uint32_t k = 0; k < n; ++k) {
        const glm::vec3 d = frame * sample_cosine(samples.at(p, k, n));
        w.rays.push_back(started(p, p.front, d, std::min(request_.ao_distance, farthest_ray), 64u + k));
      }
    }
    w.occluded.resize(w.rays.size());
    intersector_.occluded(w.rays, false, w.occluded.data(), OpaqueSet::occludes_sky);
    w.counters.rays_ao += w.rays.size();
    if (!masks_.open_distance.empty()) measure_open(points, w);
    for (size_t i = 0; i < points.size(); ++i) {
      uint32_t open = 0;
      for (uint32_t k = 0; k < n; ++k) open += !w.occluded[i * n + k];
      masks_.open[texel(0, points[i])] = static_cast<uint8_t>((255u * open + n / 2) / n);
    }
  }

  // A pixel's neighbours tell the filter the rest.
  void measure_open(const std::vector<DepthPoint>& points, TileWorker& w) const {
    w.of_ray.clear();
    size_t kept = 0;
    for (uint32_t i = 0; i < points.size(); ++i) {
      if (!w.occluded[i * request_.ao_rays] || !is_measured(points[i])) continue;
      w.rays[kept++] = w.rays[i * request_.ao_rays];
      w.of_ray.push_back(i);
    }
    w.rays.resize(kept), w.hits.resize(kept);
    intersector_.nearest_opaque(w.rays, false, w.hits.data(), OpaqueSet::occludes_sky);
    w.counters.rays_ao += kept;
    for (size_t r = 0; r < kept; ++r)
      masks_.open_distance[texel(0, points[w.of_ray[r]])] = static_cast<float>(w.hits[r].distance);
  }

  size_t tiles() const { return size_t{columns()} * tile_count(request_.height); }
  // Which tile is traced in which turn; empty = as they are numbered.
  std::vector<uint32_t> turns() const {
    if (!has_deadline(request_.deadline)) return {};
    return order_of_importance(columns(), tile_count(request_.height));
  }

 private:
  bool is_combined(uint32_t layer) const { return layer == lights_.size(); }
  bool is_coherent(uint32_t layer) const { return !is_combined(layer) && lights_[layer].coherent; }
  bool is_filtered_layer(uint32_t layer) const { return is_combined(layer) || lights_[layer].filtered; }
  static uint32_t tile_count(uint32_t pixels) { return (pixels + DepthPoints::tile_size - 1) / DepthPoints::tile_size; }
  uint32_t columns() const { return tile_count(request_.width); }
  uint32_t tile_x(size_t tile) const { return static_cast<uint32_t>(tile % columns()) * DepthPoints::tile_size; }
  uint32_t tile_y(size_t tile) const { return static_cast<uint32_t>(tile / columns()) * DepthPoints::tile_size; }
  size_t texel(uint32_t layer, const DepthPoint& p) const {
    return (size_t{layer} * request_.height + p.y) * request_.width + p.x;
  }

  // The ray from a point, with the inexact test where the point is marked for it.
  Ray started(const DepthPoint& p, glm::vec3 origin, glm::vec3 direction, float t_far, uint32_t dimension) const {
    Ray ray{origin, p.skip, direction, t_far};
    if (!p.inexact || request_.inexact == SIDERAY_INEXACT_RESTPOSE) return ray;
    const float u = unit_float(random_key({request_.seed, bias_purpose, dimension, uint32_t{p.y} << 16 | p.x}));
    if (request_.inexact == SIDERAY_INEXACT_ORIGIN)
      ray.origin += direction * (u * p.bias);
    else
      ray.t_near = std::max(p.skip, u * p.bias);
    return ray;
  }

  // False where the light sends nothing to the point.
  bool light_ray(const LightRays& to, const TileSamples& samples, uint32_t layer, const DepthPoint& p, Ray& ray) const {
    const model::Light& light = *to.light;
    const glm::vec2 u = to.samples ? samples.at(p, 0, 1) : glm::vec2(0.0f);
    if (light.type == SIDERAY_LIGHT_DIRECTIONAL) {
      const glm::vec3 d = to.samples ? to.frame * sample_cone(u, to.aperture) : to.frame[2];
      ray = started(p, p.origin(d), d, farthest_ray, layer);
      return true;
    }
    const glm::vec3 offset = light.position - p.front;
    const float distance = glm::length(offset);
    if (!(distance > light.radius) || (light.range > 0.0f && distance > light.range)) return false;
    const glm::vec3 axis = offset / distance;
    if (light.type == SIDERAY_LIGHT_SPOT && -glm::dot(axis, light.direction) < light.cos_outer) return false;
    glm::vec3 d = axis;
    float reach = distance;
    if (to.samples) {
      const glm::vec3 sample = sample_cone(u, sphere_aperture(light.radius, distance));
      d = frame_about(axis) * sample;
      reach = distance_to_sphere(light.radius, distance, 1.0f - sample.z);
    }
    ray = started(p, p.origin(d), d, reach * (1.0f - 0x1p-20f), layer);
    return true;
  }

  void make_rays(const std::vector<DepthPoint>& points, size_t tile, uint32_t layer, TileWorker& w) const {
    if (is_combined(layer)) return make_combined_rays(points, tile, w);
    const TileSamples samples(request_.seed, point_purpose, layer, tile_x(tile), tile_y(tile));
    w.rays.clear(), w.of_ray.clear();
    for (uint32_t i = 0; i < points.size(); ++i) {
      Ray ray;
      if (!light_ray(lights_[layer], samples, layer, points[i], ray)) continue;
      w.rays.push_back(ray);
      w.of_ray.push_back(i);
    }
  }

  // One ray a point, to the light that it draws.
  void make_combined_rays(const std::vector<DepthPoint>& points, size_t tile, TileWorker& w) const {
    constexpr uint32_t across = DepthPoints::tile_size / combined_block;
    const TileSamples samples(request_.seed, point_purpose, combined_dimension, tile_x(tile), tile_y(tile));
    w.rays.clear();
    w.of_ray.clear();
    for (uint32_t block = 0; block < across * across; ++block) {
      w.block.clear();
      w.block_indices.clear();
      for (uint32_t i = 0; i < points.size(); ++i) {
        const uint32_t x = points[i].x % DepthPoints::tile_size, y = points[i].y % DepthPoints::tile_size;
        if (y / combined_block * across + x / combined_block != block) continue;
        w.block.push_back(points[i]);
        w.block_indices.push_back(i);
      }
      if (!w.block.empty()) make_block_rays(samples, w);
    }
  }

  void make_block_rays(const TileSamples& samples, TileWorker& w) const {
    w.drawn.begin(combined_, w.block);
    for (size_t i = 0; i < w.block.size(); ++i) {
      const DepthPoint& p = w.block[i];
      const uint32_t key = random_key({request_.seed, combined_purpose, uint32_t{p.y} << 16 | p.x});
      const std::optional<uint32_t> light = w.drawn.draw(p, key);
      Ray ray;
      if (!light || !light_ray(light_rays(snapshot_.lights[*light], true), samples, combined_dimension, p, ray))
        continue;
      w.rays.push_back(ray);
      w.of_ray.push_back(w.block_indices[i]);
    }
  }

  uint32_t filter_columns() const { return (request_.width + filter_tile - 1) / filter_tile; }
  uint32_t filter_rows() const { return (request_.height + filter_tile - 1) / filter_tile; }

  bool has_penumbra(size_t tile, const std::vector<uint8_t>& penumbra) const {
    const uint32_t u = tile_x(tile) / filter_tile, v = tile_y(tile) / filter_tile;
    for (uint32_t layer = 0; layer < masks_.layers; ++layer)
      for (uint32_t y = v; y < std::min(v + 2, filter_rows()); ++y)
        for (uint32_t x = u; x < std::min(u + 2, filter_columns()); ++x)
          if (penumbra[(size_t{layer} * filter_rows() + y) * filter_columns() + x]) return true;
    return false;
  }

  void keep_dark(const std::vector<DepthPoint>& points, uint32_t layer, const std::vector<uint8_t>& penumbra, bool all,
                 TileWorker& w) const {
    size_t kept = 0;
    for (size_t r = 0; r < w.rays.size(); ++r) {
      const DepthPoint& p = points[w.of_ray[r]];
      const size_t tile = (size_t{layer} * filter_rows() + p.y / filter_tile) * filter_columns() + p.x / filter_tile;
      if (!penumbra[tile] || masks_.lit[texel(layer, p)] != 0 || !(all || is_measured(p))) continue;
      w.rays[kept] = w.rays[r], w.of_ray[kept++] = w.of_ray[r];
    }
    w.rays.resize(kept), w.of_ray.resize(kept);
  }

  const MaskRequest& request_;
  const model::Snapshot& snapshot_;
  const Intersector& intersector_;
  ViewRays view_;
  std::vector<LightRays> lights_;  // that have masks of their own
  CombinedLights combined_;
  OcclusionMasks& masks_;
};

void check(const MaskRequest& r, const model::Snapshot& snapshot) {
  if (r.width == 0 || r.height == 0 || r.width > 65535 || r.height > 65535)
    fail(SIDERAY_INVALID_ARGUMENT, "masks of {}x{}: each side must be 1 to 65535", r.width, r.height);
  if (!r.depth.texels) fail(SIDERAY_INVALID_ARGUMENT, "masks: no depth; give a depth buffer");
  const uint32_t lights = static_cast<uint32_t>(std::min<size_t>(snapshot.lights.size(), 32));
  if (lights < 32 && (r.lights >> lights) != 0)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow_lights {:#x}: the scene has {} lights; clear the bits beyond", r.lights,
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
}

// Tiles whose pixels, or whose neighbours' pixels, see part of a light's rays go through and part not; layer-major.
std::vector<uint8_t> penumbra_tiles(const OcclusionMasks& masks) {
  const uint32_t across = (masks.width + filter_tile - 1) / filter_tile;
  const uint32_t down = (masks.height + filter_tile - 1) / filter_tile;
  std::vector<uint8_t> seen(size_t{across} * down * masks.layers), result(seen.size());  // bit 0 dark, 1 lit
  for (uint32_t layer = 0; layer < masks.layers; ++layer)
    for (uint32_t y = 0; y < masks.height; ++y) {
      const uint8_t* row = &masks.lit[(size_t{layer} * masks.height + y) * masks.width];
      uint8_t* tiles = &seen[(size_t{layer} * down + y / filter_tile) * across];
      for (uint32_t x = 0; x < masks.width; ++x)
        tiles[x / filter_tile] = static_cast<uint8_t>(tiles[x / filter_tile] | (row[x] ? 2 : 1));
    }
  for (uint32_t layer = 0; layer < masks.layers; ++layer)
    for (uint32_t y = 0; y < down; ++y)
      for (uint32_t x = 0; x < across; ++x) {
        uint8_t around = 0;
        for (uint32_t v = y > 0 ? y - 1 : 0; v <= std::min(y + 1, down - 1); ++v)
          for (uint32_t u = x > 0 ? x - 1 : 0; u <= std::min(x + 1, across - 1); ++u)
            around = static_cast<uint8_t>(around | seen[(size_t{layer} * down + v) * across + u]);
        result[(size_t{layer} * down + y) * across + x] = around == 3;
      }
  return result;
}

}  // namespace

Counters trace_occlusion_masks(const MaskRequest& r, TracedScene& scene, OcclusionMasks& masks) {
  check(r, *scene.shading().snapshot);
  Executor& executor = scene.executor();
  const size_t pixels = size_t{r.width} * r.height;
  masks.width = r.width, masks.height = r.height;
  masks.layers = light_masks_of(r);
  masks.lit.assign(pixels * masks.layers, 255);
  masks.hit_distance.assign(r.hit_distances ? pixels * masks.layers : 0, INFINITY);
  masks.filter_distance.assign(r.filters ? pixels * masks.layers : 0, INFINITY);
  masks.open.assign(r.ao_rays > 0 ? pixels : 0, 255);
  masks.open_distance.assign(r.ao_rays > 0 && r.filters ? pixels : 0, INFINITY);
  const MaskTracer tracer(r, scene, masks);
  std::vector<TileWorker> workers(executor.threads());
  const std::vector<uint32_t> turns = tracer.turns();
  const auto run = [&](auto work) {
    const Stopwatch watch;
    executor.run(tracer.tiles(), [&](size_t turn, uint32_t thread) {
      if ((r.cancelled && r.cancelled->load()) || has_passed(r.deadline)) return;
      work(turns.empty() ? turn : turns[turn], workers[thread]);
    });
    return watch.ms();
  };
  Counters sum;
  if (masks.layers > 0) sum.trace_shadow_ms += run([&](size_t tile, TileWorker& w) { tracer.trace_shadows(tile, w); });
  if (masks.layers > 0 && (r.hit_distances || r.filters)) {
    const std::vector<uint8_t> penumbra = penumbra_tiles(masks);
    for (const bool all : {false, true})
      if (all ? r.hit_distances : r.filters != nullptr)
        sum.trace_shadow_ms += run([&](size_t tile, TileWorker& w) { tracer.trace_distances(tile, penumbra, all, w); });
  }
  if (r.ao_rays > 0) sum.trace_ao_ms += run([&](size_t tile, TileWorker& w) { tracer.trace_open(tile, w); });
  for (const TileWorker& w : workers) sum += w.counters;
  sum.pixels_total = pixels;
  return sum;
}

}  // namespace sideray::rt
