// Computes the light from surfaces toward the viewer without the rasterizer's approximations
// (docs/adr/0006-reference.md): lights have their sizes, environment and microfacets are sampled. It has scratch
// memory: one object per thread.
#pragma once

#include <vector>

#include "rt/embree/intersector.h"
#include "rt/reference/reference_lights.h"
#include "rt/reference/reference_lobes.h"
#include "rt/shading/point_shader.h"
#include "rt/light/straight_light.h"
#include "rt/textures/environment_sampler.h"

namespace sideray::rt {

// Refers to the reference's inputs, which the caller keeps alive.
struct ReferenceScene {
  const ShadingScene* scene;
  const Intersector* intersector;
  const EnvironmentSampler* environment;
  const std::vector<ReferenceLight>* lights;
};

class ReferenceShader final : public PointShader {
 public:
  // Sets scene and options until the next call. `samples`: the number for each sized light, for the environment and for
  // microfacets; at least 1.
  void begin(const ReferenceScene& scene, uint32_t samples, bool shadows);

  // The estimates are two independent halves of the samples; with one sample, both are equal. mean() averages them.
  uint32_t estimates() const override { return 2; }
  glm::vec3 mean(const glm::vec3* radiance) const;

  // Shades translucent surfaces; their base and coat reflect the scene.
  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override { shade(points, true, radiance); }
  // Shades opaque surfaces, which reflect only the unoccluded environment.
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override {
    shade(points, false, radiance);
  }
  glm::vec3 surroundings(glm::vec3 direction, float roughness) const override;

 private:
  // Says how the points of one call are lit.
  struct Lighting {
    uint32_t samples;
    uint32_t half;  // separates the random numbers of the halves
    bool shadows, traced;
  };
  // Holds the scratch memory for one bounce.
  struct Bounce {
    std::vector<LobeSampler> lobes;  // one a point
    std::vector<LightCone> cones;    // light-major: light * points + point
    std::vector<glm::vec3> sums;     // radiance of each point

    std::vector<Ray> shadow_rays;
    std::vector<glm::vec3> shadow_gains;  // unoccluded light
    std::vector<uint32_t> shadow_points;
    std::vector<uint8_t> blocked;
  };
  // Describes light from a direction, which something may occlude.
  struct DirectLight {
    glm::vec3 to_light;
    float distance;
    glm::vec3 gain;  // what it adds to the point
  };
  // Names a direction to the environment, and how dense both strategies choose such ones.
  struct EnvironmentDirection {
    glm::vec3 direction;
    float lobe_density, environment_density;
    uint32_t key;  // of random numbers
  };
  struct ReflectionRay {
    uint32_t point, key;
    glm::vec3 weight;
  };
  struct Front {  // a translucent surface in front of a reflected one
    uint32_t ray;
    shading::SrBlend blend;
  };

  void shade(std::span<const SurfacePoint> points, bool traced, glm::vec3* radiance);
  void prepare(std::span<const SurfacePoint> points, Bounce& bounce) const;
  void add_points_of_light(std::span<const SurfacePoint> points, bool shadows, Bounce& bounce);
  void add_samples(std::span<const SurfacePoint> points, const Lighting& lighting, Bounce& bounce);
  void sample_lights(std::span<const SurfacePoint> points, const Lighting& lighting, uint32_t j, Bounce& bounce);
  void sample_lobes(std::span<const SurfacePoint> points, const Lighting& lighting, uint32_t j, Bounce& bounce);
  void sample_environment(std::span<const SurfacePoint> points, const Lighting& lighting, uint32_t j, Bounce& bounce);
  void add_environment(const SurfacePoint& point, size_t i, const EnvironmentDirection& chosen,
                       const Lighting& lighting, Bounce& bounce);
  void add_direct_light(const SurfacePoint& point, size_t i, const DirectLight& light, bool shadows, Bounce& bounce);
  void end_shadow_rays(Bounce& bounce);
  void pass_glass(Bounce& bounce);
  void end_reflections(std::span<const SurfacePoint> points, Bounce& bounce);
  void light_reflected(std::span<const SurfacePoint> points, bool shadows);
  void trace_opaque(std::span<const SurfacePoint> points, bool coherent);
  void composite_in_front(std::span<const SurfacePoint> points, bool coherent);

  ReferenceScene scene_{};
  uint32_t samples_ = 1;
  bool shadows_ = true;
  Bounce first_, second_;
  StraightLight straight_;
  std::vector<Ray> free_;  // shadow rays without an opaque occluder
  std::vector<uint32_t> of_free_;

  std::vector<Ray> rays_;  // reflected rays
  std::vector<ReflectionRay> reflections_;
  std::vector<glm::vec3> reflected_;
  std::vector<Hit> hits_, layer_hits_;
  std::vector<uint32_t> layer_counts_;
  std::vector<SurfacePoint> second_points_;
  std::vector<uint32_t> second_rays_;
  std::vector<Front> fronts_;
};

}  // namespace sideray::rt
