// Writes results.json and results.csv of a chart (docs/cli.md). Plain memory; any thread.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "lab/chart/chart_row.h"

namespace sideray::lab {

struct ChartReference {
  std::string image;
  uint32_t light_samples = 0;
  std::optional<double> self_error;      // relMSE between two independent halves; empty without two halves
  uint32_t bounces = 1;                  // of the reference's light; 0 = unlimited
  std::vector<double> self_errors = {};  // for a sequence: of the frames drawn so far; negative: without halves
  bool caustics = false;                 // caustics of lamps on its paths
};

// Returns the bounces as in statistics: a number, or "unlimited".
Json bounces_json(uint32_t bounces);

// `metric`: the error that decides the Pareto flags.
Json results_json(const std::string& scene, const ChartReference& reference, std::span<const ChartRow> rows,
                  const std::string& metric);

// Returns one line for each row of results.json: the options that differ between rows, times, rays, bytes, errors,
// pareto.
std::string results_csv(const Json& results);

}  // namespace sideray::lab
