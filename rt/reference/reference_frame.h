// Draws whole pictures by rays; every other way of drawing is compared with them. One thread at a time calls it; it
// works on the executor's.
#pragma once

#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/composite/refraction_tracer.h"
#include "rt/layers/layer_tracer.h"
#include "rt/reference/reference_request.h"
#include "rt/reference/reference_shader.h"

namespace sideray::rt {

// Holds the scratch memory of one thread.
struct ReferenceWorker {
  LayerTracer layers;
  RefractionTracer refraction;
  ReferenceShader shader;
  TraceCounters counters;

  std::vector<PixelRequest> pixels;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<SurfacePoint> points;
  std::vector<uint32_t> point_pixels;  // index of the pixel that each point belongs to
  std::vector<glm::vec3> radiance;

  // Holds, for a pixel of the chunk, both estimates of what is behind the translucent surfaces, and of what they add.
  struct Pixel {
    glm::vec3 background[2], radiance[2], transmittance;
    float coverage;  // share of the background that is not sky: 0 = sky
    glm::vec3 sky;   // transmittance of refracted rays to the sky, which their radiance holds already
  };
  std::vector<Pixel> sums;
  std::vector<RefractedPixel> refracted_pixels;
};

// Refills `image`. `workers`: one a thread of the executor; `refraction`: null where nothing is refracted. Where the
// request is cancelled, the image is unfinished.
TraceCounters trace_reference_image(const ReferenceRequest& request, const ReferenceScene& scene,
                                    const RefractionScene* refraction, Executor& executor,
                                    std::vector<ReferenceWorker>& workers, ReferenceImage& image);

}  // namespace sideray::rt
