#include "rt/composite/composite_tracing.h"

#include <algorithm>

#include "model/stopwatch.h"
#include "rt/poses/particle_quads.h"

namespace sideray::rt {
namespace {

LayerSet layers_of(const LayerRequest& request) {
  if (request.particles) return LayerSet::with_sprites;
  return request.all_translucent ? LayerSet::all_translucent : LayerSet::visible_in_layers;
}

// The stencil's count does not limit a ray that is refracted into other pixels or that also hits particles.
PixelSelection selection_of(const LayerRequest& request) {
  return {.pattern = {}, .requested_bits = 0, .counted = !request.refraction && !request.particles};
}

}  // namespace

Counters CompositeTracing::trace(const LayerRequest& request, TracedScene& scene, ShaderSource* exact,
                                 CompositeImage& image) {
  const bool resolves = request.resolves && !exact;
  const bool bends = request.refraction && (!resolves || bends_light(*scene.shading().snapshot));
  if (request.particles) scene.place_sprites(request.view, request.height);
  const ShadingScene& shading = scene.shading();
  chunks_.gather(request, selection_of(request), scene.executor());
  begin_composite(request, chunks_.frame().tiles, scene.executor(), image);
  filtered_.begin(request.width, request.height, chunks_.count(), resolves && request.denoise);
  const ViewRays view(request.view, request.width, request.height);
  const FrameContext context{.request = &request,
                             .view = &view,
                             .scene = &shading,
                             .intersector = &scene.intersector(),
                             .set = layers_of(request)};
  ShaderSource& shaders = exact ? *exact : begin_shaders(request, scene);
  RefractionContext refraction{};
  if (bends) refraction = refraction_context(context, refraction_.of(shading.snapshot), exact != nullptr);
  FrameContext straight = context;
  if (bends) straight.bends = refraction.scene->bends;
  for (Worker& worker : workers_) worker.counters = {};
  Counters counters;
  if (resolves && request.particles && !shading.snapshot->shader.shade) {
    counters += sprites_.light(shading, scene.intersector(), {.shadows = request.shadows, .tints = true}, scene.executor());
    if (!sprites_.empty()) straight.sprites = &sprites_;
  }
  const TraceEnd end =
      chunks_.run(request, scene.executor(),
                  resolves ? to_resolved_surfaces(straight, bends ? &refraction : nullptr, shaders, image)
                  : bends  ? along_refracted_rays(refraction, shaders, image)
                           : along_straight_rays(context, shaders, image),
                  {}, counters);
  if (end == TraceEnd::complete) {
    const Stopwatch watch;
    filtered_.finish(scene.executor(), image);
    counters.denoise_ms = filtered_.filters() ? watch.ms() : 0.0;
  }
  if (end == TraceEnd::cancelled) std::fill(image.traced_tiles.begin(), image.traced_tiles.end(), uint8_t{1});
  for (const Worker& worker : workers_) counters += worker.counters;
  counters.pixels_total = uint64_t{request.width} * request.height;
  if (!request.particles) counters.dropped_particles = count_sprites_in_view(*scene.committed(), request.view);
  return counters;
}

ShaderSource& CompositeTracing::begin_shaders(const LayerRequest& request, TracedScene& scene) {
  const ShadingScene& shading = scene.shading();
  shaders_.begin_frame({.scene = shading,
                        .intersector = scene.intersector(),
                        .calls = host_calls(request),
                        .shading = {.shadows = request.shadows,
                                    .tell_rough = request.resolves && request.denoise,
                                    .error = request.ray_reuse,
                                    .viewer = way_to_viewer(request.view),
                                    .bounces = bounces_of(request),
                                    .seen = seen_light_of(request)}});
  return shaders_;
}

FrameChunks::Trace CompositeTracing::along_straight_rays(const FrameContext& context, ShaderSource& shaders,
                                                         CompositeImage& image) {
  return [&](size_t, std::span<const PixelRequest> pixels, uint32_t thread) {
    Worker& worker = workers_[thread];
    PointShader& shader = shaders.begin_chunk(thread);
    CompositeSink sink(image, worker.pixels, shader.estimates() > 1);
    return worker.layers.trace(context, pixels, shader, sink, worker.counters);
  };
}

FrameChunks::Trace CompositeTracing::along_refracted_rays(const RefractionContext& context, ShaderSource& shaders,
                                                          CompositeImage& image) {
  return [&](size_t, std::span<const PixelRequest> pixels, uint32_t thread) {
    Worker& worker = workers_[thread];
    const TraceEnd end = worker.refraction.trace(context, pixels, shaders.begin_chunk(thread), worker.refracted_pixels,
                                                 worker.counters);
    if (end == TraceEnd::complete) store_refracted(pixels, worker.refracted_pixels, context.exact, image);
    return end;
  };
}

FrameChunks::Trace CompositeTracing::to_resolved_surfaces(const FrameContext& straight, const RefractionContext* bent,
                                                          ShaderSource& shaders, CompositeImage& image) {
  return [&, bent](size_t chunk, std::span<const PixelRequest> pixels, uint32_t thread) {
    Worker& worker = workers_[thread];
    PointShader& shader = shaders.begin_chunk(thread);
    FilteredSink sink(*straight.scene->snapshot, straight.bends, chunk, filtered_, worker.filtered_pixels, image);
    if (!bent) return worker.layers.trace(straight, pixels, shader, sink, worker.counters);
    RefractingSink refracting(sink, *bent, shader, worker.refracting, worker.counters);
    return worker.layers.trace(straight, pixels, shader, refracting, worker.counters);
  };
}

}  // namespace sideray::rt
