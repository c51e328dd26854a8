// Says what translucent solids are filled with, and in which of them a ray is. Immutable or a value; any thread may use it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Holds the instances that a ray is inside of, in the order in which it entered them. The last one counts: a marble in
// water is glass, and where liquid overlaps the wall of its glass there is no gap of air between them.
class MediumStack {
 public:
  static constexpr uint32_t capacity = 8;

  uint32_t top() const { return count_ == 0 ? no_instance : instances_[count_ - 1]; }
  bool empty() const { return count_ == 0; }
  bool contains(uint32_t instance) const;
  bool push(uint32_t instance);    // false where it is full
  void remove(uint32_t instance);  // the one entered last

 private:
  std::array<uint32_t, capacity> instances_{};
  uint32_t count_ = 0;
};

// Says which light a ray carries: that of all channels, until a surface bends them apart, or of one.
enum class Light : uint8_t { all, red, green, blue };

// Returns the weights of that light's channels.
inline glm::vec3 channels_of(Light light) {
  if (light == Light::all) return glm::vec3(1.0f);
  return {light == Light::red ? 1.0f : 0.0f, light == Light::green ? 1.0f : 0.0f, light == Light::blue ? 1.0f : 0.0f};
}

// The transmittance of a surface without textures or vertex colours, tabulated over the angle of the ray.
struct PlainGlass {
  static constexpr uint32_t steps = 256;  // of the cosine; linear between them, to 1e-4
  std::vector<glm::vec3> through;         // transmittance between air and the medium; empty: not plain
  glm::vec3 inner, edge;                  // StraightSurface's
  float cover;

  glm::vec3 at(float cosine) const {
    const float place = std::clamp(cosine, 0.0f, 1.0f) * static_cast<float>(steps);
    const uint32_t step = std::min(static_cast<uint32_t>(place), steps - 1);
    return glm::mix(through[step], through[step + 1], place - static_cast<float>(step));
  }
};

// Holds a snapshot as refracted rays see it.
struct RefractionScene {
  explicit RefractionScene(std::shared_ptr<const model::Snapshot> committed);

  struct Medium {
    bool volume;  // transmits and is not thin-walled: refracts
    float ior;
    float spread;  // difference of red light's index below it, and of blue light's above
    glm::vec3 absorption;  // per unit of length; 0 where it is no volume
  };

  // Surfaces of volumes have no absorption in their tint: it depends on the way through them.
  ShadingScene surfaces;
  std::vector<Medium> materials;
  model::Bounds tinting;  // of all instances that tint light
  // By material, if an instance that tints light has it. plain_solid: of solids, whose absorption is added along the
  // ray; plain_other: of all others, with the absorption of the material's thickness.
  std::vector<PlainGlass> plain_solid, plain_other;
  std::vector<uint8_t> bends;  // of each material: 1 = its surfaces bend light that comes from the air, or blur it

  const Medium& medium(uint32_t instance) const { return materials[surfaces.snapshot->instances[instance].material]; }
  float ior(const MediumStack& media, Light light = Light::all) const {
    return media.empty() ? 1.0f : ior_of(medium(media.top()), light);
  }
  // Returns whether colours are refracted differently there.
  bool disperses(const MediumStack& media) const { return !media.empty() && medium(media.top()).spread > 0.0f; }
  static float ior_of(const Medium& medium, Light light) {
    constexpr float sides[] = {0.0f, -1.0f, 0.0f, 1.0f};
    return std::max(medium.ior + sides[static_cast<int>(light)] * medium.spread, 1.0f);
  }
  // Fills what is plain. `scene`: of the same snapshot.
  void find_plain(const ShadingScene& scene);
  // Follows the law of Beer and Lambert; `distance` may be infinite.
  glm::vec3 transmittance(const MediumStack& media, float distance) const;
};

// Returns the snapshot's scene with `glass`, where that is not null.
std::unique_ptr<const ShadingScene> lit_scene(const std::shared_ptr<const model::Snapshot>& snapshot);

// Keeps the refracted scene of the last requested snapshot. One thread at a time may call it.
class KeptRefractionScene {
 public:
  const RefractionScene& of(const std::shared_ptr<const model::Snapshot>& snapshot) {
    if (!kept_ || snapshot_ != snapshot) kept_ = std::make_unique<const RefractionScene>(snapshot);
    snapshot_ = snapshot;
    return *kept_;
  }

 private:
  std::shared_ptr<const model::Snapshot> snapshot_;
  std::unique_ptr<const RefractionScene> kept_;
};

// The media on both sides of a volume's surface.
struct Crossing {
  bool interface;  // otherwise the surface has no effect: the medium is the same on both sides
  float ior_from, ior_to;
  uint32_t absorber;  // instance that the ray was inside of without having entered it, or no_instance
  bool disperses;     // light of all channels is bent apart
};

// Updates `media` for a ray that crosses the surface hit. A solid is entered at front faces and left at back faces. A
// mesh that is not closed is entered at the first hit and left at the second, so a single quad is never left.
// `from_eye`: nothing has been crossed yet, so the first hit may be the back of a solid around the eye.
Crossing cross(const RefractionScene& scene, const Hit& hit, bool from_eye, MediumStack& media,
               Light light = Light::all);

// Returns StraightSurface::edge: times Fresnel's term, it is what the surface reflects between two media.
glm::vec3 edge_of(const shading::SrSurface& surface);
// Returns the tint that is left of light that is not reflected.
glm::vec3 inner_of(const shading::SrSurface& surface);

// Returns the reflectance of unpolarized light; `cosine` is on the side of the lower index.
float dielectric_reflectance(float cosine, float ior_from, float ior_to);

// Sets what the surface reflects at the crossing: as glTF defines it where it is entered from the air, the same where
// it is seen from inside, and by the two indices between media.
void set_reflectance(const Crossing& crossing, float cosine, shading::SrSurface& surface);

}  // namespace sideray::rt
