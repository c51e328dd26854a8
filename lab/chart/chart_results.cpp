#include "lab/chart/chart_results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "lab/chart/pareto.h"
#include "lab/metrics/metrics.h"

namespace sideray::lab {
namespace {

Json result_of(const ChartRow& row) {
  Json result = row.stats;
  for (const auto& [stage, times] : row.rounds_ms) {
    const Quartiles ms = quartiles(times);
    result["stages_ms"][stage] = ms.median;
    result["p25"][stage] = ms.p25;
    result["p75"][stage] = ms.p75;
  }
  result["repeats"] = row.rounds();
  result["config"]["repeat"] = row.rounds();
  result["error"] = row.error;
  return result;
}

CostAndError point_of(const Json& result, const std::string& metric) {
  CostAndError point{result["stages_ms"]["total_frame"].get<double>(), {}};
  if (result["error"].contains(metric)) {
    const double value = result["error"][metric].get<double>();
    point.error = larger_is_better(metric) ? -value : value;
  }
  return point;
}

struct Column {
  std::string title;
  Json::json_pointer at;  // in a row of results.json
};

// Returns title and place of each key that `group` has in any row.
std::vector<Column> columns_of(const Json& rows, const std::string& group, const std::string& prefix) {
  std::vector<Column> columns;
  for (const Json& row : rows) {
    if (!row.contains(group)) continue;
    for (const auto& [key, value] : row[group].items()) {
      Column column{prefix + key, Json::json_pointer() / group / key};
      if (std::none_of(columns.begin(), columns.end(), [&](const Column& c) { return c.title == column.title; }))
        columns.push_back(std::move(column));
    }
  }
  return columns;
}

bool differs(const Json& rows, const Json::json_pointer& at) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const Json& row) { return row.value(at, Json()) != rows[0].value(at, Json()); });
}

std::vector<Column> columns_of(const Json& rows) {
  std::vector<Column> columns = columns_of(rows, "config", "");
  std::erase_if(columns, [&](const Column& column) { return !differs(rows, column.at); });
  for (const Column& stage : columns_of(rows, "stages_ms", "")) {
    columns.push_back({stage.title + "_ms", stage.at});
    for (const char* quartile : {"p25", "p75"})
      columns.push_back({stage.title + "_" + quartile, Json::json_pointer() / quartile / stage.title});
  }
  for (const char* group : {"rays", "pixels", "layers", "bytes"})
    for (Column& column : columns_of(rows, group, std::string(group) + ".")) columns.push_back(std::move(column));
  for (Column& column : columns_of(rows, "error", "")) columns.push_back(std::move(column));
  for (const char* last : {"pareto", "image"}) columns.push_back({last, Json::json_pointer() / last});
  return columns;
}

// Returns the value as a cell by RFC 4180, empty where the row has none.
std::string cell(const Json& row, const Json::json_pointer& at) {
  if (!row.contains(at)) return "";
  const std::string text = row[at].is_string() ? row[at].get<std::string>() : row[at].dump();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted(1, '"');
  for (char c : text) quoted.append(c == '"' ? 2 : 1, c);
  quoted.push_back('"');
  return quoted;
}

}  // namespace

Json bounces_json(uint32_t bounces) {
  return bounces == 0 ? Json("unlimited") : Json(bounces);
}

Json results_json(const std::string& scene, const ChartReference& reference, std::span<const ChartRow> rows,
                  const std::string& metric) {
  Json results = {{"schema", 1}, {"scene", scene}};
  results["reference"] = {{"image", reference.image}, {"light_samples", reference.light_samples}};
  if (reference.bounces != 1) results["reference"]["bounces"] = bounces_json(reference.bounces);
  if (reference.bounces != 1) results["reference"]["caustics"] = reference.caustics;
  if (reference.self_error) results["reference"]["self_error"] = *reference.self_error;
  results["rows"] = Json::array();
  std::vector<CostAndError> points;
  for (const ChartRow& row : rows) {
    results["rows"].push_back(result_of(row));
    points.push_back(point_of(results["rows"].back(), metric));
  }
  const std::vector<bool> front = pareto_front(points);
  for (size_t i = 0; i < rows.size(); ++i) {
    results["rows"][i]["pareto"] = static_cast<bool>(front[i]);
    results["rows"][i]["image"] = rows[i].image;
  }
  return results;
}

std::string results_csv(const Json& results) {
  const Json& rows = results.at("rows");
  const std::vector<Column> columns = columns_of(rows);
  std::vector<std::string> titles{"index"};
  for (const Column& column : columns) titles.push_back(column.title);
  std::string text = fmt::format("{}\n", fmt::join(titles, ","));
  for (size_t i = 0; i < rows.size(); ++i) {
    std::vector<std::string> cells{std::to_string(i)};
    for (const Column& column : columns) cells.push_back(cell(rows[i], column.at));
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return text;
}

}  // namespace sideray::lab
