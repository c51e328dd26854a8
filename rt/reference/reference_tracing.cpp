#include "rt/reference/reference_tracing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/failure.h"
#include "rt/base/sampling.h"
#include "rt/layers/distortion.h"
#include "rt/layers/frame_pixels.h"
#include "rt/reference/ray_batches.h"

namespace sideray::rt {
namespace {

constexpr size_t pixels_in_chunk = 256;           // for any thread count: the same packets, the same bits
constexpr uint32_t opaque_surface = 0xffffffffu;  // replaces the layer's index in random numbers
constexpr float infinity = std::numeric_limits<float>::infinity();
// A translucent surface less than this share of the distance in front of an opaque one counts as lying on it, as in
// ViewRays::end_of_ray.
constexpr float on_surface = 0x1p-21f;

// Adds up the layers of a chunk.
class ReferenceSink final : public LayerSink {
 public:
  explicit ReferenceSink(std::vector<ReferenceWorker::Pixel>& pixels) : pixels_(pixels) {}
  void begin(std::span<const PixelRequest>) override {}
  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit&, glm::vec3& weight) override {
    const shading::SrBlend blend = shading::sr_blend(point.surface, point.to_eye, point.blend);
    weight = pixels_[pixel].transmittance * blend.cover;
    pixels_[pixel].transmittance *= blend.through;
    return blend.cover > 0.0f;
  }
  void add(uint32_t pixel, uint32_t, const Hit&, const glm::vec3* radiance, glm::vec3 weight) override {
    for (int half = 0; half < 2; ++half) pixels_[pixel].radiance[half] += radiance[half] * weight;
  }
  bool finished(uint32_t pixel) const override { return pixels_[pixel].transmittance == glm::vec3(0.0f); }
  void end(std::span<const PixelRequest>) override {}

 private:
  std::vector<ReferenceWorker::Pixel>& pixels_;
};

// Traces one sample position.
class Pass {
 public:
  Pass(const ReferenceRequest& request, const ReferenceScene& scene, const RefractionScene* refraction,
       uint32_t position, ReferenceImage& image)
      : request_(request),
        scene_(scene),
        position_(position),
        image_(image),
        view_(request.views[position], request.width, request.height),
        ends_(size_t{request.width} * request.height) {
    layers_.view = request.views[position];
    layers_.width = request.width, layers_.height = request.height;
    layers_.seed = request.seed;
    context_ = {.request = &layers_,
                .view = &view_,
                .scene = scene.scene,
                .intersector = scene.intersector,
                .set = LayerSet::with_sprites,
                .position = position,
                .ends = ends_.data()};
    if (refraction) refraction_ = refraction_context(context_, *refraction, true);
    if (distorts(*scene.scene->snapshot)) opaque_.resize(ends_.size()), offsets_.resize(ends_.size());
  }

  // Returns whether anything distorts. Then the whole opaque picture is traced first, with each pixel's offset.
  bool distorts_picture() const { return !opaque_.empty(); }
  void trace_distortion(std::span<const PixelRequest> pixels, ReferenceWorker& w) {
    w.sums.assign(pixels.size(), {});
    trace_opaque(pixels, w);
    shade_opaque(pixels, w);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const ReferenceWorker::Pixel& sum = w.sums[i];
      const PixelRequest& p = pixels[i];
      const float depth = w.hits[i].instance == no_instance ? infinity : view_.depth(p.x, p.y, w.hits[i].distance);
      opaque_[texel_of(p)] = {{sum.background[0], sum.background[1]}, sum.coverage, depth};
    }
    DistortionSink sink(view_, request_.width, offsets_);
    Counters met;
    w.layers.trace(context_, pixels, *w.shader, sink, met);
    w.counters.rays_primary += met.rays_primary;
  }

  void trace(std::span<const PixelRequest> pixels, ReferenceWorker& w) {
    w.sums.assign(pixels.size(), {});
    const bool by_paths = request_.bounces != 1;
    if (by_paths || !distorts_picture()) trace_opaque(pixels, w);
    if (distorts_picture())
      take_distorted(pixels, w);
    else if (!by_paths)
      shade_opaque(pixels, w);
    if (by_paths)
      trace_paths(pixels, w);
    else
      trace_translucent(pixels, w);
    for (size_t i = 0; i < pixels.size(); ++i) store(pixels[i], w.sums[i]);
  }

