// Finds the objects of one scene in another scene. Plain memory; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lab/golden/changes.h"

namespace sideray::lab {

constexpr size_t no_object = SIZE_MAX;

// Returns the index of each pixel's object, or no_object for the background and for surfaces without an object.
std::vector<size_t> shown_objects(const ShownPicture& shown);

// Returns for each object of `now` its index in `reference`, or no_object. `now_shown` and `reference_shown` hold the
// index of each pixel's object (shown_objects()).
std::vector<size_t> paired_objects(const std::vector<NamedObject>& now, std::span<const size_t> now_shown,
                                   const std::vector<NamedObject>& reference, std::span<const size_t> reference_shown);

}  // namespace sideray::lab
