// What the mirror directions of a batch of points show: the nearest opaque surfaces, whatever is translucent before
// them, or the surroundings. Rough lobes are sampled once. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

// A lobe that reflects: what a mirror ray stands for.
struct Mirror {
  glm::vec3 direction, normal;
  float roughness;
  uint32_t layer;  // 0 base, 1 coat
};

// Whether a lobe is too narrow for its directions to differ: the floor of roughness.
bool mirrors(float roughness);

// Where a ray out of the point's surface starts.
glm::vec3 start_of_ray(const SurfacePoint& point);

class MirrorRays {
 public:
  // All kept by the caller. `met` shades what the rays meet.
  void begin(const ShadingScene& scene, const Intersector& intersector, SecondaryHitShader& met);
  void clear();
  // `origin`: of a true mirror's ray.
  void add(const SurfacePoint& p, uint32_t point, glm::vec3 origin, const Mirror& mirror);
  // `allowances`: of each ray's radiance, by which what it meets may be off; or empty.
  void follow(std::span<const float> allowances = {});

  size_t size() const { return rays_.size(); }
  const Mirror& mirror(size_t ray) const { return mirrors_[ray]; }
  uint32_t point(size_t ray) const { return of_points_[ray]; }
  std::span<const uint32_t> of_points() const { return of_points_; }
  // After follow().
  glm::vec3 radiance(size_t ray) const { return radiance_[ray]; }
  float nearness(size_t ray) const { return nearness_[ray]; }  // RoughReflection::nearness

  // What the points' bases mirror, without weight: of the surface, normal and roughness count. `rough`, where it is not
  // null: as PointShader::rough() tells.
  void reflect(std::span<const SurfacePoint> points, glm::vec3* radiance, std::vector<RoughReflection>* rough);

  uint64_t traversals = 0;  // since begin()

 private:
  void shade_opaque_hits(std::span<const float> allowances);
  void trace_in_front(bool coherent);
  void trace_deep(bool coherent);
  void gather_in_front();
  void blend_in_front();

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  SecondaryHitShader* met_ = nullptr;

  std::vector<Ray> rays_;
  std::vector<Cone> cones_;
  std::vector<Mirror> mirrors_;
  std::vector<uint32_t> of_points_;  // which point a ray belongs to
  std::vector<glm::vec3> radiance_;
  std::vector<float> nearness_;
  std::vector<Hit> opaque_hits_, layer_hits_;
  std::vector<uint32_t> layer_counts_;
  std::vector<Ray> deep_rays_;  // with more translucent surfaces on them than layer_hits_ holds
  std::vector<uint32_t> deep_rank_, deep_counts_;
  std::vector<Hit> deep_hits_;

  std::vector<SurfacePoint> points_;      // that the rays met
  std::vector<uint32_t> rays_of_points_;  // which ray met a point
  std::vector<float> met_allowances_;
  std::vector<glm::vec3> weights_, met_radiance_;
};

}  // namespace sideray::rt
