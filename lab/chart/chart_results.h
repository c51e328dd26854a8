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
  std::optional<double> self_error;      // relMSE between two independent halves; empty: it has no halves
  uint32_t bounces = 1;                  // of its light; 0 = unlimited
  std::vector<double> self_errors = {};  // of the frames of a sequence drawn so far; negative: no halves
  bool caustics = false;                 // whether it has those of lamps
};

// Returns them as statistics hold them: a number, or "unlimited".
Json bounces_json(uint32_t bounces);

// Returns results.json; `metric` names the error that decides what is on the Pareto front.
Json results_json(const std::string& scene, const ChartReference& reference, std::span<const ChartRow> rows,
                  const std::string& metric);

// Returns one line for each row of results.json: the options that differ, times, rays, bytes, errors, pareto.
std::string results_csv(const Json& results);

}  // namespace sideray::lab
