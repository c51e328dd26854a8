#include "elementary/functions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace sideray::elementary {
namespace {

using Real = double;
using Word = uint64_t;
#define SIDERAY_CORE inline
#include "elementary/cores.h"
#undef SIDERAY_CORE

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// Returns the number, which may be outside the range of normal numbers.
double scaled_far(CoreScaled s) {
  const auto power = static_cast<int32_t>(static_cast<uint32_t>(s.power));
  return std::ldexp(s.value, power);
}

double log_of(double x, double (*core)(double), double of_power) {
  if (!(x > 0.0)) return x == 0.0 ? -infinity : nan;
  if (x == infinity) return x;
  if (x < std::numeric_limits<double>::min()) return core(x * 0x1p60) - 60.0 * of_power;
  return core(x);
}

// Returns log2(x) * y for arguments for which x^y is not a special case.
double power_of_two(double x, double y) {
  const double scale = x < std::numeric_limits<double>::min() ? 0x1p60 : 1.0;
  return y * (core_log2(x * scale) - (scale == 1.0 ? 0.0 : 60.0));
}

// Sets `value` and returns true where x^y needs no logarithm.
bool plain_power(double x, double y, double& value) {
  if (y == 0.0 || x == 1.0)
    value = 1.0;
  else if (!(x >= 0.0) || std::isnan(y))
    value = nan;
  else if (y == 1.0)
    value = x;
  else if (x == 0.0 || x == infinity)
    value = (x == 0.0) == (y > 0.0) ? 0.0 : infinity;
  else if (std::isinf(y))
    value = (x > 1.0) == (y > 0.0) ? infinity : 0.0;
  else
    return false;
  return true;
}

// Holds an angle reduced to |rest| <= pi / 4, and the number of subtracted right angles, modulo 4.
struct Turned {
  double rest;
  uint32_t quarters;
};

// The first 256 bits of 2 / pi after the binary point.
constexpr uint64_t two_over_pi[] = {0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561};

// Returns 64 bits of 2 / pi from bit `first` on; bits before the first are 0.
uint64_t digits(int first) {
  const auto word = [](int i) { return i >= 0 && i < 4 ? two_over_pi[i] : uint64_t{0}; };
  const int i = first >= 0 ? first / 64 : -((63 - first) / 64), shift = first - 64 * i;
  return shift == 0 ? word(i) : word(i) << shift | word(i + 1) >> (64 - shift);
}

// Reduces a float of any size by right angles: multiplies it by 2 / pi, without those bits of 2 / pi that only add
// whole turns (Payne and Hanek 1983).
Turned turned_far(float x) {
  __extension__ using Wide = unsigned __int128;
  __extension__ using SignedWide = __int128;
  const uint32_t bits = std::bit_cast<uint32_t>(x);
  const int exponent = static_cast<int>(bits >> 23 & 0xff) - 150;  // |x| = mantissa * 2^exponent
  const uint32_t mantissa = (bits & 0x007fffff) | 0x00800000;
  const Wide part = Wide{digits(exponent - 2)} << 64 | digits(exponent + 62);
  const Wide product = part * mantissa;  // in quarters * 2^126, modulo 4
  const auto quarters = static_cast<uint32_t>((product + (Wide{1} << 125)) >> 126);
  const auto rest = static_cast<SignedWide>(product - (Wide{quarters} << 126));
  const double angle = static_cast<double>(rest) * 0x1p-126 * 0x1.921fb54442d18p+0;
  return x < 0.0f ? Turned{-angle, 0u - quarters} : Turned{angle, quarters};
}

// Reduces an angle by right angles (Cody and Waite 1980); exact to 2^-100 for |x| <= 2^20.
Turned turned_near(double x) {
  Word bits;
  const double n = core_nearest(x * 0x1.45f306dc9c883p-1, bits);
  const double a = x - n * 0x1.921fb544p+0, b = n * 0x1.0b4611a6p-34;
  const double rest = a - b;
  return {rest - ((rest - a) + b + n * 0x1.3198a2e037073p-69), static_cast<uint32_t>(bits)};
}

Turned turned(float x) {
  return std::abs(x) <= 0x1p20f ? turned_near(static_cast<double>(x)) : turned_far(x);
}
Turned turned(double x) {
  return std::abs(x) <= 0x1p20 ? turned_near(x) : turned_near(std::fmod(x, 0x1.921fb54442d18p+2));
}

double sine(Turned t) {
  const double s = t.quarters & 1 ? core_cos_small(t.rest) : core_sin_small(t.rest);
  return t.quarters & 2 ? -s : s;
}
double cosine(Turned t) {
  return sine({t.rest, t.quarters + 1});
}
double tangent(Turned t) {
  const double s = core_sin_small(t.rest), c = core_cos_small(t.rest);
  return t.quarters & 1 ? -c / s : s / c;
}

double angle_of(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return nan;
  if (std::isinf(x) || std::isinf(y)) {
    const double to_x = std::isinf(x) ? std::copysign(1.0, x) : std::copysign(0.0, x);
    return core_atan2(std::isinf(y) ? std::copysign(1.0, y) : std::copysign(0.0, y), to_x);
  }
  // The sign of a zero x says on which side it is.
  if (x == 0.0 && y == 0.0) x = std::copysign(1.0, x);
  return core_atan2(y, x);
}

// Returns the angle of (x, y), scaled first so that core_atan2 neither overflows nor underflows.
double scaled_angle_of(double y, double x) {
  const double most = std::max(std::abs(x), std::abs(y));
  if (!(most > 0.0) || std::isinf(most) || std::isnan(x) || std::isnan(y)) return angle_of(y, x);
  const int power = -std::ilogb(most);
  return angle_of(std::ldexp(y, power), std::ldexp(x, power));
}

double arc_cosine(double x) {
  return std::abs(x) <= 1.0 ? core_atan2(std::sqrt((1.0 - x) * (1.0 + x)), x) : nan;
}
double arc_sine(double x) {
  return std::abs(x) <= 1.0 ? core_atan2(x, std::sqrt((1.0 - x) * (1.0 + x))) : nan;
}

float to_float(double x) {
  return static_cast<float>(x);
}
double to_double(float x) {
  return static_cast<double>(x);
}

}  // namespace

