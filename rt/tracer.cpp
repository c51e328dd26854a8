#include "rt/tracer.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "model/failure.h"
#include "rt/base/deadline.h"
#include "rt/base/executor.h"
#include "rt/base/view_rays.h"
#include "rt/composite/composite_sink.h"
#include "rt/composite/refraction_tracer.h"
#include "rt/embree/intersector.h"
#include "rt/layers/frame_pixels.h"
#include "rt/layers/layer_cache.h"
#include "rt/layers/layer_check.h"
#include "rt/layers/layer_filter.h"
#include "rt/layers/layer_needs.h"
#include "rt/layers/layer_tracer.h"
#include "rt/layers/temporal_sink.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/occlusion_masks.h"
#include "rt/poses/angle_cull.h"
#include "rt/poses/particle_quads.h"
#include "rt/reference/ray_batches.h"
#include "rt/reference/reference_frame.h"
#include "rt/reflections/opaque_reflections.h"
#include "rt/shading/hit_shader.h"
#include "rt/shading/host_shader.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {
namespace {

// So many that shading has full batches, or fewer where a frame has few: then the last of them would keep most threads
// waiting. A packet is 16 pixels. Whatever the thread count: the same packets, the same bits.
size_t pixels_in_chunk(size_t pixels) {
  constexpr size_t least = 256, most = 1024, wanted_chunks = 64, packet = 16;
  return std::clamp(pixels / wanted_chunks / packet * packet, least, most);
}

}  // namespace

struct Tracer::State {
  // Memory of one thread, kept from frame to frame.
  struct Worker {
    LayerTracer layers;
    HitShader shader;
    HostShader host_shader;
    std::vector<CompositeSink::Pixel> pixels;
    RefractionTracer refraction;
    std::vector<RefractedPixel> refracted_pixels;
    TraceCounters counters;
  };

  explicit State(const TracerConfig& config)
      : executor(config.threads),
        intersector(config.isa),
        workers(executor.threads()),
        reference_workers(executor.threads()) {}

  const ShadingScene& committed() {
    if (stale && snapshot) take(snapshot);
    if (!scene) fail(SIDERAY_INVALID_ARGUMENT, "trace: the scene has no commit yet; call sideray_scene_commit first");
    return *scene;
  }

  void take(std::shared_ptr<const model::Snapshot> commit);

  // Builds the sprites' quads for a view. They stay, unmet by other rays, until another view's or another scene.
  void place_sprites(const TraceView& view, uint32_t height) {
    if (!has_sprites(*committed().snapshot)) return;
    const bool placed = quads_height == height && quads_view.clip_from_local == view.clip_from_local &&
                        quads_view.local_from_clip == view.local_from_clip;
    if (placed) return;
    const auto derived = with_sprite_quads(*posed, view, height);
    executor.inside([&] { intersector.set_scene(derived, {.posed = {}, .culled = cull.culled()}); });
    scene = std::make_unique<const ShadingScene>(derived);
    refraction.reset();
    quads_view = view, quads_height = height;
  }

  // Made when first asked for: most tracers never are.
  ReferenceScene reference_scene() {
    const std::shared_ptr<const model::Environment>& wanted = committed().snapshot->environment;
    if (!environment || environment->environment() != wanted)
      environment = std::make_unique<const EnvironmentSampler>(wanted);
    lights = reference_lights(*scene->snapshot);
    return {scene.get(), &intersector, environment.get(), &lights};
  }

  // Made when first asked for.
  const RefractionScene& refraction_scene() {
    if (!refraction) refraction = std::make_unique<const RefractionScene>(committed().snapshot);
    return *refraction;
  }

  // What mirrors show is taken to be no brighter. Looks once at each commit.
  float brightest() {
    if (measured != scene->snapshot) brightest_of_measured = brightest_mirrored(*scene->snapshot);
    measured = scene->snapshot;
    return brightest_of_measured;
  }

  bool is_shaded_by_host() const { return scene->snapshot->shader.shade != nullptr; }

