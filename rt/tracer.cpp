#include "rt/tracer.h"

#include <utility>

#include "rt/base/float_mode.h"
#include "rt/cache/layer_tracing.h"
#include "rt/composite/composite_tracing.h"
#include "rt/drawing/blend_translucent.h"
#include "rt/drawing/composite_over.h"
#include "rt/drawing/distort_picture.h"
#include "rt/drawing/motion.h"
#include "rt/drawing/opaque_light.h"
#include "rt/drawing/temporal_average.h"
#include "rt/drawing/translucent_places.h"
#include "rt/irradiance/irradiance_tracing.h"
#include "rt/layers/layer_check.h"
#include "rt/masks/occlusion_masks.h"
#include "rt/masks/surface_check.h"
#include "rt/reference/ray_batches.h"
#include "rt/reference/reference_tracing.h"
#include "rt/reflections/reflection_tracing.h"
#include "rt/scene/traced_scene.h"
#include "rt/truth/as_drawn.h"
#include "rt/truth/ground_truth.h"
#include "rt/truth/layered_depth.h"
#include "rt/truth/object_truth.h"

namespace sideray::rt {

struct Tracer::State {
  State(std::string wanted_isa, std::shared_ptr<TracedScene> traced)
      : isa(std::move(wanted_isa)),
        shared_scene(std::move(traced)),
        scene(*shared_scene),
        layers(threads()),
        composite(threads()),
        reflections(threads()),
        irradiance(threads()),
        reference(threads()) {}
  uint32_t threads() { return scene.executor().threads(); }

