// Applies separable filters to planes of floats, edges repeated. Any thread may call it; it uses all cores, with the
// same bits for any thread count.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sideray::lab {

struct Plane {
  uint32_t width = 0, height = 0;
  std::vector<float> values;  // row by row

  Plane() = default;
  Plane(uint32_t plane_width, uint32_t plane_height)
      : width(plane_width), height(plane_height), values(size_t{plane_width} * plane_height) {}
  float* row(uint32_t y) { return values.data() + size_t{y} * width; }
  const float* row(uint32_t y) const { return values.data() + size_t{y} * width; }
};

// Holds an odd number of weights; the middle one belongs to the pixel itself.
using Kernel = std::vector<float>;

Plane convolve(const Plane& plane, const Kernel& across, const Kernel& down);

}  // namespace sideray::lab
