// Converts the rows of one stress case to and from JSON, with failure maps, so that cases from separate runs form one
// table and one page. Plain memory; any thread may call it.
#pragma once

#include <optional>
#include <span>

#include "lab/stress/stress.h"

namespace sideray::lab {

// Returns one object a row; the map is a text with one digit a pixel.
Json rows_json(std::span<const StressRow> rows);

// Returns nothing if the JSON does not hold rows.
std::optional<std::vector<StressRow>> parse_rows(const Json& json);

}  // namespace sideray::lab
