#include "cli/options/comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "scenes/images/images.h"

namespace sideray::cli {
namespace {

constexpr double largest_bound = 1e30;

void print_metrics(const lab::Metrics& metrics, bool json) {
  const nlohmann::ordered_json values = lab::to_json(metrics);
  if (json) {
    fmt::print("{}\n", values.dump());
    return;
  }
  for (const auto& [name, value] : values.items()) fmt::print("{:<15} {}\n", name, value.dump());
}

int check_bound(const lab::Metrics& metrics, const Bound& bound) {
  if (metrics.nonfinite != 0) {
    print_error(fmt::format("{} pixels are not finite: no metric counts with them; find the NaN or infinity first",
                            metrics.nonfinite));
    return exit_failed;
  }
  if (!bound.fail_above && !bound.fail_below) return exit_ok;
  const std::optional<double> value = lab::metric(metrics, bound.metric);
  if (!value)
    wrong_usage(
        "--metric {}: does not apply to these images (hdr_flip needs two EXR, relmse two of one kind, ssim 11x11 "
        "pixels); choose another",
        bound.metric);
  if (bound.fail_above && *value > *bound.fail_above) {
    print_error(
        fmt::format("{} is {}: above the bound {}; look at --map FILE", bound.metric, *value, *bound.fail_above));
    return exit_failed;
  }
  if (bound.fail_below && *value < *bound.fail_below) {
    print_error(
        fmt::format("{} is {}: below the bound {}; look at --map FILE", bound.metric, *value, *bound.fail_below));
    return exit_failed;
  }
  return exit_ok;
}

void check_metric(const Bound& bound) {
  const std::vector<std::string>& names = lab::metric_names();
  if (std::find(names.begin(), names.end(), bound.metric) == names.end())
    wrong_usage("--metric: unknown value \"{}\"; one of {}", bound.metric, fmt::join(names, ", "));
  if (bound.fail_above && lab::larger_is_better(bound.metric))
    wrong_usage("--fail-above: {} is better when larger; use --fail-below", bound.metric);
  if (bound.fail_below && !lab::larger_is_better(bound.metric))
    wrong_usage("--fail-below: {} is better when smaller; use --fail-above", bound.metric);
}

}  // namespace

const Table& comparison_table() {
  static const sideray_option rows[] = {
      text_row("map", "FILE.png", "", "writes the FLIP map"),
      text_row("fail-above", "X", "", "exits with 1 where the metric is larger"),
      text_row("fail-below", "X", "", "exits with 1 where the metric is smaller"),
      text_row("metric", "NAME", "flip", "which metric the bound is for"), flag_row("json", "prints JSON")};
  static const Table table{&rows[0], &rows[1], &rows[2], &rows[3], &rows[4]};
  return table;
}

ComparisonOptions resolve_comparison(const Given& given) {
  const Table& options = comparison_table();
  for (const sideray_option* option : options)
    if (const auto at = given.find(option->name); at != given.end() && at->second.empty())
      wrong_usage("--{}: is empty; give a value or leave it out", option->name);
  ComparisonOptions result;
  result.map = text_of(options, given, "map");
  result.json = given.contains("json");
  result.bound.metric = text_of(options, given, "metric");
  for (const auto& [name, bound] :
       {std::pair{"fail-above", &result.bound.fail_above}, std::pair{"fail-below", &result.bound.fail_below}})
    if (const auto at = given.find(name); at != given.end())
      *bound = number(name, at->second, -largest_bound, largest_bound);
  check_metric(result.bound);
  if (!result.map.empty()) require_extension("--map", result.map, {".png"});
  return result;
}

int run_comparison(const std::string& test, const std::string& reference, const ComparisonOptions& options,
                   const lab::Display& display) {
  const scenes::Image a = scenes::read_image(test), b = scenes::read_image(reference);
  if (a.width != b.width || a.height != b.height)
    wrong_usage("{} against {}: sizes {}x{} and {}x{} differ; compare images of one size", test, reference, a.width,
                a.height, b.width, b.height);
  const lab::Comparison comparison = lab::compare(a, b, display);
  print_metrics(comparison.metrics, options.json);
  if (!options.map.empty() && !comparison.flip_map.empty())
    scenes::write_png(options.map, a.width, a.height, lab::false_colours(comparison.flip_map));
  return check_bound(comparison.metrics, options.bound);
}

}  // namespace sideray::cli