 private:
  // Fills hits, and the background where translucent surfaces are in front of the sky.
  void trace_opaque(std::span<const PixelRequest> pixels, ReferenceWorker& w) {
    w.rays.clear();
    for (const PixelRequest& p : pixels) w.rays.push_back(view_.ray(p.x, p.y));
    trace_drawn_surfaces(*scene_.intersector, alpha_cone(), w.rays, w.hits);
    w.counters.rays_primary += w.rays.size();
    for (size_t i = 0; i < pixels.size(); ++i) {
      ReferenceWorker::Pixel& sum = w.sums[i];
      sum.transmittance = glm::vec3(1.0f);
      float& end = ends_[texel_of(pixels[i])];
      end = w.rays[i].t_far;
      if (w.hits[i].instance != no_instance) {
        end = static_cast<float>(w.hits[i].distance) * (1.0f - on_surface);
        sum.coverage = 1.0f;
      } else if (!scene_.environment->black()) {
        sum.background[0] = sum.background[1] = scene_.environment->radiance(w.rays[i].direction);
      }
    }
  }

  // Makes the points of the opaque surfaces, and stores what the image needs of them.
  void make_points(std::span<const PixelRequest> pixels, ReferenceWorker& w) {
    w.points.clear(), w.point_pixels.clear();
    for (size_t i = 0; i < pixels.size(); ++i) {
      const Hit& hit = w.hits[i];
      if (hit.instance == no_instance) continue;
      const PixelRequest& p = pixels[i];
      SurfacePoint point = surface_point(*scene_.scene, hit, w.rays[i], cone_at(p.x, p.y), &view_.steps());
      point.key = random_key({pixel_key(request_.seed, position_, p.x, p.y), opaque_surface});
      if (position_ == 0 && request_.surfaces) store_surface(p, hit, point);
      w.points.push_back(point);
      w.point_pixels.push_back(static_cast<uint32_t>(i));
    }
  }

  void shade_opaque(std::span<const PixelRequest> pixels, ReferenceWorker& w) {
    make_points(pixels, w);
    w.radiance.resize(2 * w.points.size());
    PointShader& shader = *w.shader;
    const uint64_t reflections = shader.rays_reflection, shadows = shader.rays_shadow;
    // Primary hits are in the media around the eye.
    w.media.assign(w.points.size(), refraction_.at_eye);
    shader.within(w.media.data());
    if (request_.reflections)
      shader.shade(w.points, w.radiance.data());
    else
      shader.shade_opaque(w.points, w.radiance.data());
    w.counters.rays_reflection += shader.rays_reflection - reflections;
    w.counters.rays_shadow += shader.rays_shadow - shadows;
    for (size_t i = 0; i < w.points.size(); ++i)
      for (size_t half = 0; half < 2; ++half) w.sums[w.point_pixels[i]].background[half] = w.radiance[2 * i + half];
  }

  void take_distorted(std::span<const PixelRequest> pixels, ReferenceWorker& w) const {
    for (size_t i = 0; i < pixels.size(); ++i) {
      const PixelRequest& p = pixels[i];
      const OpaqueTexel seen = distorted(opaque_, request_.width, p.x, p.y, offsets_[texel_of(p)]);
      ReferenceWorker::Pixel& sum = w.sums[i];
      for (size_t half = 0; half < 2; ++half) sum.background[half] = seen.radiance[half];
      sum.transmittance = glm::vec3(1.0f);
      sum.coverage = seen.coverage;
    }
  }

