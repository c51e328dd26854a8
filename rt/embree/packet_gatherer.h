// Finds the surfaces of rays by Embree's packets: the nearest ones, or all in one traversal. Hits near edges, where
// Embree's kernels differ, are decided in double precision. Only intersector.cpp uses it. Each object belongs to one
// thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rt/embree/packet_tracer.h"

namespace sideray::rt {

// Notes all triangles that Embree reports for the rays of a packet.
struct NamedQuery : embree::Query {
  std::vector<NamedTriangle> named;
};

template <unsigned N>
void named_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<NamedQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    query.named.push_back({packet.instance(i), packet.primitive(i)});
    return false;
  });
}

// Traces rays again that hit something near an edge, where Embree's kernels differ, and decides in double precision. A
// few rays in a thousand need it.
template <unsigned N>
class EdgeTracer {
 public:
  explicit EdgeTracer(const MaskedInstances& among) : table_(among.table), top_(among.top), packet_(among.mask) {}

  // Returns the first rules.kept surfaces, valid until the next call. `offset`: as edge_offset() gives it.
  std::span<const Hit> trace(const Ray& ray, double offset, const LayerRules& rules) {
    const RayBundle rays = rays_beside(ray, offset);
    query_.named.clear();
    Lane lane{};
    lane.ray = &ray;
    lane.hits = kept_.data();
    for (size_t first = 0; first < rays.size(); first += N) {
      const auto part = std::span(rays).subspan(first, std::min<size_t>(N, rays.size() - first));
      const uint32_t traced = packet_.set(part, (1u << part.size()) - 1u, top_, true);
      if (first == 0) lane.margin = packet_.margin[0], lane.distance_of_unit = packet_.distance_of_unit[0];
      if (traced != 0) packet_.occluded(top_.scene.get(), query_, false, named_filter<N>);
    }
    std::sort(query_.named.begin(), query_.named.end());
    query_.named.erase(std::unique(query_.named.begin(), query_.named.end()), query_.named.end());
    decide_near_edges(table_, rays, offset, query_.named, hits_);
    for (const Hit& hit : hits_) {
      const TraceInstance& instance = table_.instances[hit.instance];
      if (!hit.front && rules.cull && instance.culls) continue;
      if (instance.discards && alpha_discards(*table_.snapshot, instance, ray, hit, rules.cone)) continue;
      insert_hit(table_, rules, lane, hit);
    }
    return {lane.hits, lane.hit_count};
  }

 private:
  const TraceTable& table_;
  const TopLevel& top_;
  RayPacket<N> packet_;
  NamedQuery query_;
  std::vector<Hit> hits_;
  std::array<Hit, most_packet_layers> kept_;
};

// Finds the nearest surfaces of rays, with the same result for all of Embree's kernels. `known` is as in
// PacketTracer::trace().
template <unsigned N>
void trace_layers(const MaskedInstances& among, const LayerRules& rules, bool coherent, std::span<const Ray> rays,
                  const PacketHits& found, double* known = nullptr) {
  PacketTracer<N> tracer(among, rules, coherent);
  for (size_t first = 0; first < rays.size(); first += N)
    tracer.trace(rays.subspan(first, std::min<size_t>(N, rays.size() - first)), found.hits + first * rules.kept,
                 found.counts + first, known ? known + first : nullptr);
  std::optional<EdgeTracer<N>> edges;
  for (size_t i = 0; i < rays.size(); ++i) {
    Hit* const own = found.hits + i * rules.kept;
    uint32_t& count = found.counts[i];
    const double offset = edge_offset(among.table, rays[i], {own, count});
    if (offset == 0.0) continue;
    if (!edges) edges.emplace(among);
    const std::span<const Hit> decided = edges->trace(rays[i], offset, rules);
    std::copy(decided.begin(), decided.end(), own);
    count = static_cast<uint32_t>(decided.size());
    if (known) known[i] = count == rules.kept ? own[count - 1].distance : std::numeric_limits<double>::infinity();
  }
}

// Notes all hits of a packet's rays in any order, so that nothing is sorted during traversal.
struct GatherQuery : embree::Query {
  // Rays with more surfaces are rare.
  static constexpr uint32_t room = 32;
  struct Named {
    uint32_t instance, primitive;
  };

  const TraceTable* table = nullptr;
  std::span<const Ray> rays;  // those of the packet
  std::array<uint32_t, most_packet_lanes> counts;
  std::array<std::array<Named, room>, most_packet_lanes> named;
};

template <unsigned N>
void gather_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<GatherQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    const uint32_t id = packet.ray(i), instance = packet.instance(i), primitive = packet.primitive(i);
    if ((query.table->traits[instance] & TraceTable::trait_discards) &&
        discarded(*query.table, query.rays[id], packet.candidate(i), Cone{}))
      return false;
    uint32_t& count = query.counts[id];
    if (count < GatherQuery::room) query.named[id][count] = {instance, primitive};
    ++count;
    // Prefetches the triangle, which is read soon.
    __builtin_prefetch(query.table->instances[instance].triangles + primitive);
    return false;
  });
}

// Finds all surfaces of up to N rays at a time.
template <unsigned N>
class PacketGatherer {
 public:
  explicit PacketGatherer(const MaskedInstances& among)
      : among_(among), table_(among.table), packet_(among.mask) {
    query_.table = &table_;
  }

