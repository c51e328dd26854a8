#include "rt/embree/nearest_collector.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rt/base/vectors.h"

namespace sideray::rt {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// The width is a constant, so that this compiles to vectors without a remainder loop.
template <uint32_t N>
SIDERAY_INLINE bool note_lanes(NearestBlock& block, const NamedHits& hits) {
  int* __restrict valid = hits.valid;
  float* __restrict t_far = hits.t_far;
  const uint32_t* __restrict instance = hits.instance;
  const uint32_t* __restrict primitive = hits.primitive;
  NearestBlock& __restrict b = block;
  int any_close = 0;
  for (uint32_t i = 0; i < N; ++i) {
    const float t = t_far[i], limit = t + (b.margin[i] + relative_margin * t);
    const int within = valid[i] & -static_cast<int>(t <= b.limit[i]);
    const int first = within & -static_cast<int>(limit < b.t[i]) & -static_cast<int>(t > b.begin[i]);
    any_close |= within & ~first;
    b.t[i] = first ? t : b.t[i];
    b.limit[i] = first ? limit : b.limit[i];
    b.instance[i] = first ? instance[i] : b.instance[i];
    b.primitive[i] = first ? primitive[i] : b.primitive[i];
    t_far[i] = first ? limit : t;
    valid[i] = first;
    b.close[i] = within & ~first;
  }
  return any_close != 0;
}

}  // namespace

void NearestBlock::clear() {
  std::fill_n(t, size, infinity);
  std::fill_n(limit, size, infinity);
}

SIDERAY_VECTORS bool NearestBlock::note(const NamedHits& hits, uint32_t width) {
  if (width == 16) return note_lanes<16>(*this, hits);
  if (width == 8) return note_lanes<8>(*this, hits);
  if (width == 4) return note_lanes<4>(*this, hits);
  return note_lanes<1>(*this, hits);
}

uint32_t NearestBlock::occupied() const {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < size; ++i) bits |= static_cast<uint32_t>(std::abs(t[i]) != infinity) << i;
  return bits;
}

SIDERAY_VECTORS void NearestBlock::finish(const CandidateBlock& planes) {
  for (uint32_t i = 0; i < size; ++i) {
    const double pu = planes.u[i], pv = planes.v[i], determinant = planes.determinant[i];
    const auto d = static_cast<float>(planes.t[i] * static_cast<double>(distance_of_unit[i]));
    const float fu = static_cast<float>(pu), fv = static_cast<float>(pv);
    distance[i] = d;
    u[i] = fu;
    v[i] = std::min(fv, 1.0f - fu);
    front[i] = determinant > 0.0;
    // Hits beyond the limit were rejected by Embree's distance, which may be too large by half the margin.
    const float last = d / distance_of_unit[i] + back[i];
    const bool complete = last + 0.5f * (margin[i] + relative_margin * last) <= limit[i];
    sound[i] = static_cast<int>(determinant != 0.0) & static_cast<int>(pu >= 0.0) & static_cast<int>(pv >= 0.0) &
               static_cast<int>(pu + pv <= 1.0) & static_cast<int>(complete);
  }
}

uint32_t resolve_nearest(const TraceTable& table, const LayerRules& rules, std::span<const Ray> rays,
                         NearestBlock& nearest, CandidateBlock& planes, const PacketHits& found) {
  const uint32_t occupied = nearest.occupied();
  if (occupied == 0) return 0;
  for (uint32_t bits = occupied; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(bits));
    CandidateBlock::fetch(table.instances[nearest.instance[i]], nearest.primitive[i]);
  }
  for (uint32_t bits = occupied; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(bits));
    planes.place(i, table.instances[nearest.instance[i]], nearest.primitive[i]);
  }
  planes.meet_planes();
  nearest.finish(planes);
  uint32_t again = 0;
  for (uint32_t bits = occupied; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(bits));
    const TraceInstance& instance = table.instances[nearest.instance[i]];
    const float distance = nearest.distance[i];
    const bool front = (nearest.front[i] != 0) != instance.mirrored;
    const bool met = nearest.sound[i] && distance >= rays[i].t_near && distance <= rays[i].t_far;
    if (!met || (!front && rules.cull && instance.culls)) {
      again |= 1u << i;
      continue;
    }
    found.hits[i * rules.kept] = {planes.t[i] * static_cast<double>(nearest.distance_of_unit[i]),
                                  nearest.u[i],
                                  nearest.v[i],
                                  nearest.instance[i],
                                  nearest.primitive[i],
                                  front};
    found.counts[i] = 1;
  }
  return again;
}

}  // namespace sideray::rt
