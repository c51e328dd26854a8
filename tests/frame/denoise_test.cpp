// Compares filtered rough layers with the reference, for one direction in each pixel.
#include <gtest/gtest.h>

#include <iostream>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

double relmse(const std::vector<float>& test, const std::vector<float>& reference) {
  double sum = 0;
  for (size_t i = 0; i < test.size(); ++i) {
    const double x = static_cast<double>(test[i]), r = static_cast<double>(reference[i]);
    sum += (x - r) * (x - r) / (r * r + 0.01);
  }
  return sum / static_cast<double>(test.size());
}

// The filter makes one direction as good as 8. In smaller pictures curved glass has too few similar pixels: at 96x54
// the mean of 8 is better.
TEST(Denoise, OneDirectionIsWorthEight) {
  constexpr uint32_t raw_samples = 8;
  const scenes::Content content = scenes::generate("frosted", {});
  tests::Setup setup{.width = 160, .height = 90};
  setup.denoise = true;
  const std::vector<float> filtered = render(content, setup).rgb();
  setup.denoise = false;
  std::vector<float> raw(filtered.size());
  for (setup.seed = 1; setup.seed <= raw_samples; ++setup.seed) {
    const std::vector<float> one = render(content, setup).rgb();
    for (size_t i = 0; i < raw.size(); ++i) raw[i] += one[i] / raw_samples;
  }
  setup.translucency = SIDERAY_TRANSLUCENCY_REFERENCE;
  setup.light_samples = 64;
  const std::vector<float> reference = render(content, setup).rgb();
  const double with_filter = relmse(filtered, reference), without = relmse(raw, reference);
  std::cout << "  relmse: filtered " << with_filter << ", mean of " << raw_samples << " " << without << "\n";
  EXPECT_LT(with_filter, without);
}

// Without rough surfaces the filter changes no bit.
TEST(Denoise, LeavesMirrorsAlone) {
  scenes::Content content = scenes::generate("frosted", {});
  for (scenes::Material& m : content.materials) m.desc.roughness = m.desc.transmission > 0 ? 0 : m.desc.roughness;
  tests::Setup setup{.width = 64, .height = 36};
  const Frame off = render(content, setup);
  setup.denoise = true;
  EXPECT_EQ(off.rgb(), render(content, setup).rgb());
}

}  // namespace
}  // namespace sideray::tests