  // Appends the surfaces, ray by ray.
  void trace(std::span<const Ray> rays, RaySurfaces& surfaces) {
    const auto count = static_cast<uint32_t>(rays.size());
    query_.rays = rays;
    query_.counts.fill(0);
    if (packet_.set(rays, (1u << count) - 1u, among_.top, true) != 0)
      packet_.occluded(among_.top.scene.get(), query_, false, gather_filter<N>);
    sort();
    for (uint32_t i = 0; i < count; ++i) {
      append(i, surfaces.hits);
      surfaces.ends.push_back(static_cast<uint32_t>(surfaces.hits.size()));
    }
  }

 private:
  void append(uint32_t i, std::vector<Hit>& hits) {
    const Ray& ray = query_.rays[i];
    if (query_.counts[i] > GatherQuery::room) return append_nearest(ray, hits);
    std::span<const Hit> found{lanes_[i].hits, lanes_[i].hit_count};
    const double offset = (near_edges_ >> i & 1u) ? edge_offset(table_, ray, found) : 0.0;
    if (offset != 0.0) {
      if (!edges_) edges_.emplace(among_);
      found = edges_->trace(ray, offset, rules_of(most_packet_layers, false, {}));
    }
    hits.insert(hits.end(), found.begin(), found.end());
  }

  // Recomputes the noted hits in blocks of sixteen, which may mix rays, and sorts them by ray.
  void sort() {
    uint32_t filled = 0;
    near_edges_ = 0;
    for (uint32_t i = 0; i < query_.rays.size(); ++i) {
      lanes_[i] = {.ray = &query_.rays[i],
                   .hits = hits_[i].data(),
                   .hit_count = 0,
                   .candidate_count = 0,
                   .lossy = false,
                   .limit = 0.0f,
                   .margin = packet_.margin[i],
                   .back = 0.0f,
                   .begin = 0.0f,
                   .distance_of_unit = packet_.distance_of_unit[i]};
      const uint32_t found = query_.counts[i] <= GatherQuery::room ? query_.counts[i] : 0;
      for (uint32_t k = 0; k < found; ++k) {
        place(filled, i, query_.named[i][k]);
        if (++filled == CandidateBlock::size) finish(std::exchange(filled, 0));
      }
    }
    if (filled > 0) finish(filled);
  }

  void place(uint32_t slot, uint32_t lane, const GatherQuery::Named& named) {
    const Ray& ray = query_.rays[lane];
    for (int c = 0; c < 3; ++c) {
      block_.origin[c][slot] = ray.origin[c];
      block_.direction[c][slot] = ray.direction[c];
    }
    block_.place(slot, table_.instances[named.instance], named.primitive);
    lane_of_[slot] = lane;
    placed_[slot] = named;
  }

  void finish(uint32_t filled) {
    block_.meet_planes();
    constexpr LayerRules rules{.layers = GatherQuery::room, .kept = GatherQuery::room, .cull = false, .cone = {}};
    for (uint32_t k = 0; k < filled; ++k) {
      const GatherQuery::Named& named = placed_[k];
      Lane& lane = lanes_[lane_of_[k]];
      const PlaneHit plane{block_.determinant[k], block_.t[k], block_.u[k], block_.v[k]};
      const TraceInstance& instance = table_.instances[named.instance];
      Hit hit;
      if (!finish_hit(instance, named.instance, named.primitive, *lane.ray, plane, hit)) continue;
      const auto& [a, b, c] = block_.corners;
      const bool clear = std::min({hit.u, hit.v, 1.0f - hit.u - hit.v}) >= edge_weight ||
                         is_clear_of_edges(instance, {a[k], b[k], c[k]}, *lane.ray, plane);
      near_edges_ |= static_cast<uint32_t>(!clear) << lane_of_[k];
      insert_hit(table_, rules, lane, hit);
    }
  }

  void append_nearest(const Ray& ray, std::vector<Hit>& found) const {
    std::array<Hit, most_packet_layers> hits;
    uint32_t count = 0;
    trace_layers<N>(among_, rules_of(most_packet_layers, false, {}), false, {&ray, 1}, {hits.data(), &count});
    found.insert(found.end(), hits.begin(), hits.begin() + count);
  }

  MaskedInstances among_;
  const TraceTable& table_;
  RayPacket<N> packet_;
  GatherQuery query_;
  CandidateBlock block_{};
  std::array<uint32_t, CandidateBlock::size> lane_of_{};
  std::array<GatherQuery::Named, CandidateBlock::size> placed_{};
  std::array<Lane, most_packet_lanes> lanes_;
  std::array<std::array<Hit, GatherQuery::room>, most_packet_lanes> hits_;
  uint32_t near_edges_ = 0;  // rays, as bits, with a hit that may lie near an edge
  std::optional<EdgeTracer<N>> edges_;
};

template <unsigned N>
void gather_layers(const MaskedInstances& among, std::span<const Ray> rays, RaySurfaces& surfaces) {
  PacketGatherer<N> gatherer(among);
  for (size_t first = 0; first < rays.size(); first += N)
    gatherer.trace(rays.subspan(first, std::min<size_t>(N, rays.size() - first)), surfaces);
}

}  // namespace sideray::rt