  // Calls work(worker, chunk, pixels, shader) for the frame's pixels in chunks.
  template <typename Work>
  TraceCounters trace_chunks(const FrameRequest& request, bool tell_rough, const Work& work, bool& stopped);
  // Of the frame's pixels, as the request wants them.
  void cut_into_chunks(const FrameRequest& request) {
    chunk_pixels = has_deadline(request.deadline) ? pixels_in_late_chunk : pixels_in_chunk(frame.pixels.size());
    turns.clear();
    if (has_deadline(request.deadline))
      turns = order_of_importance(frame.pixels, chunk_pixels, request.width, request.height);
  }
  size_t chunks() const { return (frame.pixels.size() + chunk_pixels - 1) / chunk_pixels; }
  std::span<const PixelRequest> chunk_of(size_t chunk) const {
    const size_t first = chunk * chunk_pixels;
    return std::span(frame.pixels).subspan(first, std::min(chunk_pixels, frame.pixels.size() - first));
  }

  template <typename MakeSink>
  TraceCounters trace_frame(const FrameRequest& request, bool cacheable_only, const MakeSink& make_sink, bool& stopped);
  TraceCounters trace_refracted(const FrameRequest& request, CompositeImage& image, bool& stopped);

  Executor executor;
  Intersector intersector;
  std::vector<Worker> workers;
  std::shared_ptr<const model::Snapshot> snapshot;  // as committed
  FoliageOptions options, taken;                    // as wanted, and as the scene has it
  bool stale = false;                               // they differ
  Foliage foliage;
  AngleCull cull;
  std::shared_ptr<const model::Snapshot> posed;  // the snapshot in the foliage's poses
  double update_ms = 0.0;
  std::unique_ptr<const ShadingScene> scene;          // of it, or of it with quads
  TraceView quads_view{};                             // that the quads face
  uint32_t quads_height = 0;                          // 0 = there are none
  std::unique_ptr<const RefractionScene> refraction;  // of the scene
  std::shared_ptr<const model::Snapshot> measured;    // what brightest() looked at
  float brightest_of_measured = 0.0f;
  FramePixels frame;
  size_t chunk_pixels = 1;
  std::vector<uint32_t> turns;  // the order in which chunks are taken; empty = as they are numbered
  LayerFilter filter;
  OpaqueReflections reflections;
  std::vector<ReferenceWorker> reference_workers;
  std::unique_ptr<const EnvironmentSampler> environment;
  std::vector<ReferenceLight> lights;
};

Tracer::Tracer(const TracerConfig& config) : state_(std::make_unique<State>(config)) {}
Tracer::~Tracer() = default;

uint32_t Tracer::threads() const {
  return state_->executor.threads();
}
std::string Tracer::isa() const {
  return state_->intersector.isa();
}
std::string Tracer::embree() const {
  return state_->intersector.version();
}

