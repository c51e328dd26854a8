// The light that leaves surfaces toward the viewer, for batches of hits: punctual lights with shadow rays, one
// reflection (and one in the coat; sampled where rough), environment, emission. Holds scratch memory: one object per
// thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/direct_light.h"
#include "rt/intersector.h"
#include "rt/point_shader.h"
#include "rt/surface_batch.h"

namespace sideray::rt {

class HitShader final : public PointShader {
 public:
  // What the hits are shaded with until the next call; both are kept by the caller. `shadows` off: no shadow rays.
  // `tell_rough`: rough() has answers.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, bool tell_rough = false);
  // What mirrors show is no brighter than this, as far as SurfacePoint::allowance goes; 0 at first: mirrored rays are
  // all traced.
  void expect_mirrored(float brightest) { brightest_ = brightest; }

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

  void add_direct(SurfaceBatch& batch, bool shadows, std::span<float> allowances, glm::vec3* radiance);
  void gather_needed(SurfaceBatch& batch, std::span<float> allowances, DirectLight& light);
  void add_gathered(DirectLight& light, bool shadows, glm::vec3* radiance);
  bool spares_mirror(size_t point, float share, const Mirror& mirror, bool alike);
  void share_allowances(size_t points);
  void count_spared(size_t points);
  void trace_reflections(std::span<const SurfacePoint> points);
  void follow_mirror_rays();
  void collect_rough(std::span<const SurfacePoint> points);
  void add_rough(size_t ray, glm::vec3 weight, RoughReflection& rough) const;
  void collect_mirror_rays(std::span<const SurfacePoint> points);
  void add_mirror_ray(std::span<const SurfacePoint> points, size_t i, glm::vec3 origin, const Mirror& mirror);
  void shade_reflection_hits();
  void trace_in_front(bool coherent);
  void trace_deep(bool coherent);
  void shade_points(std::span<const SurfacePoint> points, SurfaceBatch& batch, bool shadows,
                    std::span<float> allowances, glm::vec3* radiance);

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  bool shadows_ = true, tell_rough_ = false;
  float brightest_ = 0.0f;

  SurfaceBatch seen_, reflected_, in_front_;  // by the eye; in mirrors; before what mirrors show

  std::vector<Ray> mirror_rays_;  // of bases, then of coats
  size_t first_coat_ = 0;
  std::vector<Cone> mirror_cones_;
  std::vector<Mirror> mirrors_;
  std::vector<uint32_t> mirror_points_;   // which point a ray belongs to
  std::vector<float> mirror_shares_;      // of its radiance in what the eye sees
  std::vector<uint32_t> mirrors_spared_;  // points, one for each ray that is not traced
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

  DirectLight seen_light_, light_;  // at what the eye sees; anywhere else
  // By how much radiance may be off: of the points, what is left of it; of mirror rays; of what they met. Empty: by
  // nothing.
  std::vector<uint8_t> traced_points_;
  std::vector<float> allowances_, mirror_allowances_, hit_allowances_;

  std::vector<RoughReflection> rough_;
};

}  // namespace sideray::rt
