#include "lab/chart/configurations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "scenes/base/files.h"

namespace sideray::lab {
namespace {

using scenes::refuse;

Configuration parse_entry(const nlohmann::json& entry, const std::string& name) {
  if (!entry.is_object()) refuse("{}: is not an object; write {{\"option\": value, ...}}", name);
  Configuration configuration;
  for (const auto& [option, value] : entry.items()) {
    if (value.is_string())
      configuration[option] = value.get<std::string>();
    else if (value.is_number() || value.is_boolean())
      configuration[option] = value.dump();
    else
      refuse("{}: {} is neither text, number, true nor false; correct it", name, option);
    // The operating system would cut a path there.
    if (configuration[option].find('\0') != std::string::npos) refuse("{}: {} holds a NUL; remove it", name, option);
  }
  return configuration;
}

}  // namespace

std::vector<Configuration> parse_configurations(const nlohmann::json& list, const std::string& file,
                                                const std::string& entry_name) {
  if (!list.is_array()) refuse("{}: is not an array; write [{{\"option\": value, ...}}, ...]", file);
  std::vector<Configuration> configurations;
  for (size_t i = 0; i < list.size(); ++i)
    configurations.push_back(parse_entry(list[i], fmt::format("{} {} {}", file, entry_name, i)));
  return configurations;
}

std::string describe(const Configuration& configuration) {
  std::vector<std::string> parts;
  for (const auto& [option, value] : configuration)
    parts.push_back(value == "true" ? option : fmt::format("{} {}", option, value));
  return parts.empty() ? "defaults" : fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace sideray::lab
