// Matches objects between two scenes. Plain memory; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lab/golden/changes.h"

namespace sideray::lab {

constexpr size_t no_object = SIZE_MAX;

// Returns for each pixel the index of its object; no_object: the background, or a surface that belongs to no object.
std::vector<size_t> shown_objects(const ShownPicture& shown);

// Returns for each object of `now` its index in `reference`, or no_object. `now_shown` and `reference_shown` have one
// entry a pixel.
std::vector<size_t> paired_objects(const std::vector<NamedObject>& now, std::span<const size_t> now_shown,
                                   const std::vector<NamedObject>& reference, std::span<const size_t> reference_shown);

}  // namespace sideray::lab
