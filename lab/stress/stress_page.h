// Makes a page of stress rows, and pictures of failure maps. Plain memory; any thread may call it.
#pragma once

#include <cstdint>
#include <span>

#include "lab/stress/stress.h"

namespace sideray::lab {

// Returns the parameters that tell rows of one case apart, as text: "relative_gap 1e-06".
std::string describe_parameters(const StressRow& row, std::span<const StressRow> of_case);

// Holds a picture of 8 bits a channel, RGB, top row first.
struct Sheet {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;
};

// Draws failure maps as tiles: one row of tiles for each variant, one column for each set of parameters, in the order
// of the rows. Wrong pixels are red; a tile's frame is green where its row passes and red where it fails. Empty where
// no row has a map.
Sheet failure_sheet(std::span<const StressRow> of_case);

// Returns a whole HTML page with all failure maps inside. `device` names the device of the measurement.
std::string stress_page(const std::vector<StressCase>& cases, const std::vector<StressRow>& rows,
                        const std::string& device);

// Returns the rows of a case, which are adjacent in `rows`.
std::span<const StressRow> rows_of(const std::string& name, std::span<const StressRow> rows);

}  // namespace sideray::lab
