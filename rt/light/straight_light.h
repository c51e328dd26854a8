// Computes the transmittance of unbent rays through translucent surfaces: the coloured shadows of glass, in every way
// of drawing that traces rays. It is the product of each surface's transmittance, by the Fresnel term at the ray's
// angle, and the absorption of solids between entry and exit. Through parallel faces Fresnel's terms are those of a
// refracted ray, which has the same angle outside, but the straight way between them is longer (by 1.6 at 60 degrees in
// glass). A straight ray is never totally reflected, but transmits nothing at grazing angles. A lamp in a
// frosted solid is brighter by what the walls reflect once, in a closed shell of thin glass by all reflections.
// It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/surfaces/media.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

// A ray whose transmittance is at most this in every channel counts as dark.
inline constexpr float least_straight_light = 1e-4f;

// Describes a translucent surface on a straight ray.
struct StraightSurface {
  Hit hit;
  bool solid;         // encloses a medium that absorbs between entry and exit
  bool shell;         // encloses air in thin glass
  float cosine;       // of the ray to the normal
  float skin;         // along the ray: surfaces this close behind count as being at the same place
  glm::vec3 through;  // transmittance between air and the medium
  // Between two media that are not air, the transmittance is 1 - cover + cover * inner * (1 - edge * Fresnel's term).
  glm::vec3 inner, edge;
  float cover;
  glm::vec3 scattered;  // what its diffuse and rough lobes reflect once of light from inside
};
// `point`: for a solid, a surface of `media.surfaces`, whose tint has no absorption; otherwise a surface of the scene.
StraightSurface straight_surface(const RefractionScene& media, const SurfacePoint& point);
// Returns whether the hit's instance encloses a medium.
inline bool is_solid(const RefractionScene& media, const Hit& hit) {
  return media.surfaces.snapshot->instances[hit.instance].solid && media.medium(hit.instance).volume;
}

inline bool is_shell(const RefractionScene& media, const Hit& hit) {
  return media.surfaces.snapshot->instances[hit.instance].shell;
}

// Returns the transmittance of a straight ray with a length through the surfaces `met`, in order. Solids nest as in
// MediumStack. Other volumes and thin walls absorb by their material's thickness. `within`: the media at the ray's
// start; null: those whose backs it hits before their fronts. A length of at least `farthest` / 2: the ray ends outside
// all media.
glm::vec3 straight_transmittance(const RefractionScene& media, std::span<const StraightSurface> met, float length,
                                 const MediumStack* within = nullptr);

class StraightLight {
 public:
  // The caller keeps both objects alive.
  void begin(const ShadingScene& scene, const Intersector& intersector);
  // Returns whether anything translucent in the scene casts a shadow (model::tints_light()); otherwise no ray is
  // followed.
  bool is_tinted() const { return scene_->glass != nullptr; }
  // Appends to `rays` those that may hit such a surface, except blocked ones (1), and their indices to `numbers`.
  void choose(const RayColumns& from, const uint8_t* blocked, std::vector<Ray>& rays, std::vector<uint32_t>& numbers);
  // Follows rays without an opaque occluder.
  void follow(std::span<const Ray> rays);
  // Returns the transmittance of a ray, 1 if it hits nothing.
  const glm::vec3& through(size_t ray) const { return through_[ray]; }
  // Returns the distance along the ray of the nearest surface that absorbs or reflects; infinite if there is none.
  float distance(size_t ray) const { return distance_[ray]; }

  uint64_t traversals = 0;  // number of rays followed since begin()

 private:
  void meet(std::span<const Ray> rays);
  void take(const Ray& ray, std::span<const Hit> hits);
  void finish_surfaces();

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  std::vector<uint8_t> near_;
  RaySurfaces found_;
  std::vector<StraightSurface> met_;  // the surfaces of found_
  // Refers to the surfaces of met_ whose tint varies by textures or vertex colours.
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
