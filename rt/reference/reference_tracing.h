// Traces whole pictures by rays, which all other ways of drawing are compared with. It reuses its memory between
// pictures. One call at a time.
#pragma once

#include "rt/base/counters.h"
#include "rt/layers/layer_tracer.h"
#include "rt/reference/eye_paths.h"
#include "rt/reference/path_shader.h"
#include "rt/reference/reference_request.h"
#include "rt/reference/reference_shader.h"
#include "rt/refraction/refraction_tracer.h"
#include "rt/scene/traced_scene.h"
#include "rt/shading/frame_shaders.h"

namespace sideray::rt {

// Says how light from surfaces is computed.
struct ReferenceLighting {
  uint32_t light_samples, bounces;  // as in ReferenceRequest
  bool shadows, refraction, caustics;
};

// Is the scratch memory of one thread.
struct ReferenceWorker {
  LayerTracer layers;
  RefractionTracer refraction;
  ReferenceShader direct;
  PathShader paths;
  EyePaths eye;
  PointShader* shader = &direct;  // the shader in use
  Counters counters;

  void begin(const ReferenceScene& scene, const RefractionScene* refracted, const EmitterSampler& emitters,
             const ReferenceLighting& lighting);

  std::vector<PixelRequest> pixels;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<SurfacePoint> points;
  std::vector<MediumStack> media;      // one a point
  std::vector<uint32_t> point_pixels;  // the pixel of each point
  std::vector<glm::vec3> radiance;

  // For a pixel of the chunk: both estimates of the light behind the translucent surfaces, and of the light that these
  // add.
  struct Pixel {
    glm::vec3 background[2], radiance[2], transmittance;
    float coverage;  // of the background: 0 = sky
    glm::vec3 sky;   // transmittance to the sky along bent rays, whose radiance includes the sky
  };
  std::vector<Pixel> sums;
  std::vector<RefractedPixel> refracted_pixels;
  std::vector<EyeRay> eye_rays;
  std::vector<SeenByEye> seen;
};

class ReferenceTracing {
 public:
  explicit ReferenceTracing(uint32_t threads) : workers_(threads) {}

  // Refills `image`, which is unfinished if the request is cancelled. Throws Failure.
  Counters trace(const ReferenceRequest& request, TracedScene& scene, ReferenceImage& image);
  // Returns shaders for a frame whose surfaces are shaded as in the reference; valid until the next call.
  ShaderSource& shaders(TracedScene& scene, const ReferenceLighting& lighting);

 private:
  // The workers' shaders.
  class Shaders final : public ShaderSource {
   public:
    explicit Shaders(std::vector<ReferenceWorker>& workers) : workers_(workers) {}
    PointShader& begin_chunk(uint32_t thread) override;
    ReferenceScene scene{};
    const RefractionScene* refraction = nullptr;
    const EmitterSampler* emitters = nullptr;
    ReferenceLighting lighting{};

   private:
    std::vector<ReferenceWorker>& workers_;
  };
  ReferenceScene reference_scene(TracedScene& scene);
  const RefractionScene* refracted(const ReferenceScene& scene, bool refraction);
  // Returns the emissive surfaces, if paths are traced.
  const EmitterSampler& emitters(const ReferenceScene& scene, uint32_t bounces);

  std::vector<ReferenceWorker> workers_;
  Shaders shaders_{workers_};
  std::vector<ReferenceLight> lights_;
  KeptRefractionScene refraction_;
  EmitterSampler emitters_;
};

}  // namespace sideray::rt
