// Traces a committed scene: the front of all of rt, whose parts each have a folder. Plain memory, no OpenGL; one call
// at a time. Row 0 of pixels is the bottom row. Results have the same bits for any thread count. Several tracers may
// share one scene and trace at the same time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
#include "rt/base/opaque_point.h"
#include "rt/base/tracer_config.h"
#include "rt/base/view.h"
#include "rt/composite/composite_image.h"
#include "rt/embree/raw_frame.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/layers/layer_request.h"
#include "rt/masks/mask_request.h"
#include "rt/poses/foliage.h"
#include "rt/reference/reference_request.h"
#include "rt/reflections/reflection_request.h"

namespace sideray::rt {

// rt/truth/ground_truth.h, object_truth.h and layered_depth.h, for callers that want them.
struct GroundTruthRequest;
struct GroundTruthImage;
struct ObjectTruthRequest;
struct ObjectTruth;
struct LayeredDepthRequest;
// rt/drawing/: drawing without a rasterizer.
struct OpaqueRequest;
struct OpaquePixels;
struct OpaqueMaterials;
struct OpaqueLightRequest;
struct MotionRequest;
struct BlendRequest;
struct AverageRequest;
class TemporalAverage;

class Tracer {
 public:
  explicit Tracer(const TracerConfig& config);
  // Makes a tracer with the scene and threads of another one. Functions that change the scene change it for both; call
  // them only while neither traces.
  struct SceneOf {
    Tracer& tracer;
  };
  explicit Tracer(SceneOf other);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  // Returns whether tracers that share the scene may trace at the same time. They may not if rays of each view hit a
  // different scene, or before one of them has traced all that the others trace, because parts of the scene are made on
  // first use.
  bool may_trace_beside() const;
  // As Executor::run, on the tracing threads. Whatever `work` traces runs on its own thread alone.
  void run(size_t count, const std::function<void(size_t index, uint32_t worker)>& work);

  // Builds or updates the acceleration structures. Throws Failure.
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot);

  // Sets which poses of moving plants rays hit, and which instances are too small to be hit, from the next set_scene,
  // trace or culled() on. It costs nothing if the options have not changed.
  void set_foliage(const FoliageOptions& options);
  // Sets whether translucent surfaces cast coloured shadows (model::tints_light()), from the next trace on; by default
  // they do.
  void set_glass_shadows(bool on);
  // Returns one entry an instance of the snapshot, 1 = no ray hits it; empty = all are hit. Valid until the next of the
  // calls above.
  const std::vector<uint8_t>& culled();
  // Returns the time of the last change of scene or foliage: poses, refits, set-up and commits.
  double update_ms() const;

  Counters trace_cache(const CacheRequest& request, LayerCache& cache);
  LayerTruth trace_truth(const CacheRequest& request);  // what a cache of this request is checked against
  Counters trace_composite(const LayerRequest& request, CompositeImage& image);
  Counters trace_masks(const MaskRequest& request, OcclusionMasks& masks);
  Counters trace_reflections(const ReflectionRequest& request, ReflectionImage& image);
  Counters trace_irradiance(const IrradianceRequest& request, IrradianceImage& image);
  Counters trace_reference(const ReferenceRequest& request, ReferenceImage& image);
  PrimaryImage trace_primary(const TraceView& view, uint32_t width, uint32_t height);
  std::vector<OpaquePoint> trace_points(const TraceView& view, uint32_t width, uint32_t height);

  // These draw what a rasterizer draws elsewhere.
  Counters trace_opaque(const OpaqueRequest& request, OpaquePixels& pixels);
  OpaqueMaterials opaque_materials(const OpaqueRequest& request, const OpaquePixels& pixels);
  std::vector<glm::uvec2> opaque_ids(const OpaquePixels& pixels);  // OpaqueMaterials::ids
  // As in rt/drawing/translucent_places.h.
  std::vector<uint8_t> translucent_places(const OpaqueRequest& request);
  // Counts the translucent surfaces in front of opaque ones, at most `most` a pixel.
  std::vector<uint8_t> count_translucent(const OpaqueRequest& request, const OpaquePixels& pixels, bool sprites,
                                         uint32_t most);
  Counters light_opaque(const OpaqueLightRequest& request, std::vector<glm::vec4>& picture);
  std::vector<glm::vec2> trace_motion(const MotionRequest& request, const OpaquePixels& pixels);
  void distort(const OpaqueRequest& request, const OpaquePixels& pixels, std::vector<glm::vec4>& picture);
  Counters blend(const BlendRequest& request, std::vector<glm::vec4>& picture);
  void average(const AverageRequest& request, const OpaquePixels& pixels, const std::vector<glm::vec2>& motion,
               TemporalAverage& average, std::vector<glm::vec4>& picture);
  // Composites the image over the picture.
  void composite_over(const CompositeImage& image, std::vector<glm::vec4>& picture);

  // These hit the scene as drawn, whatever the foliage options: nothing culled, in its own poses.
  GroundTruthImage trace_ground_truth(const GroundTruthRequest& request);
  std::vector<ObjectTruth> trace_objects(const ObjectTruthRequest& request);
  void trace_layered_depth(const LayeredDepthRequest& request);

  // Traces rays in local space: hits[i * layers + k]. The caller checks the arguments.
  void trace_rays(sideray_ray_set set, std::span<const sideray_ray> rays, uint32_t layers, sideray_hit* hits);

  // Times a raw frame of the scene with its poses, nothing culled. Nothing else may be traced meanwhile.
  RawFrame time_raw_frame(const RawFrameRequest& request);

  uint32_t threads() const;
  std::string isa() const;     // the one in use, e.g. "avx2"
  std::string embree() const;  // "3.13.5"

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sideray::rt
