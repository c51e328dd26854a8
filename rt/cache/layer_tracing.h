// Traces the layers of a frame into a cache: gathers pixels, traces and shades them in chunks, and filters rough
// reflections. It reuses its memory every frame. One call at a time.
#pragma once

#include <vector>

#include "rt/base/counters.h"
#include "rt/cache/layer_cache.h"
#include "rt/cache/layer_filter.h"
#include "rt/layers/frame_chunks.h"
#include "rt/layers/layer_request.h"
#include "rt/layers/layer_tracer.h"
#include "rt/refraction/refracting_sink.h"
#include "rt/scene/traced_scene.h"
#include "rt/shading/frame_shaders.h"

namespace sideray::rt {

class LayerTracing {
 public:
  explicit LayerTracing(uint32_t threads) : shaders_(threads), workers_(threads) {}
  // Traces the layers of `request` into `cache`. Throws Failure.
  Counters trace(const CacheRequest& request, TracedScene& scene, LayerCache& cache);

 private:
  struct Worker {
    LayerTracer tracer;
    WholePixels whole;
    RefractingScratch refraction;
    Counters counters;
  };
  void check(const CacheRequest& request, const LayerCache& cache) const;
  std::vector<uint8_t> choose_chunks(const CacheRequest& request);
  void prepare(const CacheRequest& request, TracedScene& scene, LayerCache& cache);
  // Holds the state for pixels whose light is refracted.
  struct Bent {
    FrameContext behind;  // scene of the refracted rays
    RefractionContext context;
  };
  void refract(const CacheRequest& request, TracedScene& scene, FrameContext& straight, Bent& bent);
  void composite_filtered(Executor& executor, LayerCache& cache);
  TraceEnd trace_chunks(const CacheRequest& request, TracedScene& scene, LayerCache& cache, Counters& counters);
  // Names what all chunks of a frame share.
  struct Traced {
    const CacheRequest& request;
    const FrameContext& straight;
    const RefractionContext* bent;  // null: nothing bends light
    LayerCache& cache;
    OlderLayers* older;  // null: the frame takes nothing from earlier ones
  };
  TraceEnd trace_chunk(const Traced& traced, size_t chunk, std::span<const PixelRequest> pixels, uint32_t thread);

  FrameChunks chunks_;
  std::vector<uint8_t> chosen_;  // chunks to trace; empty: all
  FrameShaders shaders_;
  LayerFilter filter_;
  std::vector<std::vector<WholePixels::Pixel>> whole_later_;  // by chunk: whole pixels that wait for the filter
  KeptRefractionScene refraction_;
  std::vector<Worker> workers_;
};

}  // namespace sideray::rt
