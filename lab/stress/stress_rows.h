// Converts the rows of one stress case to and from JSON, with failure maps, so that cases of separate runs make one
// table and one page. Plain memory; any thread may call it.
#pragma once

#include <optional>
#include <span>

#include "lab/stress/stress.h"

namespace sideray::lab {

// Returns an object for each row; its map is a string with one digit for each pixel.
Json rows_json(std::span<const StressRow> rows);

// Returns nothing where the JSON does not hold rows.
std::optional<std::vector<StressRow>> parse_rows(const Json& json);

}  // namespace sideray::lab