  void trace_translucent(std::span<const PixelRequest> pixels, ReferenceWorker& w) {
    if (!refraction_.scene) {
      ReferenceSink sink(w.sums);
      w.layers.trace(context_, pixels, *w.shader, sink, w.counters);
      return;
    }
    w.refraction.trace(refraction_, pixels, *w.shader, w.refracted_pixels, w.counters);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const RefractedPixel& refracted = w.refracted_pixels[i];
      for (size_t half = 0; half < 2; ++half) w.sums[i].radiance[half] = refracted.radiance[half];
      w.sums[i].transmittance = refracted.transmittance, w.sums[i].sky = refracted.sky;
    }
  }

  // Lights primary hits by paths, except the opaque picture if it is distorted.
  void trace_paths(std::span<const PixelRequest> pixels, ReferenceWorker& w) {
    if (position_ == 0 && request_.surfaces && !distorts_picture()) make_points(pixels, w);
    w.eye_rays.clear();
    for (size_t i = 0; i < pixels.size(); ++i) {
      const PixelRequest& p = pixels[i];
      w.eye_rays.push_back({w.rays[i], cone_at(p.x, p.y), w.hits[i], pixel_key(request_.seed, 0, p.x, p.y)});
    }
    PathTracer& tracer = w.paths.tracer();
    tracer.ways().look(alpha_cone());
    const uint64_t reflections = tracer.rays_reflection, shadows = tracer.rays_shadow(), ways = tracer.ways().traversals;
    w.eye.trace(w.eye_rays, {request_.light_samples, position_, distorts_picture(), refraction_.at_eye}, tracer, w.seen);
    w.counters.rays_reflection += tracer.rays_reflection - reflections;
    w.counters.rays_shadow += tracer.rays_shadow() - shadows;
    w.counters.rays_primary += tracer.ways().traversals - ways - (tracer.rays_reflection - reflections);
    w.counters.pixels_masked += pixels.size();
    for (size_t i = 0; i < pixels.size(); ++i) {
      const SeenByEye& seen = w.seen[i];
      for (size_t half = 0; half < 2; ++half) w.sums[i].radiance[half] = seen.radiance[half];
      w.sums[i].transmittance = seen.transmittance, w.sums[i].sky = seen.sky;
      w.counters.layers_found += seen.surfaces;
      w.counters.traversals_wasted += seen.surfaces == 0;
    }
  }

  // Return the cones of textures. With paths, all positions together cover the pixel, so each uses only its share of
  // it: otherwise cut-out leaves with coarse texels would grow, and textures blur.
  Cone cone_at(uint32_t x, uint32_t y) const { return shared(view_.cone(x, y)); }
  AlphaCone alpha_cone() const {
    AlphaCone alpha = view_.alpha_cone();
    alpha.cone = shared(alpha.cone);
    return alpha;
  }
  Cone shared(Cone cone) const {
    if (request_.bounces == 1) return cone;
    const float share = 1.0f / std::sqrt(static_cast<float>(request_.views.size()));
    return {cone.width * share, cone.spread * share};
  }

  size_t texel_of(const PixelRequest& p) const { return size_t{p.y} * request_.width + p.x; }

  void store(const PixelRequest& p, const ReferenceWorker::Pixel& sum) {
    const glm::vec3 first = sum.radiance[0] + sum.transmittance * sum.background[0],
                    second = sum.radiance[1] + sum.transmittance * sum.background[1];
    const glm::vec3 to_sky = sum.transmittance * (1.0f - sum.coverage) + sum.sky;
    const float share = 1.0f / static_cast<float>(request_.views.size());
    const size_t texel = texel_of(p);
    image_.color[texel] += share * glm::vec4(0.5f * (first + second), 1.0f - (to_sky.x + to_sky.y + to_sky.z) / 3.0f);
    image_.half_difference[texel] += share * 0.5f * (first - second);
  }

  void store_surface(const PixelRequest& p, const Hit& hit, const SurfacePoint& point) {
    image_.surfaces[texel_of(p)] = {
        point.position,          point.surface.normal,
        point.surface.albedo,    point.surface.metallic,
        point.surface.roughness, {scene_.scene->snapshot->instances[hit.instance].surface_id, hit.primitive + 1}};
  }

  const ReferenceRequest& request_;
  const ReferenceScene& scene_;
  uint32_t position_;
  ReferenceImage& image_;
  ViewRays view_;
  std::vector<float> ends_;          // ends of the rays for layers, one a texel
  std::vector<OpaqueTexel> opaque_;  // set only if something distorts, like offsets_
  std::vector<PixelOffset> offsets_;
  LayerRequest layers_;
  FrameContext context_{};
  RefractionContext refraction_{};  // has no scene if nothing is refracted
};

