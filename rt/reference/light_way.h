// Follows rays through everything translucent, those of the eye and those that leave surfaces: which surface comes next, in
// which media a ray is, what is left of its light. Holds scratch memory: one object per thread.
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

// Describes a ray on its way, and the surfaces found ahead of it.
struct LightWay {
  LightWay(const Ray& unit, Cone footprint, const MediumStack& around);
  // The ray ends at an opaque surface; no_instance: at none.
  void end_at(const Hit& hit);

  Ray ray;
  Cone cone;
  MediumStack media;
  Light light = Light::all;  // that it carries
  bool fresh = true;      // the opaque surface on the ray is still to be found
  bool bent = false;      // it has been refracted or scattered: backs are seen, as by the tracer of refracted rays
  // It hits what the eye sees, also what reflections do not show, and no backs of opaque surfaces that are not double
  // sided.
  bool from_eye = false;
  bool crossed = false;   // it has hit a translucent surface: before, the eye may be inside of any
  float absorbed = 0.0f;  // distance along the ray up to which its medium has absorbed
  Hit opaque;             // where the ray ends; no_instance: at none, or not looked for
  SurfacesAhead ahead;
};

// Says how light goes on behind a translucent surface.
enum class Passage {
  straight,   // in its direction
  refracted,  // in another, which the surface determines
  scattered,  // in one of many
  mirrored    // not at all: it is reflected totally
};

// Describes a translucent surface that a ray hits.
struct WayEvent {
  Passage passage;
  SurfacePoint point;
  glm::vec3 arriving;   // what the medium leaves of light on the way there since the event before
  Crossing crossing;
  MediumStack behind;   // the media on the far side
  glm::vec3 direction;  // refracted and mirrored: where the light goes on
};

class LightWays {
 public:
  // The caller keeps all of it. `refraction` null: nothing bends light, and volumes absorb by their thickness.
  void begin(const ShadingScene& scene, const Intersector& intersector, const RefractionScene* refraction);
  // Sets the cone at which rays of the eye read alpha.
  void look(Cone eye) { eye_ = eye; }

  // Finds the opaque surfaces at which those rays end that are fresh.
  void find_opaque(std::span<LightWay* const> ways);
  // Finds the next translucent surfaces of those ways that have used up theirs and may have more.
  void find_translucent(std::span<LightWay* const> ways);
  // Takes the way's next surface; the way stays in the media in front of it. Returns false if none is left: a complete
  // way ends there.
  bool next(LightWay& way, WayEvent& event) const;
  // Makes the way one of that light alone, and says how the surface bends it.
  void disperse(LightWay& way, WayEvent& event, Light light) const;
  // Returns what the medium leaves from the last event on to `distance`, which may be infinite.
  glm::vec3 arriving(const LightWay& way, float distance) const;
  // Returns the surface at which the ray ends.
  SurfacePoint end_point(const LightWay& way) const { return surface_point(*surfaces_, way.opaque, way.ray, way.cone); }

  // Sends the light on in another direction: on the near side of the surface where it is mirrored, else on the far one.
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
  Cone eye_{};
  std::vector<LightWay*> group_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<uint32_t> counts_;
};

}  // namespace sideray::rt
