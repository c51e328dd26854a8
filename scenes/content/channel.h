// Holds a value over time as keys, and interpolates them. The loader makes it; afterwards it is only read. Any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::scenes {

enum class Interpolation { step, linear, cubic };
enum class Property { translation, rotation, scale, weights, visible, value };

// Animates a property of a node, or a value of a material, light or camera. A key has 3 numbers; that of a rotation has
// 4 (x, y, z, w), that of weights one for each target. Cubic keys are (in-tangent, value, out-tangent), as in glTF.
struct Channel {
  uint32_t node = 0;  // unused for values
  Property property = Property::translation;
  uint32_t targets = 0;  // of weights: their number; of values: numbers in each
  Interpolation interpolation = Interpolation::linear;
  double period_s = 0;        // length of its animation, which repeats
  std::vector<float> times;   // seconds, ascending or equal; at least one
  std::vector<float> values;  // finite
};

// Returns how many numbers a key has.
size_t components_of(const Channel& channel);

// Returns the value at a time, which is constant before the first and after the last key. Rotations have unit length.
glm::dvec4 sample(const Channel& channel, double time_s);
// Returns the same for weights.
std::vector<double> sample_weights(const Channel& channel, double time_s);

}  // namespace sideray::scenes
