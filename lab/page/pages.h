// The pages of charts and of goldens: each one file that a browser opens without a network. Plain memory; any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sideray::lab {

// `data`: what lab/page/chart.js shows: {"results" (results.json), "metric", "larger_is_better":[], "command",
// "program", "machine":{}, "scale":{"width","height","is_exact"}, "reference" (data URI),
// "points":[{"label","command","picture", "map"}]}, one point a row of the results.
std::string chart_page(const nlohmann::ordered_json& data);

// `data`: what lab/page/golden.js shows: {"title", "summary", "pictures":[{"name", "verdict", "changes":[], and of those
// that differ "reference", "now", "map" (data URIs)}]}.
std::string golden_page(const nlohmann::ordered_json& data);

}  // namespace sideray::lab
