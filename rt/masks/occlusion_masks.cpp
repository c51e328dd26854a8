#include "rt/masks/occlusion_masks.h"

#include <sideray/diagnostics.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/base/deadline.h"
#include "rt/history/frame_camera.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/mask_tracer.h"
#include "rt/masks/older_masks.h"
#include "rt/reach/wanted_tiles.h"

namespace sideray::rt {
namespace {

// How many tiles around a wanted one are filtered and traced for it: a filter takes its width from the tiles beside it,
// and they from theirs. Masks of lights need one more tile for clamping tints, and one for measured borders. In units
// of filter_tile and tile_size.
constexpr uint32_t lights_filtered = 2, sky_filtered = 1, lights_traced = 2, sky_traced = 1;
// The share of tiles without history (1 in 8) whose sky is sampled in each frame, whatever the budget. Each costs a
// sixteenth of a traced tile.
constexpr size_t least_sampled = 8;

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

// Resizes the masks as requested; their content stays if the size does.
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

// Fills in depths for hosts that look masks up by surface positions.
void find_depth(const MaskRequest& r, Executor& executor, OcclusionMasks& masks) {
  if (!r.moving) {
    masks.depth.clear();
    return;
  }
  fill_depths(executor, r.depth, FrameCamera(r.view, r.width, r.height), masks.depth);
  masks.depth_step = r.depth.format == DepthFormat::d16 ? 0x1p-16f : 0x1p-24f;
}

// The sky's masks are traced after those of lights, and get half of the time.
WorkTime half_of(WorkTime work) {
  const Deadline now = Deadline::clock::now();
  if (has_deadline(work.deadline) && work.deadline > now) work.deadline = now + (work.deadline - now) / 2;
  return work;
}

// All parts of the masks share the time that rays have at least.
WorkTime with_least_shared(WorkTime work) {
  if (!work.ends_in_time || !has_deadline(work.deadline)) return work;
  work.deadline = std::max(work.deadline, Deadline::clock::now() + work.least);
  work.least = {};
  return work;
}

// Returns whether some mask of a position has not been traced yet.
bool waits(const MaskRequest& r, const Counters& counters) {
  return r.position_frames > 0 && (counters.mask_pixels_late > 0 || counters.frames_waiting >= r.position_frames);
}

// Traces `masks`, except those that the request reuses.
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
  const WorkTime all_work = with_least_shared(r.work);
  std::vector<MaskTracer::Worker> workers(executor.threads());
  std::atomic<bool> whole{true};
  std::vector<uint8_t> fresh(tracer.tiles(), 1);  // by tile: lights do not show history
  const std::vector<uint8_t> for_lights = traced_tiles(r.wanted, r.width, lights_traced);
  const std::vector<uint8_t> for_sky = traced_tiles(r.wanted, r.width, sky_traced);
  if (!for_lights.empty()) fresh = for_lights;
  TileReach* reach = r.wanted ? r.wanted->reach.get() : nullptr;
  if (reach) reach->fit(r.view, r.width, r.height, r.depth);
  const auto trace_tile = [&](const std::vector<uint8_t>& traced, size_t tile, MaskTracer::Worker& w, const auto& work) {
    if (!traced.empty() && !traced[tile]) return;
    Following rays(r.wanted && r.wanted->has(tile) ? reach : nullptr, Following::Rays::of_masks);
    work(tile, w);
    rays.add_to(tile);
  };
  const auto is_cancelled = [&] { return r.cancelled && r.cancelled->load(); };
  // Skipped tiles are lit, unless they have history.
  const auto leave = [&](OlderMasks::Part part, size_t tile, uint32_t thread, const auto& open) {
    if (whole) whole = false;
    const bool is_older = older && older->knows(part);
    if (!is_older) open(tile);
    if (older) older->leave(r, part, tile, masks, workers[thread].counters);
    if (is_older && part == OlderMasks::of_lights) fresh[tile] = 0;
  };
  const auto leave_all = [&](OlderMasks::Part part, const auto& open) {
    executor.run_cheap(tracer.tiles(), [&](size_t tile, uint32_t thread) { leave(part, tile, thread, open); });
  };
  // Traces a part of the masks, tile by tile.
  const auto trace = [&](OlderMasks::Part part, const WorkTime& time, const auto& work, const auto& open) {
    const std::vector<uint32_t> turns = tracer.turns(part);
    WorkClock clock(time);
    std::atomic<size_t> next{0};
    // Without an order, threads get ranges of numbers; with one, each free thread takes the next tile.
    executor.run(tracer.tiles(), [&](size_t numbered, uint32_t thread) {
      const size_t number = turns.empty() ? numbered : next++, tile = turns.empty() ? numbered : turns[number];
      if (is_cancelled() || !clock.run(number, [&] {
            trace_tile(part == OlderMasks::of_sky ? for_sky : for_lights, tile, workers[thread], work);
          }))
        return leave(part, tile, thread, open);
      if (older) older->traced(r, part, tile);
    });
  };
  const auto run = [&](OlderMasks::Part part, const WorkTime& time, const auto& work, const auto& open) {
    const Stopwatch watch;
    if (is_over(time)) leave_all(part, open);
    else trace(part, time, work, open);
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
  // Tiles without history sample the sky coarsely first.
  const auto sample_sky = [&] {
    const Stopwatch watch;
    std::vector<uint32_t> lacking = tracer.turns(OlderMasks::of_sky);
    std::erase_if(lacking, [&](uint32_t tile) { return !older->lacks_sky(tile); });
    WorkTime time = half_of(all_work);
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
  if (older && tracer.traces_sky() && r.position_frames == 0 && !is_over(all_work)) sum.trace_ao_ms += sample_sky();
  if (tracer.traces_lights()) {
    PiecesLeft pieces{r.work.pieces ? r.work.pieces->load() : 0};  // the sky gets as many
    WorkTime time = tracer.traces_sky() ? half_of(all_work) : all_work;
    if (r.work.pieces) time.pieces = &pieces;
    sum.trace_shadow_ms += run(OlderMasks::of_lights, time,
                               [&](size_t tile, MaskTracer::Worker& w) { tracer.trace_shadows(tile, w); },
                               [&](size_t tile) { tracer.open_tile(tile); });
    if (masks.tints > 0 || scene.shading().glass) {
      const Stopwatch storing;
      tracer.store_tints(workers, fresh, executor);
      sum.trace_shadow_ms += storing.ms();
    }
    // Borders are measured only in complete masks.
    const bool later = std::ranges::any_of(workers, [&](const MaskTracer::Worker& w) { return waits(r, w.counters); });
    if (r.filters && !later)
      sum.trace_shadow_ms += run_after([&](size_t tile, MaskTracer::Worker& w) { tracer.trace_borders(tile, w); });
    if (r.hit_distances)
      sum.trace_shadow_ms += run_after([&](size_t tile, MaskTracer::Worker& w) { tracer.trace_distances(tile, w); });
  }
  if (tracer.traces_sky())
    sum.trace_ao_ms += run(OlderMasks::of_sky, all_work, [&](size_t tile, MaskTracer::Worker& w) { tracer.trace_open(tile, w); },
                           [&](size_t tile) { tracer.open_sky(tile); });
  masks.whole = whole;
  for (const MaskTracer::Worker& w : workers) sum += w.counters;
  sum.pixels_total = size_t{r.width} * r.height;
  return sum;
}

// Returns the filter tiles of the wanted tiles, and up to `around` tiles beside them.
std::vector<uint8_t> filter_tiles_of(const WantedTiles& wanted, const OcclusionMasks& masks, uint32_t around) {
  const uint32_t columns = tile_count(masks.width);
  std::vector<uint8_t> result;
  for (uint32_t v = 0; v < masks.filter_rows(); ++v)
    for (uint32_t u = 0; u < masks.filter_columns(); ++u)
      result.push_back(wanted.has(size_t{v / MaskTracer::filter_across} * columns + u / MaskTracer::filter_across));
  return grown(result, masks.filter_columns(), around);
}

// The history has computed the frame's depths, and is filtered already.
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
  if (!has_older(request)) masks.answers.clear();
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
  masks.find_tinted(scene.executor(), [&](uint32_t layer, size_t tile) {
    return has_older(request) && request.older->is_white(request, masks, layer, tile);
  });
  if (has_older(request)) request.older->end_frame(request, masks, scene.executor());
  if (has_older(request)) request.older->tell_answers(request, scene.executor(), masks);
  if (has_older(request) && request.position_frames > 0 && !later) request.older->complete();
  const bool all = !request.wanted || request.wanted->tiles.empty();
  if (request.kept) request.kept->end(masks, masks.whole && all);
  return counters;
}

}  // namespace sideray::rt
