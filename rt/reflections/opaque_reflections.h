// What glossy opaque surfaces of a frame mirror, by rays from the depth buffer: one a pixel, and a filter over the
// pixels of a surface where it is rough. Plain memory; any thread. Pixels: row 0 is the bottom row.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/layers/layer_filter.h"
#include "rt/reflections/reflection_request.h"
#include "rt/shading/hit_shader.h"

namespace sideray::rt {

// How much of the mirrored radiance counts beside the prefiltered environment: 1 up to two thirds of the largest
// roughness that is traced, then falling to 0 there, so that no edge is seen where tracing ends.
float reflection_share(float roughness, float max_roughness);

class OpaqueReflections {
 public:
  // Throws Failure.
  TraceCounters trace(const ReflectionRequest& request, const ShadingScene& scene, const Intersector& intersector,
                      Executor& executor, ReflectionImage& image);

 private:
  // Memory of one thread, kept from frame to frame.
  struct Worker;
  struct Tile {
    const ReflectionRequest* request;
    const ViewRays* view;
    const ShadingScene* scene;
    const Intersector* intersector;
    uint32_t index, x, y;
  };

  void trace_tile(const Tile& tile, Worker& worker, ReflectionImage& image);
  static bool gather(const Tile& tile, Worker& worker);
  static void reflect(const Tile& tile, Worker& worker);

  std::vector<std::shared_ptr<Worker>> workers_;
  LayerFilter filter_;
};

}  // namespace sideray::rt
