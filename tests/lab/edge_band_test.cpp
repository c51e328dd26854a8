#include "lab/metrics/edge_band.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace sideray::lab {
namespace {

constexpr uint32_t width = 12, height = 9;

TEST(EdgeBand, SurroundsWhatDiffers) {
  std::vector<std::vector<uint32_t>> layers(2, std::vector<uint32_t>(width * height, 7));
  layers[1][4 * width + 5] = 8;  // a single pixel of another surface, in the deeper layer
  const std::vector<uint8_t> band = edge_band(layers, width, height, 2);
  for (int y = 0; y < static_cast<int>(height); ++y)
    for (int x = 0; x < static_cast<int>(width); ++x) {
      // The pixel and its four neighbours are edges.
      const int dx = std::abs(x - 5), dy = std::abs(y - 4);
      const bool near = (dx <= 3 && dy <= 2) || (dx <= 2 && dy <= 3);
      EXPECT_EQ(band[static_cast<size_t>(y) * width + static_cast<size_t>(x)], near) << x << "," << y;
    }
}

TEST(EdgeBand, StaysInThePicture) {
  std::vector<std::vector<uint32_t>> layers(1, std::vector<uint32_t>(width * height, 1));
  layers[0][0] = 2;
  layers[0][width * height - 1] = 3;
  const std::vector<uint8_t> band = edge_band(layers, width, height, 1);
  size_t count = 0;
  for (const uint8_t b : band) count += b;
  EXPECT_EQ(count, 2u * 8);  // of 3x3 pixels around each corner's two edges, what lies inside
}

TEST(EdgeBand, NothingDiffersNowhere) {
  const std::vector<std::vector<uint32_t>> layers(1, std::vector<uint32_t>(width * height, 1));
  for (const uint8_t b : edge_band(layers, width, height, 4)) EXPECT_EQ(b, 0);
}

TEST(EdgeBand, MeansAreOfOneSide) {
  const std::vector<float> values{1, 2, 4, 8};
  const std::vector<uint8_t> band{1, 0, 1, 0};
  EXPECT_EQ(mean_over(values, band, true), 2.5);
  EXPECT_EQ(mean_over(values, band, false), 5.0);
  EXPECT_EQ(mean_over(values, std::vector<uint8_t>(4, 0), true), 0.0);
}

}  // namespace
}  // namespace sideray::lab
