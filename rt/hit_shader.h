// The light that leaves surfaces toward the viewer, for batches of hits: punctual lights with shadow rays, one
// reflection (and one in the coat; sampled where rough), environment, emission. Holds scratch memory: one object per
// thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/intersector.h"
#include "rt/point_shader.h"
#include "rt/surface_batch.h"

namespace sideray::rt {

class HitShader final : public PointShader {
 public:
  // What the hits are shaded with until the next call; both are kept by the caller. `shadows` off: no shadow rays.
  // `tell_rough`: rough() has answers.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, bool tell_rough = false);

  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  std::span<const RoughReflection> rough() const override { return rough_; }
  // What the points' bases mirror, as shade() has it, without weight: of the surface, normal and roughness count.
  // rough() has answers where it is asked for.
  void reflect(std::span<const SurfacePoint> points, glm::vec3* radiance);

 private:
  // A lobe that reflects: what a mirror ray stands for.
  struct Mirror {
    glm::vec3 direction, normal;
    float roughness;
    uint32_t layer;  // 0 base, 1 coat
  };

  void add_direct(SurfaceBatch& batch, bool shadows, glm::vec3* radiance);
  void trace_reflections(std::span<const SurfacePoint> points);
  void follow_mirror_rays();
  void collect_rough(std::span<const SurfacePoint> points);
  void add_rough(size_t ray, glm::vec3 weight, RoughReflection& rough) const;
  void collect_mirror_rays(std::span<const SurfacePoint> points);
  void add_mirror_ray(std::span<const SurfacePoint> points, size_t i, glm::vec3 origin, const Mirror& mirror);
  void shade_reflection_hits();
  void trace_in_front(bool coherent);
  void trace_deep(bool coherent);
  void shade_points(std::span<const SurfacePoint> points, SurfaceBatch& batch, bool shadows, glm::vec3* radiance);

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  bool shadows_ = true, tell_rough_ = false;

  SurfaceBatch seen_, reflected_, in_front_;  // by the eye; in mirrors; before what mirrors show

  std::vector<Ray> mirror_rays_;  // of bases, then of coats
  size_t first_coat_ = 0;
  std::vector<Cone> mirror_cones_;
  std::vector<Mirror> mirrors_;
  std::vector<uint32_t> mirror_points_;  // which point a ray belongs to
  std::vector<glm::vec3> mirror_radiance_;
  std::vector<float> mirror_nearness_;  // RoughReflection::nearness of every ray
  std::vector<Hit> opaque_hits_, layer_hits_;
  std::vector<uint32_t> layer_counts_;
  std::vector<Ray> deep_rays_;  // with more translucent surfaces on them than layer_hits_ holds
  std::vector<uint32_t> deep_rank_, deep_counts_;
  std::vector<Hit> deep_hits_;

  std::vector<SurfacePoint> points_;      // that mirror rays met
  std::vector<uint32_t> rays_of_points_;  // which mirror ray met a point
  std::vector<glm::vec3> weights_, radiance_;

  std::vector<Ray> shadow_rays_;
  std::vector<glm::vec3> shadow_gains_;  // what the light adds where it is not blocked
  std::vector<uint32_t> shadow_points_;
  std::vector<uint8_t> blocked_;

  std::vector<RoughReflection> rough_;
};

}  // namespace sideray::rt
