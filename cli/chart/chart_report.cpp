#include "cli/chart/chart_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/chart/chart_ledger.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

using lab::ChartRow;
using lab::Json;

// Prints the noise: two halves differ by four times the variance of their mean (docs/cli.md, chart).
void print_noise(const Json& results) {
  const Json& reference = results["reference"];
  fmt::print("reference: {} light samples", reference["light_samples"].get<uint32_t>());
  if (reference.contains("bounces")) fmt::print(", bounces: {}", reference["bounces"].dump());
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

int refuse_not_finite(const ChartFolder& folder, std::span<const ChartRow> rows, const Json& ledger) {
  for (const ChartRow& row : rows)
    if (row.error["nonfinite"] != 0) {
      print_error(
          fmt::format("{}: {} pixels are not finite: no metric counts with them; find the NaN or infinity first",
                      folder.path(row.image), row.error["nonfinite"].get<uint64_t>()));
      return exit_failed;
    }
  if (!ledger.is_null() && ledger["nonfinite"] != 0) {
    print_error(fmt::format("ledger: {} pixels are not finite: they are in no figure; find the NaN or infinity first",
                            ledger["nonfinite"].get<uint64_t>()));
    return exit_failed;
  }
  return exit_ok;
}

}  // namespace

int write_chart(const ChartOptions& options, const ChartFolder& folder, const lab::ChartReference& reference,
                const std::vector<PagePoint>& shown, std::span<const ChartRow> rows, const Json& ledger) {
  Json results = lab::results_json(options.scene, reference, rows, options.metric);
  if (const std::optional<FrameRange>& frames = options.frames)
    results["frames"] = {{"first", frames->first}, {"last", frames->last}, {"fps", frames->fps}};
  write_text(folder.path("results.json"), scenes::json_text(results, 2) + "\n");
  write_text(folder.path("results.csv"), lab::results_csv(results));
  write_text(folder.path("index.html"), chart_page(options, folder, shown, results, ledger));
  print_noise(results);
  print_table(shown, results, options);
  if (!ledger.is_null()) print_ledger(ledger);
  fmt::print("page: {}\n", folder.path("index.html"));
  return refuse_not_finite(folder, rows, ledger);
}

}  // namespace sideray::cli
