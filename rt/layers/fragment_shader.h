// Shades points as the rasterizer shades fragments: rays go only to lights, and mirrors show the prefiltered
// environment. It has scratch memory: one object per thread.
#pragma once

#include "rt/light/direct_light.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

class FragmentShader final : public PointShader {
 public:
  // The caller keeps both objects alive. `shadows`: rays shadow the lights; `tints`: translucent surfaces tint them.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, bool tints);

  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override { shade_opaque(points, radiance); }
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  glm::vec3 surroundings(glm::vec3 direction, float roughness) const override;

 private:
  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  bool shadows_ = true;
  SurfaceBatch batch_;
  DirectLight light_;
};

}  // namespace sideray::rt