float exp(float x) {
  if (std::isnan(x)) return x;
  return to_float(core_scaled(core_exp(to_double(std::clamp(x, -120.0f, 120.0f)))));
}
double exp(double x) {
  if (std::isnan(x)) return x;
  return scaled_far(core_exp(std::clamp(x, -800.0, 800.0)));
}

float exp2(float x) {
  if (std::isnan(x)) return x;
  const double inside = to_double(std::clamp(x, -200.0f, 200.0f));
  Word power;
  if (core_nearest(inside, power) == inside) return to_float(core_scaled({1.0, power}));
  return to_float(core_scaled(core_exp2(inside)));
}
double exp2(double x) {
  if (std::isnan(x)) return x;
  return scaled_far(core_exp2(std::clamp(x, -1200.0, 1200.0)));
}

double expm1(double x) {
  return std::abs(x) <= 0.35 ? core_exp_small(x) : exp(x) - 1.0;
}

float log(float x) {
  return to_float(log(to_double(x)));
}
double log(double x) {
  return log_of(x, core_log, 0x1.62e42fefa39efp-1);
}

float log2(float x) {
  return to_float(log2(to_double(x)));
}
double log2(double x) {
  return log_of(x, core_log2, 1.0);
}

float pow(float x, float y) {
  if (x >= std::numeric_limits<float>::min() && x < std::numeric_limits<float>::infinity() && std::abs(y) <= 0x1p20f)
    return to_float(core_scaled(core_exp2(std::clamp(to_double(y) * core_log2(to_double(x)), -200.0, 200.0))));
  double value;
  if (plain_power(to_double(x), to_double(y), value)) return to_float(value);
  return to_float(core_scaled(core_exp2(std::clamp(power_of_two(to_double(x), to_double(y)), -200.0, 200.0))));
}
double pow(double x, double y) {
  double value;
  if (plain_power(x, y, value)) return value;
  return scaled_far(core_exp2(std::clamp(power_of_two(x, y), -1200.0, 1200.0)));
}

float sin(float x) {
  return std::isfinite(x) ? to_float(sine(turned(x))) : to_float(nan);
}
double sin(double x) {
  return std::isfinite(x) ? sine(turned(x)) : nan;
}
float cos(float x) {
  return std::isfinite(x) ? to_float(cosine(turned(x))) : to_float(nan);
}
double cos(double x) {
  return std::isfinite(x) ? cosine(turned(x)) : nan;
}
float tan(float x) {
  return std::isfinite(x) ? to_float(tangent(turned(x))) : to_float(nan);
}
double tan(double x) {
  return std::isfinite(x) ? tangent(turned(x)) : nan;
}

float asin(float x) {
  return to_float(arc_sine(to_double(x)));
}
double asin(double x) {
  return arc_sine(x);
}
float acos(float x) {
  return to_float(arc_cosine(to_double(x)));
}
double acos(double x) {
  return arc_cosine(x);
}
float atan(float x) {
  return to_float(angle_of(to_double(x), 1.0));
}
double atan(double x) {
  return scaled_angle_of(x, 1.0);
}
float atan2(float y, float x) {
  return to_float(angle_of(to_double(y), to_double(x)));
}
double atan2(double y, double x) {
  return scaled_angle_of(y, x);
}

double cbrt(double x) {
  if (x == 0.0 || !std::isfinite(x)) return x;
  const double size = std::abs(x);
  double root = exp(log(size) * (1.0 / 3.0));
  // One step of Newton's method takes the error from 2^-45 to the last place.
  root -= (root - size / (root * root)) * (1.0 / 3.0);
  return std::copysign(root, x);
}
float cbrt(float x) {
  return to_float(cbrt(to_double(x)));
}

float hypot(float x, float y) {
  return to_float(hypot(to_double(x), to_double(y)));
}
float hypot(float x, float y, float z) {
  return to_float(hypot(to_double(x), to_double(y), to_double(z)));
}
double hypot(double x, double y) {
  return hypot(x, y, 0.0);
}
double hypot(double x, double y, double z) {
  const double most = std::max({std::abs(x), std::abs(y), std::abs(z)});
  if (std::isinf(x) || std::isinf(y) || std::isinf(z)) return infinity;
  if (!(most > 0x1p-400 && most < 0x1p400)) {
    if (most == 0.0 || std::isnan(most)) return x + y + z == 0.0 ? 0.0 : nan;
    const int power = std::ilogb(most);
    return std::ldexp(hypot(std::ldexp(x, -power), std::ldexp(y, -power), std::ldexp(z, -power)), power);
  }
  return std::sqrt(x * x + y * y + z * z);
}

}  // namespace sideray::elementary
