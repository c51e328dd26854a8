// The rows of one stress case as JSON, failure maps too, so that cases that ran apart make one table and one page.
// Plain memory; any thread may call it.
#pragma once

#include <optional>
#include <span>

#include "lab/stress/stress.h"

namespace sideray::lab {

// An object a row; the map is a text of one digit a pixel.
Json rows_json(std::span<const StressRow> rows);

// Empty where the JSON is not of rows.
std::optional<std::vector<StressRow>> parse_rows(const Json& json);

}  // namespace sideray::lab
