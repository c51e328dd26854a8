// Describes the media inside translucent solids, and tracks which of them a ray is in. Immutable or a value; any thread
// may use it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Holds the instances that a ray is inside of, in the order in which it entered them. The last one is the medium: a
// marble in water is glass, and liquid that overlaps the wall of its glass leaves no gap of air.
class MediumStack {
 public:
  static constexpr uint32_t capacity = 8;

  uint32_t top() const { return count_ == 0 ? no_instance : instances_[count_ - 1]; }
  bool empty() const { return count_ == 0; }
  bool contains(uint32_t instance) const;
  bool push(uint32_t instance);    // returns false if it is full
  void remove(uint32_t instance);  // removes the entry made last

 private:
  std::array<uint32_t, capacity> instances_{};
  uint32_t count_ = 0;
};

// Says which light a ray carries: all channels, until a surface disperses them, or one channel.
enum class Light : uint8_t { all, red, green, blue };

// Returns the weights of the light's channels.
inline glm::vec3 channels_of(Light light) {
  if (light == Light::all) return glm::vec3(1.0f);
  return {light == Light::red ? 1.0f : 0.0f, light == Light::green ? 1.0f : 0.0f, light == Light::blue ? 1.0f : 0.0f};
}

// Tabulates the transmittance of a surface without textures or vertex colours over the ray's angle.
struct PlainGlass {
  static constexpr uint32_t steps = 256;  // of the cosine; linear between them, to 1e-4
  std::vector<glm::vec3> through;         // transmittance between air and the medium; empty if the surface is textured
                                          // or has vertex colours
  glm::vec3 inner, edge, scattered;       // StraightSurface's
  float cover;

  glm::vec3 at(float cosine) const {
    const float place = std::clamp(cosine, 0.0f, 1.0f) * static_cast<float>(steps);
    const uint32_t step = std::min(static_cast<uint32_t>(place), steps - 1);
    return glm::mix(through[step], through[step + 1], place - static_cast<float>(step));
  }
};

// Holds a snapshot for tracing refracted rays.
struct RefractionScene {
  explicit RefractionScene(std::shared_ptr<const model::Snapshot> committed);

  struct Medium {
    bool volume;  // transmits and is not thin-walled: refracts
    float ior;
    float spread;  // index of blue light minus `ior`, and `ior` minus that of red light
    glm::vec3 absorption;  // per unit of length; 0 if it is no volume
  };

  // Tints of volumes' surfaces contain no absorption, because it depends on the path through the volume.
  ShadingScene surfaces;
  std::vector<Medium> materials;
  model::Bounds tinting;  // of all instances that tint light (model::tints_light())
  // One entry for each material that tints light in some instance. plain_solid is for solids, whose absorption is added
  // along the ray; plain_other for all others, with the absorption of the material's thickness.
  std::vector<PlainGlass> plain_solid, plain_other;
  std::vector<uint8_t> bends;  // by material: 1 = its surfaces bend light that comes from air, or blur it

  const Medium& medium(uint32_t instance) const { return materials[surfaces.snapshot->instances[instance].material]; }
  float ior(const MediumStack& media, Light light = Light::all) const {
    return media.empty() ? 1.0f : ior_of(medium(media.top()), light);
  }
  // Returns whether the current medium refracts colours differently.
  bool disperses(const MediumStack& media) const { return !media.empty() && medium(media.top()).spread > 0.0f; }
  static float ior_of(const Medium& medium, Light light) {
    constexpr float sides[] = {0.0f, -1.0f, 0.0f, 1.0f};
    return std::max(medium.ior + sides[static_cast<int>(light)] * medium.spread, 1.0f);
  }
  // Fills plain_solid and plain_other; `scene` is of the same snapshot.
  void find_plain(const ShadingScene& scene);
  // Follows the law of Beer and Lambert; `distance` may be infinite.
  glm::vec3 transmittance(const MediumStack& media, float distance) const;
};

// Returns the snapshot's scene, with `glass` set if anything translucent casts a shadow.
std::unique_ptr<ShadingScene> lit_scene(const std::shared_ptr<const model::Snapshot>& snapshot);

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

// Describes the media on both sides of a volume's surface.
struct Crossing {
  bool interface;  // false: the medium is the same on both sides, so the surface has no effect
  float ior_from, ior_to;
  uint32_t absorber;  // an instance that the ray starts in, found at its back face; else no_instance
  bool disperses;     // channels are refracted in different directions
};

// Updates `media` for a ray that crosses the surface it hit. A ray enters a solid at front faces and leaves it at back
// faces. It enters an open mesh at the first hit and leaves it at the second, so it never leaves a single quad.
// `from_eye`: no surface has been crossed yet, so the first hit may be the back of a solid around the eye.
Crossing cross(const RefractionScene& scene, const Hit& hit, bool from_eye, MediumStack& media,
               Light light = Light::all);

// Returns StraightSurface::edge: times the Fresnel term, it is the reflectance between two media.
glm::vec3 edge_of(const shading::SrSurface& surface);
// Returns the tint of the light that is not reflected.
glm::vec3 inner_of(const shading::SrSurface& surface);
// Returns StraightSurface::scattered.
glm::vec3 scattered_by(const shading::SrSurface& surface);

// Returns the Fresnel reflectance of unpolarized light; `cosine` is on the side of the lower index.
float dielectric_reflectance(float cosine, float ior_from, float ior_to);

// Sets the surface's reflectance at the crossing: entered from air as glTF defines it, left into air the same value,
// and between two media by their indices.
void set_reflectance(const Crossing& crossing, float cosine, shading::SrSurface& surface);

}  // namespace sideray::rt
