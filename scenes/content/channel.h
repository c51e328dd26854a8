// A value over time: keys, and what lies between them. Made by the loader, read only afterwards. Any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::scenes {

enum class Interpolation { step, linear, cubic };
enum class Property { translation, rotation, scale, weights, visible, value };

// One property of one node over time, or a value of something else. Values are 3 numbers a key, rotations 4 (x, y, z,
// w), weights one for each target; cubic keys are (in-tangent, value, out-tangent), as glTF stores them.
struct Channel {
  uint32_t node = 0;  // not of values
  Property property = Property::translation;
  uint32_t targets = 0;  // of weights; of values, the numbers of one
  Interpolation interpolation = Interpolation::linear;
  double period_s = 0;        // the length of its animation, after which it starts again
  std::vector<float> times;   // seconds, not falling; at least one
  std::vector<float> values;  // finite
};

// The number of numbers that a key has.
size_t components_of(const Channel& channel);

// The value at a time; before the first key and behind the last one it stands still. Rotations have unit length.
glm::dvec4 sample(const Channel& channel, double time_s);
// The same of weights.
std::vector<double> sample_weights(const Channel& channel, double time_s);

}  // namespace sideray::scenes
