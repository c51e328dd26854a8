// Adds arithmetic on vectors of doubles to rt/base/lanes.h. It is included by files that are compiled once for each
// instruction set, and the same rules apply. Any thread may call it.
#pragma once

#include "rt/base/lanes.h"

namespace sideray::rt::SIDERAY_LANES {

SIDERAY_LANE DoubleVector every(double value) {
  return value - DoubleVector{};  // x - 0 is x, even where x is -0
}
SIDERAY_LANE DoubleVector load_doubles(const double* values) {
  DoubleVector v;
  __builtin_memcpy(&v, values, sizeof(v));
  return v;
}
SIDERAY_LANE void store_doubles(double* values, DoubleVector v) {
  __builtin_memcpy(values, &v, sizeof(v));
}
SIDERAY_LANE DoubleVector widened(NarrowVector v) {
  return __builtin_convertvector(v, DoubleVector);
}
SIDERAY_LANE NarrowVector narrowed(DoubleVector v) {
  return __builtin_convertvector(v, NarrowVector);
}
SIDERAY_LANE DoubleVector absolute(DoubleVector v) {
  return __builtin_bit_cast(DoubleVector, __builtin_bit_cast(LongVector, v) & 0x7fffffffffffffffll);
}
// Return their first argument if either is NaN, as std::min and std::max do.
SIDERAY_LANE DoubleVector lesser(DoubleVector a, DoubleVector b) {
  return b < a ? b : a;
}
SIDERAY_LANE DoubleVector greater(DoubleVector a, DoubleVector b) {
  return a < b ? b : a;
}

// Returns a mask whose bit i stands for lane i.
SIDERAY_LANE uint32_t double_bits(LongVector mask) {
#if defined(__AVX512DQ__) && SIDERAY_LANE_COUNT == 16
  return _mm512_movepi64_mask(__builtin_bit_cast(__m512i, mask));
#elif defined(__AVX2__) && SIDERAY_LANE_COUNT == 8
  return static_cast<uint32_t>(_mm256_movemask_pd(__builtin_bit_cast(__m256d, mask)));
#elif defined(__SSE2__) && SIDERAY_LANE_COUNT == 4
  return static_cast<uint32_t>(_mm_movemask_pd(__builtin_bit_cast(__m128d, mask)));
#else
  uint32_t bits = 0;
  for (int i = 0; i < double_count; ++i) bits |= (static_cast<uint32_t>(mask[i]) & 1u) << i;
  return bits;
#endif
}

struct Doubles3 {
  DoubleVector x, y, z;
};
SIDERAY_LANE Doubles3 operator+(Doubles3 a, Doubles3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
SIDERAY_LANE Doubles3 operator-(Doubles3 a, Doubles3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
SIDERAY_LANE Doubles3 operator-(Doubles3 a) {
  return {-a.x, -a.y, -a.z};
}
SIDERAY_LANE Doubles3 operator*(Doubles3 a, DoubleVector s) {
  return {a.x * s, a.y * s, a.z * s};
}
SIDERAY_LANE Doubles3 operator/(Doubles3 a, DoubleVector s) {
  return {a.x / s, a.y / s, a.z / s};
}
SIDERAY_LANE DoubleVector dot(Doubles3 a, Doubles3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
SIDERAY_LANE Doubles3 cross(Doubles3 a, Doubles3 b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
SIDERAY_LANE Doubles3 chosen(LongVector mask, Doubles3 yes, Doubles3 no) {
  return {mask ? yes.x : no.x, mask ? yes.y : no.y, mask ? yes.z : no.z};
}

}  // namespace sideray::rt::SIDERAY_LANES
