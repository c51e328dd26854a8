// Does the first pass for one layer: the rules of layer_collector.h in vectors, for all lanes of a packet at once.
// Lanes with several candidates within rounding use lists instead. Each packet belongs to one thread.
#pragma once

#include <cstdint>
#include <span>

#include "rt/embree/layer_collector.h"

namespace sideray::rt {

// Holds the hits passed to a filter, one array per member, as wide as the packet. Lane i is ray i.
struct NamedHits {
  int* valid;  // -1 or 0
  float* t_far;
  const uint32_t *instance, *primitive;
};

struct NearestBlock {
  static constexpr uint32_t size = CandidateBlock::size;

  // Each lane's only candidate: t is infinite where there is none, and -infinite where the lane keeps a list.
  alignas(64) float t[size], limit[size];
  alignas(64) uint32_t instance[size], primitive[size];
  alignas(64) float margin[size], back[size], begin[size], distance_of_unit[size];  // as in Lane

  alignas(64) int close[size];  // not 0: note() could not decide whether this hit counts, or whether it is nearer

  // finish() writes these for each candidate.
  alignas(64) float distance[size], u[size], v[size];
  alignas(64) int sound[size], front[size];

  void clear();
  // Keeps hits that are nearer than all before by more than rounding, narrows the ends of their lanes, and rejects the
  // others. Returns whether a rejected hit is `close` to its lane's candidate or to the ray's start, so that it needs a
  // list if it counts.
  bool note(const NamedHits& hits, uint32_t width);
  // Returns the bits of the lanes that hold exactly one candidate.
  uint32_t occupied() const;
  // Does the vector part of finish_hit(), and checks that no nearer hit was rejected. The planes must have been
  // intersected.
  void finish(const CandidateBlock& planes);
};

// Names where hits are written: ray i has counts[i] hits, from hits[i * rules.kept] on.
struct PacketHits {
  Hit* hits;
  uint32_t* counts;
};

// Recomputes the candidates of lanes that have one. Returns the bits of the lanes that must be traced again with the
// exact pass. The origins and directions of `planes` must be set.
uint32_t resolve_nearest(const TraceTable& table, const LayerRules& rules, std::span<const Ray> rays,
                         NearestBlock& nearest, CandidateBlock& planes, const PacketHits& found);

}  // namespace sideray::rt
