// Finds the nearest surfaces of the rays of one of Embree's packets: has the filters that note candidates during
// traversal, and turns candidates into hits. Only intersector.cpp and packet_gatherer.h use it. A tracer belongs to one
// thread.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>

#include "rt/embree/alpha_test.h"
#include "rt/embree/filter_packet.h"
#include "rt/embree/layer_collector.h"
#include "rt/embree/nearest_collector.h"
#include "rt/embree/ray_batch.h"
#include "rt/embree/ray_packet.h"
#include "rt/embree/recompute.h"
#include "rt/embree/top_level.h"
#include "rt/embree/trace_table.h"

namespace sideray::rt {

inline constexpr uint32_t most_packet_lanes = 16, most_packet_layers = 64;

inline LayerRules rules_of(uint32_t layers, bool cull, const AlphaCone& cone) {
  layers = std::min(layers, most_packet_layers);
  return {.layers = layers, .kept = layers, .cull = cull, .cone = cone};
}

// Selects by a mask the instances of an acceleration structure that packets are traced through.
struct MaskedInstances {
  const TraceTable& table;
  const TopLevel& top;
  uint32_t mask;
};

struct LayerQuery : embree::Query {
  const TraceTable* table = nullptr;
  LayerRules rules{};
  std::array<Lane, most_packet_lanes> lanes;
  std::array<Candidate, most_packet_lanes*(most_packet_layers + Lane::spare)> candidates;

  uint32_t stride() const { return rules.layers + Lane::spare; }
  Candidate* list(uint32_t lane) { return candidates.data() + lane * stride(); }
  CandidateLists lists() const { return {candidates.data(), stride()}; }

  std::span<const Ray> rays;  // those of the packet
  Hit* hits = nullptr;
  // One layer is kept in `nearest`, and in the lists for lanes whose bit is in `listed`.
  NearestBlock nearest{};
  uint32_t listed = 0;

  // Makes a lane empty.
  void start_lane(uint32_t i) {
    Lane& lane = lanes[i];
    lane.ray = &rays[i];
    lane.hits = hits + size_t{i} * rules.kept;
    lane.hit_count = lane.candidate_count = 0;
    lane.lossy = false;
    lane.limit = std::numeric_limits<float>::infinity();
    lane.margin = nearest.margin[i];
    lane.back = nearest.back[i];
    lane.begin = nearest.begin[i];
    lane.distance_of_unit = nearest.distance_of_unit[i];
  }
};

inline bool discarded(const TraceTable& table, const Ray& ray, const Candidate& candidate, const AlphaCone& cone) {
  const TraceInstance& instance = table.instances[candidate.instance];
  Hit hit;
  return !recompute(instance, candidate.instance, candidate.primitive, ray, hit) ||
         alpha_discards(*table.snapshot, instance, ray, hit, cone);
}

// Returns whether a candidate near its ray's start lies before it, and so does not count. It is mostly the surface that
// the ray starts on. On the list it would displace a candidate that counts, and the ray would have to be traced again.
inline bool lies_before(const TraceTable& table, const Ray& ray, float begin, const Candidate& candidate) {
  if (candidate.t > begin) return false;
  Hit hit;
  return !recompute(table.instances[candidate.instance], candidate.instance, candidate.primitive, ray, hit);
}

template <unsigned N>
void first_pass_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    const uint32_t id = packet.ray(i), instance = packet.instance(i);
    Lane& lane = query.lanes[id];
    const uint8_t traits = query.table->traits[instance];
    if ((traits & TraceTable::trait_culls) && query.rules.cull && packet.surely_back(i)) return false;
    if ((traits & TraceTable::trait_discards) &&
        discarded(*query.table, *lane.ray, packet.candidate(i), query.rules.cone))
      return false;
    if (lies_before(*query.table, *lane.ray, lane.begin, packet.candidate(i))) return false;
    if (!note_candidate(lane, query.list(id), query.rules.layers, packet.t_far(i), instance, packet.primitive(i)))
      return false;
    packet.t_far(i) = lane.limit;
    // The hit is recomputed soon, from the triangle's vertices.
    __builtin_prefetch(query.table->instances[instance].triangles + packet.primitive(i));
    return true;
  });
}

