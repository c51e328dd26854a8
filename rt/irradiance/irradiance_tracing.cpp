#include "rt/irradiance/irradiance_tracing.h"

#include <algorithm>

#include "model/stopwatch.h"
#include "rt/base/sampling.h"
#include "rt/history/still_frames.h"
#include "rt/irradiance/diffuse_paths.h"
#include "rt/irradiance/irradiance_history.h"
#include "rt/layers/frame_tiles.h"
#include "rt/layers/layer_tracer.h"
#include "rt/masks/depth_points.h"
#include "rt/light/light_tiles.h"
#include "rt/masks/mask_rays.h"
#include "rt/shading/host_shader.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr uint32_t tile_size = DepthPoints::tile_size;
constexpr uint32_t cells_across = tile_size / cell_side;
constexpr uint32_t sample_purpose = 60, path_purpose = 63;
constexpr uint32_t sky_purpose = 64;
constexpr float blur_of_sky = 0.25f;  // roughness of the lobe that the sky's colour is averaged over
constexpr uint32_t read_around = 2;  // tiles that the filter reads beside one

FrameKey key_of(const IrradianceRequest& r) {
  struct Inputs {
    uint32_t denoise, exact;
  };
  const Inputs inputs{r.denoise, !r.points.empty()};
  return frame_key(r, bytes_through(&Inputs::exact, inputs));
}

glm::vec3 of_mean_one(glm::vec3 colour) {
  const float mean = (colour.x + colour.y + colour.z) / 3.0f;
  return mean > 0.0f ? colour / mean : glm::vec3(0.0f);
}

}  // namespace

struct IrradianceTracing::Worker {
  DepthPoints depth_points;
  DiffusePaths paths;
  HostShader host;
  std::vector<Ray> rays;
  std::vector<Cone> cones;
  std::vector<uint32_t> keys, cells;
  std::vector<glm::vec3> radiance;
  std::vector<float> nearness;
  std::vector<Ray> sky_rays;
  std::vector<uint8_t> hidden;
  std::vector<CellLight> samples;
  Counters counters;
};

struct IrradianceTracing::Frame {
  const IrradianceRequest& request;
  const ViewRays& view;
  const ShadingScene& scene;
  const Intersector& intersector;
  const IrradianceHistory* history;
  uint32_t seed;  // of this frame of the sequence
  uint32_t columns;
  const SkyDirections* sky;  // null: black
};

IrradianceTracing::IrradianceTracing(uint32_t threads) : workers_(threads) {}
IrradianceTracing::~IrradianceTracing() = default;

// Chooses the pixel of each cell, another one in each frame, and what is known of it.
void IrradianceTracing::find_places(const Frame& f, Worker& w, uint32_t tile) {
  const IrradianceRequest& r = f.request;
  const uint32_t x0 = tile % f.columns * tile_size, y0 = tile / f.columns * tile_size;
  for (uint32_t y = y0 / cell_side; y < std::min(y0 / cell_side + cells_across, cells_.rows); ++y)
    for (uint32_t x = x0 / cell_side; x < std::min(x0 / cell_side + cells_across, cells_.columns); ++x)
      cells_.places[size_t{y} * cells_.columns + x] = {}, cells_.lights[size_t{y} * cells_.columns + x] = {};
  const PointTile& points = w.depth_points.gather(depth_request(r), f.view, x0, y0);
  for_each_pixel(points.drawn, [&](uint32_t pixel) {
    const uint32_t x = x0 + column_in_tile(pixel), y = y0 + row_in_tile(pixel);
    const size_t cell = size_t{y / cell_side} * cells_.columns + x / cell_side;
    const uint32_t wanted = (f.seed + x / cell_side + y / cell_side) & 3u;  // neighbours take others
    const bool is_it = (x % cell_side) + (y % cell_side) * cell_side == wanted;
    if (cells_.places[cell].width > 0.0f && !is_it) return;
    const DepthPoint p = point_at(points, pixel);
    const Ray ray = f.view.ray(x, y);
    const Cone cone = f.view.cone(x, y);
    const float distance = glm::dot(p.front - ray.origin, ray.direction);
    cells_.places[cell] = {p.front, p.normal, std::max(cone.width + cone.spread * distance, 1e-20f)};
    pixels_[cell] = {x, y};
  });
}

