// Presents stress rows: one page, and failure maps as pictures. Plain memory; any thread may call it.
#pragma once

#include <cstdint>
#include <span>

#include "lab/stress/stress.h"

namespace sideray::lab {

// Returns the parameters that differ between rows of one case, as text: "relative_gap 1e-06".
std::string describe_parameters(const StressRow& row, std::span<const StressRow> of_case);

// Holds a picture of 8 bits a channel, RGB, top row first.
struct Sheet {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;
};

// Draws a row of tiles for each variant and a column for each set of parameters, in the order of the rows. Wrong pixels
// are red; a tile's frame is green if its row passes, and red if it fails. Empty if no row has a map.
Sheet failure_sheet(std::span<const StressRow> of_case);

// Returns a complete HTML page with all failure maps. `device` names the measured device.
std::string stress_page(const std::vector<StressCase>& cases, const std::vector<StressRow>& rows,
                        const std::string& device);

// Returns the rows of a case, which are contiguous in `rows`.
std::span<const StressRow> rows_of(const std::string& name, std::span<const StressRow> rows);

}  // namespace sideray::lab
