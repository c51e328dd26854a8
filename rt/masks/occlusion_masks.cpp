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

// The masks of lights get half of the time, because the sky's are traced after them.
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

// Resizes the masks and begins the frame in what earlier ones left.
void begin(const MaskRequest& r, TracedScene& scene, OcclusionMasks& masks) {
  if (r.kept) r.kept->begin(r, scene, masks);
  fit(r, masks);
  if (has_older(r))
    r.older->begin(r, scene, masks);
  else if (r.older)
    r.older->forget();
}

// Traces a frame's masks, except those that the request reuses: first those of lights, then the sky's.
class MaskFrame {
 public:
  using Part = OlderMasks::Part;
  using Worker = MaskTracer::Worker;

  // All arguments must outlive the object.
  MaskFrame(const MaskRequest& request, TracedScene& scene, OcclusionMasks& masks)
      : request_(request),
        executor_(scene.executor()),
        masks_(masks),
        older_(has_older(request) ? request.older : nullptr),
        tracer_(request, scene, masks),
        has_glass_(scene.shading().glass),
        work_(with_least_shared(request.work)),
        workers_(executor_.threads()),
        traced_{traced_tiles(request.wanted, request.width, lights_traced),
                traced_tiles(request.wanted, request.width, sky_traced)},
        fresh_(traced_[OlderMasks::of_lights]),
        reach_(request.wanted ? request.wanted->reach.get() : nullptr) {
    if (fresh_.empty()) fresh_.assign(tracer_.tiles(), 1);
    if (reach_) reach_->fit(request.view, request.width, request.height, request.depth);
  }

  Counters trace() {
    Counters sum;
    if (older_ && tracer_.traces_sky() && request_.position_frames == 0 && !is_over(work_))
      sum.trace_ao_ms += ms_of([&] { sample_sky(); });
    if (tracer_.traces_lights()) sum.trace_shadow_ms += ms_of([&] { trace_lights(); });
    if (tracer_.traces_sky()) sum.trace_ao_ms += ms_of([&] { trace_part(OlderMasks::of_sky, work_); });
    masks_.whole = whole_;
    for (const Worker& w : workers_) sum += w.counters;
    sum.pixels_total = size_t{request_.width} * request_.height;
    return sum;
  }

 private:
  template <typename Work>
  static double ms_of(const Work& work) {
    const Stopwatch watch;
    work();
    return watch.ms();
  }

  bool is_cancelled() const { return request_.cancelled && request_.cancelled->load(); }
  PiecesLeft pieces_left(int64_t per_piece = 1) const {
    return PiecesLeft{request_.work.pieces ? request_.work.pieces->load() * per_piece : 0};
  }

  // Gives tiles without history coarse samples of the sky.
  void sample_sky() {
    std::vector<uint32_t> lacking = tracer_.turns(OlderMasks::of_sky);
    std::erase_if(lacking, [&](uint32_t tile) { return !older_->lacks_sky(tile); });
    WorkTime time = half_of(work_);
    time.least_pieces = lacking.size() / least_sampled + 1;
    PiecesLeft pieces = pieces_left(CoarseSky::across * CoarseSky::across);
    if (request_.work.pieces) time.pieces = &pieces, time.least_pieces = 0;
    WorkClock clock(time);
    std::atomic<size_t> next{0};
    executor_.run(lacking.size(), [&](size_t, uint32_t thread) {
      const size_t number = next++;
      if (is_cancelled()) return;
      clock.run(number, [&] { tracer_.sample_sky(lacking[number], workers_[thread], older_->coarse_sky()); });
    });
  }

  void trace_lights() {
    PiecesLeft pieces = pieces_left();  // the sky gets as many
    WorkTime time = tracer_.traces_sky() ? half_of(work_) : work_;
    if (request_.work.pieces) time.pieces = &pieces;
    trace_part(OlderMasks::of_lights, time);
    if (masks_.tints > 0 || has_glass_) tracer_.store_tints(workers_, fresh_, executor_);
    // Borders are measured only in complete masks.
    const bool later = std::ranges::any_of(workers_, [&](const Worker& w) { return waits(request_, w.counters); });
    if (request_.filters && !later) measure([&](size_t tile, Worker& w) { tracer_.trace_borders(tile, w); });
    if (request_.hit_distances) measure([&](size_t tile, Worker& w) { tracer_.trace_distances(tile, w); });
  }

