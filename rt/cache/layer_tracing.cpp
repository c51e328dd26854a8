#include "rt/cache/layer_tracing.h"

#include <algorithm>

#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/cache/layer_cache.h"
#include "rt/cache/older_layers.h"
#include "rt/history/still_frames.h"
#include "rt/reach/wanted_tiles.h"

namespace sideray::rt {
namespace {

FrameKey key_of(const CacheRequest& r) {
  FrameKey key;
  key.inputs = bytes_through(&sideray_layer_inputs::bounces, static_cast<const sideray_layer_inputs&>(r));
  key.bounces = r.light_bounces;
  key.view = r.view;
  key.width = r.width;
  key.height = r.height;
  key.format = r.depth.format;
  key.mask = static_cast<uint32_t>(r.mask);
  key.stencil_bits = r.stencil_bits;
  key.seed = r.seed;
  key.position = r.position;
  key.shadows = r.shadows;
  key.subpixel = r.subpixel;
  return key;
}

StillFrames::Hashes hash_pictures(const CacheRequest& r, Executor& executor) {
  const bool reads_stencil = r.mask == SIDERAY_MASK_STENCIL || r.mask == SIDERAY_MASK_COUNT;
  const uint32_t bits = (reads_stencil ? r.stencil_bits : 0u) | r.others_bits;
  return {hash_depth(executor, r.depth, r.width, r.height, bits), hash_rows(executor, std::as_bytes(r.mask_bytes), r.height),
          hash_rows(executor, std::as_bytes(r.lit.thrown), r.height), hash_rows(executor, std::as_bytes(r.lit.open), r.height)};
}

// The filter's passes reach 15 pixels, and the computation of its reach 2 more.
constexpr uint32_t read_around = 1;

size_t tile_of(const PixelRequest& pixel, uint32_t width) {
  return size_t{pixel.y / frame_tile_size} * tile_count(width) + pixel.x / frame_tile_size;
}

// Adds the rays of a chunk to those of its tiles that are wanted; the pixels of a tile are consecutive.
void add_to_tiles(const CacheRequest& request, std::span<const PixelRequest> pixels, Following& rays) {
  size_t last = ~size_t{0};
  for (const PixelRequest& pixel : pixels) {
    const size_t tile = tile_of(pixel, request.width);
    if (tile != last && request.wanted->has(tile)) rays.add_to(tile);
    last = tile;
  }
}

bool holds(const LayerCache& cache, const CacheRequest& request) {
  return cache.width == request.width && cache.height == request.height && cache.layers == request.max_layers;
}

}  // namespace

void LayerTracing::check(const CacheRequest& request, const LayerCache& cache) const {
  if (request.requested_bits != 0 &&
      (cache.width != request.width || cache.height != request.height || cache.layers != request.max_layers ||
       cache.traced_tiles.size() != chunks_.frame().tiles.size()))
    fail(SIDERAY_INVALID_ARGUMENT, "second wave of {}x{}, {} layers: the cache that it adds to holds {}x{}, {} layers",
         request.width, request.height, request.max_layers, cache.width, cache.height, cache.layers);
}

// The pixels of a chunk are donors to each other, so a chunk is traced as a whole if any of its tiles is needed.
// Returns the tiles with pixels to trace or to clear; empty: all.
std::vector<uint8_t> LayerTracing::choose_chunks(const CacheRequest& request) {
  chosen_.clear();
  const std::vector<uint8_t> needed = traced_tiles(request.wanted, request.width, read_around);
  if (needed.empty()) return {};
  std::vector<uint8_t> traced = needed;
  chosen_.resize(chunks_.count());
  for (size_t i = 0; i < chosen_.size(); ++i) {
    const std::span<const PixelRequest> pixels = chunks_.chunk(i);
    chosen_[i] = std::ranges::any_of(pixels, [&](const PixelRequest& p) { return needed[tile_of(p, request.width)] != 0; });
    if (!chosen_[i]) continue;
    for (const PixelRequest& p : pixels) traced[tile_of(p, request.width)] = 1;
  }
  return traced;
}

// With history, the history clears the cache; without it the history is reset.
void LayerTracing::prepare(const CacheRequest& request, TracedScene& scene, LayerCache& cache) {
  if (!takes_older(request)) {
    begin_cache(request, chunks_.frame().tiles, choose_chunks(request), scene.executor(), cache);
    if (request.older) request.older->forget();
    return;
  }
  chosen_.clear();
  OlderLayers& older = *request.older;
  older.begin(request, scene.shading().snapshot, scene.committed(), chunks_.frame(), scene.executor(), cache);
  chunks_.take_turns(request, [&](std::span<const PixelRequest> pixels) { return older.last_turn(pixels); }, scene.executor());
}

Counters LayerTracing::trace(const CacheRequest& request, TracedScene& scene, LayerCache& cache) {
  scene.shading();  // fails if nothing is committed; then the cache is unchanged
  if (request.max_layers == 0 || request.max_layers > most_cached_layers)
    fail(SIDERAY_INVALID_ARGUMENT, "layers is {}: a layer cache holds 1 to {}", request.max_layers, most_cached_layers);
  if (request.still && request.still->begin(key_of(request), request.sequence, scene.committed(),
                                            [&] { return hash_pictures(request, scene.executor()); }) &&
      holds(cache, request)) {
    std::fill(cache.dirty_tiles.begin(), cache.dirty_tiles.end(), uint8_t{0});
    return request.still->counters();
  }
  chunks_.gather(request, selection_of(request), scene.executor());
  check(request, cache);
  prepare(request, scene, cache);
  filter_.begin(request.denoise ? chunks_.count() : 0);
  whole_later_.resize(request.whole_pixels ? chunks_.count() : 0);
  for (std::vector<WholePixels::Pixel>& pixels : whole_later_) pixels.clear();
  for (Worker& worker : workers_) worker.counters = {};
  Counters counters;
  const TraceEnd end = trace_chunks(request, scene, cache, counters);
  if (end == TraceEnd::complete && request.denoise) {
    const Stopwatch watch;
    filter_.apply(scene.executor(), cache);
    composite_filtered(scene.executor(), cache);
    counters.denoise_ms = watch.ms();
  }
  // A cancelled frame leaves the owner's textures undefined, so the next frame must clear and upload everything.
  if (end == TraceEnd::cancelled) std::fill(cache.traced_tiles.begin(), cache.traced_tiles.end(), uint8_t{1});
  if (end == TraceEnd::cancelled && request.older) request.older->forget();
  for (const Worker& worker : workers_) counters += worker.counters;
  counters.pixels_total = uint64_t{request.width} * request.height;
  counters.pixels_masked = chunks_.frame().masked;
  counters.layers_requested = chunks_.frame().requested;
  if (request.still)
    request.still->end(counters, end == TraceEnd::complete && !is_bounded(request.work) && chosen_.empty());
  return counters;
}

void LayerTracing::composite_filtered(Executor& executor, LayerCache& cache) {
  executor.run(whole_later_.size(), [&](size_t chunk, uint32_t) {
    for (const WholePixels::Pixel& pixel : whole_later_[chunk]) composite_whole(pixel, cache);
  });
}

// Makes straight rays end at the first surface that bends light; refracted rays then hit everything that the frame
// shows.
void LayerTracing::refract(const CacheRequest& request, TracedScene& scene, FrameContext& straight, Bent& bent) {
  scene.place_sprites(request.view, request.height);
  const RefractionScene& refracted = refraction_.of(scene.shading().snapshot);
  straight.scene = &scene.shading();
  straight.bends = refracted.bends;
  bent.behind = straight;
  bent.behind.cache = nullptr;
  bent.behind.bends = {};
  bent.behind.set = LayerSet::with_sprites;
  bent.context = refraction_context(bent.behind, refracted, false);
}

TraceEnd LayerTracing::trace_chunks(const CacheRequest& request, TracedScene& scene, LayerCache& cache,
                                    Counters& counters) {
  OlderLayers* older = takes_older(request) ? request.older : nullptr;
  FrameChunks::Leave leave;
  if (older)
    leave = [&](std::span<const PixelRequest> pixels, uint32_t thread) {
      return older->leave(pixels, workers_[thread].counters);
    };
  if (is_over(request.work)) return chunks_.run(request, scene.executor(), {}, leave, counters);
  const ViewRays view(request.view, request.width, request.height);
  FrameContext context{.request = &request,
                       .cache = &request,
                       .view = &view,
                       .scene = &scene.shading(),
                       .intersector = &scene.intersector(),
                       .set = request.all_translucent ? LayerSet::all_translucent : LayerSet::visible_in_layers};
  Bent bent{};
  const bool bends = request.refraction && bends_light(*scene.shading().snapshot);
  if (bends) refract(request, scene, context, bent);
  const ShadingScene& shading = scene.shading();
  shaders_.begin_frame({.scene = shading,
                        .intersector = scene.intersector(),
                        .calls = host_calls(request),
                        .shading = {.shadows = request.shadows,
                                    .tell_rough = request.denoise != 0,
                                    .error = request.ray_reuse,
                                    .viewer = way_to_viewer(request.view),
                                    .bounces = bounces_of(request),
                                    .seen = seen_light_of(request)}});
  TileReach* reach = request.wanted ? request.wanted->reach.get() : nullptr;
  if (reach) reach->fit(request.view, request.width, request.height, request.depth);
  const Traced traced{request, context, bends ? &bent.context : nullptr, cache, older};
  const auto trace = [&](size_t chunk, std::span<const PixelRequest> pixels, uint32_t thread) {
    if (!chosen_.empty() && !chosen_[chunk]) return TraceEnd::complete;
    Following rays(reach, Following::Rays::of_layers);
    const TraceEnd end = trace_chunk(traced, chunk, pixels, thread);
    if (older && end == TraceEnd::complete) older->traced(pixels, cache);
    if (reach) add_to_tiles(request, pixels, rays);
    return end;
  };
  return chunks_.run(request, scene.executor(), trace, leave, counters);
}

TraceEnd LayerTracing::trace_chunk(const Traced& traced, size_t chunk, std::span<const PixelRequest> pixels,
                                   uint32_t thread) {
  Worker& worker = workers_[thread];
  PointShader& shader = shaders_.begin_chunk(thread);
  const ShadingScene& shading = *traced.straight.scene;
  WholePixels* whole = traced.request.whole_pixels ? &worker.whole : nullptr;
  if (whole) whole->begin(traced.request, shading, whole_later_[chunk]);
  LayerFilter::Chunk* rough = traced.request.denoise ? &filter_.chunk(chunk) : nullptr;
  CacheSink sink(traced.cache, *shading.snapshot, rough, whole, traced.older);
  const auto into = [&](LayerSink& any) {
    return worker.tracer.trace(traced.straight, pixels, shader, any, worker.counters);
  };
  if (!traced.bent) return into(sink);
  RefractingSink refracting(sink, *traced.bent, shader, worker.refraction, worker.counters);
  return into(refracting);
}

}  // namespace sideray::rt
