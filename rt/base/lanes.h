// Provides vectors of floats, one lane a hit, with everything that shaders/shading/shading.h requires of its scalar
// type. It is compiled once for each instruction set: sideray_lanes() in rt/CMakeLists.txt defines SIDERAY_LANES (a
// separate namespace) and SIDERAY_LANE_COUNT. Instruction sets must not share functions, so it includes no header with
// inline functions, of ours or of the standard library. Any thread may call it. Results have the same bits everywhere:
// only operations that IEEE 754 defines exactly, no contraction, no approximate reciprocals. Transcendental functions
// use the cores of elementary/functions.h in vectors of doubles, and give the same bits.
#pragma once

#if !defined(SIDERAY_LANES) || !defined(SIDERAY_LANE_COUNT)
#error "for the sources that sideray_lanes() compiles (rt/CMakeLists.txt)"
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

// Holds a mask: all bits of a lane are set, or none.
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

// Returns a mask whose bit i stands for lane i.
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

// Holds half as many doubles as there are lanes, in a vector of the same size; two of them hold all lanes.
using DoubleVector = double __attribute__((vector_size(4 * SIDERAY_LANE_COUNT)));
using LongVector = int64_t __attribute__((vector_size(4 * SIDERAY_LANE_COUNT)));
using NarrowVector = float __attribute__((vector_size(2 * SIDERAY_LANE_COUNT)));  // as many floats as doubles

constexpr int double_count = SIDERAY_LANE_COUNT / 2;

SIDERAY_LANE DoubleVector root(DoubleVector v) {
#if defined(__AVX512F__) && SIDERAY_LANE_COUNT == 16
  return __builtin_bit_cast(DoubleVector, _mm512_maskz_sqrt_pd(0xff, __builtin_bit_cast(__m512d, v)));
#elif defined(__AVX2__) && SIDERAY_LANE_COUNT == 8
  return __builtin_bit_cast(DoubleVector, _mm256_sqrt_pd(__builtin_bit_cast(__m256d, v)));
#elif defined(__SSE2__) && SIDERAY_LANE_COUNT == 4
  return __builtin_bit_cast(DoubleVector, _mm_sqrt_pd(__builtin_bit_cast(__m128d, v)));
#else
  for (int i = 0; i < double_count; ++i) v[i] = __builtin_sqrt(v[i]);
  return v;
#endif
}

namespace cores {
using Real = DoubleVector;
using Word = uint64_t __attribute__((vector_size(4 * SIDERAY_LANE_COUNT)));
#define SIDERAY_CORE SIDERAY_LANE
#include "elementary/cores.h"
#undef SIDERAY_CORE
}  // namespace cores

// Calls a function of doubles for each half of the lanes, and rounds the results.
template <typename Function>
SIDERAY_LANE real in_doubles(Function function, real a, real b) {
  struct Halves {
    NarrowVector v[2];
  };
  Halves x = __builtin_bit_cast(Halves, a.v), y = __builtin_bit_cast(Halves, b.v);
  for (int i = 0; i < 2; ++i)
    x.v[i] = __builtin_convertvector(
        function(__builtin_convertvector(x.v[i], DoubleVector), __builtin_convertvector(y.v[i], DoubleVector)),
        NarrowVector);
  return __builtin_bit_cast(FloatVector, x);
}

SIDERAY_LANE real exp(real x) {
  const auto of_doubles = [](DoubleVector v, DoubleVector) __attribute__((always_inline)) {
    return cores::core_scaled(cores::core_exp(v));
  };
  return sr_select(x == x, in_doubles(of_doubles, clamp(x, -120.0f, 120.0f), x), x);
}

SIDERAY_LANE real log(real x) {
  const auto of_doubles = [](DoubleVector v, DoubleVector) __attribute__((always_inline)) { return cores::core_log(v); };
  const real result = in_doubles(of_doubles, x, x), infinity(__builtin_inff()), nan(__builtin_nanf(""));
  return sr_select(x > 0.0f && x < infinity, result, sr_select(x == 0.0f, -infinity, sr_select(x > 0.0f, x, nan)));
}

// The arguments must be finite.
SIDERAY_LANE real sr_atan2(real y, real x) {
  // If both are zero, the sign of x decides its side.
  const real one = as_float((as_int(x.v) & static_cast<int32_t>(0x80000000)) | 0x3f800000);
  const auto of_doubles = [](DoubleVector v, DoubleVector w) __attribute__((always_inline)) {
    return cores::core_atan2(v, w);
  };
  return in_doubles(of_doubles, y, sr_select(x == 0.0f && y == 0.0f, one, x));
}

SIDERAY_LANE real acos(real x) {
  const auto of_doubles = [](DoubleVector v, DoubleVector) __attribute__((always_inline)) {
    return cores::core_atan2(root((1.0 - v) * (1.0 + v)), v);
  };
  return sr_select(abs(x) <= 1.0f, in_doubles(of_doubles, x, x), real(__builtin_nanf("")));
}

struct real2 {
  real x, y;
  real2() = default;
  SIDERAY_LANE real2(real a, real b) : x(a), y(b) {}
};

// Is a scalar that is the same for all lanes.
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

#include "shaders/shading/fixed_function.h"
#undef SR_FN

}  // namespace sideray::rt::SIDERAY_LANES