void Tracer::State::take(std::shared_ptr<const model::Snapshot> commit) {
  const auto start = std::chrono::steady_clock::now();
  const bool same_poses = scene && commit == snapshot && options.mode == taken.mode &&
                          options.shared_copies == taken.shared_copies && options.unique_cap == taken.unique_cap;
  const bool culls_anew = cull.update(*commit, options.cull_angle_deg, options.eye, executor, options.cull);
  if (!same_poses || culls_anew) {
    // Where something throws there is no scene, and the next call tries again.
    scene.reset();
    snapshot = commit;
    stale = true;
    refraction.reset();
    quads_height = 0;
    if (!same_poses) posed = foliage.pose(commit, options, executor);
    const SceneUpdate update{same_poses ? std::span<const PosedMesh>() : foliage.posed(), cull.culled(), &executor};
    executor.inside([&] { intersector.set_scene(posed, update); });
    scene = std::make_unique<const ShadingScene>(posed);
  }
  taken = options;
  stale = false;
  update_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void Tracer::set_scene(std::shared_ptr<const model::Snapshot> snapshot) {
  State& s = *state_;
  if (s.scene && s.snapshot == snapshot && !s.stale) return;
  s.take(std::move(snapshot));
}

void Tracer::set_foliage(const FoliageOptions& options) {
  state_->options = options;
  state_->stale = options != state_->taken;
}

const std::vector<uint8_t>& Tracer::culled() {
  state_->committed();
  return state_->cull.culled();
}

double Tracer::update_ms() const {
  return state_->update_ms;
}

namespace {

LayerSet layers_of(const FrameRequest& request) {
  if (request.particles) return LayerSet::with_sprites;
  return request.all_translucent ? LayerSet::all_translucent : LayerSet::visible_in_layers;
}

}  // namespace

template <typename Work>
TraceCounters Tracer::State::trace_chunks(const FrameRequest& request, bool tell_rough, const Work& work,
                                          bool& stopped) {
  const bool as_reference = request.light_samples > 0;
  const ReferenceScene scene_of_reference = as_reference ? reference_scene() : ReferenceScene{};
  const float mirrored = request.layer_threshold > 0.0f ? brightest() : 0.0f;
  for (Worker& worker : workers) worker.counters = {};
  std::atomic<bool> cancelled{false};
  executor.run(chunks(), [&](size_t turn, uint32_t thread) {
    if (cancelled || (request.cancelled && request.cancelled->load())) {
      cancelled = true;
      return;
    }
    const size_t chunk = turns.empty() ? turn : turns[turn];
    const std::span<const PixelRequest> pixels = chunk_of(chunk);
    Worker& worker = workers[thread];
    if (has_passed(request.deadline)) {
      worker.counters.pixels_late += pixels.size();
      return;
    }
    if (as_reference) {
      ReferenceShader& shader = reference_workers[thread].shader;
      shader.begin(scene_of_reference, request.light_samples, request.shadows);
      work(worker, chunk, pixels, shader);
    } else if (is_shaded_by_host()) {
      try {
        worker.host_shader.begin(*scene, intersector, host_calls(request), request.shadows);
        work(worker, chunk, pixels, worker.host_shader);
      } catch (const ShadingGivenUp& given_up) {
        if (given_up.cancelled) cancelled = true;
        worker.counters.pixels_late += pixels.size();
      }
    } else {
      worker.shader.begin(*scene, intersector, request.shadows, tell_rough);
      worker.shader.expect_mirrored(mirrored);
      work(worker, chunk, pixels, worker.shader);
    }
  });
  stopped = cancelled;
  TraceCounters sum;
  for (const Worker& worker : workers) sum += worker.counters;
  sum.pixels_total = uint64_t{request.width} * request.height;
  return sum;
}

template <typename MakeSink>
TraceCounters Tracer::State::trace_frame(const FrameRequest& request, bool cacheable_only, const MakeSink& make_sink,
                                         bool& stopped) {
  const ViewRays view(request.view, request.width, request.height);
  const LayerSet set = layers_of(request);
  const FrameContext context{&request, &view, &committed(), &intersector, set, cacheable_only};
  const auto work = [&](Worker& worker, size_t chunk, std::span<const PixelRequest> pixels, PointShader& shader) {
    auto sink = make_sink(worker, chunk);
    worker.layers.trace(context, pixels, shader, sink, worker.counters);
  };
  return trace_chunks(request, request.denoise && cacheable_only, work, stopped);
}

TraceCounters Tracer::State::trace_refracted(const FrameRequest& request, CompositeImage& image, bool& stopped) {
  const ViewRays view(request.view, request.width, request.height);
  const LayerSet set = layers_of(request);
  const FrameContext frame_context{&request, &view, &committed(), &intersector, set, false};
  const bool exact = request.light_samples > 0;
  const RefractionContext context = refraction_context(frame_context, refraction_scene(), exact);
  const auto work = [&](Worker& worker, size_t, std::span<const PixelRequest> pixels, PointShader& shader) {
    worker.refraction.trace(context, pixels, shader, worker.refracted_pixels, worker.counters);
    store_refracted(pixels, worker.refracted_pixels, exact, image);
  };
  return trace_chunks(request, false, work, stopped);
}

TraceCounters Tracer::trace_cache(const FrameRequest& request, LayerCache& cache) {
  State& s = *state_;
  const ShadingScene& scene = s.committed();
  if (request.max_layers == 0 || request.max_layers > 8)
    fail(SIDERAY_INVALID_ARGUMENT, "layers is {}: a layer cache holds 1 to 8", request.max_layers);
  gather_pixels(request, s.executor, s.frame);
  if (request.asked_bits != 0 &&
      (cache.width != request.width || cache.height != request.height || cache.layers != request.max_layers ||
       cache.traced_tiles.size() != s.frame.tiles.size()))
    fail(SIDERAY_INVALID_ARGUMENT, "second wave of {}x{}, {} layers: the cache that it adds to holds {}x{}, {} layers",
         request.width, request.height, request.max_layers, cache.width, cache.height, cache.layers);
  s.cut_into_chunks(request);
  begin_cache(request, s.frame.tiles, s.executor, cache);
  s.filter.begin(request.denoise ? s.chunks() : 0);
  bool stopped = false;
  LayerHistory* history = temporal_period(request.cache_rate) > 0 ? request.history : nullptr;
  if (history) history->begin(request, scene.snapshot, s.snapshot, s.frame);
  const auto rough = [&](size_t chunk) { return request.denoise ? &s.filter.chunk(chunk) : nullptr; };
  TraceCounters counters =
      history
          ? s.trace_frame(
                request, true,
                [&](State::Worker&, size_t chunk) {
                  return TemporalSink(cache, *scene.snapshot, *history, rough(chunk));
                },
                stopped)
          : s.trace_frame(
                request, true,
                [&](State::Worker&, size_t chunk) { return CacheSink(cache, *scene.snapshot, rough(chunk)); }, stopped);
  if (!stopped && request.denoise) {
    const auto start = std::chrono::steady_clock::now();
    s.filter.apply(s.executor, cache, history);
    counters.denoise_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }
  if (history) history->end(!stopped);
  // What the owner uploads after a frame that was given up is unknown: the next one clears and sends everything.
  if (stopped) std::fill(cache.traced_tiles.begin(), cache.traced_tiles.end(), uint8_t{1});
  counters.pixels_masked = s.frame.masked, counters.layers_requested = s.frame.requested;
  return counters;
}

LayerTruth Tracer::trace_truth(const FrameRequest& request) {
  State& s = *state_;
  return trace_layer_truth(request, s.committed(), s.intersector, s.executor);
}

TraceCounters Tracer::trace_composite(const FrameRequest& request, CompositeImage& image) {
  State& s = *state_;
  s.committed();
  if (request.particles) s.place_sprites(request.view, request.height);
  gather_pixels(request, s.executor, s.frame);
  s.cut_into_chunks(request);
  begin_composite(request, s.frame.tiles, s.executor, image);
  const bool exact = request.light_samples > 0;
  bool stopped = false;
  const auto make_sink = [&](State::Worker& worker, size_t) { return CompositeSink(image, worker.pixels, exact); };
  TraceCounters counters =
      request.refraction ? s.trace_refracted(request, image, stopped)
                         : s.trace_frame(request, false, make_sink, stopped);
  if (stopped) std::fill(image.traced_tiles.begin(), image.traced_tiles.end(), uint8_t{1});
  if (!request.particles) counters.dropped_particles = count_sprites_in_view(*s.snapshot, request.view);
  return counters;
}

TraceCounters Tracer::trace_masks(const MaskRequest& request, OcclusionMasks& masks) {
  State& s = *state_;
  const model::Snapshot& snapshot = *s.committed().snapshot;
  TraceCounters counters = trace_occlusion_masks(request, snapshot, s.intersector, s.executor, masks);
  if (!request.filters || (request.cancelled && *request.cancelled)) return counters;
  const auto start = std::chrono::steady_clock::now();
  request.filters->filter(s.executor, request, snapshot, masks);
  counters.denoise_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return counters;
}

TraceCounters Tracer::trace_reflections(const ReflectionRequest& request, ReflectionImage& image) {
  State& s = *state_;
  return s.reflections.trace(request, s.committed(), s.intersector, s.executor, image);
}

TraceCounters Tracer::trace_reference(const ReferenceRequest& request, ReferenceImage& image) {
  State& s = *state_;
  if (request.views.empty() || request.light_samples == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "reference: no view or no light samples; give at least one of each");
  // Sample positions move the picture's window, not the eye or its axes.
  s.place_sprites(request.views.front(), request.height);
  const ReferenceScene scene = s.reference_scene();
  const RefractionScene* refraction = request.refraction ? &s.refraction_scene() : nullptr;
  return trace_reference_image(request, scene, refraction, s.executor, s.reference_workers, image);
}

PrimaryImage Tracer::trace_primary(const TraceView& view, uint32_t width, uint32_t height) {
  State& s = *state_;
  return trace_primary_image(s.committed(), s.intersector, s.executor, view, width, height);
}

std::vector<OpaquePoint> Tracer::trace_points(const TraceView& view, uint32_t width, uint32_t height) {
  State& s = *state_;
  return trace_opaque_points(s.committed(), s.intersector, s.executor, view, width, height);
}

void Tracer::trace_rays(sideray_ray_set set, std::span<const sideray_ray> rays, uint32_t layers, sideray_hit* hits) {
  State& s = *state_;
  trace_ray_batch(*s.committed().snapshot, s.intersector, s.executor, set, rays, layers, hits);
}

}  // namespace sideray::rt
