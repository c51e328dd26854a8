#include "lab/prediction/picking.h"

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
// The growth from the reduced to the whole frame may differ by these factors between candidates of one kind, and of
// different kinds.
constexpr double margin_within_kind = 1.15, margin_across_kinds = 1.5;
// Errors up to this multiple of the least count as equal: the noise of references is greater.
constexpr double as_accurate = 1.02;
// The error of two changes together may be smaller than the sum of their errors by this factor.
constexpr double sum_margin = 1.1;

std::optional<size_t> find(Candidates all, size_t drawing, size_t shadows) {
  const auto at = std::find_if(all.begin(), all.end(),
                               [&](const Candidate& c) { return c.drawing == drawing && c.shadows == shadows; });
  if (at == all.end()) return {};
  return static_cast<size_t>(at - all.begin());
}

// Returns the two candidates that each make one of the two changes by which `c` differs from the first candidate. Empty
// where `c` makes only one.
std::optional<std::pair<size_t, size_t>> parts_of(Candidates all, const Candidate& c) {
  const Candidate& first = all.front();
  if (c.drawing == first.drawing || c.shadows == first.shadows) return {};
  const std::optional<size_t> drawn = find(all, c.drawing, first.shadows),
                              shadowed = find(all, first.drawing, c.shadows);
  if (!drawn || !shadowed) return {};
  return std::pair(*drawn, *shadowed);
}

// Holds all candidates with the known or expected measurements of their reduced frames.
class Costs {
 public:
  Costs(Candidates all, std::vector<Look> looks, const CostBounds& bounds)
      : all_(all), looks_(std::move(looks)), correction_(correction(all, bounds)) {}

  size_t size() const { return all_.size(); }
  bool is_timed(size_t i) const { return all_[i].ms.has_value(); }
  bool is_seen(size_t i) const { return all_[i].look.has_value(); }
  bool is_drawn(size_t i) const { return all_[i].drawn_ms.has_value(); }
  size_t corrections() const { return correction_.count; }
  // Returns the measured time, or else the predicted one times the correction.
  double ms(size_t i) const {
    return is_drawn(i) ? *all_[i].drawn_ms : all_[i].ms.value_or(unknown) * correction_.scale;
  }
  double small_ms(size_t i) const { return looks_[i].ms; }
  double error(size_t i) const { return looks_[i].error.value_or(unknown); }
  // Returns whether the candidate may hold the bound. Expected errors get a margin: the measured one may be smaller.
  bool may_hold(size_t i, double most_error) const { return error(i) <= most_error * (is_seen(i) ? 1.0 : sum_margin); }
  // Returns the least time that the whole frame may take, by the growth of other candidates.
  double least_ms(size_t i) const {
    if (is_timed(i)) return ms(i);
    double growth = unknown, growth_of_kind = unknown;
    for (size_t k = 0; k < size(); ++k) {
      if (!is_timed(k) || small_ms(k) <= 0) continue;
      const double ratio = ms(k) / small_ms(k);
      growth = std::min(growth, ratio);
      if (all_[k].kind == all_[i].kind) growth_of_kind = std::min(growth_of_kind, ratio);
    }
    if (std::isfinite(growth_of_kind)) return small_ms(i) * std::max(growth_of_kind / margin_within_kind, 1.0);
    return small_ms(i) * (std::isfinite(growth) ? std::max(growth / margin_across_kinds, 1.0) : 1.0);
  }
  // Returns the next measurement that the candidate needs before it can be picked.
  PickStep next(size_t i) const {
    return !is_seen(i) ? PickStep::look : !is_timed(i) ? PickStep::time : PickStep::picked;
  }

 private:
  Candidates all_;
  std::vector<Look> looks_;
  Correction correction_;
};

template <typename Less>
Order sorted(Order order, const Less& less) {
  std::stable_sort(order.begin(), order.end(), less);
  return order;
}

Order by_error(const Costs& costs, Order order) {
  return sorted(std::move(order), [&](size_t a, size_t b) { return costs.error(a) < costs.error(b); });
}

