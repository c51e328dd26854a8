#include "rt/layers/layer_steps.h"

#include <sideray/diagnostics.h>

#include <algorithm>
#include <array>

namespace sideray::rt {
namespace {

// Pixels that request similar numbers of layers share a traversal. Requests above layers_in_round take further rounds.
constexpr std::array<uint32_t, 8> group_layers{1, 2, 3, 4, 6, 8, 16, most_layers_in_round};
constexpr uint32_t layers_in_round = 16;
// A further round starts before the last surface, by this share of its distance; the total order tells which surfaces
// are known.
constexpr double step_back = 1e-6;
// Is the epsilon of listing 50-1, which gives no value: the smallest share of the distance that leaves the surface
// behind.
constexpr double listing_epsilon = 1e-6;

uint32_t group_of(uint32_t layers) {
  const auto found = std::lower_bound(group_layers.begin(), group_layers.end(), layers);
  return found == group_layers.end() ? most_layers_in_round : *found;
}

}  // namespace

uint32_t layers_in_traversal(sideray_step policy, const LayerStep& step, uint32_t missing) {
  if (policy != SIDERAY_STEP_MULTIHIT) return group_of(step.known + 1);
  const uint32_t most = std::max(layers_in_round, step.known + 1);
  return group_of(missing < most ? std::min(step.known + missing, most) : most);
}

void step_on(sideray_step policy, std::span<const Hit> met, LayerStep& step, Ray& ray) {
  const double distance = step.last.distance;
  if (policy == SIDERAY_STEP_LISTING) {
    // As printed in the listing, the distance is added although it is measured from the eye.
    step.listing_start += static_cast<float>(distance * (1.0 + listing_epsilon));
    ray.t_near = std::max(ray.t_near, step.listing_start);
    return;
  }
  ray.t_near = std::max(ray.t_near, static_cast<float>(distance * (1.0 - step_back)));
  step.known = static_cast<uint32_t>(std::count_if(
      met.begin(), met.end(), [&](const Hit& hit) { return static_cast<float>(hit.distance) >= ray.t_near; }));
}

}  // namespace sideray::rt
