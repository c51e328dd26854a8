// Advances a ray behind the surfaces that it has hit, by the policies of sideray_step. Pure functions; any thread may
// call them.
#pragma once

#include <sideray/sideray.h>

#include <cstdint>
#include <span>

#include "rt/embree/intersector.h"

namespace sideray::rt {

inline constexpr uint32_t most_layers_in_round = 64;

struct LayerStep {
  Hit last;                    // no_instance: nothing hit yet
  uint32_t known = 0;          // known surfaces that the next traversal hits first
  float listing_start = 0.0f;  // Ray.MinT of listing 50-1
};

// Returns how many surfaces the next traversal looks for, known ones included, to find `missing` more.
uint32_t layers_in_traversal(sideray_step policy, const LayerStep& step, uint32_t missing);

// Returns the most new surfaces that one traversal may add.
inline uint32_t new_layers_in_traversal(sideray_step policy) {
  return policy == SIDERAY_STEP_MULTIHIT ? most_layers_in_round : 1;
}

// Advances the start of the ray. `met` holds the hits of the last traversal, up to step.last.
void step_on(sideray_step policy, std::span<const Hit> met, LayerStep& step, Ray& ray);

}  // namespace sideray::rt
