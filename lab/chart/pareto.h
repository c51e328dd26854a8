// Finds the measurements that no other beats in cost and error at once. Plain memory; any thread.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace sideray::lab {

// Smaller is better in both.
struct CostAndError {
  double cost = 0;
  std::optional<double> error;  // empty: not measurable, never on the front
};

// Returns which points are on the front: no other point is at least as good in both values and better in one.
std::vector<bool> pareto_front(std::span<const CostAndError> points);

}  // namespace sideray::lab
