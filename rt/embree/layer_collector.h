// Keeps the nearest surfaces of each ray of a packet in the total order, while Embree reports candidates in any order.
// It does not depend on Embree. t is in Embree's scale of the ray, a power of two times ours. Each packet belongs to
// one thread.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "rt/embree/recompute.h"

namespace sideray::rt {

// Embree's float distance may differ from ours by this share of it, plus Lane::margin.
inline constexpr float relative_margin = 5e-5f;

struct Candidate {
  float t;
  uint32_t instance, primitive;
};

// Holds one ray's state. Candidates are sorted by t as soon as there is more than one.
struct Lane {
  static constexpr uint32_t spare = 15;  // candidates behind the last layer, within rounding of it

  const Ray* ray;
  Hit* hits;  // has room for LayerRules::kept
  uint32_t hit_count;
  uint32_t candidate_count;
  bool lossy;              // a candidate that might have counted was rejected
  float limit;             // no candidate farther than this t counts
  float margin;            // absolute part of t's rounding margin
  float back;              // how far before the origin t starts
  float begin;             // a candidate up to this t may lie before the ray's start
  float distance_of_unit;  // our distance where t = 1

  float margin_at(float t) const { return margin + relative_margin * t; }
};

// Says which candidates count as surfaces, and how many are kept.
struct LayerRules {
  uint32_t layers;  // the number to find
  uint32_t kept;    // limit of the hits kept: the layers, and others within rounding of the last one
  bool cull;        // obey TraceInstance::culls
  AlphaCone cone;
};

// First pass: notes a candidate and narrows lane.limit by Embree's own distances. This is optimistic: the candidate may
// prove to be no surface, or a known one. Returns whether the limit was narrowed. Takes and stores scalars, because a
// struct that is stored in parts and loaded whole would stall the processor.
inline bool note_candidate(Lane& lane, Candidate* list, uint32_t layers, float t, uint32_t instance,
                           uint32_t primitive) {
  if (t > lane.limit) return false;
  if (layers == 1 && lane.candidate_count == 0) {  // the case of most traversals
    list->t = t, list->instance = instance, list->primitive = primitive;
    lane.candidate_count = 1;
    lane.limit = t + lane.margin_at(t);
    return true;
  }
  while (lane.candidate_count > layers && list[lane.candidate_count - 1].t > lane.limit) --lane.candidate_count;
  if (lane.candidate_count == layers + Lane::spare) {
    lane.lossy = true;
    --lane.candidate_count;
  }
  uint32_t i = lane.candidate_count++;
  for (; i > 0 && list[i - 1].t > t; --i) list[i] = list[i - 1];
  list[i].t = t, list[i].instance = instance, list[i].primitive = primitive;
  if (lane.candidate_count < layers) return false;
  const float last = list[layers - 1].t;
  const float limit = last + lane.margin_at(last);
  if (limit >= lane.limit) return false;
  lane.limit = limit;
  return true;
}

// Inserts `hit` into the lane's hits by the total order. Drops it if it is farther than the last one, or the same
// crossing as another.
void insert_hit(const TraceTable& table, const LayerRules& rules, Lane& lane, const Hit& hit);

// Exact pass: recomputes a candidate at once and inserts it if it counts. Returns whether the lane's limit was
// narrowed.
bool insert_candidate(const TraceTable& table, const LayerRules& rules, Lane& lane, const Candidate& candidate);

// Recomputes candidates of up to 16 rays side by side, with the arithmetic of recompute() in vectors.
struct CandidateBlock {
  static constexpr uint32_t size = 16;
  alignas(64) float origin[3][size], direction[3][size];  // as in Ray; unused lanes hold anything finite
  LocalPosition corners[3][size];
  alignas(64) double determinant[size], t[size], u[size], v[size];

  // Prefetches what place() reads.
  static void fetch(const TraceInstance& instance, uint32_t primitive) {
    const glm::uvec3 triangle = instance.triangles[primitive];
    for (int i = 0; i < 3; ++i) __builtin_prefetch(instance.positions + triangle[i]);
  }
  void place(uint32_t lane, const TraceInstance& instance, uint32_t primitive) {
    const glm::uvec3 triangle = instance.triangles[primitive];
    for (int i = 0; i < 3; ++i) corners[i][lane] = local_position(instance, triangle[i]);
  }
  void meet_planes();
};

// The lists of a packet's lanes, one behind the other.
struct CandidateLists {
  const Candidate* first;
  uint32_t stride;  // from one lane's list to the next
  const Candidate* of(uint32_t lane) const { return first + lane * stride; }
};

// Ends the first pass: recomputes the candidates of the lanes in `pending`. Returns the bits of the lanes that the first
// pass narrowed too far; their rays must be traced again with the exact pass. Candidates must have passed the alpha
// test. The block's origins and directions must be set.
uint32_t resolve_candidates(const TraceTable& table, const LayerRules& rules, std::span<Lane> lanes, uint32_t pending,
                            const CandidateLists& lists, CandidateBlock& block);

}  // namespace sideray::rt
