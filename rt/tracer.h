// Traces a snapshot: layer cache, ray-ordered composite, ray batches. Plain memory; no OpenGL. Embree stays in
// rt/embree. Pixels: row 0 is the bottom row. All results are the same bits for any thread count.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
#include "rt/base/opaque_point.h"
#include "rt/base/view.h"
#include "rt/composite/composite_image.h"
#include "rt/layers/layer_request.h"
#include "rt/masks/mask_request.h"
#include "rt/poses/foliage.h"
#include "rt/reference/reference_request.h"
#include "rt/reflections/reflection_request.h"

namespace sideray::rt {

struct TracerConfig {
  uint32_t threads = 0;  // 0 = all
  std::string isa;       // "", "sse4.2", "avx2", "avx512"
};

class Tracer {
 public:
  explicit Tracer(const TracerConfig& config);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  // Builds or updates the acceleration structures. Throws Failure.
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot);

  // Which poses of moving plants rays meet, and which instances look too small to be met: from the next set_scene,
  // trace or culled() on. Costs nothing where the options are those it has.
  void set_foliage(const FoliageOptions& options);
  // 1 = no ray meets the instance of the snapshot; empty = all are met. Holds until the next of the calls above.
  const std::vector<uint8_t>& culled();
  // What the last change of scene or foliage took: poses, refits, set-up and commits.
  double update_ms() const;

  TraceCounters trace_cache(const FrameRequest& request, LayerCache& cache);
  LayerTruth trace_truth(const FrameRequest& request);  // what a cache of this request is checked against
  TraceCounters trace_composite(const FrameRequest& request, CompositeImage& image);
  TraceCounters trace_masks(const MaskRequest& request, OcclusionMasks& masks);
  TraceCounters trace_reflections(const ReflectionRequest& request, ReflectionImage& image);
  TraceCounters trace_reference(const ReferenceRequest& request, ReferenceImage& image);
  PrimaryImage trace_primary(const TraceView& view, uint32_t width, uint32_t height);
  std::vector<OpaquePoint> trace_points(const TraceView& view, uint32_t width, uint32_t height);

  // Rays in local space; hits[i * layers + k]. Arguments are checked by the caller.
  void trace_rays(sideray_ray_set set, std::span<const sideray_ray> rays, uint32_t layers, sideray_hit* hits);

  uint32_t threads() const;
  std::string isa() const;     // what is used, e.g. "avx2"
  std::string embree() const;  // "3.13.5"

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sideray::rt