// Returns the cheapest candidate of `order`, or the next measurement that decides it.
Pick cheapest(const Costs& costs, const Order& order) {
  std::optional<size_t> best;
  for (const size_t i : order)
    if (costs.is_seen(i) && costs.is_timed(i) && (!best || costs.ms(i) < costs.ms(*best))) best = i;
  const Order rising = sorted(order, [&](size_t a, size_t b) { return costs.small_ms(a) < costs.small_ms(b); });
  for (const size_t i : rising)
    if (costs.next(i) != PickStep::picked && (!best || costs.least_ms(i) < costs.ms(*best))) return {costs.next(i), i};
  return {PickStep::picked, *best};
}

// Accepts a picked candidate only after its whole frame was measured to take at most `most_ms`.
Pick held(const Costs& costs, Pick pick, double most_ms) {
  if (pick.step != PickStep::picked) return pick;
  if (costs.ms(pick.candidate) > most_ms || costs.corrections() > most_corrections)
    return {PickStep::failed, pick.candidate};
  return costs.is_drawn(pick.candidate) ? pick : Pick{PickStep::draw, pick.candidate};
}

// Returns the cheapest of the candidates within `most_ms` that are as accurate as the most accurate of them.
Pick most_accurate_within(const Costs& costs, const Order& order, double most_ms) {
  if (costs.corrections() >= most_corrections) return held(costs, cheapest(costs, order), most_ms);
  Order holding;
  for (const size_t i : by_error(costs, order))
    if (costs.least_ms(i) <= most_ms) holding.push_back(i);
  if (holding.empty()) return held(costs, cheapest(costs, order), most_ms);
  if (!costs.is_seen(holding.front())) return {PickStep::look, holding.front()};
  const double most_error = costs.error(holding.front()) * as_accurate;
  std::erase_if(holding, [&](size_t i) { return costs.error(i) > most_error; });
  return held(costs, cheapest(costs, holding), most_ms);
}

Pick cheapest_within(const Costs& costs, const Order& order, const CostBounds& bounds) {
  Order holding;
  for (const size_t i : order)
    if (costs.may_hold(i, *bounds.most_error)) holding.push_back(i);
  if (holding.empty()) {
    const size_t nearest = by_error(costs, order).front();
    const PickStep step = costs.next(nearest);
    return {step == PickStep::picked ? PickStep::failed : step, nearest};
  }
  const Pick pick = cheapest(costs, holding);
  return bounds.most_ms ? held(costs, pick, *bounds.most_ms) : pick;
}

}  // namespace

Correction correction(Candidates all, const CostBounds& bounds) {
  Correction result;
  for (const Candidate& c : all) {
    if (!c.drawn_ms || !c.ms || !bounds.most_ms || *c.drawn_ms <= *bounds.most_ms) continue;
    ++result.count;
    if (*c.ms > 0) result.scale = std::max(result.scale, *c.drawn_ms / *c.ms);
  }
  return result;
}

std::optional<Look> expected_look(Candidates all, size_t candidate) {
  const Candidate& c = all[candidate];
  if (c.look) return c.look;
  const auto parts = parts_of(all, c);
  if (!parts) return {};
  const std::optional<Look>&first = all.front().look, &drawn = all[parts->first].look,
        &shadowed = all[parts->second].look;
  if (!first || !drawn || !shadowed) return {};
  Look sum{std::max(drawn->ms + shadowed->ms - first->ms, 0.0), {}};
  if (first->error && drawn->error && shadowed->error)
    sum.error = std::max(*drawn->error + *shadowed->error - *first->error, 0.0);
  return sum;
}

Pick next_pick(Candidates candidates, const CostBounds& bounds) {
  // Only picked candidates have their whole frame drawn, so the first that holds the bound ends the search.
  for (size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].drawn_ms && bounds.most_ms && *candidates[i].drawn_ms <= *bounds.most_ms)
      return {PickStep::picked, i};
  std::vector<Look> looks;
  for (size_t i = 0; i < candidates.size(); ++i)
    if (!candidates[i].look && !parts_of(candidates, candidates[i])) return {PickStep::look, i};
  for (size_t i = 0; i < candidates.size(); ++i) looks.push_back(*expected_look(candidates, i));
  const Costs costs(candidates, std::move(looks), bounds);
  Order order(candidates.size());
  std::iota(order.begin(), order.end(), size_t{0});
  if (bounds.most_error) return cheapest_within(costs, order, bounds);
  return most_accurate_within(costs, order, bounds.most_ms.value_or(unknown));
}

}  // namespace sideray::lab
