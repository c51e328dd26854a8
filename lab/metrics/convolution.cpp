#include "lab/metrics/convolution.h"

#include "lab/metrics/parallel.h"

namespace sideray::lab {
namespace {

Plane convolve_rows(const Plane& plane, const Kernel& kernel) {
  const uint32_t radius = static_cast<uint32_t>(kernel.size() / 2);
  Plane result(plane.width, plane.height);
  for_rows(plane.height, [&](uint32_t y) {
    const float* row = plane.row(y);
    std::vector<float> padded(plane.width + 2 * radius);
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, plane.width, padded.begin() + radius);
    std::fill_n(padded.begin() + radius + plane.width, radius, row[plane.width - 1]);
    float* out = result.row(y);
    for (size_t k = 0; k < kernel.size(); ++k)
      for (uint32_t x = 0; x < plane.width; ++x) out[x] += kernel[k] * padded[x + k];
  });
  return result;
}

Plane convolve_columns(const Plane& plane, const Kernel& kernel) {
  const int64_t radius = static_cast<int64_t>(kernel.size() / 2);
  Plane result(plane.width, plane.height);
  for_rows(plane.height, [&](uint32_t y) {
    float* out = result.row(y);
    for (size_t k = 0; k < kernel.size(); ++k) {
      const int64_t source = int64_t{y} + static_cast<int64_t>(k) - radius;
      const float* row = plane.row(static_cast<uint32_t>(std::clamp<int64_t>(source, 0, int64_t{plane.height} - 1)));
      for (uint32_t x = 0; x < plane.width; ++x) out[x] += kernel[k] * row[x];
    }
  });
  return result;
}

}  // namespace

Plane convolve(const Plane& plane, const Kernel& across, const Kernel& down) {
  return convolve_columns(convolve_rows(plane, across), down);
}

}  // namespace sideray::lab
