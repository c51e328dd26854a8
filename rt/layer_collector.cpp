#include "rt/layer_collector.h"

namespace sideray::rt {
namespace {

// Is the candidate a surface as the rasterizer would show it, between the ray's ends?
bool make_hit(const TraceTable& table, const LayerRules& rules, const Ray& ray, const Candidate& candidate, Hit& hit) {
  const TraceInstance& instance = table.instances[candidate.instance];
  return recompute(instance, candidate.instance, candidate.primitive, ray, hit) &&
         (hit.front || !(rules.cull && instance.culls));
}

double distance_margin(const Lane& lane, double distance) {
  const auto t_of_unit = static_cast<double>(lane.t_of_unit);
  return static_cast<double>(lane.margin) / t_of_unit + static_cast<double>(relative_margin) * distance;
}

// Whether hits[hit_count], just written, is simply the next one: behind the others, and none of their crossings.
bool is_next(const TraceTable& table, const Lane& lane) {
  if (lane.hit_count == 0) return true;
  const Hit& hit = lane.hits[lane.hit_count];
  if (!nearer(table, lane.hits[lane.hit_count - 1], hit)) return false;
  const double margin = distance_margin(lane, hit.distance);
  for (uint32_t i = 0; i < lane.hit_count; ++i)
    if (same_crossing(table, *lane.ray, lane.hits[i], hit, margin)) return false;
  return true;
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
  if (end == rules.layers) {
    if (!nearer(table, hit, lane.hits[end - 1])) return;
    --end;
  }
  uint32_t i = end;
  for (; i > 0 && nearer(table, hit, lane.hits[i - 1]); --i) lane.hits[i] = lane.hits[i - 1];
  lane.hits[i] = hit;
  lane.hit_count = end + 1;
}

bool insert_candidate(const TraceTable& table, const LayerRules& rules, Lane& lane, const Candidate& candidate) {
  Hit hit;
  if (!make_hit(table, rules, *lane.ray, candidate, hit)) return false;
  const TraceInstance& instance = table.instances[hit.instance];
  if (instance.discards && alpha_discards(*table.snapshot, instance, hit.primitive, hit.u, hit.v)) return false;
  insert_hit(table, rules, lane, hit);
  if (lane.hit_count < rules.layers) return false;
  const float last = static_cast<float>(lane.hits[rules.layers - 1].distance) * lane.t_of_unit;
  const float limit = last + lane.margin_at(last);
  if (limit >= lane.limit) return false;
  lane.limit = limit;
  return true;
}

bool resolve_candidates(const TraceTable& table, const LayerRules& rules, Lane& lane, const Candidate* list) {
  for (uint32_t i = 0; i < lane.candidate_count; ++i) {
    if (list[i].t > lane.limit) break;
    // In place, because Embree's order is nearly always ours.
    Hit beyond;
    Hit& hit = lane.hit_count < rules.layers ? lane.hits[lane.hit_count] : beyond;
    if (!make_hit(table, rules, *lane.ray, list[i], hit)) continue;
    if (&hit != &beyond && is_next(table, lane))
      ++lane.hit_count;
    else
      insert_hit(table, rules, lane, Hit(hit));
  }
  if (lane.lossy) return false;
  if (lane.limit == std::numeric_limits<float>::infinity()) return true;
  if (lane.hit_count < rules.layers) return false;
  // Everything farther than the limit was turned away; it may be nearer than it said by half the margin.
  const float last = static_cast<float>(lane.hits[rules.layers - 1].distance) * lane.t_of_unit;
  return last + 0.5f * lane.margin_at(last) <= lane.limit;
}

}  // namespace sideray::rt
