// Makes the pages of charts and of goldens, each a single file that a browser shows without a network. Plain memory;
// any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sideray::lab {

// `data` is shown by lab/page/chart.js: {"results" (results.json), "metric", "larger_is_better":[], "command",
// "program", "machine":{}, "scale":{"width","height","is_exact"}, "reference" (data URI),
// "points":[{"label","command","picture", "map"}]}, one point a row of the results.
std::string chart_page(const nlohmann::ordered_json& data);

// `data` is shown by lab/page/golden.js: {"title", "summary", "pictures":[{"name", "verdict", "changes":[], and where
// pictures differ "reference", "now", "map" (data URIs)}]}.
std::string golden_page(const nlohmann::ordered_json& data);

}  // namespace sideray::lab
