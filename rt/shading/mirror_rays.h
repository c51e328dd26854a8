// Traces the mirror directions of a batch of points and returns their radiance: of the nearest opaque surfaces behind
// translucent ones, or of the surroundings. Rough lobes are sampled once. It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

// Describes a reflecting lobe that one ray represents.
struct Mirror {
  glm::vec3 direction, normal;  // for an anisotropic base: those for the look-up in prefiltered surroundings
  float roughness;              // for an anisotropic base: that for the look-up
  uint32_t layer;               // 0 base, 1 coat
  bool brushed = false;         // an anisotropic base
  bool narrow = false;          // its mirror direction represents it, so its ray is not random
  float weight = 1.0f;          // SurfacePoint::weight of the reflection
};

// Returns whether a lobe is treated as a mirror: the roughness has a floor, so it is never 0.
bool mirrors(float roughness);
bool mirrors(const Mirror& mirror);

class MirrorRays {
 public:
  // All arguments must outlive the object. `met` shades secondary hits.
  void begin(const ShadingScene& scene, const Intersector& intersector, SecondaryHitShader& met);
  void clear();
  // Adds a lobe's ray. `origin` is where a true mirror's ray starts.
  void add(const SurfacePoint& p, uint32_t point, glm::vec3 origin, const Mirror& mirror);
  void follow();

  size_t size() const { return rays_.size(); }
  const Mirror& mirror(size_t ray) const { return mirrors_[ray]; }
  uint32_t point(size_t ray) const { return of_points_[ray]; }
  // These are valid after follow().
  glm::vec3 radiance(size_t ray) const { return radiance_[ray]; }
  float nearness(size_t ray) const { return nearness_[ray]; }  // RoughReflection::nearness

  // Computes the points' unweighted mirror radiance, from normal and roughness of their bases alone. `rough`, unless
  // null, receives the values of PointShader::rough().
  void reflect(std::span<const SurfacePoint> points, glm::vec3* radiance, std::vector<RoughReflection>* rough);

  uint64_t traversals = 0;  // since begin()

 private:
  struct Weight {
    glm::vec3 weight;
    size_t hit;
  };
  void shade_opaque_hits();
  void see_surroundings();
  void look_up_surroundings();
  void see_past(std::vector<RoughReflection>& rough);
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
  std::vector<uint32_t> of_points_;  // each ray's point
  std::vector<glm::vec3> radiance_;
  std::vector<float> nearness_;
  std::vector<Hit> opaque_hits_, layer_hits_;
  std::vector<uint32_t> layer_counts_;
  std::vector<Ray> deep_rays_;  // rays with more translucent surfaces than layer_hits_ holds
  std::vector<uint32_t> deep_rank_, deep_counts_;
  std::vector<Hit> deep_hits_;

  std::vector<HitPlace> hits_;            // secondary hits: opaque ones, then translucent ones
  std::vector<uint32_t> rays_of_points_;  // the ray of each of hits_
  std::vector<uint32_t> missed_;          // rays that need the environment: they hit nothing opaque, or belong to rough
                                          // lobes
  std::vector<EnvironmentPlace> places_;  // where they sample the environment
  std::vector<glm::vec3> met_radiance_;
  std::vector<shading::SrBlend> blends_;  // of translucent hits
  std::vector<Weight> weights_;           // of the hits along one ray
};

}  // namespace sideray::rt
