// Shows stress rows to people: one page, and failure maps as pictures. Plain memory; any thread.
#pragma once

#include <cstdint>
#include <span>

#include "lab/stress/stress.h"

namespace sideray::lab {

// The parameters that tell rows of one case apart, as text: "relative_gap 1e-06".
std::string describe_parameters(const StressRow& row, std::span<const StressRow> of_case);

// 8 bits a channel, RGB, top row first.
struct Sheet {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;
};

// A row of tiles a variant, a column a set of parameters, in the order of the rows: pixels that are wrong are red, a
// tile's frame is green where its row passes and red where it fails. Empty where no row has a map.
Sheet failure_sheet(std::span<const StressRow> of_case);

// A whole HTML page with all failure maps inside. `device`: what it was measured on.
std::string stress_page(const std::vector<StressCase>& cases, const std::vector<StressRow>& rows,
                        const std::string& device);

// The rows of a case: neighbours in `rows`.
std::span<const StressRow> rows_of(const std::string& name, std::span<const StressRow> rows);

}  // namespace sideray::lab
