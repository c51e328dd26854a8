// Shades surfaces by paths of any number of bounces (docs/adr/0028-paths.md), for callers that find the primary hits
// themselves. It has scratch memory: one object per thread.
#pragma once

#include <vector>

#include "rt/reference/path_tracer.h"

namespace sideray::rt {

class PathShader final : public PointShader {
 public:
  // `samples`: paths per point, at least 1; other arguments as in PathTracer::begin().
  void begin(const ReferenceScene& scene, const RefractionScene* refraction, const EmitterSampler& emitters,
             const PathSettings& settings, uint32_t samples);
  PathTracer& tracer() { return tracer_; }

  // Returns two independent halves of the samples, as ReferenceShader does.
  uint32_t estimates() const override { return 2; }
  void within(const MediumStack* media) override { media_ = media; }
  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override { shade(points, radiance); }
  glm::vec3 surroundings(glm::vec3 direction, float roughness) const override;

 private:
  PathTracer tracer_;
  const model::Environment* environment_ = nullptr;
  uint32_t samples_ = 1;
  const MediumStack* media_ = nullptr;
  std::vector<LightWay> ways_;  // primary rays up to the points
  std::vector<PathStart> starts_;
  std::vector<PathSum> sums_;
};

}  // namespace sideray::rt
