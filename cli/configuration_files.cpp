#include "configuration_files.h"

#include <algorithm>

#include "failure.h"
#include "render_options.h"
#include "scenes/files.h"

namespace sideray::cli {
namespace {

bool is_flag(const std::string& name) {
  const std::vector<Option>& table = render_table();
  return std::any_of(table.begin(), table.end(),
                     [&](const Option& o) { return o.name == name && o.kind == Option::Kind::flag; });
}

}  // namespace

std::vector<lab::Configuration> read_configurations(const std::string& path, const std::string& entry_name) {
  constexpr uint64_t most_bytes = uint64_t{64} << 20;
  const std::vector<uint8_t> bytes = scenes::read_file(path, most_bytes);
  nlohmann::json list;
  try {
    list = nlohmann::json::parse(bytes);
  } catch (const nlohmann::json::parse_error& error) {
    scenes::refuse("{}: is not JSON from byte {} on; correct it", path, error.byte);
  }
  try {
    return lab::parse_configurations(list, path, entry_name);
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

Given given_of(const lab::Configuration& configuration, const std::string& name) {
  Given given;
  for (const auto& [option, value] : configuration) {
    if (is_flag(option) && value == "false") continue;
    if (is_flag(option) && value != "true")
      wrong_usage("{}: --{}: unknown value \"{}\"; give true or false", name, option, value);
    given[option] = value;
  }
  return given;
}

}  // namespace sideray::cli
