// The light that leaves surfaces toward the viewer, for batches of hits: punctual lights with shadow rays, one mirror
// reflection (and one in the coat), environment, emission. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/intersector.h"
#include "rt/point_shader.h"
#include "rt/surface.h"

namespace sideray::rt {

class HitShader final : public PointShader {
 public:
  // What the hits are shaded with until the next call; both are kept by the caller. `shadows` off: no shadow rays.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows);

  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override;

 private:
  void add_direct(std::span<const SurfacePoint> points, glm::vec3* radiance);
  void trace_reflections(std::span<const SurfacePoint> points);
  void collect_mirror_rays(std::span<const SurfacePoint> points);
  void shade_reflection_hits();
  void composite_in_front();
  glm::vec3 unshadowed(const SurfacePoint& point) const;
  glm::vec3 ambient(const SurfacePoint& point) const;

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  bool shadows_ = true;

  std::vector<glm::vec2> albedo_terms_;  // of the points
  std::vector<glm::vec3> reflected_;     // radiance from the mirror direction of each point, then about its coat normal

  std::vector<Ray> mirror_rays_;
  std::vector<Cone> mirror_cones_;
  std::vector<float> mirror_roughness_;
  std::vector<uint32_t> mirror_targets_;  // which of reflected_ a ray is for
  std::vector<uint32_t> coats_;           // points with a reflection of their own in the coat
  std::vector<Hit> opaque_hits_, layer_hits_;
  std::vector<uint32_t> layer_counts_;
  std::vector<SurfacePoint> second_points_;
  std::vector<glm::vec3> second_radiance_;
  std::vector<uint32_t> second_rays_;  // which mirror ray a second point belongs to

  std::vector<Ray> shadow_rays_;
  std::vector<glm::vec3> shadow_gains_;  // what the light adds where it is not blocked
  std::vector<uint32_t> shadow_points_;
  std::vector<uint8_t> blocked_;
};

}  // namespace sideray::rt
