#include "lab/chart/pareto.h"

#include <algorithm>

namespace sideray::lab {
namespace {

bool beats(const CostAndError& a, const CostAndError& b) {
  if (!a.error) return false;
  return a.cost <= b.cost && *a.error <= *b.error && (a.cost < b.cost || *a.error < *b.error);
}

}  // namespace

std::vector<bool> pareto_front(std::span<const CostAndError> points) {
  std::vector<bool> front;
  for (const CostAndError& point : points)
    front.push_back(point.error && std::none_of(points.begin(), points.end(),
                                                [&](const CostAndError& other) { return beats(other, point); }));
  return front;
}

}  // namespace sideray::lab
