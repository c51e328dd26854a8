#include "rt/drawing/blend_translucent.h"

#include <algorithm>
#include <optional>

#include "rt/base/view_rays.h"
#include "rt/drawing/seen_aside.h"
#include "rt/layers/fragment_shader.h"
#include "rt/layers/frame_chunks.h"
#include "rt/layers/layer_tracer.h"
#include "rt/layers/sprite_lights.h"

namespace sideray::rt {
namespace {

// Glass tints the light on surfaces, but not on sprites, as in the rasterizer's maps of tints.
constexpr bool tints = true, tints_sprites = false;
// A pixel with less transmittance counts as opaque.
constexpr float least_let_through = 1e-4f;

// Holds the light in front of a pixel's opaque surface, and its transmittance.
struct Veil {
  glm::vec3 radiance{0.0f}, through{1.0f};
  float see_through = 1.0f;  // product of the surfaces' mean transmittance, from which alpha follows
};

// Blends as shaders/translucent/raster_order.glsl does.
class BlendSink final : public LayerSink {
 public:
  BlendSink(const SeenAside* aside, uint32_t width, std::vector<Veil>& scratch, std::vector<glm::vec4>& picture)
      : aside_(aside), width_(width), veils_(scratch), picture_(picture) {}

  void begin(std::span<const PixelRequest> pixels) override {
    requests_ = pixels;
    veils_.assign(pixels.size(), {});
  }

  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit&, glm::vec3& weight) override {
    Veil& veil = veils_[pixel];
    const shading::SrBlend& blend = point.blended;
    weight = veil.through * blend.cover;
    if (aside_) veil.radiance += veil.through * aside_->added(point, {requests_[pixel].x, requests_[pixel].y});
    veil.through *= blend.through;
    veil.see_through *= (blend.through.x + blend.through.y + blend.through.z) * (1.0f / 3.0f);
    return blend.cover > 0.0f;
  }

  void add(uint32_t pixel, uint32_t, const Hit&, const glm::vec3* radiance, glm::vec3 weight) override {
    veils_[pixel].radiance += *radiance * weight;
  }

  bool finished(uint32_t pixel) const override {
    const glm::vec3 t = veils_[pixel].through;
    return std::max({t.x, t.y, t.z}) < least_let_through;
  }

  void end(std::span<const PixelRequest> pixels) override {
    for (size_t i = 0; i < pixels.size(); ++i) {
      glm::vec4& color = picture_[size_t{pixels[i].y} * width_ + pixels[i].x];
      const Veil& veil = veils_[i];
      // Rounding may make the subtracted refracted light larger than the picture.
      color = {glm::max(veil.radiance + glm::vec3(color) * veil.through, glm::vec3(0.0f)),
               1.0f - veil.see_through + color.w * veil.see_through};
    }
  }

 private:
  const SeenAside* aside_;  // null: no surface is refracted
  uint32_t width_;
  std::vector<Veil>& veils_;  // of the chunk's pixels
  std::vector<glm::vec4>& picture_;
  std::span<const PixelRequest> requests_;
};

struct BlendWorker {
  LayerTracer tracer;
  FragmentShader shader;
  std::vector<Veil> veils;
  Counters counters;
};

// Requests all surfaces in front of opaque ones.
LayerRequest all_surfaces(const BlendRequest& r, bool sprites) {
  LayerRequest request;
  request.view = r.view;
  request.width = r.pixels->width;
  request.height = r.pixels->height;
  request.depth = r.pixels->depth();
  request.mask = r.places.empty() ? SIDERAY_MASK_NONE : SIDERAY_MASK_MEMORY;
  request.mask_bytes = r.places;
  request.max_layers = 0;
  request.all_translucent = 1;
  request.particles = sprites;
  request.shadows = r.shadows;
  return request;
}

}  // namespace

Counters blend_translucent(const BlendRequest& r, TracedScene& scene, std::vector<glm::vec4>& picture) {
  const bool has_sprites = !scene.shading().snapshot->particles.empty();
  const LayerRequest request = all_surfaces(r, has_sprites);
  if (has_sprites) scene.place_sprites(r.view, request.height);
  const ShadingScene& shading = scene.shading();
  Executor& executor = scene.executor();
  const ViewRays view(r.view, request.width, request.height);
  OpaqueLevels levels;
  std::optional<SeenAside> aside;
  if (r.aside && SeenAside::is_needed(*shading.snapshot)) {
    levels.fill(request.width, request.height, picture, executor);
    aside.emplace(shading, r.view, levels);
  }
  SpriteLights sprites(executor.threads());
  Counters traced = sprites.light(shading, scene.intersector(), {r.shadows, tints_sprites}, executor);
  const FrameContext context{.request = &request,
                             .view = &view,
                             .scene = &shading,
                             .intersector = &scene.intersector(),
                             .set = has_sprites ? LayerSet::with_sprites : LayerSet::all_translucent,
                             .sprites = sprites.empty() ? nullptr : &sprites};
  FrameChunks chunks;
  chunks.gather(request, {.pattern = {}, .requested_bits = 0, .counted = false}, executor);
  std::vector<BlendWorker> workers(executor.threads());
  Counters unread;
  chunks.run(request, executor,
             [&](size_t, std::span<const PixelRequest> part, uint32_t thread) {
               BlendWorker& w = workers[thread];
               BlendSink sink(aside ? &*aside : nullptr, request.width, w.veils, picture);
               w.shader.begin(shading, scene.intersector(), r.shadows, tints);
               return w.tracer.trace(context, part, w.shader, sink, w.counters);
             },
             {}, unread);
  for (const BlendWorker& worker : workers) traced += worker.counters;
  // No layer is stored, so the other counters stay 0.
  Counters rays;
  rays.rays_primary = traced.rays_primary;
  rays.rays_shadow = traced.rays_shadow;
  return rays;
}

}  // namespace sideray::rt
