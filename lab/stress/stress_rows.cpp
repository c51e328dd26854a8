#include "lab/stress/stress_rows.h"

namespace sideray::lab {
namespace {

Json map_json(const FailureMap& map) {
  std::string digits;
  for (const uint8_t wrong : map.wrong) digits += wrong ? '1' : '0';
  return {{"width", map.width}, {"height", map.height}, {"wrong", digits}};
}

FailureMap parse_map(const Json& json) {
  FailureMap map{json.at("width"), json.at("height"), {}};
  for (const char digit : json.at("wrong").get<std::string>()) map.wrong.push_back(digit == '1');
  return map;
}

}  // namespace

Json rows_json(std::span<const StressRow> rows) {
  Json list = Json::array();
  for (const StressRow& row : rows)
    list.push_back({{"name", row.name},
                    {"variant", row.variant},
                    {"parameters", row.parameters},
                    {"measure", row.measure},
                    {"value", row.value},
                    {"bound", row.bound},
                    {"default", row.is_default},
                    {"map", map_json(row.map)}});
  return list;
}

std::optional<std::vector<StressRow>> parse_rows(const Json& json) {
  try {
    std::vector<StressRow> rows;
    for (const Json& row : json)
      rows.push_back({row.at("name"), row.at("variant"), row.at("parameters"), row.at("measure"), row.at("value"),
                      row.at("bound"), row.at("default"), parse_map(row.at("map"))});
    return rows;
  } catch (const Json::exception&) {
    return {};
  }
}

}  // namespace sideray::lab
