// Finds the name that a mistyped one probably means. Any thread.
#pragma once

#include <span>
#include <string>

namespace sideray::cli {

// Returns the name with the fewest letters to insert, remove or replace, or an empty string if none is near.
std::string near_name(const std::string& typed, std::span<const std::string> names);
// Returns "did you mean NAME? ", or an empty string if there is no name.
std::string did_you_mean(const std::string& name);

}  // namespace sideray::cli
