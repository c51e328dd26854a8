// Compares two images by metrics, with a bound (`compare`) or without (`render --compare`). Any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/options/options.h"
#include "lab/metrics/metrics.h"

namespace sideray::cli {

struct Bound {
  std::string metric = "flip";
  std::optional<double> fail_above, fail_below;
};

struct ComparisonOptions {
  std::string map;  // PNG to write; "" = none
  Bound bound;
  bool json = false;
};

// --map, --fail-above, --fail-below, --metric, --json
const Table& comparison_table();
ComparisonOptions resolve_comparison(const Given& given);

// Prints the metrics and returns the exit code: failed beyond the bound or with pixels that are not finite.
int run_comparison(const std::string& test, const std::string& reference, const ComparisonOptions& options,
                   const lab::Display& display);

}  // namespace sideray::cli
