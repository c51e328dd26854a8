#include "lab/chart/candidates.h"

#include <sideray/options.h>

#include <algorithm>
#include <string_view>

namespace sideray::lab {
namespace {

using Configurations = std::vector<Configuration>;

// Returns whether the given options still allow this way.
bool is_open(const Way& way, const Configuration& given) {
  const Axis& kind = way.front();
  const auto at = given.find(kind.option);
  return at == given.end() || kind.values.size() > 1 || at->second == kind.values.front();
}

// Returns the product of the values of all axes, without the options that are given.
Configurations crossed(const Way& way, const Configuration& given) {
  Configurations list{{}};
  for (const Axis& axis : way) {
    if (given.contains(axis.option)) continue;
    Configurations longer;
    for (const Configuration& configuration : list)
      for (const std::string& value : axis.values) {
        longer.push_back(configuration);
        longer.back()[axis.option] = value;
      }
    list = std::move(longer);
  }
  return list;
}

std::vector<Way> open_ways(std::vector<Way> ways, const Configuration& given) {
  std::erase_if(ways, [&](const Way& way) { return !is_open(way, given); });
  return ways;
}

// Returns all configurations of the ways, or a single empty one where there are no ways.
Configurations crossed(const std::vector<Way>& ways, const Configuration& given) {
  Configurations list;
  for (const Way& way : ways)
    for (Configuration& configuration : crossed(way, given)) list.push_back(std::move(configuration));
  return list.empty() ? Configurations{{}} : list;
}

// Adds the usual values of the way that `point` chooses, or of the first way where it chooses none.
void complete(Configuration& point, const std::vector<Way>& ways, const Configuration& given) {
  const auto goes = [&](const Way& way) {
    const auto at = point.find(way.front().option);
    const std::vector<std::string>& values = way.front().values;
    return at == point.end() || std::find(values.begin(), values.end(), at->second) != values.end();
  };
  const auto way = std::find_if(ways.begin(), ways.end(), goes);
  if (way == ways.end()) return;
  for (const Axis& axis : *way)
    if (!given.contains(axis.option)) point.emplace(axis.option, axis.values.front());
}

bool is_of_shadows(const std::string& name) {
  const sideray_option* option = sideray_option_find(name.c_str());
  const std::string_view part = option ? option->part : "";
  return part == "shadows" || part == "poses";
}

CandidateConfiguration candidate(const Configuration& configuration) {
  Configuration drawing, shadows;
  for (const auto& option : configuration) (is_of_shadows(option.first) ? shadows : drawing).insert(option);
  return {configuration, describe(drawing), describe(shadows)};
}

}  // namespace

std::vector<CandidateConfiguration> candidate_configurations(const SweepScene& scene, const Configuration& given) {
  const std::vector<Way> to_draw = open_ways(ways_to_draw(scene), given);
  const std::vector<Way> to_shadow = open_ways(ways_to_shadow(scene), given);
  Configurations list;
  for (const Configuration& drawing : crossed(to_draw, given))
    for (const Configuration& shadows : crossed(to_shadow, given)) {
      list.push_back(drawing);
      list.back().insert(shadows.begin(), shadows.end());
    }
  for (Configuration point : default_sweep(Sweep::all, scene).choices) {
    if (std::any_of(point.begin(), point.end(), [&](const auto& o) { return given.contains(o.first); })) continue;
    complete(point, to_draw, given);
    complete(point, to_shadow, given);
    if (std::find(list.begin(), list.end(), point) == list.end()) list.push_back(point);
  }
  std::vector<CandidateConfiguration> candidates;
  for (const Configuration& configuration : list) candidates.push_back(candidate(configuration));
  return candidates;
}

}  // namespace sideray::lab
