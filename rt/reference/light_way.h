// Follows rays, primary ones and those that leave surfaces, through translucent surfaces: finds the next surface, the
// media around the ray, and the transmittance. It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/refraction/refraction.h"
#include "rt/refraction/surfaces_ahead.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Is a ray and the surfaces found ahead of it.
struct LightWay {
  LightWay(const Ray& unit, Cone footprint, const MediumStack& around);
  // Ends the ray at an opaque surface; no_instance: it has none.
  void end_at(const Hit& hit);

  Ray ray;
  Cone cone;
  MediumStack media;
  Light light = Light::all;  // the channels that it carries
  bool fresh = true;      // its opaque surface has not been searched yet
  bool bent = false;      // refracted or scattered before; it then hits back faces, as in RefractionTracer
  // It is a primary ray: it also hits surfaces invisible in reflections, and no backs of opaque surfaces that are not
  // double sided.
  bool from_eye = false;
  bool crossed = false;   // it has hit a translucent surface; before that, the eye may be inside any solid
  float absorbed = 0.0f;  // distance along the ray up to which its medium has absorbed
  Hit opaque;             // end of the ray; no_instance: none, or not searched yet
  SurfacesAhead ahead;
};

// Says how light continues behind a translucent surface.
enum class Passage {
  straight,   // in the same direction
  refracted,  // in another direction, determined by the surface
  scattered,  // in a random direction
  mirrored    // totally reflected
};

// Describes a translucent surface that a ray hits.
struct WayEvent {
  Passage passage;
  SurfacePoint point;
  glm::vec3 arriving;   // transmittance of the medium since the previous event
  Crossing crossing;
  MediumStack behind;   // the media on the far side
  glm::vec3 direction;  // refracted and mirrored: the new direction
};

class LightWays {
 public:
  // The caller keeps all objects alive. `refraction` null: nothing bends light, and volumes absorb by their thickness.
  void begin(const ShadingScene& scene, const Intersector& intersector, const RefractionScene* refraction);
  // Sets the cone for the alpha of primary rays.
  void look(const AlphaCone& eye) { eye_ = eye; }

  // Finds the opaque ends of those rays that are fresh.
  void find_opaque(std::span<LightWay* const> ways);
  // Finds the next translucent surfaces of ways that have none left ahead and may hit more.
  void find_translucent(std::span<LightWay* const> ways);
  // Returns the way's next surface; the way stays in the media in front of it. Returns false if none is left; a
  // complete way ends then.
  bool next(LightWay& way, WayEvent& event) const;
  // Restricts the way to that light, and recomputes how the surface bends it.
  void disperse(LightWay& way, WayEvent& event, Light light) const;
  // Returns the medium's transmittance from the last event to `distance`, which may be infinite.
  glm::vec3 arriving(const LightWay& way, float distance) const;
  // Makes the surface at the ray's end.
  SurfacePoint end_point(const LightWay& way) const { return surface_point(*surfaces_, way.opaque, way.ray, way.cone); }

  // Continues in another direction: on the surface's near side if the light is mirrored, else on the far side.
  void redirect(LightWay& way, const WayEvent& event, glm::vec3 direction) const;
  // Returns the media behind a surface that a ray reaches in the media `before`.
  MediumStack behind(const SurfacePoint& point, const MediumStack& before) const;

  uint64_t traversals = 0;

 private:
  void find_opaque(std::span<LightWay* const> ways, bool from_eye);
  void find_translucent(std::span<LightWay* const> ways, bool from_eye, uint32_t layers);
  bool is_there(const LightWay& way, const Hit& hit) const;
  bool is_volume(const Hit& hit) const { return refraction_ && refraction_->medium(hit.instance).volume; }
  bool exits(const Hit& hit) const;
  Hit take(LightWay& way) const;

  const ShadingScene* surfaces_ = nullptr;
  const Intersector* intersector_ = nullptr;
  const RefractionScene* refraction_ = nullptr;
  bool has_translucent_ = false;
  AlphaCone eye_;
  std::vector<LightWay*> group_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<uint32_t> counts_;
};

}  // namespace sideray::rt
