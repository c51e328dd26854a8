// Traces whole pictures by rays: what every other way of drawing is compared with. Keeps its memory from picture to
// picture. One call at a time.
#pragma once

#include "rt/base/counters.h"
#include "rt/layers/layer_tracer.h"
#include "rt/reference/reference_request.h"
#include "rt/reference/reference_shader.h"
#include "rt/refraction/refraction_tracer.h"
#include "rt/scene/traced_scene.h"
#include "rt/shading/frame_shaders.h"

namespace sideray::rt {

// Memory of one thread.
struct ReferenceWorker {
  LayerTracer layers;
  RefractionTracer refraction;
  ReferenceShader shader;
  Counters counters;

  std::vector<PixelRequest> pixels;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<SurfacePoint> points;
  std::vector<uint32_t> point_pixels;  // which of the pixels a point belongs to
  std::vector<glm::vec3> radiance;

  // A pixel of the chunk: both estimates of what is behind the translucent surfaces, and of what they add.
  struct Pixel {
    glm::vec3 background[2], radiance[2], transmittance;
    float coverage;  // of the background: 0 = sky
    glm::vec3 sky;   // transmittance to it of bent rays, whose radiance holds it
  };
  std::vector<Pixel> sums;
  std::vector<RefractedPixel> refracted_pixels;
};

class ReferenceTracing {
 public:
  explicit ReferenceTracing(uint32_t threads) : workers_(threads) {}

  // Refills `image`. Where the request is cancelled, it is unfinished. Throws Failure.
  Counters trace(const ReferenceRequest& request, TracedScene& scene, ReferenceImage& image);
  // For a frame whose surfaces are shaded as in the reference; they hold until the next call.
  ShaderSource& shaders(TracedScene& scene, uint32_t light_samples, bool shadows);

 private:
  // The workers' shaders.
  class Shaders final : public ShaderSource {
   public:
    explicit Shaders(std::vector<ReferenceWorker>& workers) : workers_(workers) {}
    PointShader& begin_chunk(uint32_t thread) override;
    ReferenceScene scene{};
    uint32_t samples = 1;
    bool shadows = true;

   private:
    std::vector<ReferenceWorker>& workers_;
  };
  ReferenceScene reference_scene(TracedScene& scene);

  std::vector<ReferenceWorker> workers_;
  Shaders shaders_{workers_};
  std::vector<ReferenceLight> lights_;
  KeptRefractionScene refraction_;
};

}  // namespace sideray::rt
