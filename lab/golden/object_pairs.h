// Which object of one scene is which of another one. Plain memory; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lab/golden/changes.h"

namespace sideray::lab {

constexpr size_t no_object = SIZE_MAX;

// Of each pixel the index of its object; no_object: the background, or a surface that no object has.
std::vector<size_t> shown_objects(const ShownPicture& shown);

// Of each object of `now` its index in `reference`, or no_object. `now_shown`, `reference_shown`: of each pixel.
std::vector<size_t> paired_objects(const std::vector<NamedObject>& now, std::span<const size_t> now_shown,
                                   const std::vector<NamedObject>& reference, std::span<const size_t> reference_shown);

}  // namespace sideray::lab
