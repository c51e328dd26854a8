// Makes the pages of charts and goldens: each is one file that a browser opens without a network. Plain memory; any
// thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sideray::lab {

// Returns the page of a chart. `data` is read by lab/page/chart.js: {"results" (results.json), "metric",
// "larger_is_better":[], "command", "program", "machine":{}, "scale":{"width","height","is_exact"}, "reference" (data
// URI), "points":[{"label","command","picture", "map"}]}, with one point for each row of the results.
std::string chart_page(const nlohmann::ordered_json& data);

// Returns the page of goldens. `data` is read by lab/page/golden.js: {"title", "summary", "pictures":[{"name",
// "verdict", "changes":[], and for pictures that differ "reference", "now", "map" (data URIs)}]}.
std::string golden_page(const nlohmann::ordered_json& data);

}  // namespace sideray::lab
