// Says how much of a light comes straight through translucent surfaces: the coloured shadows of glass, in every way of
// drawing that traces rays. The ray is not bent. What is left of it is the product of what each surface lets through, by
// Fresnel's term at the angle that the ray itself has with it, and of what the solids keep between entry and exit. Through
// parallel faces a real ray is reflected as much, for it has that angle outside; nowhere along a straight ray is light
// reflected totally, but toward grazing angles nothing passes. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/surfaces/media.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

// A ray of which no channel keeps more than this share is taken to keep nothing.
inline constexpr float least_straight_light = 1e-4f;

// Returns what is left of light along a straight ray of a length that passes the surfaces `met`, in order; those of solids
// are surfaces of `media.surfaces`, whose tint has no absorption. Solids nest as MediumStack says. Other volumes and thin
// walls absorb by their material's thickness. `within`: the media in which the ray begins; null: those whose backs it meets
// without having met their fronts. A length of `farthest` / 2 or more: the ray ends outside all of them.
glm::vec3 straight_transmittance(const RefractionScene& media, std::span<const SurfacePoint* const> met, float length,
                                 const MediumStack* within = nullptr);

class StraightLight {
 public:
  // The caller keeps both.
  void begin(const ShadingScene& scene, const Intersector& intersector);
  // Returns whether anything translucent in the scene throws a shadow (model::tints_light()); otherwise no ray is followed.
  bool is_tinted() const { return scene_->glass != nullptr; }
  // Appends to `rays` those that may meet anything of that kind, but for blocked ones (1), and their numbers to `numbers`.
  void choose(const RayColumns& from, const uint8_t* blocked, std::vector<Ray>& rays, std::vector<uint32_t>& numbers);
  // Follows rays that nothing opaque stops.
  void follow(std::span<const Ray> rays, bool coherent);
  // Returns what is left of the light of a ray, 1 where it met nothing.
  const glm::vec3& through(size_t ray) const { return through_[ray]; }
  // Returns how far along the ray the nearest surface is that keeps something; infinite where there is none.
  float distance(size_t ray) const { return distance_[ray]; }

  uint64_t traversals = 0;  // rays that were followed, since begin()

 private:
  struct Met {
    uint32_t point;
    bool solid;
  };
  void meet(std::span<const Ray> rays, bool coherent);
  void take(const Ray& ray, std::span<const Hit> hits);

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  std::vector<uint8_t> near_;
  std::vector<Ray> deep_rays_;
  std::vector<uint32_t> counts_, deep_counts_, deep_of_;
  std::vector<Hit> hits_, deep_hits_;
  std::vector<HitPlace> solid_places_, other_places_;
  std::vector<SurfacePoint> solid_points_, other_points_;
  std::vector<Met> met_;           // all surfaces, ray by ray
  std::vector<uint32_t> met_end_;  // of each ray
  std::vector<const SurfacePoint*> on_ray_;
  std::vector<glm::vec3> through_;
  std::vector<float> distance_;
};

}  // namespace sideray::rt