// Puts a candidate that is within rounding of the lane's other candidates on the lane's list. Returns whether that
// narrowed the lane's limit.
inline bool note_on_list(LayerQuery& query, uint32_t i, const Candidate& candidate) {
  NearestBlock& nearest = query.nearest;
  Lane& lane = query.lanes[i];
  if (!(query.listed >> i & 1u)) {
    query.listed |= 1u << i;
    query.start_lane(i);
    constexpr float infinity = std::numeric_limits<float>::infinity();
    if (nearest.t[i] < infinity)  // false only for a first candidate so far away that its limit overflows
      note_candidate(lane, query.list(i), 1, nearest.t[i], nearest.instance[i], nearest.primitive[i]);
    nearest.t[i] = -infinity;
  }
  if (!note_candidate(lane, query.list(i), 1, candidate.t, candidate.instance, candidate.primitive)) return false;
  nearest.limit[i] = lane.limit;
  return true;
}

// Does the work of first_pass_filter if one layer is wanted.
template <unsigned N>
void nearest_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  const TraceTable& table = *query.table;
  if (table.all_traits != 0)
    for_each_hit<N>(*arguments, [&](const FilterPacket<N>& packet, uint32_t i) {
      const uint8_t traits = table.traits[packet.instance(i)];
      if ((traits & TraceTable::trait_culls) && query.rules.cull && packet.surely_back(i)) return false;
      return !(traits & TraceTable::trait_discards) ||
             !discarded(table, query.rays[i], packet.candidate(i), query.rules.cone);
    });
  const NamedHits named{arguments->valid, &RTCRayN_tfar(arguments->ray, N, 0), &RTCHitN_instID(arguments->hit, N, 0, 0),
                        &RTCHitN_primID(arguments->hit, N, 0)};
  if (!query.nearest.note(named, N)) return;
  const FilterPacket<N> packet{*arguments};
  for (uint32_t i = 0; i < N; ++i) {
    if (!query.nearest.close[i]) continue;
    const Candidate candidate = packet.candidate(i);
    if (lies_before(table, query.rays[i], query.nearest.begin[i], candidate) || !note_on_list(query, i, candidate))
      continue;
    packet.valid(i) = -1;
    packet.t_far(i) = query.lanes[i].limit;
  }
}

template <unsigned N>
void exact_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    Lane& lane = query.lanes[packet.ray(i)];
    if (!insert_candidate(*query.table, query.rules, lane, packet.candidate(i))) return false;
    packet.t_far(i) = lane.limit;
    return true;
  });
}

// Finds the nearest surfaces of up to N rays at a time.
template <unsigned N>
class PacketTracer {
 public:
  PacketTracer(const MaskedInstances& among, LayerRules rules, bool coherent)
      : table_(among.table), top_(among.top), all_coherent_(coherent), packet_(among.mask) {
    query_.table = &table_;
    query_.rules = rules;
  }

  // `known`, if not null, receives the distance up to which the hits of each ray are complete. Hits behind it are
  // dropped, except the first.
  void trace(std::span<const Ray> rays, Hit* hits, uint32_t* counts, double* known = nullptr) {
    const auto count = static_cast<uint32_t>(rays.size());
    query_.rays = rays;
    query_.hits = hits;
    // The rays of one packet often share a direction even if the whole batch does not.
    coherent_ = all_coherent_ || directions_agree(rays);
    const uint32_t wanted = (1u << count) - 1u;
    const uint32_t again = query_.rules.layers == 1 ? trace_nearest(wanted, counts) : trace_first(wanted, counts);
    if (known) cut_to_known(wanted & ~again, query_.listed, counts, known);
    if (again == 0) return;
    set(again);
    start_lanes(again);
    packet_.intersect(top_.scene.get(), query_, false, exact_filter<N>);
    take_counts(again, counts);
    if (known) cut_to_known(again, again, counts, known);
  }

