#include "lab/chart/chart_row.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace sideray::lab {

size_t ChartRow::rounds() const {
  return rounds_ms.empty() ? 0 : rounds_ms.begin()->second.size() / frames;
}

void ChartRow::add_round(const std::vector<Json>& round) {
  frames = round.size();
  for (const Json& frame : round)
    for (const auto& [stage, ms] : frame.at("stages_ms").items()) rounds_ms[stage].push_back(ms.get<double>());
  stats = median_stats(round);
}

Json to_json(const ChartRow& row) {
  return {{"schema", 1},        {"made_with", row.made_with}, {"stats", row.stats},        {"error", row.error},
          {"image", row.image}, {"frames", row.frames},       {"rounds_ms", row.rounds_ms}};
}

std::optional<ChartRow> parse_row(const std::string& text, const Json& made_with) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != 1 || json.at("made_with") != made_with) return {};
    ChartRow row{made_with, json.at("stats"), json.at("error"), json.at("image").get<std::string>(), {}};
    json.at("rounds_ms").get_to(row.rounds_ms);
    json.at("frames").get_to(row.frames);
    if (row.frames == 0) return {};
    for (const auto& [stage, times] : row.rounds_ms)
      if (times.size() != row.rounds() * row.frames || !row.stats.at("stages_ms").contains(stage)) return {};
    return row;
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

Json median_stats(const std::vector<Json>& frames) {
  Json stats = frames.back();
  const auto set_median = [&](const Json::json_pointer& at) {
    std::vector<Json> values;
    for (const Json& frame : frames)
      if (frame.contains(at)) values.push_back(frame[at]);
    std::sort(values.begin(), values.end());
    stats[at] = values[(values.size() - 1) / 2];
  };
  for (const char* group : {"rays", "pixels", "layers", "bytes"}) {
    if (!stats.contains(group)) continue;
    const Json counted = stats[group];
    for (const auto& [key, value] : counted.items()) set_median(Json::json_pointer() / group / key);
  }
  if (stats.contains("dropped_particles")) set_median(Json::json_pointer() / "dropped_particles");
  return stats;
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
