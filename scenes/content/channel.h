// Holds a value over time: keys and their interpolation. Made by the loader, then immutable. Any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::scenes {

enum class Interpolation { step, linear, cubic };
enum class Property { translation, rotation, scale, weights, visible, value };

// Animates one property of one node, or another value. A key has 3 numbers, rotations 4 (x, y, z, w), weights one for
// each target. Cubic keys are (in-tangent, value, out-tangent), as in glTF.
struct Channel {
  uint32_t node = 0;  // unused for other values
  Property property = Property::translation;
  uint32_t targets = 0;  // of weights; for other values, their number of numbers
  Interpolation interpolation = Interpolation::linear;
  double period_s = 0;        // length of its animation, which loops
  std::vector<float> times;   // seconds, in ascending order; at least one
  std::vector<float> values;  // finite
};

// Returns how many numbers a key has.
size_t components_of(const Channel& channel);

// Returns the value at a time; it is constant before the first and after the last key. Rotations have unit length.
glm::dvec4 sample(const Channel& channel, double time_s);
// Does the same for weights.
std::vector<double> sample_weights(const Channel& channel, double time_s);

}  // namespace sideray::scenes