 private:
  // Runs the first passes. Returns the bits of the lanes that need the exact pass.
  uint32_t trace_first(uint32_t wanted, uint32_t* counts) {
    const bool any = set(wanted);
    start_lanes(wanted);
    uint32_t again = 0;
    if (any) {
      packet_.intersect(top_.scene.get(), query_, coherent_, first_pass_filter<N>);
      packet_.copy_rays(block_);
      again = resolve_lists(wanted);
    }
    take_counts(wanted, counts);
    return again;
  }

  uint32_t trace_nearest(uint32_t wanted, uint32_t* counts) {
    std::fill_n(counts, query_.rays.size(), 0u);
    if (!set(wanted)) return 0;
    query_.nearest.clear();
    query_.listed = 0;
    packet_.intersect(top_.scene.get(), query_, coherent_, nearest_filter<N>);
    packet_.copy_rays(block_);
    uint32_t again = resolve_nearest(table_, query_.rules, query_.rays, query_.nearest, block_, {query_.hits, counts});
    if (query_.listed != 0) {
      again |= resolve_lists(query_.listed);
      take_counts(query_.listed, counts);
    }
    return again;
  }

  uint32_t resolve_lists(uint32_t lanes) {
    return resolve_candidates(table_, query_.rules, query_.lanes, lanes, query_.lists(), block_);
  }

  // Sets up the lanes whose bit is wanted and clears the others; returns false if no ray is left to trace.
  bool set(uint32_t wanted) {
    const uint32_t traced = packet_.set(query_.rays, wanted, top_, true);
    std::copy_n(packet_.margin.begin(), N, query_.nearest.margin);
    std::copy_n(packet_.back.begin(), N, query_.nearest.back);
    std::copy_n(packet_.begin.begin(), N, query_.nearest.begin);
    std::copy_n(packet_.distance_of_unit.begin(), N, query_.nearest.distance_of_unit);
    return traced != 0;
  }

  void start_lanes(uint32_t lanes) {
    for (; lanes != 0; lanes &= lanes - 1) query_.start_lane(static_cast<uint32_t>(std::countr_zero(lanes)));
  }

  void take_counts(uint32_t lanes, uint32_t* counts) const {
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
      counts[i] = query_.lanes[i].hit_count;
    }
  }

  void cut_to_known(uint32_t lanes, uint32_t listed, uint32_t* counts, double* known) const {
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
      known[i] = cut_to_known(i, (listed >> i & 1u) ? query_.lanes[i].limit : query_.nearest.limit[i], counts[i]);
    }
  }

  // Returns the distance up to which a lane's hits are complete, and drops the hits behind it, except the first.
  double cut_to_known(uint32_t i, float limit, uint32_t& count) const {
    if (count == 0) return std::numeric_limits<double>::infinity();
    // A hit that was rejected, beyond the limit, may be nearer than Embree said by half the margin.
    const float sure = limit - 0.5f * (query_.nearest.margin[i] + relative_margin * limit) - query_.nearest.back[i];
    const Hit* hits = query_.hits + size_t{i} * query_.rules.kept;
    double known = static_cast<double>(sure) * static_cast<double>(query_.nearest.distance_of_unit[i]);
    if (count == query_.rules.kept) known = std::min(known, hits[count - 1].distance);
    known = std::max(known, hits[0].distance);
    while (hits[count - 1].distance > known) --count;
    return known;
  }

  const TraceTable& table_;
  const TopLevel& top_;
  bool all_coherent_, coherent_ = false;  // of all packets, of this one
  RayPacket<N> packet_;
  LayerQuery query_;
  CandidateBlock block_{};
};

}  // namespace sideray::rt
