#include "rt/irradiance/irradiance_tracing.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "model/stopwatch.h"
#include "rt/base/largest.h"
#include "rt/base/sampling.h"
#include "rt/history/still_frames.h"
#include "rt/light/diffuse_paths.h"
#include "rt/light/veils.h"
#include "rt/irradiance/irradiance_history.h"
#include "rt/layers/frame_tiles.h"
#include "rt/layers/layer_tracer.h"
#include "rt/masks/depth_points.h"
#include "rt/opaque/light_tiles.h"
#include "rt/masks/mask_rays.h"
#include "rt/shading/host_shader.h"
#include "rt/surfaces/environment_lanes.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {
namespace {

constexpr uint32_t tile_size = DepthPoints::tile_size;
constexpr uint32_t cells_across = tile_size / cell_side;
constexpr uint32_t sample_purpose = 60, path_purpose = 63;
constexpr uint32_t sky_purpose = 64;
constexpr float blur_of_sky = 0.25f;  // roughness of the lobe that averages the sky's colour
constexpr float least_along = 1e-4f;  // squared, of a direction
constexpr float rounding = 0x1p-21f;  // of coordinates in floats
constexpr uint32_t read_around = 2;  // tiles that the filter reads around one

FrameKey key_of(const IrradianceRequest& r) {
  struct Inputs {
    uint32_t denoise, exact;
  };
  const Inputs inputs{r.denoise, !r.points.empty()};
  return frame_key(r, bytes_through(&Inputs::exact, inputs));
}

// Calls visit(cell) for the cells of the tile that starts at a pixel.
template <typename Visit>
void for_cells_of_tile(const IrradianceCells& cells, uint32_t x0, uint32_t y0, const Visit& visit) {
  for (uint32_t y = y0 / cell_side; y < std::min(y0 / cell_side + cells_across, cells.rows); ++y)
    for (uint32_t x = x0 / cell_side; x < std::min(x0 / cell_side + cells_across, cells.columns); ++x)
      visit(size_t{y} * cells.columns + x);
}

PixelRows pixels_of(TileRows rows, uint32_t height) {
  return {rows.first * tile_size, std::min(rows.end * tile_size, height)};
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
  std::vector<glm::vec3> path_normals;
  std::vector<float> widths;
  std::vector<uint32_t> keys, cells;
  std::vector<PathLight> light;
  std::vector<Ray> sky_rays, clear_rays;
  std::vector<float> sky_weights;
  std::vector<glm::vec3> directions, normals, sky_light, whole_sky;  // directions of sky_rays, normals there, the sky's
                                                                     // light from there; and of the whole sky at the
                                                                     // cells
  std::vector<uint8_t> hidden;
  std::vector<uint32_t> seen_cells;  // of `cells`, those that see the sky
  Veils veils;
  std::vector<CellLight> samples;
  std::vector<Hit> met;
  IrradianceHistory::Scratch looking_back;
  Counters counters;
};

struct IrradianceTracing::Frame {
  bool has_samples(uint32_t x, uint32_t y) const {
    return cells.lights[size_t{y / cell_side} * cells.columns + x / cell_side].samples > 0.0f;
  }

