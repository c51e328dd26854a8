#include "lab/metrics/sequence_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace sideray::lab::sequence_error_test {
namespace {

constexpr uint32_t side = 16;

scenes::Image flat(double value) {
  scenes::Image image{side, side, {}, false};
  for (const char* name : {"R", "G", "B"})
    image.planes.push_back(
        {name, scenes::Plane::Type::half, std::vector<float>(side * side, static_cast<float>(value)), {}});
  return image;
}

scenes::Image still() {
  scenes::Image image{side, side, {}, true};
  for (const char* name : {"motion.X", "motion.Y", "Z"})
    image.planes.push_back({name, scenes::Plane::Type::single, std::vector<float>(side * side, 0.0f), {}});
  image.planes.push_back({"id.surface", scenes::Plane::Type::uint, {}, std::vector<uint32_t>(side * side, 1)});
  return image;
}

TEST(SequenceError, HoldsMeansOfTheMetrics) {
  SequenceError error(3);
  double flip = 0, psnr = 0;
  for (const double value : {0.5, 0.6, 0.4}) {
    error.add(flat(value), flat(0.45), still());
    const Metrics one = compare(flat(value), flat(0.45)).metrics;
    flip += *one.flip / 3, psnr += *one.psnr / 3;
  }
  const nlohmann::ordered_json result = error.result();
  EXPECT_NEAR(result["flip"], flip, 1e-12);
  EXPECT_NEAR(result["psnr"], psnr, 1e-12);
  EXPECT_EQ(result["nonfinite"], 0);
  EXPECT_FALSE(result.contains("hdr_flip")) << "display images have none";
}

// Steps of 0.1 and 0.2, after two frames that do not count, over a constant reference: half their mean square, and the
// same along the motion.
TEST(SequenceError, HoldsWhatShowsInTime) {
  SequenceError error(5);
  for (const double value : {0.9, 0.1, 0.5, 0.6, 0.4}) error.add(flat(value), flat(0.45), still());
  const nlohmann::ordered_json result = error.result();
  for (const char* name : {"flicker", "flicker_of_error", "warped_difference"})
    EXPECT_NEAR(result[name], 0.5 * (0.01 + 0.04) / 2, 1e-7) << name;
  for (const char* name : {"ghost", "ghost_half_life", "settle_time"})
    EXPECT_EQ(result[name], 0) << name << ": without pictures at rest there is no past";
}

TEST(SequenceError, TheLastFrameIsWhatSettles) {
  SequenceError error(2);
  for (const double value : {0.1, 0.8}) error.add(flat(value), flat(0.5), still());
  for (uint32_t k = 1; k <= SettleMeter::held; ++k) error.add_at_rest(flat(0.5 + 0.3 * std::pow(0.5, k)));
  EXPECT_NEAR(error.result()["ghost"], 0.3, 1e-4);
  EXPECT_NEAR(error.result()["ghost_half_life"], 1, 1e-3);
  EXPECT_EQ(error.result()["settle_time"], 7) << "0.3 / 2^7 is below 1/255";
}

TEST(SequenceError, APixelThatIsNotFiniteHidesAll) {
  SequenceError error(3);
  scenes::Image broken = flat(0.5);
  broken.linear = true;
  broken.planes[0].values[7] = std::numeric_limits<float>::quiet_NaN();
  scenes::Image linear = flat(0.5);
  linear.linear = true;
  for (const scenes::Image& image : {linear, broken, linear}) error.add(image, linear, still());
  const nlohmann::ordered_json result = error.result();
  EXPECT_EQ(result.size(), 1u) << result.dump();
  EXPECT_EQ(result["nonfinite"], 1);
}

}  // namespace
}  // namespace sideray::lab::sequence_error_test
