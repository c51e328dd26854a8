// Finds the measurements that no other beats in both cost and error. Plain memory; any thread.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace sideray::lab {

// Smaller is better for both.
struct CostAndError {
  double cost = 0;
  std::optional<double> error;  // empty: not measurable; then never on the front
};

// A point is on the front if no other is at most as costly and at most as wrong, and better in one of the two.
std::vector<bool> pareto_front(std::span<const CostAndError> points);

}  // namespace sideray::lab
