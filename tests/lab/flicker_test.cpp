#include "lab/metrics/flicker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <random>
#include <sideray/sideray.hpp>

namespace sideray::lab {
namespace {

// Display values, which no tone map changes.
scenes::Image shown(uint32_t side, const std::function<double(uint32_t x, uint32_t y)>& value) {
  scenes::Image image{side, side, {}, false};
  for (const char* name : {"R", "G", "B"}) {
    scenes::Plane plane{name, scenes::Plane::Type::half, {}, {}};
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) plane.values.push_back(static_cast<float>(value(x, y)));
    image.planes.push_back(std::move(plane));
  }
  return image;
}

scenes::Image flat(double value) {
  return shown(4, [=](uint32_t, uint32_t) { return value; });
}

TEST(Flicker, StillPicturesHaveNone) {
  FlickerMeter meter;
  for (int i = 0; i < 5; ++i) meter.add(flat(0.3), flat(0.7));
  const Flicker f = meter.result();
  EXPECT_EQ(f.frames, 5u);
  EXPECT_EQ(f.energy, 0.0);
  EXPECT_EQ(f.reference_energy, 0.0);
  EXPECT_EQ(f.error_energy, 0.0);
  EXPECT_NEAR(f.excess_variance, 0.0, 1e-15);
}

// +-a about a mean: every step is 2a, the variance a^2.
TEST(Flicker, AnAlternatingPicture) {
  constexpr double a = 0.125;
  FlickerMeter meter;
  for (int i = 0; i < 8; ++i) meter.add(flat(i % 2 ? 0.5 + a : 0.5 - a), flat(0.5));
  const Flicker f = meter.result();
  EXPECT_DOUBLE_EQ(f.energy, 2 * a * a);
  EXPECT_DOUBLE_EQ(f.excess_energy(), 2 * a * a);
  EXPECT_DOUBLE_EQ(f.error_energy, 2 * a * a);
  EXPECT_NEAR(f.excess_variance, a * a, 1e-15);
}

// What both do is no flicker, however fast it is.
TEST(Flicker, TheReferencesOwnMotionDoesNotCount) {
  FlickerMeter meter;
  for (int i = 0; i < 9; ++i) {
    const double v = 0.5 + 0.25 * std::cos(glm::half_pi<double>() * i);
    meter.add(flat(v), flat(v));
  }
  const Flicker f = meter.result();
  EXPECT_GT(f.energy, 0.0);
  EXPECT_EQ(f.excess_energy(), 0.0);
  EXPECT_EQ(f.error_energy, 0.0);
  EXPECT_EQ(f.excess_variance, 0.0);
}

// A picture that stands still where the reference moves flickers less than it, and its error moves as the reference.
TEST(Flicker, AFrozenPicture) {
  FlickerMeter meter;
  for (int i = 0; i < 8; ++i) meter.add(flat(0.5), flat(i % 2 ? 0.75 : 0.25));
  const Flicker f = meter.result();
  EXPECT_LT(f.excess_energy(), 0.0);
  EXPECT_DOUBLE_EQ(f.error_energy, f.reference_energy);
  EXPECT_NEAR(f.excess_variance, -0.0625, 1e-15);
}

// Noise that is new in every frame: its energy is its variance, here of a uniform distribution of width w: w^2 / 12.
TEST(Flicker, OfWhiteNoiseItIsTheVariance) {
  constexpr double w = 0.5;
  constexpr uint32_t side = 32, frames = 40;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.5 - w / 2, 0.5 + w / 2);
  FlickerMeter meter;
  for (uint32_t i = 0; i < frames; ++i)
    meter.add(shown(side, [&](uint32_t, uint32_t) { return uniform(random); }),
              shown(side, [](uint32_t, uint32_t) { return 0.5; }));
  const double variance = w * w / 12;
  // A squared step of uniform noise has the variance 7/5 (2 variance)^2 at most; steps that share a frame are
  // correlated, which doubles it at most. The three channels are equal.
  const double standard_error = variance * std::sqrt(2 * 1.4 / (double{side} * side * (frames - 1)));
  const Flicker f = meter.result();
  EXPECT_NEAR(f.energy, variance, 4 * standard_error);
  EXPECT_NEAR(f.excess_variance, variance * (frames - 1) / frames, 4 * standard_error);
}

TEST(Flicker, OneFrameHasNoneAndSizesMustAgree) {
  FlickerMeter meter;
  meter.add(flat(0.1), flat(0.9));
  EXPECT_EQ(meter.result().error_energy, 0.0);
  EXPECT_THROW(meter.add(shown(5, [](uint32_t, uint32_t) { return 0.1; }), flat(0.1)), Error);
}

}  // namespace
}  // namespace sideray::lab
