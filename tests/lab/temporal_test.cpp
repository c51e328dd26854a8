#include "lab/metrics/temporal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <sideray/sideray.hpp>

namespace sideray::lab::temporal_test {
namespace {

constexpr uint32_t side = 24;
using Value = std::function<double(double x, double y)>;

scenes::Plane plane_of(const std::string& name, uint32_t width, const Value& value) {
  scenes::Plane plane{name, scenes::Plane::Type::single, {}, {}};
  for (uint32_t y = 0; y < width; ++y)
    for (uint32_t x = 0; x < width; ++x) plane.values.push_back(static_cast<float>(value(x, y)));
  return plane;
}

// Display values, which no tone map changes.
scenes::Image shown(const Value& value, uint32_t width = side) {
  scenes::Image image{width, width, {}, false};
  for (const char* name : {"R", "G", "B"}) image.planes.push_back(plane_of(name, width, value));
  return image;
}

scenes::Image flat(double value) {
  return shown([=](double, double) { return value; });
}

struct Moves {
  double across = 0, down = 0;
  Value distance = [](double, double) { return 5.0; };
  Value surface = [](double, double) { return 1.0; };
};

scenes::Image motion(const Moves& moves) {
  scenes::Image image{side, side, {}, true};
  image.planes.push_back(plane_of("motion.X", side, [&](double, double) { return moves.across; }));
  image.planes.push_back(plane_of("motion.Y", side, [&](double, double) { return moves.down; }));
  image.planes.push_back(plane_of("Z", side, moves.distance));
  scenes::Plane ids{"id.surface", scenes::Plane::Type::uint, {}, {}};
  for (const float id : plane_of("", side, moves.surface).values) ids.uint_values.push_back(static_cast<uint32_t>(id));
  image.planes.push_back(std::move(ids));
  return image;
}

// A pattern with detail down to the pixel, and never the same along a line.
double pattern(double x, double y) {
  return 0.5 + 0.25 * std::sin(2.1 * x + 0.3 * y) + 0.2 * std::cos(1.7 * y - 0.9 * x);
}

TEST(Warped, WhatMovesAsTheMotionSaysIsTheSame) {
  WarpMeter meter;
  for (int k = 0; k < 5; ++k) {
    const scenes::Image picture = shown([=](double x, double y) { return pattern(x - 3 * k, y + 2 * k); });
    meter.add(picture, picture, motion({.across = 3, .down = -2}));
  }
  const Warped warped = meter.result();
  EXPECT_LT(warped.difference, 1e-13) << "float rounding of the pattern alone";
  EXPECT_DOUBLE_EQ(warped.excess(), 0);
  // Of every frame the pixels that came from within the picture.
  EXPECT_NEAR(warped.share, double{side - 3} * (side - 2) / (side * side), 1e-12);
}

// The same motion stated falsely is seen.
TEST(Warped, WrongMotionIsNot) {
  WarpMeter meter;
  for (int k = 0; k < 3; ++k) {
    const scenes::Image picture = shown([=](double x, double y) { return pattern(x - 3 * k, y); });
    meter.add(picture, picture, motion({.across = -3}));
  }
  EXPECT_GT(meter.result().difference, 1e-3);
}

// Between pixels a straight line is looked up exactly.
TEST(Warped, MotionOfPartsOfPixelsIsInterpolated) {
  WarpMeter meter;
  for (int k = 0; k < 4; ++k) {
    const scenes::Image picture =
        shown([=](double x, double y) { return 0.3 + 0.01 * (x - 0.25 * k) + 0.005 * (y - 0.5 * k); });
    meter.add(picture, flat(0.3), motion({.across = 0.25, .down = 0.5}));
  }
  EXPECT_LT(meter.result().difference, 1e-12);
}

// Noise that is new in every frame, of whole-pixel motion: its variance; the reference's own is taken off.
TEST(Warped, OfWhiteNoiseItIsTheVariance) {
  constexpr double w = 0.5, variance = w * w / 12;
  constexpr int frames = 60;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.5 - w / 2, 0.5 + w / 2);
  const auto noise = [&] { return shown([&](double, double) { return uniform(random); }); };
  WarpMeter meter;
  for (int k = 0; k < frames; ++k) meter.add(noise(), flat(0.5), motion({.across = 1}));
  // As in flicker_test: a squared step has the variance 7/5 (2 variance)^2, steps that share a frame double it.
  const double standard_error = variance * std::sqrt(2 * 1.4 / (double{side} * (side - 1) * (frames - 1)));
  EXPECT_NEAR(meter.result().difference, variance, 4 * standard_error);
  EXPECT_EQ(meter.result().reference_difference, 0);
  EXPECT_EQ(meter.result().excess(), meter.result().difference);
}

// What comes from behind something has no picture before: another surface, or one far nearer.
TEST(Warped, WhatWasHiddenDoesNotCount) {
  const auto jump = [](int k) { return shown([=](double x, double) { return x < 8 ? 0.1 * k : 0.5; }); };
  const auto excess = [&](const Moves& before, const Moves& now) {
    WarpMeter meter;
    meter.add(jump(0), flat(0.5), motion(before));
    meter.add(jump(5), flat(0.5), motion(now));
    return meter.result();
  };
  const Moves same;
  EXPECT_GT(excess(same, same).difference, 0.01);
  const Moves other{.surface = [](double x, double) { return x < 8 ? 2.0 : 1.0; }};
  EXPECT_EQ(excess(other, same).difference, 0);
  EXPECT_NEAR(excess(other, same).share, 16.0 / 24, 1e-12);
  const Moves nearer{.distance = [](double x, double) { return x < 8 ? 3.0 : 5.0; }};
  EXPECT_EQ(excess(nearer, same).difference, 0);
  const Moves sky{.distance = [](double, double) { return INFINITY; }};
  EXPECT_GT(excess(sky, sky).difference, 0.01) << "the sky is as far as the sky";
  EXPECT_EQ(excess(sky, same).share, 0);
  EXPECT_EQ(excess(sky, same).difference, 0) << "and where nothing can be compared, nothing is found";
}

TEST(Warped, NeedsItsChannels) {
  WarpMeter meter;
  EXPECT_THROW(meter.add(flat(0.5), flat(0.5), flat(0.5)), Error);
  EXPECT_THROW(meter.add(shown([](double, double) { return 0.5; }, 5), flat(0.5), motion({})), Error);
}

Settling settling(const std::function<scenes::Image(uint32_t)>& frame) {
  SettleMeter meter;
  for (uint32_t k = 0; k <= SettleMeter::held; ++k) meter.add(frame(k));
  return meter.result();
}

// A past that fades by the factor r a frame is half as strong after ln 2 / -ln r frames.
TEST(Settling, OfExponentialDecay) {
  for (const double r : {0.5, 0.75, 0.85}) {
    const double a = 0.3;
    const Settling s = settling([&](uint32_t k) { return flat(0.5 + a * std::pow(r, k)); });
    EXPECT_NEAR(s.ghost, a, 2e-3) << r;
    EXPECT_NEAR(s.half_life, std::log(2.0) / -std::log(r), 0.02 * std::log(2.0) / -std::log(r)) << r;
    EXPECT_NEAR(s.settle_time, std::ceil(std::log(SettleMeter::tolerance / a) / std::log(r)), 1) << r;
  }
}

// The mean over n frames that temporal anti-aliasing keeps, n = 10: what is settled is not quite so after 48 frames,
// and the half-life is below the true one by less than the residue.
TEST(Settling, OfAnAverageOfTenFrames) {
  const double r = 0.9, half_life = std::log(2.0) / -std::log(r);
  const Settling s = settling([&](uint32_t k) { return flat(0.4 + 0.2 * std::pow(r, k)); });
  EXPECT_LT(s.half_life, half_life);
  EXPECT_GT(s.half_life, 0.97 * half_life);
}

TEST(Settling, WithoutAPastThereIsNone) {
  const Settling s = settling([](uint32_t) { return shown(pattern); });
  EXPECT_EQ(s.ghost, 0);
  EXPECT_EQ(s.half_life, 0);
  EXPECT_EQ(s.settle_time, 0);
}

// A picture that repeats itself is at rest.
TEST(Settling, PlacesInThePixelAreNoGhost) {
  const Settling s = settling([](uint32_t k) {
    return shown([=](double x, double y) { return pattern(x + 0.1 * (k % SettleMeter::period), y); });
  });
  EXPECT_EQ(s.ghost, 0);
  EXPECT_EQ(s.settle_time, 0);
}

// So is one that has new noise in every frame; a ghost beneath it is found all the same.
TEST(Settling, NoiseIsTakenOff) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0, 0.02);
  const auto noisy = [&](double a) {
    return settling([&](uint32_t k) {
      const double past = a * std::pow(0.5, k);
      return shown([&](double, double) { return 0.5 + past + normal(random); }, 96);
    });
  };
  // The square of noise between two pictures, 8e-4, is known to sqrt(2 / 9216) of itself: 1.2e-5, or a ghost of 3.4e-3.
  EXPECT_LT(noisy(0).ghost, 2 * 3.4e-3);
  const Settling s = noisy(0.2);
  EXPECT_NEAR(s.ghost, 0.2, 2e-3);
  EXPECT_NEAR(s.half_life, 1, 0.03);
}

// One frame late, then right at once.
TEST(Settling, ALateFrameIsSettledWithTheNext) {
  const Settling s = settling([](uint32_t k) { return flat(k == 0 ? 0.9 : 0.5); });
  EXPECT_NEAR(s.ghost, 0.4, 1e-4);
  EXPECT_NEAR(s.half_life, 0.5, 1e-9);
  EXPECT_EQ(s.settle_time, 1);
}

TEST(Settling, NeedsAllPicturesOfOneSize) {
  SettleMeter meter;
  meter.add(flat(0.5));
  EXPECT_THROW(static_cast<void>(meter.result()), Error);
  EXPECT_THROW(meter.add(shown([](double, double) { return 0.5; }, 5)), Error);
}

}  // namespace
}  // namespace sideray::lab::temporal_test
