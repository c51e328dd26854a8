#include "cli/options/configuration_files.h"

#include <nlohmann/json.hpp>
#include <set>

#include "cli/base/failure.h"
#include "cli/options/render_options.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

bool is_flag(const std::string& name) {
  const sideray_option* option = find(render_table(), name);
  return option && option->type == SIDERAY_OPTION_FLAG;
}

// Refuses an object with the same key twice, of which one value would win silently.
nlohmann::json parse_unique(const std::vector<uint8_t>& bytes, const std::string& path) {
  using Json = nlohmann::json;
  std::vector<std::set<std::string>> keys;  // of the objects around the current place
  const auto check = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
      wrong_usage("{}: \"{}\" is given twice in one object; remove one", path, value.get<std::string>());
    return true;
  };
  try {
    return Json::parse(bytes, check);
  } catch (const Json::parse_error& error) {
    wrong_usage("{}: is not JSON from byte {} on; correct it", path, error.byte);
  } catch (const Json::out_of_range&) {  // the only one of parse()
    wrong_usage("{}: holds a number that no double holds; correct it", path);
  }
}

}  // namespace

std::vector<lab::Configuration> read_configurations(const std::string& path, const std::string& entry_name) {
  constexpr uint64_t most_bytes = uint64_t{64} << 20;
  const nlohmann::json list = parse_unique(scenes::read_file(path, most_bytes), path);
  try {
    std::vector<lab::Configuration> configurations = lab::parse_configurations(list, path, entry_name);
    for (lab::Configuration& configuration : configurations) {
      Given given;
      for (const auto& [option, value] : configuration) give(given, option, value);
      configuration = std::move(given);
    }
    return configurations;
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

Given given_of(const lab::Configuration& configuration, const std::string& name) {
  Given given;
  for (const auto& [option, value] : configuration) {
    if (is_flag(option) && value == "false") continue;
    if (is_flag(option) && value != "true")
      wrong_usage("{}: {}: unknown value \"{}\"; give true or false", name, dashed(option), value);
    given[option] = value;
  }
  return given;
}

}  // namespace sideray::cli
