// Samples directions toward the surroundings of lamps. Shades, bulbs and walls beside a lamp receive light by the
// inverse square of their distance: they are the brightest surfaces of a room, and random directions seldom hit them.
// Values; any thread may use them.
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "rt/reference/reference_lights.h"

namespace sideray::rt {

class LampGuide {
 public:
  // Removes all lamps.
  void clear() { count_ = 0, sum_ = 0.0f; }
  // Adds a lamp with a position. Only the most important lamps are kept.
  void add(const ReferenceLight& light, const shading::SrIncidence& incidence);
  bool empty() const { return count_ == 0; }

  // Samples a direction, unit; `u` is a point of the unit square.
  glm::vec3 sample(glm::vec2 u) const;
  // Returns the density per steradian.
  float density(glm::vec3 direction) const;

 private:
  // Cones about the direction to the lamp, each half as wide as the previous one. If light falls with the square of the
  // angle, each ring receives the same amount.
  static constexpr uint32_t most_lamps = 8, most_cones = 8;
  static constexpr float widest = 0.5f;  // radians
  struct Lamp {
    glm::vec3 axis;
    float weight;
    uint32_t cones;
  };
  static float aperture(uint32_t cone);

  std::array<Lamp, most_lamps> lamps_;
  uint32_t count_ = 0;
  float sum_ = 0.0f;
};

}  // namespace sideray::rt
