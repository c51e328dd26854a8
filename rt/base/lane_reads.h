// Reads arrays where the lanes of a vector say: by loads where these follow each other, as neighbours in a picture
// mostly do, by gathers elsewhere. A part of rt/base/lanes.h, compiled as that is. Any thread may call it.
#include "rt/base/lanes.h"

namespace sideray::rt::SIDERAY_LANES {

SIDERAY_LANE real load_any(const float* values) {
  FloatVector v;
  __builtin_memcpy(&v, values, sizeof(v));
  return v;
}

SIDERAY_LANE integer load_any(const int32_t* values) {
  IntVector v;
  __builtin_memcpy(&v, values, sizeof(v));
  return v;
}

SIDERAY_LANE void store_any(float* values, real a) {
  __builtin_memcpy(values, &a.v, sizeof(a.v));
}

SIDERAY_LANE void store_any(int32_t* values, integer a) {
  __builtin_memcpy(values, &a.v, sizeof(a.v));
}

// Returns from, from + 1 and so on.
SIDERAY_LANE integer ramp(int32_t from) {
  IntVector v = IntVector{} + from;
  for (int i = 0; i < lane_count; ++i) v[i] += i;
  return v;
}

SIDERAY_LANE integer gather(const int32_t* values, integer at) {
#if defined(__AVX512F__) && SIDERAY_LANE_COUNT == 16
  return __builtin_bit_cast(IntVector, _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff,
                                                                   __builtin_bit_cast(__m512i, at.v), values, 4));
#else
  IntVector result;
  for (int i = 0; i < lane_count; ++i) result[i] = values[at.v[i]];
  return result;
#endif
}

// Reads arrays at places that follow each other.
struct Run {
  int32_t first;
  SIDERAY_LANE real operator()(const float* values) const { return load_any(values + first); }
  SIDERAY_LANE integer operator()(const int32_t* values) const { return load_any(values + first); }
};

// The same for lanes that begin a new run at one of them.
struct TwoRuns {
  int32_t first, second;
  boolean in_first;
  SIDERAY_LANE real operator()(const float* values) const {
    return sr_select(in_first, load_any(values + first), load_any(values + second));
  }
  SIDERAY_LANE integer operator()(const int32_t* values) const {
    return sr_select(in_first, load_any(values + first), load_any(values + second));
  }
};

// Reads them anywhere.
struct Scattered {
  integer at;
  SIDERAY_LANE real operator()(const float* values) const { return gather(values, at); }
  SIDERAY_LANE integer operator()(const int32_t* values) const { return gather(values, at); }
};

// Returns the address of lane 0, as if the lowest lane of `bits` were read from the start.
SIDERAY_LANE int32_t start_of(integer at, uint32_t bits) {
  const int lane = __builtin_ctz(bits);
  return at.v[lane] - lane;
}

// Calls `work` with what reads the places `at`, as far as they are `wanted`: some are. Others read anything.
template <typename Work>
SIDERAY_LANE void read_at(integer at, boolean wanted, const Work& work) {
  const int32_t first = start_of(at, lane_bits(wanted));
  const boolean in_first = at == ramp(first);
  const boolean others = wanted && !in_first;
  const uint32_t other_bits = lane_bits(others);
  if (other_bits == 0) return work(Run{first});
  const int32_t second = start_of(at, other_bits);
  if (!sr_any(others && !(at == ramp(second)))) return work(TwoRuns{first, second, in_first});
  work(Scattered{sr_select(wanted, at, integer(0))});
}

}  // namespace sideray::rt::SIDERAY_LANES
