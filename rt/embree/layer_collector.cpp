#include "rt/embree/layer_collector.h"

#include <bit>

#include "rt/base/vectors.h"
#include "rt/embree/alpha_test.h"

namespace sideray::rt {
namespace {

double distance_margin(const Lane& lane, double distance) {
  return static_cast<double>(lane.margin) * static_cast<double>(lane.distance_of_unit) +
         static_cast<double>(relative_margin) * distance;
}

// Returns whether hits[hit_count], just written, can stay there: it lies behind all others and is no crossing of
// theirs.
bool is_next(const TraceTable& table, const Lane& lane) {
  if (lane.hit_count == 0) return true;
  const Hit& hit = lane.hits[lane.hit_count];
  if (!nearer(table, lane.hits[lane.hit_count - 1], hit)) return false;
  const double margin = distance_margin(lane, hit.distance);
  for (uint32_t i = 0; i < lane.hit_count; ++i)
    if (same_crossing(table, *lane.ray, lane.hits[i], hit, margin)) return false;
  return true;
}

void resolve(const TraceTable& table, const LayerRules& rules, Lane& lane, const Candidate& candidate,
             const PlaneHit& plane) {
  const TraceInstance& instance = table.instances[candidate.instance];
  // Tries the end of the list first, because Embree's order is nearly always ours.
  Hit beyond;
  const bool room = lane.hit_count < rules.kept;
  Hit& hit = room ? lane.hits[lane.hit_count] : beyond;
  if (!finish_hit(instance, candidate.instance, candidate.primitive, *lane.ray, plane, hit)) return;
  if (!hit.front && rules.cull && instance.culls) return;
  if (room && is_next(table, lane))
    ++lane.hit_count;
  else
    insert_hit(table, rules, lane, Hit(hit));
}

bool is_complete(const LayerRules& rules, const Lane& lane) {
  if (lane.lossy) return false;
  if (lane.limit == std::numeric_limits<float>::infinity()) return true;
  if (lane.hit_count < rules.layers) return false;
  // Hits beyond the limit were rejected, but may be nearer than Embree said by half the margin.
  const float last = static_cast<float>(lane.hits[rules.layers - 1].distance) / lane.distance_of_unit + lane.back;
  return last + 0.5f * lane.margin_at(last) <= lane.limit;
}

}  // namespace

void insert_hit(const TraceTable& table, const LayerRules& rules, Lane& lane, const Hit& hit) {
  const double margin = distance_margin(lane, hit.distance);
  uint32_t end = lane.hit_count;
  for (uint32_t i = 0; i < lane.hit_count; ++i) {
    if (!same_crossing(table, *lane.ray, lane.hits[i], hit, margin)) continue;
    if (!nearer(table, hit, lane.hits[i])) return;
    for (uint32_t k = i + 1; k < lane.hit_count; ++k) lane.hits[k - 1] = lane.hits[k];
    end = lane.hit_count - 1;
    lane.hit_count = end;
    break;
  }
  if (end == rules.kept) {
    if (!nearer(table, hit, lane.hits[end - 1])) return;
    --end;
  }
  uint32_t i = end;
  for (; i > 0 && nearer(table, hit, lane.hits[i - 1]); --i) lane.hits[i] = lane.hits[i - 1];
  lane.hits[i] = hit;
  lane.hit_count = end + 1;
}

bool insert_candidate(const TraceTable& table, const LayerRules& rules, Lane& lane, const Candidate& candidate) {
  const TraceInstance& instance = table.instances[candidate.instance];
  Hit hit;
  if (!recompute(instance, candidate.instance, candidate.primitive, *lane.ray, hit)) return false;
  if (!hit.front && rules.cull && instance.culls) return false;
  if (instance.discards && alpha_discards(*table.snapshot, instance, *lane.ray, hit, rules.cone)) return false;
  insert_hit(table, rules, lane, hit);
  if (lane.hit_count < rules.layers) return false;
  const float last = static_cast<float>(lane.hits[rules.layers - 1].distance) / lane.distance_of_unit + lane.back;
  const float limit = last + lane.margin_at(last);
  if (limit >= lane.limit) return false;
  lane.limit = limit;
  return true;
}

SIDERAY_VECTORS void CandidateBlock::meet_planes() {
  const auto at = [](const float(&rows)[3][size], uint32_t i) {
    return Double3{static_cast<double>(rows[0][i]), static_cast<double>(rows[1][i]), static_cast<double>(rows[2][i])};
  };
  const auto corner = [this](int k, uint32_t i) {
    const LocalPosition& p = corners[k][i];
    return Double3{static_cast<double>(p.x[0]), static_cast<double>(p.x[1]), static_cast<double>(p.x[2])};
  };
  for (uint32_t i = 0; i < size; ++i) {
    const PlaneHit hit = meet_plane(at(origin, i), at(direction, i), corner(0, i), corner(1, i), corner(2, i));
    determinant[i] = hit.determinant, t[i] = hit.t, u[i] = hit.u, v[i] = hit.v;
  }
}

uint32_t resolve_candidates(const TraceTable& table, const LayerRules& rules, std::span<Lane> lanes, uint32_t pending,
                            const CandidateLists& lists, CandidateBlock& block) {
  uint32_t wrong = 0;
  for (uint32_t bits = pending; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(bits));
    if (lanes[i].candidate_count == 0) pending &= ~(1u << i);
  }
  for (uint32_t rank = 0; pending != 0; ++rank) {
    for (uint32_t bits = pending; bits != 0; bits &= bits - 1) {
      const Candidate& candidate = lists.of(static_cast<uint32_t>(std::countr_zero(bits)))[rank];
      CandidateBlock::fetch(table.instances[candidate.instance], candidate.primitive);
    }
    for (uint32_t bits = pending; bits != 0; bits &= bits - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(bits));
      const Candidate& candidate = lists.of(i)[rank];
      block.place(i, table.instances[candidate.instance], candidate.primitive);
    }
    block.meet_planes();
    for (uint32_t bits = pending; bits != 0; bits &= bits - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(bits));
      const Candidate* list = lists.of(i);
      const double t = block.t[i] * static_cast<double>(lanes[i].distance_of_unit);
      resolve(table, rules, lanes[i], list[rank], {block.determinant[i], t, block.u[i], block.v[i]});
      if (rank + 1 < lanes[i].candidate_count && list[rank + 1].t <= lanes[i].limit) continue;
      pending &= ~(1u << i);
      wrong |= static_cast<uint32_t>(!is_complete(rules, lanes[i])) << i;
    }
  }
  return wrong;
}

}  // namespace sideray::rt