// Finds what the mask of the sky, which has one channel, says wrong: of the light of each direction that is seen, by how much its
// colour differs from that of all the sky's light.
void IrradianceTracing::see_sky(const Frame& f, Worker& w) {
  const model::Environment& environment = *f.scene.snapshot->environment;
  w.sky_rays.clear();
  for (size_t i = 0; i < w.cells.size(); ++i) {
    const CellPlace& place = cells_.places[w.cells[i]];
    const uint32_t key = random_key({w.keys[i], sky_purpose});
    const SkyDirections::Draw drawn = f.sky->draw(SkyDirections::facing(place.normal), place.normal,
                                                  {unit_float(key), unit_float(hash_bits(key))});
    w.sky_rays.push_back({w.rays[i].origin, w.rays[i].t_near, drawn.direction, farthest});
    const glm::vec3 here = environment_specular(environment, drawn.direction, blur_of_sky);
    const glm::vec3 all = environment_irradiance(environment, place.normal);
    w.samples[i].tint = (drawn.weight * glm::one_over_pi<float>()) * (of_mean_one(here) - of_mean_one(all));
  }
  w.hidden.resize(w.sky_rays.size());
  f.intersector.occluded(w.sky_rays, false, w.hidden.data(), OpaqueSet::occludes_sky);
  w.counters.rays_bounce += w.sky_rays.size();
  for (size_t i = 0; i < w.cells.size(); ++i) {
    if (w.hidden[i] != 0) continue;
    w.samples[i].open = 1.0f;
    w.samples[i].light += w.samples[i].tint;
  }
}

TraceEnd IrradianceTracing::trace_tile(const Frame& f, Worker& w, uint32_t tile) {
  const IrradianceRequest& r = f.request;
  const uint32_t x0 = tile % f.columns * tile_size, y0 = tile / f.columns * tile_size;
  const PointTile& points = w.depth_points.gather(depth_request(r), f.view, x0, y0);
  const TileSamples samples({f.seed, sample_purpose, 0, 0, SIDERAY_EXACT}, x0, y0);
  w.rays.clear(), w.cones.clear(), w.keys.clear(), w.cells.clear();
  for_each_pixel(points.drawn, [&](uint32_t pixel) {
    const uint32_t x = x0 + column_in_tile(pixel), y = y0 + row_in_tile(pixel);
    const size_t cell = size_t{y / cell_side} * cells_.columns + x / cell_side;
    if (pixels_[cell] != glm::u16vec2(x, y)) return;
    const DepthPoint p = point_at(points, pixel);
    const glm::vec3 direction = frame_about(p.normal) * sample_cosine(samples.at(x, y, 0, 1));
    w.rays.push_back({p.front, p.skip, direction, farthest});
    w.cones.push_back({cells_.places[cell].width, f.view.cone(x, y).spread});
    w.keys.push_back(random_key({pixel_key(f.seed, 0, x, y), path_purpose}));
    w.cells.push_back(static_cast<uint32_t>(cell));
  });
  if (w.rays.empty()) return TraceEnd::complete;
  const bool by_host = f.scene.snapshot->shader.shade != nullptr;
  if (by_host) w.host.begin(f.scene, f.intersector, host_calls(r), r.shadows);
  w.paths.begin(f.scene, f.intersector, r.shadows, by_host ? &w.host : nullptr);
  w.radiance.resize(w.rays.size());
  w.nearness.resize(w.rays.size());
  w.paths.follow(w.rays, w.cones, w.keys, w.radiance.data(), w.nearness.data());
  if (by_host && w.host.end != TraceEnd::complete) return w.host.end;
  w.counters.rays_bounce += w.paths.rays;
  w.counters.rays_shadow += w.paths.rays_shadow;
  if (by_host) add_work(w.host, {}, w.counters);
  w.samples.resize(w.cells.size());
  for (size_t i = 0; i < w.cells.size(); ++i) w.samples[i] = {.light = w.radiance[i], .nearness = w.nearness[i]};
  if (f.sky) see_sky(f, w);
  for (size_t i = 0; i < w.cells.size(); ++i) {
    CellLight& light = cells_.lights[w.cells[i]];
    if (r.position_frames > 0) light = {};
    light.add(w.samples[i]);
  }
  return TraceEnd::complete;
}

