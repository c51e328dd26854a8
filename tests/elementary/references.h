// Makes references for the elementary functions: the float nearest to the truth, by the C library in double, or in long
// double where the result is too near the middle between two floats.
#pragma once

#include <cmath>
#include <cstdint>

namespace sideray::elementary_tests {

using OfOne = double (*)(double);
using OfOneLong = long double (*)(long double);

// Returns the float nearest to the truth; the relative error of `value` is 2^-51, that of `more` 2^-62.
template <typename More>
float nearest_float(double value, const More& more) {
  if (std::isnan(value)) return static_cast<float>(value);
  const auto low = static_cast<float>(value * (1.0 - 0x1p-50)), high = static_cast<float>(value * (1.0 + 0x1p-50));
  return low == high ? low : static_cast<float>(more());
}

// Returns whether two results are the same; all NaN are, and both zeros.
inline bool same(float a, float b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

struct Function {
  const char* name;
  float (*ours)(float);
  OfOne reference;
  OfOneLong long_reference;
  uint64_t most_wrong;  // of all floats
};

extern const Function functions[10];

// Counts the floats, of every `step`-th bit pattern from `first` on, for which our result is not the nearest float.
// `off` gets the number of those that differ by more than one unit in the last place.
uint64_t count_wrong(const Function& function, uint32_t first, uint64_t step, uint64_t& off);

}  // namespace sideray::elementary_tests
