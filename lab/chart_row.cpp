#include "lab/chart_row.h"

#include <algorithm>

namespace sideray::lab {

size_t ChartRow::rounds() const {
  return rounds_ms.empty() ? 0 : rounds_ms.begin()->second.size();
}

void ChartRow::add_round(Json round) {
  for (const auto& [stage, ms] : round.at("stages_ms").items()) rounds_ms[stage].push_back(ms.get<double>());
  stats = std::move(round);
}

Json to_json(const ChartRow& row) {
  return {{"schema", 1},        {"made_with", row.made_with}, {"stats", row.stats},
          {"error", row.error}, {"image", row.image},         {"rounds_ms", row.rounds_ms}};
}

std::optional<ChartRow> parse_row(const std::string& text, const Json& made_with) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != 1 || json.at("made_with") != made_with) return {};
    ChartRow row{made_with, json.at("stats"), json.at("error"), json.at("image").get<std::string>(), {}};
    json.at("rounds_ms").get_to(row.rounds_ms);
    for (const auto& [stage, times] : row.rounds_ms)
      if (times.size() != row.rounds() || !row.stats.at("stages_ms").contains(stage)) return {};
    return row;
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

Quartiles quartiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double q) {
    const double position = q * static_cast<double>(values.size() - 1);
    const size_t below = static_cast<size_t>(position), above = std::min(below + 1, values.size() - 1);
    return values[below] + (values[above] - values[below]) * (position - static_cast<double>(below));
  };
  return {at(0.25), at(0.5), at(0.75)};
}

}  // namespace sideray::lab
