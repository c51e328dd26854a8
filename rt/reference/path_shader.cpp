#include "rt/reference/path_shader.h"

#include "rt/base/sampling.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {

void PathShader::begin(const ReferenceScene& scene, const RefractionScene* refraction, const EmitterSampler& emitters,
                       const PathSettings& settings, uint32_t samples) {
  tracer_.begin(scene, refraction, emitters, settings);
  environment_ = scene.scene->snapshot->environment.get();
  samples_ = samples;
  media_ = nullptr;
  rays_reflection = rays_shadow = 0;
}

glm::vec3 PathShader::surroundings(glm::vec3 direction, float roughness) const {
  return environment_specular(*environment_, direction, roughness);
}

void PathShader::shade(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  // For each point: two halves, and their common part.
  sums_.assign(3 * points.size(), {});
  ways_.clear();
  starts_.clear();
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    ways_.emplace_back(Ray{p.position, 0.0f, -p.to_eye, 0.0f}, p.cone, media_ ? media_[i] : MediumStack{});
    sums_[3 * i + 2].radiance = shading::sr_emitted(p.surface);
  }
  for (uint32_t i = 0; i < points.size(); ++i) {
    tracer_.add_exact_lights({&ways_[i], &points[i], nullptr, 3 * i + 2, 0, 0, 0, glm::vec3(1.0f)}, sums_);
    for (uint32_t half = 0; half < 2; ++half) {
      const uint32_t samples = samples_of_half(samples_, half);
      if (samples > 0)
        starts_.push_back({&ways_[i], &points[i], nullptr, 3 * i + half, random_key({points[i].key, half}), 0, samples,
                           glm::vec3(1.0f / static_cast<float>(samples))});
    }
  }
  tracer_.trace(starts_, sums_);
  for (size_t i = 0; i < points.size(); ++i)
    for (size_t half = 0; half < 2; ++half)
      radiance[2 * i + half] = sums_[3 * i + 2].radiance + sums_[3 * i + (samples_ == 1 ? 0 : half)].radiance;
  rays_reflection = tracer_.rays_reflection, rays_shadow = tracer_.rays_shadow();
  media_ = nullptr;
}

}  // namespace sideray::rt