  const std::string isa;  // as requested
  const std::shared_ptr<TracedScene> shared_scene;
  TracedScene& scene;
  LayerTracing layers;
  CompositeTracing composite;
  ReflectionTracing reflections;
  IrradianceTracing irradiance;
  ReferenceTracing reference;
  GroundTruthTracing truth;
  LayeredDepthTracing layered_depth;
};

Tracer::Tracer(const TracerConfig& config)
    : state_(std::make_unique<State>(config.isa, std::make_shared<TracedScene>(config))) {}
Tracer::Tracer(SceneOf other)
    : state_(std::make_unique<State>(other.tracer.state_->isa, other.tracer.state_->shared_scene)) {}
Tracer::~Tracer() = default;

bool Tracer::may_trace_beside() const {
  const TracedScene& scene = state_->scene;
  return scene.committed() && scene.committed()->particles.empty() && scene.foliage().cull_angle_deg == 0.0f;
}

uint32_t Tracer::threads() const {
  return state_->threads();
}
std::string Tracer::isa() const {
  return state_->scene.intersector().isa();
}
std::string Tracer::embree() const {
  return state_->scene.intersector().version();
}

void Tracer::set_scene(std::shared_ptr<const model::Snapshot> snapshot) {
  state_->scene.set_scene(std::move(snapshot));
}

void Tracer::set_foliage(const FoliageOptions& options) {
  state_->scene.set_foliage(options);
}

void Tracer::set_glass_shadows(bool on) {
  state_->scene.set_glass_shadows(on);
}

const std::vector<uint8_t>& Tracer::culled() {
  return state_->scene.culled();
}

double Tracer::update_ms() const {
  return state_->scene.update_ms();
}

void Tracer::run(size_t count, const std::function<void(size_t index, uint32_t worker)>& work) {
  // Between traces denormals are kept, as on the calling thread.
  state_->scene.executor().run(count, [&](size_t index, uint32_t worker) {
    const KeepDenormals keep;
    work(index, worker);
  });
}

Counters Tracer::trace_cache(const CacheRequest& request, LayerCache& cache) {
  return state_->layers.trace(request, state_->scene, cache);
}

LayerTruth Tracer::trace_truth(const CacheRequest& request) {
  return trace_layer_truth(request, state_->scene);
}

Counters Tracer::trace_composite(const LayerRequest& request, CompositeImage& image) {
  State& s = *state_;
  if (request.light_samples == 0) return s.composite.trace(request, s.scene, nullptr, image);
  if (request.particles) s.scene.place_sprites(request.view, request.height);
  ShaderSource& exact = s.reference.shaders(
      s.scene, {request.light_samples, request.bounces, request.shadows, request.refraction != 0, false});
  return s.composite.trace(request, s.scene, &exact, image);
}

Counters Tracer::trace_masks(const MaskRequest& request, OcclusionMasks& masks) {
  Counters counters = rt::trace_masks(request, state_->scene, masks);
  if (request.checks_surfaces) counters += check_surfaces(request, state_->scene);
  return counters;
}

Counters Tracer::trace_reflections(const ReflectionRequest& request, ReflectionImage& image) {
  return state_->reflections.trace(request, state_->scene, image);
}

Counters Tracer::trace_irradiance(const IrradianceRequest& request, IrradianceImage& image) {
  return state_->irradiance.trace(request, state_->scene, image);
}

Counters Tracer::trace_reference(const ReferenceRequest& request, ReferenceImage& image) {
  return state_->reference.trace(request, state_->scene, image);
}

PrimaryImage Tracer::trace_primary(const TraceView& view, uint32_t width, uint32_t height) {
  TracedScene& scene = state_->scene;
  return trace_primary_image(scene.shading(), scene.intersector(), scene.executor(), view, width, height);
}

std::vector<OpaquePoint> Tracer::trace_points(const TraceView& view, uint32_t width, uint32_t height) {
  TracedScene& scene = state_->scene;
  return trace_opaque_points(scene.shading(), scene.intersector(), scene.executor(), view, width, height);
}

Counters Tracer::trace_opaque(const OpaqueRequest& request, OpaquePixels& pixels) {
  return trace_opaque_pixels(request, state_->scene, pixels);
}

OpaqueMaterials Tracer::opaque_materials(const OpaqueRequest& request, const OpaquePixels& pixels) {
  return materials_of(request, pixels, state_->scene);
}

std::vector<glm::uvec2> Tracer::opaque_ids(const OpaquePixels& pixels) {
  return ids_of(pixels, state_->scene);
}

std::vector<uint8_t> Tracer::translucent_places(const OpaqueRequest& request) {
  return rt::translucent_places(*state_->scene.shading().snapshot, request.view, request.width, request.height);
}

std::vector<uint8_t> Tracer::count_translucent(const OpaqueRequest& request, const OpaquePixels& pixels, bool sprites,
                                               uint32_t most) {
  return rt::count_translucent(request, pixels, sprites, most, state_->scene);
}

std::vector<glm::vec2> Tracer::trace_motion(const MotionRequest& request, const OpaquePixels& pixels) {
  return rt::trace_motion(request, pixels, state_->scene);
}

void Tracer::distort(const OpaqueRequest& request, const OpaquePixels& pixels, std::vector<glm::vec4>& picture) {
  distort_picture(request, pixels, state_->scene, picture);
}

Counters Tracer::blend(const BlendRequest& request, std::vector<glm::vec4>& picture) {
  return blend_translucent(request, state_->scene, picture);
}

void Tracer::average(const AverageRequest& request, const OpaquePixels& pixels, const std::vector<glm::vec2>& motion,
                     TemporalAverage& average, std::vector<glm::vec4>& picture) {
  average.average(request, pixels, motion, state_->scene.executor(), picture);
}

void Tracer::composite_over(const CompositeImage& image, std::vector<glm::vec4>& picture) {
  rt::composite_over(image, state_->scene.executor(), picture);
}

Counters Tracer::light_opaque(const OpaqueLightRequest& request, std::vector<glm::vec4>& picture) {
  return light_opaque_pixels(request, state_->scene, picture);
}

GroundTruthImage Tracer::trace_ground_truth(const GroundTruthRequest& request) {
  const AsDrawn as_drawn(state_->scene);
  return state_->truth.trace(request, state_->scene);
}

std::vector<ObjectTruth> Tracer::trace_objects(const ObjectTruthRequest& request) {
  const AsDrawn as_drawn(state_->scene);
  return trace_object_truth(request, state_->scene);
}

void Tracer::trace_layered_depth(const LayeredDepthRequest& request) {
  const AsDrawn as_drawn(state_->scene);
  state_->layered_depth.trace(request, state_->scene);
}

void Tracer::trace_rays(sideray_ray_set set, std::span<const sideray_ray> rays, uint32_t layers, sideray_hit* hits) {
  TracedScene& scene = state_->scene;
  trace_ray_batch(*scene.shading().snapshot, scene.intersector(), scene.executor(), {set, rays, layers, hits});
}

RawFrame Tracer::time_raw_frame(const RawFrameRequest& request) {
  TracedScene& scene = state_->scene;
  return rt::time_raw_frame(*scene.shading().snapshot, request, state_->isa, scene.executor());
}

}  // namespace sideray::rt
