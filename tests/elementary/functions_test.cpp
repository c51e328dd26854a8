// Compares the functions with the C library in higher precision, and their bits with recorded ones.
#include "elementary/functions.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <random>

#include "elementary/references.h"

namespace sideray::elementary_tests {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// A prime, so that samples cover all exponents and all patterns of the mantissa.
constexpr uint64_t sample_step = 40009;

class OfOneNumber : public testing::TestWithParam<Function> {};
class EveryFloat : public testing::TestWithParam<Function> {};

TEST_P(OfOneNumber, IsTheNearestFloat) {
  uint64_t off = 0;
  EXPECT_EQ(count_wrong(GetParam(), 0, sample_step, off), 0u);
}

TEST_P(EveryFloat, HasTheNearestFloat) {
  uint64_t off = 0;
  EXPECT_LE(count_wrong(GetParam(), 0, 1, off), GetParam().most_wrong);
  EXPECT_EQ(off, 0u);
}

const auto name_of = [](const testing::TestParamInfo<Function>& test) { return test.param.name; };
INSTANTIATE_TEST_SUITE_P(Each, OfOneNumber, testing::ValuesIn(functions), name_of);
INSTANTIATE_TEST_SUITE_P(Slow, EveryFloat, testing::ValuesIn(functions), name_of);

uint64_t count_wrong_powers(float exponent, uint32_t step) {
  uint64_t wrong = 0;
  for (uint64_t bits = 0; bits < 0x7f800000u; bits += step) {
    const auto x = std::bit_cast<float>(static_cast<uint32_t>(bits));
    const float wanted = nearest_float(std::pow(static_cast<double>(x), static_cast<double>(exponent)), [&] {
      return std::pow(static_cast<long double>(x), static_cast<long double>(exponent));
    });
    wrong += !same(elementary::pow(x, exponent), wanted);
  }
  return wrong;
}

// Holds an exponent of an encoding curve (model/environment.h, model/texture.cpp), or of shapes and textures of the
// built-in scenes.
struct Exponent {
  float value;
  uint64_t wrong;  // of all floats
};
constexpr Exponent exponents[] = {{1.0f / 2.2f, 32}, {1.0f / 2.4f, 30}, {2.4f, 22}, {0.75f, 0}, {0.8f, 54}, {0.85f, 54}};

TEST(Power, IsTheNearestFloat) {
  for (const Exponent& exponent : exponents) EXPECT_EQ(count_wrong_powers(exponent.value, 50021), 0u) << exponent.value;
}

TEST(SlowPower, IsTheNearestFloatForAll) {
  for (const Exponent& exponent : exponents)
    EXPECT_EQ(count_wrong_powers(exponent.value, 1), exponent.wrong) << exponent.value;
}

// Counts wrong results for pairs of any floats, most of which overflow, and for pairs that mostly do not.
uint64_t count_wrong_pairs(uint64_t count) {
  std::mt19937_64 random(1);
  uint64_t wrong = 0;
  const auto power = [&](float x, float y) {
    const float wanted = nearest_float(std::pow(static_cast<double>(x), static_cast<double>(y)), [&] {
      return std::pow(static_cast<long double>(x), static_cast<long double>(y));
    });
    wrong += !same(elementary::pow(x, y), wanted);
  };
  const auto angle = [&](float y, float x) {
    const float wanted = nearest_float(std::atan2(static_cast<double>(y), static_cast<double>(x)), [&] {
      return std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    });
    wrong += !same(elementary::atan2(y, x), wanted) || std::signbit(elementary::atan2(y, x)) != std::signbit(wanted);
  };
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t bits = random();
    const auto x = std::bit_cast<float>(static_cast<uint32_t>(bits)), y = std::bit_cast<float>(static_cast<uint32_t>(bits >> 32));
    if (std::isnan(x) || std::isnan(y)) continue;
    const float share = std::ldexp(static_cast<float>(bits >> 40), -24 - static_cast<int>(bits & 7));
    const float exponent = std::ldexp(static_cast<float>((bits & 0xffffff) + 1), -20);
    power(std::abs(x), y);
    power(share, exponent);
    angle(y, x);
    angle(exponent, x < 0 ? -share : share);
  }
  return wrong;
}

