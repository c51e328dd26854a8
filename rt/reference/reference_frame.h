// Whole pictures by rays: what every other way of drawing is compared with. One call at a time.
#pragma once

#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/composite/refraction_tracer.h"
#include "rt/layers/layer_tracer.h"
#include "rt/reference/reference_request.h"
#include "rt/reference/reference_shader.h"

namespace sideray::rt {

// Memory of one thread.
struct ReferenceWorker {
  LayerTracer layers;
  RefractionTracer refraction;
  ReferenceShader shader;
  TraceCounters counters;

  std::vector<PixelRequest> pixels;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<SurfacePoint> points;
  std::vector<uint32_t> point_pixels;  // which of the pixels a point belongs to
  std::vector<glm::vec3> radiance;

  // Of the chunk's pixels: both estimates of what is behind the translucent surfaces, and of what they add.
  struct Pixel {
    glm::vec3 background[2], radiance[2], transmittance;
    float coverage;  // of the background: 0 = sky
    glm::vec3 sky;   // transmittance to it of bent rays, whose radiance holds it
  };
  std::vector<Pixel> sums;
  std::vector<RefractedPixel> refracted_pixels;
};

// Refills `image`; `workers`: one a thread of the executor; `refraction`: null where nothing is bent. Where the request
// is cancelled, the image is unfinished.
TraceCounters trace_reference_image(const ReferenceRequest& request, const ReferenceScene& scene,
                                    const RefractionScene* refraction, Executor& executor,
                                    std::vector<ReferenceWorker>& workers, ReferenceImage& image);

}  // namespace sideray::rt