// Counts the pixels of a tile that had no turn.
void IrradianceTracing::count_left(const Frame& f, Worker& w, uint32_t tile) const {
  const uint32_t x0 = tile % f.columns * cells_across, y0 = tile / f.columns * cells_across;
  for (uint32_t y = y0; y < std::min(y0 + cells_across, cells_.rows); ++y)
    for (uint32_t x = x0; x < std::min(x0 + cells_across, cells_.columns); ++x) {
      const size_t cell = size_t{y} * cells_.columns + x;
      if (!(cells_.places[cell].width > 0.0f)) continue;
      constexpr uint64_t pixels = cell_side * cell_side;
      (cells_.lights[cell].samples > 0.0f ? w.counters.irradiance_pixels_older : w.counters.irradiance_pixels_late) += pixels;
      if (!f.history) continue;
      const uint64_t waits = f.history->frame() - f.history->turns()[tile];
      w.counters.frames_waiting = std::max(w.counters.frames_waiting, waits);
    }
}

// Goes on with what is known, without a ray.
Counters IrradianceTracing::keep(IrradianceHistory& history, const IrradianceRequest& r) {
  history.keep();
  Counters counters;
  counters.pixels_total = uint64_t{r.width} * r.height;
  if (r.still) r.still->end(counters, true);
  return counters;
}

Counters IrradianceTracing::trace(const IrradianceRequest& r, TracedScene& scene, IrradianceImage& image) {
  check_light(r, "irradiance");
  const auto hash = [&] { return StillFrames::Hashes{hash_depth(scene.executor(), r.depth, r.width, r.height, 0), {}}; };
  image.changed = !(r.still && r.still->begin(key_of(r), r.sequence, scene.committed(), hash) &&
                    image.width == r.width && image.height == r.height);
  if (!image.changed) return r.still->counters();
  const std::vector<uint8_t> traced = traced_tiles(r.wanted, r.width, read_around);
  if (r.history && !traced.empty()) r.history->forget();
  IrradianceHistory* history = traced.empty() ? r.history : nullptr;
  if (history) history->begin(r, scene);
  image.changed = !(history && history->is_settled() && image.width == r.width && image.height == r.height);
  if (!image.changed) return keep(*history, r);
  image.width = r.width;
  image.height = r.height;
  cells_.fit(r.width, r.height);
  pixels_.resize(cells_.size());
  for (Worker& worker : workers_) worker.counters = {};
  const ViewRays view(r.view, r.width, r.height);
  const bool is_later = history && history->frame() > 1 && r.position_frames == 0;
  const uint32_t seed = is_later ? random_key({r.seed, history->frame()}) : r.seed;
  const SkyDirections* sky = scene.sky().black() ? nullptr : &scene.sky();
  const Frame frame{r, view, scene.shading(), scene.intersector(), history, seed, tile_count(r.width), sky};
  for_light_tiles(
      r, scene.executor(), history ? std::span(history->turns()) : std::span<const uint32_t>(), traced,
      [&](uint32_t tile, uint32_t thread) {
        find_places(frame, workers_[thread], tile);
        if (history) history->look_back(tile, pixels_, cells_);
      },
      [&](uint32_t tile, uint32_t thread) { trace_tile(frame, workers_[thread], tile); },
      [&](uint32_t tile, uint32_t thread, bool is_traced) {
        if (history && is_traced) history->traced(tile);
        if (!is_traced) count_left(frame, workers_[thread], tile);
      });
  if (history && !(r.cancelled && r.cancelled->load())) history->end(cells_);
  Counters sum;
  for (const Worker& worker : workers_) sum += worker.counters;
  sum.pixels_total = uint64_t{r.width} * r.height;
  const Stopwatch watch;
  filter_.apply(r, cells_, scene.executor(), image);
  if (r.denoise) sum.denoise_ms = watch.ms();
  if (r.still) r.still->end(sum, !is_bounded(r.work) && traced.empty());
  return sum;
}

}  // namespace sideray::rt
