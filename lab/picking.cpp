#include "lab/picking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace sideray::lab {
namespace {

using Candidates = std::span<const Candidate>;
using Order = std::vector<size_t>;

constexpr double unknown = std::numeric_limits<double>::infinity();
// By how much the growth from a reduced frame to the whole may differ between candidates.
constexpr double growth_margin = 1.5;

double error_of(const Candidate& c) {
  return c.error.value_or(unknown);
}

template <typename Less>
Order sorted(Order order, const Less& less) {
  std::stable_sort(order.begin(), order.end(), less);
  return order;
}

Order by_small_time(Candidates all, Order order) {
  return sorted(std::move(order), [&](size_t a, size_t b) { return all[a].small_ms < all[b].small_ms; });
}

Order by_error(Candidates all, Order order) {
  return sorted(std::move(order), [&](size_t a, size_t b) {
    return std::pair(error_of(all[a]), all[a].small_ms) < std::pair(error_of(all[b]), all[b].small_ms);
  });
}

// What the candidate costs at least, told from its reduced frame and from how others grow.
double least_ms(Candidates all, size_t i) {
  if (all[i].ms) return *all[i].ms;
  double growth = unknown;
  for (const Candidate& c : all)
    if (c.ms && c.small_ms > 0) growth = std::min(growth, *c.ms / c.small_ms);
  return all[i].small_ms * (std::isinf(growth) ? 1.0 : std::max(growth / growth_margin, 1.0));
}

std::optional<size_t> cheapest_timed(Candidates all, const Order& order) {
  std::optional<size_t> best;
  for (const size_t i : order)
    if (all[i].ms && (!best || *all[i].ms < *all[*best].ms)) best = i;
  return best;
}

// The cheapest of these; timed where it is not yet told.
Pick cheapest(Candidates all, const Order& order) {
  const std::optional<size_t> best = cheapest_timed(all, order);
  for (const size_t i : by_small_time(all, order))
    if (!all[i].ms && (!best || least_ms(all, i) < *all[*best].ms)) return {PickStep::time, i};
  return {PickStep::picked, *best};
}

Pick most_accurate_within(Candidates all, const Order& order, double most_ms) {
  for (const size_t i : by_error(all, order)) {
    if (all[i].ms && *all[i].ms <= most_ms) return {PickStep::picked, i};
    if (!all[i].ms && least_ms(all, i) <= most_ms) return {PickStep::time, i};
  }
  const Pick nearest = cheapest(all, order);
  return {nearest.step == PickStep::time ? PickStep::time : PickStep::failed, nearest.candidate};
}

}  // namespace

Pick next_pick(Candidates candidates, const CostBounds& bounds) {
  Order order(candidates.size());
  std::iota(order.begin(), order.end(), size_t{0});
  if (!bounds.most_error) return most_accurate_within(candidates, order, bounds.most_ms.value_or(unknown));
  Order holding;
  for (const size_t i : order)
    if (error_of(candidates[i]) <= *bounds.most_error) holding.push_back(i);
  if (holding.empty()) {
    const size_t nearest = by_error(candidates, order).front();
    return {candidates[nearest].ms ? PickStep::failed : PickStep::time, nearest};
  }
  Pick pick = cheapest(candidates, holding);
  if (pick.step == PickStep::picked && bounds.most_ms && *candidates[pick.candidate].ms > *bounds.most_ms)
    pick.step = PickStep::failed;
  return pick;
}

}  // namespace sideray::lab
