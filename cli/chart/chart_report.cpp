#include "cli/chart/chart_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace sideray::cli {

using lab::Json;

// Two halves differ by four times the variance of their mean (docs/cli.md, chart).
void print_noise(const Json& results) {
  const Json& reference = results["reference"];
  fmt::print("reference: {} light samples", reference["light_samples"].get<uint32_t>());
  if (reference.contains("self_error")) {
    const double halves = reference["self_error"].get<double>();
    const auto close = std::count_if(results["rows"].begin(), results["rows"].end(), [&](const Json& row) {
      return row["error"].contains("relmse") && row["error"]["relmse"].get<double>() < halves;
    });
    fmt::print(", its own relmse is about {:.2g}", halves / 4);
    if (close > 0) fmt::print("; {} rows are within 4 times that: raise --light-samples to tell them apart", close);
  }
  fmt::print("\n");
}

void print_table(const std::vector<PagePoint>& points, const Json& results, const ChartOptions& options) {
  fmt::print("{:>5} {:>10} {:>10} {:>10} {:>14}  front  configuration\n", "index", "frame ms", "p25", "p75",
             options.metric);
  for (size_t i = 0; i < points.size(); ++i) {
    const Json& row = results["rows"][i];
    const Json& error = row["error"];
    fmt::print("{:>5} {:>10.3f} {:>10.3f} {:>10.3f} {:>14}  {:<5}  {}\n", i,
               row["stages_ms"]["total_frame"].get<double>(), row["p25"]["total_frame"].get<double>(),
               row["p75"]["total_frame"].get<double>(),
               error.contains(options.metric) ? fmt::format("{:.6g}", error[options.metric].get<double>()) : "-",
               row["pareto"].get<bool>() ? "*" : "", points[i].label);
  }
}

}  // namespace sideray::cli