  const IrradianceRequest& request;
  const ViewRays& view;
  const ShadingScene& scene;
  const Intersector& intersector;
  IrradianceHistory* history;
  IrradianceCells& cells;
  std::span<const float> depths;
  uint32_t seed;  // of this frame of the sequence
  uint32_t columns;
  const FrameCamera& camera;
  EnvironmentLanes environment;
  const SkyDirections* sky;  // null: it is black, or of one colour with nothing translucent in front
  bool veiled;               // something translucent is in front of the sky
};

IrradianceTracing::IrradianceTracing(uint32_t threads) : workers_(threads) {}
IrradianceTracing::~IrradianceTracing() = default;

// Chooses the pixel of each cell, a different one in each frame, and finds its surface.
void IrradianceTracing::find_places(const Frame& f, Worker& w, uint32_t tile) {
  w.rays.clear(), w.cells.clear();
  for_cells_of_tile(f.cells, tile % f.columns * tile_size, tile / f.columns * tile_size, [&](size_t cell) {
    f.cells.places[cell] = {}, f.cells.lights[cell] = {};
    const auto column = static_cast<uint32_t>(cell % f.cells.columns), row = static_cast<uint32_t>(cell / f.cells.columns);
    const uint32_t wanted = f.seed + column + row;  // neighbouring cells choose different pixels
    for (uint32_t i = 0; i < cell_side * cell_side; ++i) {
      const uint32_t pixel = (wanted + i) % (cell_side * cell_side);
      const uint32_t x = column * cell_side + pixel % cell_side, y = row * cell_side + pixel / cell_side;
      if (x >= f.request.width || y >= f.request.height || !(f.depths[size_t{y} * f.request.width + x] > 0.0f)) continue;
      pixels_[cell] = {x, y};
      w.rays.push_back(f.view.ray(x, y));
      w.cells.push_back(static_cast<uint32_t>(cell));
      return;
    }
  });
  if (w.rays.empty()) return;
  meet_places(f, w);
  if (!w.cells.empty()) guess_places(f, w, tile);
}

// Places cells by primary rays: if no neighbouring pixel shows the same surface, the depth buffer does not tell its
// tilt, and paths that skip near hits would pass through a thin wall. Keeps the cells whose ray hits something else
// than the drawn surface.
void IrradianceTracing::meet_places(const Frame& f, Worker& w) {
  w.met.resize(w.rays.size());
  f.intersector.nearest_opaque(w.rays, {.set = OpaqueSet::all, .coherent = true, .cull = true}, w.met.data());
  w.counters.rays_bounce += w.rays.size();
  size_t unmet = 0;
  for (size_t i = 0; i < w.rays.size(); ++i) {
    const Ray& ray = w.rays[i];
    const uint32_t cell = w.cells[i];
    const glm::u16vec2 pixel = pixels_[cell];
    const glm::dvec2 at(pixel);
    const double depth = f.depths[size_t{pixel.y} * f.request.width + pixel.x];
    const glm::vec3 drawn(f.camera.origin_at(at) + depth * f.camera.ray_at(at));
    const float distance = glm::dot(drawn - ray.origin, ray.direction), met = static_cast<float>(w.met[i].distance);
    const Cone cone = f.view.cone(pixel.x, pixel.y);
    const float width = std::max(cone.width + cone.spread * distance, 1e-20f);
    if (w.met[i].instance == no_instance || std::abs(met - distance) > width) {
      w.cells[unmet++] = cell;
      continue;
    }
    const glm::vec3 normal = geometric_normal(*f.scene.snapshot, w.met[i]);
    CellPlace& place = f.cells.places[cell];
    place = {ray.origin + met * ray.direction, glm::dot(normal, ray.direction) > 0.0f ? -normal : normal, width, 0.0f};
    place.position += rounding * largest(glm::abs(place.position)) * place.normal;
  }
  w.cells.resize(unmet);
}

// Places the remaining cells by the depth buffer alone.
void IrradianceTracing::guess_places(const Frame& f, Worker& w, uint32_t tile) {
  const uint32_t x0 = tile % f.columns * tile_size, y0 = tile / f.columns * tile_size;
  const PointTile& points = w.depth_points.gather(depth_request(f.request), f.view, x0, y0);
  for_each_pixel(points.drawn, [&](uint32_t pixel) {
    const uint32_t x = x0 + column_in_tile(pixel), y = y0 + row_in_tile(pixel);
    const size_t cell = size_t{y / cell_side} * f.cells.columns + x / cell_side;
    if (f.cells.places[cell].width > 0.0f || pixels_[cell] != glm::u16vec2(x, y)) return;
    const DepthPoint p = point_at(points, pixel);
    const Ray ray = f.view.ray(x, y);
    const Cone cone = f.view.cone(x, y);
    const float distance = glm::dot(p.front - ray.origin, ray.direction);
    f.cells.places[cell] = {p.front, p.normal, std::max(cone.width + cone.spread * distance, 1e-20f), p.skip};
  });
}

// Computes the error of the sky's one-channel mask: for each visible direction, the difference between the colour of
// its light and that of the whole sky.
void IrradianceTracing::see_sky(const Frame& f, Worker& w) {
  w.sky_rays.clear(), w.sky_weights.clear(), w.directions.clear(), w.normals.clear();
  for (size_t i = 0; i < w.cells.size(); ++i) {
    const CellPlace& place = f.cells.places[w.cells[i]];
    const uint32_t key = random_key({w.keys[i], sky_purpose});
    const SkyDirections::Draw drawn = f.sky->draw(SkyDirections::facing(place.normal), place.normal,
                                                  {unit_float(key), unit_float(hash_bits(key))});
    w.sky_rays.push_back({w.rays[i].origin, w.rays[i].t_near, drawn.direction, farthest});
    w.sky_weights.push_back(drawn.weight * glm::one_over_pi<float>());
    w.directions.push_back(drawn.direction);
    w.normals.push_back(place.normal);
  }
  w.sky_light.resize(w.cells.size()), w.whole_sky.resize(w.cells.size());
  f.environment.specular(w.directions, blur_of_sky, w.sky_light.data());
  f.environment.irradiance(w.normals, w.whole_sky.data());
  for (size_t i = 0; i < w.cells.size(); ++i) {
    const glm::vec3 here = of_mean_one(w.sky_light[i]);
    w.sky_light[i] = w.sky_weights[i] * here;
    w.samples[i].tint = w.sky_weights[i] * (here - of_mean_one(w.whole_sky[i]));
  }
  w.hidden.resize(w.sky_rays.size());
  f.intersector.occluded(w.sky_rays, false, w.hidden.data(), OpaqueSet::occludes_sky);
  w.counters.rays_bounce += w.sky_rays.size();
  w.seen_cells.clear();
  for (uint32_t i = 0; i < w.cells.size(); ++i)
    if (w.hidden[i] == 0) w.seen_cells.push_back(i);
  for (const uint32_t i : w.seen_cells) w.samples[i].open = 1.0f;
  if (f.veiled) see_through_veils(f, w);
  for (const uint32_t i : w.seen_cells) w.samples[i].light += w.samples[i].tint * w.samples[i].open;
}

// Adds the colour of translucent surfaces in front of the sky; the mask contains only the mean of their channels.
void IrradianceTracing::see_through_veils(const Frame& f, Worker& w) {
  w.clear_rays.clear();
  for (const uint32_t i : w.seen_cells) w.clear_rays.push_back(w.sky_rays[i]);
  w.veils.meet(f.scene, f.intersector, w.clear_rays, false);
  w.counters.rays_bounce += w.clear_rays.size();
  for (size_t k = 0; k < w.seen_cells.size(); ++k) {
    const uint32_t i = w.seen_cells[k];
    w.samples[i].open = w.veils.through(k);
    w.samples[i].light += w.sky_light[i] * (w.veils.color(k) - w.veils.through(k));
  }
}

// Finds the places of a tile's cells, and their history.
void IrradianceTracing::prepare(const Frame& f, Worker& w, uint32_t tile) {
  find_places(f, w, tile);
  if (f.history) f.history->look_back(tile, pixels_, f.intersector, w.looking_back, f.cells);
}

// The places of the tile must be set.
TraceEnd IrradianceTracing::trace_tile(const Frame& f, Worker& w, uint32_t tile) {
  const IrradianceRequest& r = f.request;
  const uint32_t x0 = tile % f.columns * tile_size, y0 = tile / f.columns * tile_size;
  const TileSamples samples({f.seed, sample_purpose, 0, 0, SIDERAY_EXACT}, x0, y0);
  w.rays.clear(), w.path_normals.clear(), w.widths.clear(), w.keys.clear(), w.cells.clear();
  for_cells_of_tile(f.cells, x0, y0, [&](size_t cell) {
    const CellPlace& place = f.cells.places[cell];
    if (!(place.width > 0.0f)) return;
    const uint32_t x = pixels_[cell].x, y = pixels_[cell].y;
    const glm::vec3 direction = frame_about(place.normal) * sample_cosine(samples.at(x, y, 0, 1));
    w.rays.push_back({place.position, place.skip, direction, farthest});
    w.path_normals.push_back(place.normal);
    w.widths.push_back(place.width);
    w.keys.push_back(random_key({pixel_key(f.seed, 0, x, y), path_purpose}));
    w.cells.push_back(static_cast<uint32_t>(cell));
  });
  if (w.rays.empty()) return TraceEnd::complete;
  const bool by_host = f.scene.snapshot->shader.shade != nullptr;
  if (by_host) w.host.begin(f.scene, f.intersector, host_calls(r), r.shadows);
  w.paths.begin(f.scene, f.intersector, r.shadows, by_host ? &w.host : nullptr);
  w.light.resize(w.rays.size());
  w.paths.follow({w.rays, w.path_normals, w.widths, w.keys}, w.light.data());
  if (by_host && w.host.end != TraceEnd::complete) return w.host.end;
  w.counters.rays_bounce += w.paths.rays;
  w.counters.rays_shadow += w.paths.rays_shadow;
  if (by_host) add_work(w.host, {}, w.counters);
  w.samples.resize(w.cells.size());
  for (size_t i = 0; i < w.cells.size(); ++i) {
    const float rise = glm::dot(w.rays[i].direction, f.cells.places[w.cells[i]].normal);
    const float along = std::sqrt(std::max(1.0f - rise * rise, least_along));
    const PathLight& l = w.light[i];
    w.samples[i] = {.light = l.radiance, .nearness = l.nearness + l.emitter_nearness, .most_near = l.nearness / along};
  }
  if (f.sky) see_sky(f, w);
  for (size_t i = 0; i < w.cells.size(); ++i) {
    CellLight& light = f.cells.lights[w.cells[i]];
    if (r.position_frames > 0) light = {};
    light.add(w.samples[i]);
  }
  return TraceEnd::complete;
}

// Counts the pixels of a skipped tile, whose cells may have samples of earlier frames.
void IrradianceTracing::count_left(const Frame& f, Worker& w, uint32_t tile) {
  const uint32_t x0 = tile % f.columns * tile_size, y0 = tile / f.columns * tile_size, width = f.request.width;
  for (uint32_t y = y0; y < std::min(y0 + tile_size, f.request.height); ++y)
    for (uint32_t x = x0; x < std::min(x0 + tile_size, width); ++x) {
      if (!(f.depths[size_t{y} * width + x] > 0.0f)) continue;
      ++(f.has_samples(x, y) ? w.counters.irradiance_pixels_older : w.counters.irradiance_pixels_late);
    }
  if (!f.history) return;
  const uint64_t waits = f.history->frame() - f.history->turns()[tile];
  w.counters.frames_waiting = std::max(w.counters.frames_waiting, waits);
}

// Shows the last image again, without rays.
Counters IrradianceTracing::keep(IrradianceHistory& history, const IrradianceRequest& r) {
  history.keep();
  Counters counters;
  counters.pixels_total = uint64_t{r.width} * r.height;
  if (r.still) r.still->end(counters, true);
  return counters;
}

void IrradianceTracing::trace_all(const Frame& f, const std::vector<uint8_t>& traced, Executor& executor) {
  const std::span<const uint32_t> turns = f.history ? std::span(f.history->turns()) : std::span<const uint32_t>();
  for_light_tiles(
      {f.request, f.request.work, light_tile_order(f.request, turns), traced}, executor,
      [&](uint32_t tile, uint32_t thread) { prepare(f, workers_[thread], tile); },
      [&](uint32_t tile, uint32_t thread) { trace_tile(f, workers_[thread], tile); },
      [&](uint32_t tile, uint32_t thread, bool is_traced) {
        if (f.history && is_traced) f.history->traced(tile);
        if (!is_traced) count_left(f, workers_[thread], tile);
      });
}

// Traces and filters adjacent rows of tiles, because the filter needs neighbours. The other rows show the reprojected
// image.
TileRows IrradianceTracing::trace_rows(const Frame& f, Executor& executor, IrradianceImage& image) {
  const IrradianceRequest& r = f.request;
  const uint32_t rows = tile_count(r.height);
  const TileRows chosen = f.history->next_rows(r.work);
  const bool traces = chosen.first < chosen.end;
  if (traces) f.history->carry_cells(r, executor);
  f.history->begin_image(image);
  const auto is_around = [&](uint32_t row) { return traces && row + 1 >= chosen.first && row <= chosen.end; };
  executor.run_cheap(size_t{rows} * f.columns, [&](size_t index, uint32_t thread) {
    const auto tile = static_cast<uint32_t>(index), row = tile / f.columns;
    if (row >= chosen.first && row < chosen.end) return;
    f.history->carry_tile(tile, image, workers_[thread].counters);
    if (is_around(row)) prepare(f, workers_[thread], tile);
  });
  if (!traces) return chosen;
  std::vector<uint32_t> order(size_t{chosen.end - chosen.first} * f.columns);
  std::iota(order.begin(), order.end(), chosen.first * f.columns);
  order_by_turns(f.history->turns(), order);
  // Traces at least half a row, even if the time is too short for that.
  const WorkTime work{
      .deadline = r.work.deadline, .least_pieces = r.work.pieces ? 0 : (f.columns + 1) / 2, .pieces = r.work.pieces};
  for_light_tiles(
      {r, work, std::move(order)}, executor,
      [&](uint32_t tile, uint32_t thread) { prepare(f, workers_[thread], tile); },
      [&](uint32_t tile, uint32_t thread) { trace_tile(f, workers_[thread], tile); },
      [&](uint32_t tile, uint32_t thread, bool is_traced) {
        if (is_traced) f.history->traced(tile);
        else count_left(f, workers_[thread], tile);
      });
  return chosen;
}

// Traces tiles that the position lacks. Once all are traced, returns rows to filter; before, none.
TileRows IrradianceTracing::trace_position(const Frame& f, Executor& executor) {
  const IrradianceRequest& r = f.request;
  IrradianceHistory& history = *f.history;
  if (r.position_frames == 1 || history.frame() == 1) history.carry_cells(r, executor), history.filtered_rows = 0;
  const std::vector<uint32_t>& turns = history.turns();
  std::vector<uint8_t> lacking(turns.size());
  for (size_t tile = 0; tile < turns.size(); ++tile) lacking[tile] = turns[tile] == 0 || history.frame() - turns[tile] >= r.position_frames;
  std::atomic<bool> is_whole{true};
  for_light_tiles(
      {r, r.work, light_tile_order(r, turns), lacking}, executor, [](uint32_t, uint32_t) {},
      [&](uint32_t tile, uint32_t thread) {
        find_places(f, workers_[thread], tile);
        trace_tile(f, workers_[thread], tile);
      },
      [&](uint32_t tile, uint32_t thread, bool is_traced) {
        if (is_traced) return history.traced(tile);
        count_left(f, workers_[thread], tile);
        is_whole = false;
      });
  if (!is_whole) return {};
  const uint32_t first = history.filtered_rows, rows = tile_count(r.height);
  history.filtered_rows = r.work.pieces ? rows : std::min(first + history.rows_in(r.work), rows);
  return {first, history.filtered_rows};
}

Counters IrradianceTracing::trace(const IrradianceRequest& r, TracedScene& scene, IrradianceImage& image) {
  check_light(r, "irradiance");
  const auto hash = [&] { return StillFrames::Hashes{hash_depth(scene.executor(), r.depth, r.width, r.height, 0), {}}; };
  const bool fits = image.width == r.width && image.height == r.height;
  image.changed = !(r.still && r.still->begin(key_of(r), r.sequence, scene.committed(), hash) && fits);
  if (!image.changed) return r.still->counters();
  const std::vector<uint8_t> traced = traced_tiles(r.wanted, r.width, read_around);
  if (r.history && !traced.empty()) r.history->forget();
  IrradianceHistory* history = traced.empty() ? r.history : nullptr;
  if (history) history->begin(r, scene);
  image.changed = !(history && history->is_settled() && fits);
  if (!image.changed) return keep(*history, r);
  image.width = r.width;
  image.height = r.height;
  if (!fits) image.light.assign(size_t{4} * r.width * r.height, 0);
  Counters counters = trace_frame(r, scene, history, traced, image);
  image.changed = image.changed || !fits;
  if (r.still) r.still->end(counters, !is_bounded(r.work) && traced.empty());
  return counters;
}

Counters IrradianceTracing::trace_frame(const IrradianceRequest& r, TracedScene& scene, IrradianceHistory* history,
                                        const std::vector<uint8_t>& traced, IrradianceImage& image) {
  Executor& executor = scene.executor();
  const FrameCamera camera(r.view, r.width, r.height);
  const bool keeps = history && !history->stands_for_last();
  IrradianceCells& cells = keeps ? history->cells() : cells_;
  cells.fit(r.width, r.height);
  pixels_.resize(cells.size());
  if (!keeps) fill_depths(executor, r.depth, camera, depths_);
  const std::span<const float> depths = keeps ? history->depths() : depths_;
  for (Worker& worker : workers_) worker.counters = {};
  const ViewRays view(r.view, r.width, r.height);
  const bool is_later = history && history->frame() > 1 && r.position_frames == 0;
  const uint32_t seed = is_later ? random_key({r.seed, history->frame()}) : r.seed;
  const model::Snapshot& shown = *scene.shading().snapshot;
  const bool veiled = veils_sky(shown), has_colours = !scene.sky().black() && (veiled || !shown.environment->uniform);
  const EnvironmentLanes environment(*shown.environment, shade_kernels(scene.intersector().isa().c_str()));
  const Frame frame{r, view, scene.shading(), scene.intersector(), history, cells, depths, seed, tile_count(r.width), camera, environment,
                    has_colours ? &scene.sky() : nullptr, veiled};
  const bool in_parts = keeps && is_bounded(r.work), of_position = in_parts && r.position_frames > 0;
  const TileRows all{0, tile_count(r.height)};
  const Stopwatch tracing;
  TileRows rows = all;
  if (of_position) rows = trace_position(frame, executor);
  else if (in_parts) rows = trace_rows(frame, executor, image);
  else trace_all(frame, traced, executor);
  if (history && !(r.cancelled && r.cancelled->load())) history->end();
  Counters sum;
  for (const Worker& worker : workers_) sum += worker.counters;
  sum.pixels_total = uint64_t{r.width} * r.height;
  const Stopwatch filtering;
  const bool filters = rows.first < rows.end;
  if (filters) filter_.apply({r, cells, keeps ? history->walls() : walls_, depths}, pixels_of(rows, r.height), scene, image);
  if (r.denoise) sum.denoise_ms = filtering.ms();
  if (in_parts && filters) history->took(of_position ? filtering.ms() : tracing.ms(), rows.end - rows.first);
  if (!of_position) return sum;
  // The position is shown when all of its rows are filtered.
  image.changed = filters && rows.end == all.end;
  if (rows.end < all.end) sum.frames_waiting = std::max<uint64_t>(sum.frames_waiting, r.position_frames);
  return sum;
}

}  // namespace sideray::rt
