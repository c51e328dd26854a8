// Which measurements nothing else beats in cost and error at once. Plain memory; any thread.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace sideray::lab {

// Smaller is better in both.
struct CostAndError {
  double cost = 0;
  std::optional<double> error;  // empty: could not be measured, never on the front
};

// A point is on the front where no other is at most as costly and at most as wrong, and better in one of the two.
std::vector<bool> pareto_front(std::span<const CostAndError> points);

}  // namespace sideray::lab
