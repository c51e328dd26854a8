// results.json and results.csv of a chart (docs/cli.md). Plain memory; any thread.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "lab/chart/chart_row.h"

namespace sideray::lab {

struct ChartReference {
  std::string image;
  uint32_t light_samples = 0;
  std::optional<double> self_error;      // relMSE between two independent halves; empty: there are no two halves
  uint32_t bounces = 1;                  // of its light; 0 = unlimited
  std::vector<double> self_errors = {};  // of a sequence: of the frames drawn so far; negative: of no halves
  bool caustics = false;                 // of lamps on its paths
};

// As statistics have them: a number, or "unlimited".
Json bounces_json(uint32_t bounces);

// `metric` decides the error that the Pareto flags go by.
Json results_json(const std::string& scene, const ChartReference& reference, std::span<const ChartRow> rows,
                  const std::string& metric);

// One line a row of results.json: the options that differ between rows, times, rays, bytes, errors, pareto.
std::string results_csv(const Json& results);

}  // namespace sideray::lab
