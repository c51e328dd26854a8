// Shades surfaces by the host's shader (sideray_scene_set_shader) in place of the built-in model. Reflections are
// traced and added with the host's weights, all in the host's colour space. It has scratch memory: one object per
// thread.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/shading/host_points.h"
#include "rt/shading/mirror_rays.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

class HostShader final : public PointShader, public SecondaryHitShader {
 public:
  // The caller keeps all arguments alive; the snapshot must have a shader.
  void begin(const ShadingScene& scene, const Intersector& intersector, const HostCalls& calls, bool shadows);

  void cover(std::span<SurfacePoint> points) override;
  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override;

  void shade_secondary_hits(std::span<const HitPlace> hits, glm::vec3* radiance) override;
  void shade_in_front(std::span<const HitPlace> hits, shading::SrBlend* blends, glm::vec3* radiance) override;

  glm::vec3 surroundings(glm::vec3 direction, float roughness) const override;
  void surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const override;

 private:
  glm::vec3 encoded(glm::vec3 linear) const;
  void ask(std::span<const SurfacePoint> points, HostPoints::Kind kind, std::vector<HostAnswer>& answers);
  void trace_reflections(std::span<const SurfacePoint> points);
  glm::vec3 surrounded(const HostAnswer& answer) const;

  const ShadingScene* scene_ = nullptr;
  const ShadeKernels* kernels_ = nullptr;
  HostPoints host_;
  MirrorRays mirrors_;
  std::vector<SurfacePoint> hits_;            // secondary hits
  std::vector<HostAnswer> seen_, met_;        // of points seen by the eye; in mirrors
  std::vector<const HostAnswer*> of_points_;  // of the points of shade()
};

}  // namespace sideray::rt