void clear(const ReferenceRequest& request, ReferenceImage& image) {
  const size_t texels = size_t{request.width} * request.height;
  image.width = request.width, image.height = request.height;
  image.color.assign(texels, glm::vec4(0.0f));
  image.half_difference.assign(texels, glm::vec3(0.0f));
  image.surfaces.assign(request.surfaces ? texels : 0,
                        {glm::vec3(infinity), glm::vec3(0.0f), glm::vec3(0.0f), 0.0f, 0.0f, glm::uvec2(0)});
}

}  // namespace

void ReferenceWorker::begin(const ReferenceScene& scene, const RefractionScene* refracted,
                            const EmitterSampler& emitters, const ReferenceLighting& lighting) {
  if (lighting.bounces == 1) {
    direct.begin(scene, lighting.light_samples, lighting.shadows);
    shader = &direct;
  } else {
    paths.begin(scene, refracted, emitters, {lighting.bounces, lighting.shadows, lighting.caustics}, lighting.light_samples);
    shader = &paths;
  }
}

PointShader& ReferenceTracing::Shaders::begin_chunk(uint32_t thread) {
  workers_[thread].begin(scene, refraction, *emitters, lighting);
  return *workers_[thread].shader;
}

ShaderSource& ReferenceTracing::shaders(TracedScene& scene, const ReferenceLighting& lighting) {
  shaders_.scene = reference_scene(scene);
  shaders_.refraction = refracted(shaders_.scene, lighting.refraction);
  shaders_.emitters = &emitters(shaders_.scene, lighting.bounces);
  shaders_.lighting = lighting;
  return shaders_;
}

const RefractionScene* ReferenceTracing::refracted(const ReferenceScene& scene, bool refraction) {
  return refraction ? &refraction_.of(scene.scene->snapshot) : nullptr;
}

const EmitterSampler& ReferenceTracing::emitters(const ReferenceScene& scene, uint32_t bounces) {
  if (bounces != 1 && !emitters_.is_alike(*scene.scene->snapshot)) emitters_ = EmitterSampler(*scene.scene->snapshot);
  return emitters_;
}

ReferenceScene ReferenceTracing::reference_scene(TracedScene& scene) {
  const ShadingScene& shading = scene.shading();
  lights_ = reference_lights(*shading.snapshot);
  return {&shading, &scene.intersector(), &scene.environment(), &lights_};
}

Counters ReferenceTracing::trace(const ReferenceRequest& request, TracedScene& scene, ReferenceImage& image) {
  if (request.views.empty() || request.light_samples == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "reference: no view or no light samples; give at least one of each");
  // Sample positions shift the picture's window, not the eye or its axes.
  scene.place_sprites(request.views.front(), request.height);
  const ReferenceScene reference = reference_scene(scene);
  const RefractionScene* refraction = refracted(reference, request.refraction);
  const EmitterSampler& shining = emitters(reference, request.bounces);
  clear(request, image);
  const FramePixels frame = every_pixel(request.width, request.height, scene.executor());
  for (ReferenceWorker& w : workers_) {
    w.counters = {};
    w.begin(reference, refraction, shining, {request.light_samples, request.bounces, request.shadows, request.refraction,
                                                request.caustics});
  }
  for (uint32_t position = 0; position < request.views.size(); ++position) {
    Pass pass(request, reference, refraction, position, image);
    const auto for_all_pixels = [&](void (Pass::*step)(std::span<const PixelRequest>, ReferenceWorker&)) {
      trace_in_chunks(frame, pixels_in_chunk, scene.executor(), [&](std::span<const PixelRequest> pixels, uint32_t thread) {
        if (!request.cancelled || !request.cancelled->load()) (pass.*step)(pixels, workers_[thread]);
      });
    };
    if (pass.distorts_picture()) for_all_pixels(&Pass::trace_distortion);
    for_all_pixels(&Pass::trace);
  }
  Counters sum;
  for (const ReferenceWorker& w : workers_) sum += w.counters;
  sum.pixels_total = uint64_t{request.width} * request.height * request.views.size();
  return sum;
}

}  // namespace sideray::rt
