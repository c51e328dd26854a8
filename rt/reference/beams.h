// Follows rays toward lights and attenuates their light: opaque surfaces block it, translucent ones transmit a part.
// Rays are not bent (rt/light/straight_light.h). It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/light/straight_light.h"
#include "rt/surfaces/media.h"

namespace sideray::rt {

// A ray to a lamp hits what casts shadows; one to the environment or to an emissive surface hits what paths hit.
enum class BeamTarget { lamp, scene };

struct Beam {
  Ray ray;            // starts at t = 0 and ends at the light
  MediumStack media;  // at its start
  uint32_t sum;       // index of the sum that it adds to
  glm::vec3 gain;       // unoccluded light
  glm::vec3 bent_gain;  // the same if something on the way refracts; 0: paths find that light
};

class Beams {
 public:
  // The caller keeps all objects alive. `refraction` null: nothing bends light, and volumes absorb by their thickness.
  void begin(const ShadingScene& scene, const Intersector& intersector, const RefractionScene* refraction);
  void add(BeamTarget target, const Beam& beam) { (target == BeamTarget::lamp ? lamps_ : scene_beams_).push_back(beam); }
  size_t size() const { return lamps_.size() + scene_beams_.size(); }
  // Follows all beams, and calls add(sum, light) with the attenuated light of each, in order.
  template <typename Add>
  void end(const Add& add);

  uint64_t traversals = 0;

 private:
  static constexpr uint32_t most_at_first = 8, most_met = 64;
  void find_free(std::vector<Beam>& beams, BeamTarget target);
  void dim(std::vector<Beam>& beams, BeamTarget target);
  void dim(Beam& beam, BeamTarget target, std::span<const Hit> hits);
  bool is_there(BeamTarget target, const MediumStack& media, const Hit& hit) const;
  bool is_volume(const Hit& hit) const { return refraction_ && refraction_->medium(hit.instance).volume; }
  StraightSurface surface(const Beam& beam, const Hit& hit, bool& scatters) const;

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  const RefractionScene* refraction_ = nullptr;
  bool has_translucent_ = false;
  std::vector<Beam> lamps_, scene_beams_;
  std::vector<Ray> rays_, deep_rays_;
  std::vector<uint8_t> blocked_;
  std::vector<Hit> hits_, deep_hits_;
  std::vector<uint32_t> counts_, deep_counts_;
  std::vector<StraightSurface> met_;
};

template <typename Add>
void Beams::end(const Add& add) {
  for (const BeamTarget target : {BeamTarget::lamp, BeamTarget::scene}) {
    std::vector<Beam>& beams = target == BeamTarget::lamp ? lamps_ : scene_beams_;
    if (beams.empty()) continue;
    find_free(beams, target);
    if (has_translucent_) dim(beams, target);
    for (const Beam& beam : beams) add(beam.sum, beam.gain);
    beams.clear();
  }
}

}  // namespace sideray::rt