  // Traces or skips each tile of a part.
  void trace_part(Part part, const WorkTime& time) {
    if (is_over(time))
      executor_.run_cheap(tracer_.tiles(), [&](size_t tile, uint32_t thread) { skip(part, tile, thread); });
    else
      trace_in_turns(part, time);
    if (older_ && !is_cancelled()) older_->end(part);
  }

  void trace_in_turns(Part part, const WorkTime& time) {
    const std::vector<uint32_t> turns = tracer_.turns(part);
    WorkClock clock(time);
    std::atomic<size_t> next{0};
    // Without an order, threads get ranges of numbers; with one, each free thread takes the next tile.
    executor_.run(tracer_.tiles(), [&](size_t numbered, uint32_t thread) {
      const size_t number = turns.empty() ? numbered : next++, tile = turns.empty() ? numbered : turns[number];
      if (is_cancelled() || !clock.run(number, [&] { trace_tile(part, tile, workers_[thread]); }))
        skip(part, tile, thread);
      else if (older_)
        older_->traced(request_, part, tile);
    });
  }

  void trace_tile(Part part, size_t tile, Worker& w) {
    record_reach(part, tile, [&] {
      if (part == OlderMasks::of_sky)
        tracer_.trace_open(tile, w);
      else
        tracer_.trace_shadows(tile, w);
    });
  }

  // Runs work on a tile if the part traces it, and records where the rays of a wanted tile go.
  template <typename Work>
  void record_reach(Part part, size_t tile, const Work& work) {
    if (!traced_[part].empty() && !traced_[part][tile]) return;
    Following rays(request_.wanted && request_.wanted->has(tile) ? reach_ : nullptr, Following::Rays::of_masks);
    work();
    rays.add_to(tile);
  }

  // Makes a tile show its history, or be lit if it has none.
  void skip(Part part, size_t tile, uint32_t thread) {
    if (whole_) whole_ = false;
    const bool is_older = older_ && older_->knows(part);
    if (!is_older) light(part, tile);
    if (older_) older_->leave(request_, part, tile, masks_, workers_[thread].counters);
    if (is_older && part == OlderMasks::of_lights) fresh_[tile] = 0;
  }

  void light(Part part, size_t tile) const {
    if (part == OlderMasks::of_sky)
      tracer_.open_sky(tile);
    else
      tracer_.open_tile(tile);
  }

  // Measures hit distances of lights' masks that were traced in this frame.
  template <typename Work>
  void measure(const Work& work) {
    executor_.run(tracer_.tiles(), [&](size_t tile, uint32_t thread) {
      if (is_cancelled() || has_passed(request_.work.deadline)) return;
      record_reach(OlderMasks::of_lights, tile, [&] { work(tile, workers_[thread]); });
    });
  }

  const MaskRequest& request_;
  Executor& executor_;
  OcclusionMasks& masks_;
  OlderMasks* older_;  // null: no deadline
  const MaskTracer tracer_;
  const bool has_glass_;
  const WorkTime work_;
  std::vector<Worker> workers_;
  const std::vector<uint8_t> traced_[OlderMasks::part_count];  // by tile; empty: all are
  std::vector<uint8_t> fresh_;                                 // by tile: its lights do not show history
  TileReach* reach_;
  std::atomic<bool> whole_{true};
};

// Traces `masks`, except those that the request reuses.
Counters trace_unfiltered(const MaskRequest& r, TracedScene& scene, OcclusionMasks& masks) {
  check(r, *scene.shading().snapshot);
  const Stopwatch watch;
  begin(r, scene, masks);
  const double ms = watch.ms();
  Counters counters = MaskFrame(r, scene, masks).trace();
  (light_masks_of(r) > 0 ? counters.trace_shadow_ms : counters.trace_ao_ms) += ms;
  return counters;
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
  OlderMasks* const older = has_older(request) ? request.older : nullptr;
  const bool in_turns = older && request.position_frames > 0;
  if (in_turns && request.position_frames > 1 && request.sequence == SequenceStep::next && older->is_complete()) return {};
  if (!older) masks.answers.clear();
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
    return older && older->is_white(request, masks, layer, tile);
  });
  if (older) older->end_frame(request, masks, scene.executor());
  if (older) older->tell_answers(request, scene.executor(), masks);
  if (in_turns && !later) older->complete();
  const bool all = !request.wanted || request.wanted->tiles.empty();
  if (request.kept) request.kept->end(masks, masks.whole && all);
  return counters;
}

}  // namespace sideray::rt
