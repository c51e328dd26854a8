// Provides vectors of floats, one lane a hit, with what shaders/shading/shading.h requires of its scalar type. It is
// compiled once for each instruction set, by the files that define SIDERAY_LANES (a namespace of their own) and
// SIDERAY_LANE_COUNT; nothing in here may be shared between them, so it includes nothing that defines inline functions
// of ours or of the library. Any thread may call it.
// Results are the same bits everywhere: only operations that IEEE 754 defines exactly, no contraction, no approximate
// reciprocals; the transcendental functions are polynomials after Moshier's Cephes library (single precision). Largest
// errors, as tests/rt/lanes_test.cpp finds them: exp and log 2 ulp, atan2 and acos 4e-7 absolutely.
#if !defined(SIDERAY_LANES) || !defined(SIDERAY_LANE_COUNT)
#error "include through rt/shade_kernels_*.cpp"
#endif

#include <stdint.h>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#define SIDERAY_LANE inline __attribute__((always_inline))

namespace sideray::rt::SIDERAY_LANES {

constexpr int lane_count = SIDERAY_LANE_COUNT;
using FloatVector = float __attribute__((vector_size(4 * SIDERAY_LANE_COUNT)));
using IntVector = int32_t __attribute__((vector_size(4 * SIDERAY_LANE_COUNT)));

// Holds all bits of a lane, or none.
struct boolean {
  IntVector bits;
};

struct integer {
  IntVector v;
  integer() = default;
  SIDERAY_LANE integer(IntVector values) : v(values) {}
  SIDERAY_LANE integer(int32_t value) : v(value + IntVector{}) {}
};

struct real {
  FloatVector v;
  real() = default;
  SIDERAY_LANE real(FloatVector values) : v(values) {}
  SIDERAY_LANE real(float value) : v(value - FloatVector{}) {}  // x - 0 is x, even where x is -0
};

SIDERAY_LANE FloatVector as_float(IntVector v) {
  return __builtin_bit_cast(FloatVector, v);
}
SIDERAY_LANE IntVector as_int(FloatVector v) {
  return __builtin_bit_cast(IntVector, v);
}

SIDERAY_LANE boolean operator&&(boolean a, boolean b) {
  return {a.bits & b.bits};
}
SIDERAY_LANE boolean operator||(boolean a, boolean b) {
  return {a.bits | b.bits};
}
SIDERAY_LANE boolean operator!(boolean a) {
  return {~a.bits};
}

SIDERAY_LANE boolean operator==(integer a, integer b) {
  return {a.v == b.v};
}
SIDERAY_LANE integer operator+(integer a, integer b) {
  return a.v + b.v;
}
SIDERAY_LANE integer operator-(integer a, integer b) {
  return a.v - b.v;
}
SIDERAY_LANE integer operator*(integer a, integer b) {
  return a.v * b.v;
}
SIDERAY_LANE boolean operator<(integer a, integer b) {
  return {a.v < b.v};
}

SIDERAY_LANE real operator+(real a, real b) {
  return a.v + b.v;
}
SIDERAY_LANE real operator-(real a, real b) {
  return a.v - b.v;
}
SIDERAY_LANE real operator*(real a, real b) {
  return a.v * b.v;
}
SIDERAY_LANE real operator/(real a, real b) {
  return a.v / b.v;
}
SIDERAY_LANE real operator-(real a) {
  return -a.v;
}
SIDERAY_LANE boolean operator==(real a, real b) {
  return {a.v == b.v};
}
SIDERAY_LANE boolean operator<(real a, real b) {
  return {a.v < b.v};
}
SIDERAY_LANE boolean operator>(real a, real b) {
  return {a.v > b.v};
}
SIDERAY_LANE boolean operator<=(real a, real b) {
  return {a.v <= b.v};
}
SIDERAY_LANE boolean operator>=(real a, real b) {
  return {a.v >= b.v};
}

SIDERAY_LANE real sr_select(boolean c, real yes, real no) {
  return c.bits ? yes.v : no.v;
}
SIDERAY_LANE integer sr_select(boolean c, integer yes, integer no) {
  return c.bits ? yes.v : no.v;
}

// Bit i stands for lane i.
SIDERAY_LANE uint32_t lane_bits(boolean c) {
#if defined(__AVX512F__) && SIDERAY_LANE_COUNT == 16
  return _mm512_cmplt_epi32_mask(__builtin_bit_cast(__m512i, c.bits), _mm512_setzero_si512());
#elif defined(__AVX2__) && SIDERAY_LANE_COUNT == 8
  return static_cast<uint32_t>(_mm256_movemask_ps(__builtin_bit_cast(__m256, c.bits)));
#elif defined(__SSE2__) && SIDERAY_LANE_COUNT == 4
  return static_cast<uint32_t>(_mm_movemask_ps(__builtin_bit_cast(__m128, c.bits)));
#else
  uint32_t bits = 0;
  for (int i = 0; i < lane_count; ++i) bits |= (static_cast<uint32_t>(c.bits[i]) & 1u) << i;
  return bits;
#endif
}

SIDERAY_LANE bool sr_any(boolean c) {
  return lane_bits(c) != 0;
}

SIDERAY_LANE real min(real a, real b) {
  return b.v < a.v ? b.v : a.v;
}
SIDERAY_LANE real max(real a, real b) {
  return a.v < b.v ? b.v : a.v;
}
SIDERAY_LANE integer min(integer a, integer b) {
  return b.v < a.v ? b.v : a.v;
}
SIDERAY_LANE real clamp(real x, real least, real most) {
  return min(max(x, least), most);
}
SIDERAY_LANE real abs(real a) {
  return as_float(as_int(a.v) & 0x7fffffff);
}

SIDERAY_LANE real sqrt(real a) {
#if defined(__AVX512F__) && SIDERAY_LANE_COUNT == 16
  return __builtin_bit_cast(FloatVector, _mm512_maskz_sqrt_ps(0xffff, __builtin_bit_cast(__m512, a.v)));
#elif defined(__AVX2__) && SIDERAY_LANE_COUNT == 8
  return __builtin_bit_cast(FloatVector, _mm256_sqrt_ps(__builtin_bit_cast(__m256, a.v)));
#elif defined(__SSE2__) && SIDERAY_LANE_COUNT == 4
  return __builtin_bit_cast(FloatVector, _mm_sqrt_ps(__builtin_bit_cast(__m128, a.v)));
#else
  for (int i = 0; i < lane_count; ++i) a.v[i] = __builtin_sqrtf(a.v[i]);
  return a;
#endif
}

// Rounds toward zero; |a| < 2^31.
SIDERAY_LANE integer truncate(real a) {
  return __builtin_convertvector(a.v, IntVector);
}
SIDERAY_LANE real to_real(integer a) {
  return __builtin_convertvector(a.v, FloatVector);
}
SIDERAY_LANE real floor(real a) {
  const real towards_zero = to_real(truncate(a));
  return towards_zero - sr_select(towards_zero > a, real(1.0f), real(0.0f));
}

SIDERAY_LANE real load(const float* values) {
  return *reinterpret_cast<const FloatVector*>(values);
}
SIDERAY_LANE void store(float* values, real a) {
  *reinterpret_cast<FloatVector*>(values) = a.v;
}

// Returns values[at[i]] in lane i.
SIDERAY_LANE real gather(const float* values, integer at) {
#if defined(__AVX512F__) && SIDERAY_LANE_COUNT == 16
  return __builtin_bit_cast(
      FloatVector, _mm512_mask_i32gather_ps(_mm512_setzero_ps(), 0xffff, __builtin_bit_cast(__m512i, at.v), values, 4));
#else
  FloatVector result;
  for (int i = 0; i < lane_count; ++i) result[i] = values[at.v[i]];
  return result;
#endif
}

// Returns 0 under -87, where the result would be denormal.
SIDERAY_LANE real exp(real x) {
  const real most(88.37f);
  const real inside = clamp(x, -87.0f, most);
  const real n = floor(inside * 1.44269504f + 0.5f);
  const real r = (inside - n * 0.693359375f) - n * -2.12194440e-4f;
  real p = r * 1.9875691500e-4f + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  const real value = (p * (r * r) + r) + 1.0f;
  const real scale = as_float((truncate(n).v + 127) << 23);
  return sr_select(x < -87.0f, real(0.0f), value * scale);
}

// Takes normal numbers > 0.
SIDERAY_LANE real log(real x) {
  const IntVector bits = as_int(x.v);
  const real mantissa = as_float((bits & 0x007fffff) | 0x3f000000);  // 0.5 .. 1
  const real exponent = to_real(integer((bits >> 23) - 126));
  const boolean low = mantissa < 0.707106781f;
  const real e = exponent - sr_select(low, real(1.0f), real(0.0f));
  const real r = mantissa - 1.0f + sr_select(low, mantissa, real(0.0f));
  const real r2 = r * r;
  real p = r * 7.0376836292e-2f - 1.1514610310e-1f;
  p = p * r + 1.1676998740e-1f;
  p = p * r - 1.2420140846e-1f;
  p = p * r + 1.4249322787e-1f;
  p = p * r - 1.6668057665e-1f;
  p = p * r + 2.0000714765e-1f;
  p = p * r - 2.4999993993e-1f;
  p = p * r + 3.3333331174e-1f;
  const real low_part = (p * r * r2 + e * -2.12194440e-4f) - r2 * 0.5f;
  return (r + low_part) + e * 0.693359375f;
}

// Returns 0 where both are 0.
SIDERAY_LANE real sr_atan2(real y, real x) {
  const real ax = abs(x), ay = abs(y);
  const real least = min(ax, ay), most = max(ax, ay);
  const real q = least / max(most, 1e-37f);  // tangent of 0 .. 45 degrees
  const boolean steep = q > 0.414213562f;
  const real t = sr_select(steep, (q - 1.0f) / (q + 1.0f), q);
  const real t2 = t * t;
  real p = t2 * 8.05374449538e-2f - 1.38776856032e-1f;
  p = p * t2 + 1.99777106478e-1f;
  p = p * t2 - 3.33329491539e-1f;
  real angle = p * t2 * t + t + sr_select(steep, real(0.785398163f), real(0.0f));
  angle = sr_select(ay > ax, 1.57079633f - angle, angle);
  angle = sr_select(x < 0.0f, 3.14159265f - angle, angle);
  return sr_select(y < 0.0f, -angle, angle);
}

// Takes -1 <= x <= 1.
SIDERAY_LANE real acos(real x) {
  return sr_atan2(sqrt((1.0f - x) * (1.0f + x)), x);
}

struct real2 {
  real x, y;
  real2() = default;
  SIDERAY_LANE real2(real a, real b) : x(a), y(b) {}
};

// Names a scalar that is the same for all lanes.
using one_real = float;
struct one_real3 {
  float x, y, z;
};
SIDERAY_LANE one_real3 operator-(one_real3 a) {
  return {-a.x, -a.y, -a.z};
}

struct real3 {
  real x, y, z;
  real3() = default;
  SIDERAY_LANE real3(real a, real b, real c) : x(a), y(b), z(c) {}
  SIDERAY_LANE explicit real3(one_real3 a) : x(a.x), y(a.y), z(a.z) {}
};

struct real4 {
  real x, y, z, w;
  real4() = default;
  SIDERAY_LANE real4(real a, real b, real c, real d) : x(a), y(b), z(c), w(d) {}
};

SIDERAY_LANE real3 operator+(real3 a, real3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
SIDERAY_LANE real3 operator-(real3 a, real3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
SIDERAY_LANE real3 operator-(real3 a) {
  return {-a.x, -a.y, -a.z};
}
SIDERAY_LANE real3 operator*(real3 a, real s) {
  return {a.x * s, a.y * s, a.z * s};
}
SIDERAY_LANE real dot(real3 a, real3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
SIDERAY_LANE real3 cross(real3 a, real3 b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
SIDERAY_LANE real length(real3 a) {
  return sqrt(dot(a, a));
}
SIDERAY_LANE real3 normalize(real3 a) {
  return a * (1.0f / sqrt(dot(a, a)));
}
SIDERAY_LANE real3 min(real3 a, real3 b) {
  return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}
SIDERAY_LANE real3 max(real3 a, real3 b) {
  return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
}
SIDERAY_LANE real mix(real a, real b, real t) {
  return a * (1.0f - t) + b * t;
}
SIDERAY_LANE real3 mix(real3 a, real3 b, real t) {
  return {mix(a.x, b.x, t), mix(a.y, b.y, t), mix(a.z, b.z, t)};
}
SIDERAY_LANE real3 sr_select(boolean c, real3 yes, real3 no) {
  return {sr_select(c, yes.x, no.x), sr_select(c, yes.y, no.y), sr_select(c, yes.z, no.z)};
}
SIDERAY_LANE real largest(real3 a) {
  return max(a.x, max(a.y, a.z));
}

#define SR_FN SIDERAY_LANE
#include "shaders/shading/shading.h"
#undef SR_FN

}  // namespace sideray::rt::SIDERAY_LANES
