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

// A ray with at most this share left in every channel counts as dark.
inline constexpr float least_straight_light = 1e-4f;

// Describes a translucent surface that a straight ray passes.
struct StraightSurface {
  Hit hit;
  bool solid;         // encloses a medium that absorbs between entry and exit
  float cosine;       // of the ray to the normal
  float skin;         // along the ray: surfaces so close behind are at the same place
  glm::vec3 through;  // what is left of light that comes from the air or goes into it
  // Between two media that are both not air, what is left is 1 - cover + cover * inner * (1 - edge * Fresnel's term).
  glm::vec3 inner, edge;
  float cover;
};
// `point`: of a solid, a surface of `media.surfaces`, whose tint has no absorption; else of the scene itself.
StraightSurface straight_surface(const RefractionScene& media, const SurfacePoint& point);
// Returns whether the hit's instance encloses a medium.
inline bool is_solid(const RefractionScene& media, const Hit& hit) {
  return media.surfaces.snapshot->instances[hit.instance].solid && media.medium(hit.instance).volume;
}

// Returns the transmittance of a straight ray of a length through the surfaces `met`, in order. Solids nest as
// MediumStack says. Other volumes and thin walls absorb by their material's thickness. `within`: the media in which the
// ray begins; null: those whose backs it hits without having hit their fronts. A length of `farthest` / 2 or more: the
// ray ends outside all of them.
glm::vec3 straight_transmittance(const RefractionScene& media, std::span<const StraightSurface> met, float length,
                                 const MediumStack* within = nullptr);

class StraightLight {
 public:
  // The caller keeps both.
  void begin(const ShadingScene& scene, const Intersector& intersector);
  // Returns whether anything translucent in the scene throws a shadow (model::tints_light()); otherwise no ray is followed.
  bool is_tinted() const { return scene_->glass != nullptr; }
  // Appends to `rays` those that may hit such a surface, except blocked ones (1), and their numbers to `numbers`.
  void choose(const RayColumns& from, const uint8_t* blocked, std::vector<Ray>& rays, std::vector<uint32_t>& numbers);
  // Follows rays that nothing opaque stops.
  void follow(std::span<const Ray> rays);
  // Returns the transmittance of a ray, 1 if it hits nothing.
  const glm::vec3& through(size_t ray) const { return through_[ray]; }
  // Returns the distance along the ray of the nearest surface that absorbs or reflects; infinite if there is none.
  float distance(size_t ray) const { return distance_[ray]; }

  uint64_t traversals = 0;  // rays that were followed, since begin()

 private:
  void meet(std::span<const Ray> rays);
  void take(const Ray& ray, std::span<const Hit> hits);
  void finish_surfaces();

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  std::vector<uint8_t> near_;
  RaySurfaces found_;
  std::vector<StraightSurface> met_;  // those of found_
  // The surfaces of met_ whose tint depends on the place: on textures or vertex colours.
  struct Textured {
    std::vector<HitPlace> places;
    std::vector<uint32_t> met;
  };
  Textured solids_, others_;
  std::vector<SurfacePoint> points_;
  std::vector<glm::vec3> through_;
  std::vector<float> distance_;
};

}  // namespace sideray::rt
