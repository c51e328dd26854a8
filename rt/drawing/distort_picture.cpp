#include "rt/drawing/distort_picture.h"

#include "rt/base/view_rays.h"
#include "rt/drawing/view_tile.h"
#include "rt/layers/distortion.h"
#include "rt/layers/frame_chunks.h"
#include "rt/shading/hit_shader.h"

namespace sideray::rt {
namespace {

// Requests all surfaces of the pixels that show any.
LayerRequest offset_request(const OpaqueRequest& r, const OpaquePixels& pixels) {
  LayerRequest request;
  request.view = r.view;
  request.width = r.width;
  request.height = r.height;
  request.depth = pixels.depth();
  request.mask = SIDERAY_MASK_NONE;
  request.max_layers = 0;
  request.all_translucent = 1;
  return request;
}

std::vector<OpaqueTexel> opaque_texels(const OpaquePixels& pixels, const ViewRays& view, Executor& executor,
                                       const std::vector<glm::vec4>& picture) {
  std::vector<OpaqueTexel> texels(picture.size());
  executor.run(pixels.height, [&](size_t row, uint32_t) {
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < pixels.width; ++x) {
      const size_t i = row * pixels.width + x;
      const Hit& hit = pixels.hits[i];
      const glm::vec3 color(picture[i]);
      texels[i] = {{color, color}, picture[i].w, std::numeric_limits<float>::infinity()};
      if (hit.instance != no_instance) texels[i].depth = view.depth(x, y, hit.distance);
    }
  });
  return texels;
}

}  // namespace

void distort_picture(const OpaqueRequest& r, const OpaquePixels& pixels, TracedScene& scene,
                     std::vector<glm::vec4>& picture) {
  const ShadingScene& shading = scene.shading();
  if (!distorts(*shading.snapshot)) return;
  Executor& executor = scene.executor();
  const ViewRays view(r.view, r.width, r.height);
  const LayerRequest request = offset_request(r, pixels);
  const FrameContext context{.request = &request,
                             .view = &view,
                             .scene = &shading,
                             .intersector = &scene.intersector(),
                             .set = LayerSet::all_translucent};
  std::vector<PixelOffset> offsets(picture.size());
  std::vector<LayerTracer> tracers(executor.threads());
  std::vector<HitShader> shaders(executor.threads());
  FrameChunks chunks;
  chunks.gather(request, {.pattern = {}, .requested_bits = 0, .counted = false}, executor);
  Counters unread;
  chunks.run(request, executor,
             [&](size_t, std::span<const PixelRequest> part, uint32_t thread) {
               Counters counters;
               DistortionSink sink(view, r.width, offsets);
               shaders[thread].begin(shading, scene.intersector(), {.shadows = false});
               return tracers[thread].trace(context, part, shaders[thread], sink, counters);
             },
             {}, unread);
  const std::vector<OpaqueTexel> texels = opaque_texels(pixels, view, executor, picture);
  executor.run(r.height, [&](size_t row, uint32_t) {
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < r.width; ++x) {
      const size_t i = row * r.width + x;
      if (offsets[i].nearest == std::numeric_limits<float>::infinity()) continue;
      const OpaqueTexel seen = distorted(texels, r.width, x, y, offsets[i]);
      picture[i] = {seen.radiance[0], seen.coverage};
    }
  });
}

}  // namespace sideray::rt
