// The first pass where one layer is wanted: layer_collector.h's rules for the lanes of a packet side by side, in
// vectors. Lanes with several candidates within rounding go back to lists. One thread per packet.
#pragma once

#include <cstdint>
#include <span>

#include "rt/embree/layer_collector.h"

namespace sideray::rt {

// What a filter is handed, one array per member, as wide as the packet. Lane i is ray i.
struct NamedHits {
  int* valid;  // -1 or 0
  float* t_far;
  const uint32_t *instance, *primitive;
};

struct NearestBlock {
  static constexpr uint32_t size = CandidateBlock::size;

  // The only candidate of each lane: t is infinite where there is none, and -infinite where the lane keeps a list.
  alignas(64) float t[size], limit[size];
  alignas(64) uint32_t instance[size], primitive[size];
  alignas(64) float margin[size], distance_of_unit[size];  // as in Lane

  alignas(64) int close[size];  // what note() could not tell, not 0: such a hit

  // What finish() makes of them.
  alignas(64) float distance[size], u[size], v[size];
  alignas(64) int sound[size], front[size];

  void clear();
  // Keeps what is nearer than all before by more than rounding, narrows those lanes' ends and turns the others away.
  // True where some of those are too close to their lane's candidate to tell: they need a list.
  bool note(const NamedHits& hits, uint32_t width);
  // Lanes, as bits, with an only candidate.
  uint32_t occupied() const;
  // The vector part of finish_hit() and of the proof that nothing nearer has been turned away. Planes must be met.
  void finish(const CandidateBlock& planes);
};

// Recomputes the only candidates: hits[i], counts[i]. Returns the lanes, as bits, that must be traced again with the
// exact pass. Origins and directions of the planes must be set.
uint32_t resolve_nearest(const TraceTable& table, const LayerRules& rules, std::span<const Ray> rays,
                         NearestBlock& nearest, CandidateBlock& planes, Hit* hits, uint32_t* counts);

}  // namespace sideray::rt
