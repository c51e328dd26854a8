// Traces reflections of glossy opaque surfaces in a frame, by rays from the depth buffer: one a pixel, filtered over
// neighbouring pixels of a rough surface. It reuses its memory every frame. One call at a time. Row 0 of pixels is the
// bottom row.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/trace_end.h"
#include "rt/base/view_rays.h"
#include "rt/cache/layer_filter.h"
#include "rt/reflections/reflection_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

// Returns the weight of traced radiance against the prefiltered environment: 1 up to two thirds of max_roughness, then
// falling to 0, so that no edge shows where tracing ends.
float reflection_share(float roughness, float max_roughness);

class ReflectionTracing {
 public:
  explicit ReflectionTracing(uint32_t threads);
  ~ReflectionTracing();
  // Traces `request` into `image`. Throws Failure.
  Counters trace(const ReflectionRequest& request, TracedScene& scene, ReflectionImage& image);

 private:
  // Scratch memory of one thread, reused by the next frame.
  struct Worker;
  struct Tile {
    const ReflectionRequest* request;
    const ViewRays* view;
    const ShadingScene* scene;
    const Intersector* intersector;
    uint32_t index, x, y;
  };

  Counters trace_tiles(const ReflectionRequest& request, TracedScene& scene, const std::vector<uint8_t>& traced,
                       OlderReflections* older, ReflectionImage& image);
  static void empty(const Tile& tile, ReflectionImage& image);
  void trace_tile(const Tile& tile, Worker& worker, ReflectionImage& image);
  static bool gather(const Tile& tile, Worker& worker);
  static TraceEnd reflect(const Tile& tile, Worker& worker);
  void filter(const ReflectionRequest& request, Executor& executor, ReflectionImage& image);

  std::vector<Worker> workers_;
  LayerFilter filter_;
};

}  // namespace sideray::rt