TEST(Pairs, GiveTheNearestFloat) {
  EXPECT_EQ(count_wrong_pairs(100'000), 0u);
}

TEST(SlowPairs, GiveTheNearestFloat) {
  EXPECT_LE(count_wrong_pairs(50'000'000), 1u);
}

TEST(Elementary, HasTheSpecialValuesOfTheStandard) {
  EXPECT_EQ(elementary::exp(-infinity), 0.0f);
  EXPECT_EQ(elementary::exp(infinity), infinity);
  EXPECT_EQ(elementary::log(0.0f), -infinity);
  EXPECT_TRUE(std::isnan(elementary::log(-1.0f)));
  EXPECT_EQ(elementary::log2(8.0f), 3.0f);
  EXPECT_EQ(elementary::exp2(-149.0f), 0x1p-149f);
  EXPECT_EQ(elementary::pow(0.0f, 0.0f), 1.0f);
  EXPECT_EQ(elementary::pow(0.0f, -1.0f), infinity);
  EXPECT_TRUE(std::isnan(elementary::pow(-1.0f, 0.5f)));
  EXPECT_TRUE(std::isnan(elementary::sin(infinity)));
  EXPECT_TRUE(std::isnan(elementary::acos(1.0000001f)));
  EXPECT_EQ(elementary::acos(1.0f), 0.0f);
  for (const float y : {0.0f, -0.0f, 1.0f, -1.0f, infinity, -infinity})
    for (const float x : {0.0f, -0.0f, 1.0f, -1.0f, infinity, -infinity}) {
      const float wanted = std::atan2(y, x), ours = elementary::atan2(y, x);
      EXPECT_EQ(ours, wanted) << y << ", " << x;
      EXPECT_EQ(std::signbit(ours), std::signbit(wanted)) << y << ", " << x;
    }
}

// Returns the error in units in the last place of the wanted result.
double units(double ours, long double wanted) {
  const double place = std::ldexp(1.0, std::ilogb(static_cast<double>(wanted)) - 52);
  return static_cast<double>(std::abs(ours - wanted)) / place;
}

TEST(Elementary, IsRightInDoublePrecision) {
  std::mt19937_64 random(2);
  double most = 0.0, most_power = 0.0, most_angle = 0.0;
  for (int i = 0; i < 200'000; ++i) {
    const double x = std::ldexp(static_cast<double>(random() >> 11), -53) * 20.0 - 10.0, size = std::abs(x) + 1e-9;
    const long double wide = x, wide_size = size;
    most = std::max({most, units(elementary::exp(x), std::exp(wide)), units(elementary::exp2(x), std::exp2(wide)),
                     units(elementary::log(size), std::log(wide_size)), units(elementary::log2(size), std::log2(wide_size)),
                     units(elementary::atan(x), std::atan(wide)), units(elementary::cbrt(x), std::cbrt(wide)),
                     units(elementary::acos(x / 10), std::acos(static_cast<long double>(x / 10))),
                     units(elementary::asin(x / 10), std::asin(static_cast<long double>(x / 10))),
                     units(elementary::hypot(x, 0.7), std::hypot(wide, 0.7)), units(elementary::expm1(x / 30), std::expm1(static_cast<long double>(x / 30)))});
    most_power = std::max(most_power, units(elementary::pow(size, 2.4), std::pow(wide_size, 2.4L)) * 0x1p-52);
    most_angle = std::max({most_angle, static_cast<double>(std::abs(elementary::sin(1000 * x) - std::sin(static_cast<long double>(1000 * x)))),
                           static_cast<double>(std::abs(elementary::cos(x) - std::cos(wide)))});
  }
  EXPECT_LE(most, 4.0);
  EXPECT_LE(most_power, 0x1p-44);
  EXPECT_LE(most_angle, 0x1p-52);
  EXPECT_EQ(elementary::hypot(3e300, 4e300), 5e300);
  EXPECT_EQ(elementary::exp(800.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(elementary::exp(-800.0), 0.0);
  EXPECT_NEAR(elementary::log(0x1p-1070), -1070 * 0.69314718055994531, 1e-10);
}

// Hashes the bits of samples of all functions. A change of a core fails here first; it changes the digest of every
// picture too (tests/golden/rays_alone.json).
TEST(Elementary, HasTheBitsThatWereRecorded) {
  uint64_t hash = 14695981039346656037u;
  for (const Function& function : functions)
    for (uint64_t bits = 0; bits < uint64_t{1} << 32; bits += 1000003) {
      const float result = function.ours(std::bit_cast<float>(static_cast<uint32_t>(bits)));
      hash = (hash ^ (std::isnan(result) ? 0x7fc00000u : std::bit_cast<uint32_t>(result))) * 1099511628211u;
    }
  EXPECT_EQ(hash, 7993870379910327170u);
}

}  // namespace
}  // namespace sideray::elementary_tests
