// Lists of configurations in JSON: sweep files and jobs files. Plain memory; any thread.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Configuration = std::map<std::string, std::string>;  // option without dashes -> its text; flags "true", "false"

// An array of {option: value}, values strings, numbers or booleans. Throws Error that begins with the file or with
// "FILE ENTRY_NAME INDEX", counted from 0.
std::vector<Configuration> parse_configurations(const nlohmann::json& list, const std::string& file,
                                                const std::string& entry_name);

// "layers 4, mask count": for people.
std::string describe(const Configuration& configuration);

// What decides how much there is to sweep.
struct SweepScene {
  size_t translucent_objects = 0;
  size_t layered_objects = 0;  // those that `--ray-traced auto` gives layers
};

struct DefaultSweep {
  std::vector<Configuration> configurations;
  std::string left_out;  // why it is shorter than it could be; "" = it is whole
};

// No translucency, the rasterizer's, layers 1 to 8 and events 1 to unlimited, each with the masks that cost
// differently.
DefaultSweep default_sweep(const SweepScene& scene);

}  // namespace sideray::lab
