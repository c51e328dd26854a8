// Reads arrays at the indices in the lanes of a vector: by loads if the indices are consecutive, as for neighbouring
// pixels, by gathers otherwise. A part of rt/base/lanes.h, compiled like it. Any thread may call it.
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

// Returns a vector of from, from + 1 and so on.
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

// Reads arrays at consecutive indices.
struct Run {
  int32_t first;
  SIDERAY_LANE real operator()(const float* values) const { return load_any(values + first); }
  SIDERAY_LANE integer operator()(const int32_t* values) const { return load_any(values + first); }
};

// Reads arrays at two runs of consecutive indices; `in_first` says which lanes belong to the first.
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

// Reads arrays at any indices.
struct Scattered {
  integer at;
  SIDERAY_LANE real operator()(const float* values) const { return gather(values, at); }
  SIDERAY_LANE integer operator()(const int32_t* values) const { return gather(values, at); }
};

// Returns the index of lane 0 in the run of consecutive indices that contains the lowest lane of `bits`.
SIDERAY_LANE int32_t start_of(integer at, uint32_t bits) {
  const int lane = __builtin_ctz(bits);
  return at.v[lane] - lane;
}

// Calls `work` with the cheapest reader for the indices `at` of the `wanted` lanes, of which there is at least one.
// Other lanes read any element.
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
