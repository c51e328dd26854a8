#include "lab/chart/candidates.h"

#include <algorithm>
#include <set>

namespace sideray::lab {
namespace {

using Values = std::vector<std::string>;
using Configurations = std::vector<Configuration>;

const std::set<std::string> shadow_options{"shadows", "inexact",       "inexact-bias", "inexact-target",
                                           "foliage", "shared-copies", "unique-cap",   "cull-angle"};

class Axes {
 public:
  explicit Axes(const Configuration& given) : given_(given) {}

  // Each configuration once with each value; as it is where the option is given.
  Configurations crossed(const Configurations& list, const std::string& option, const Values& values) const {
    if (given_.contains(option)) return list;
    Configurations result;
    for (const Configuration& c : list)
      for (const std::string& value : values) {
        result.push_back(c);
        result.back()[option] = value;
      }
    return result;
  }

  // Whether translucency may be drawn this way.
  bool allows(const std::string& translucency) const {
    const auto at = given_.find("translucency");
    return at == given_.end() || at->second == translucency;
  }
  Configurations drawn(const std::string& translucency) const {
    if (!allows(translucency)) return {};
    return crossed({{}}, "translucency", {translucency});
  }

 private:
  const Configuration& given_;
};

void append(Configurations& list, const Configurations& more) {
  list.insert(list.end(), more.begin(), more.end());
}

// The usual one first: four layers in full.
Configurations ways_to_draw(const SweepScene& scene, const Axes& axes) {
  if (scene.translucent_objects == 0 && !scene.has_particles) return {{}};
  Configurations list;
  if (scene.layered_objects > 0) {
    const Configurations layered = axes.crossed(axes.drawn("hybrid"), "layers", {"4", "1", "2", "8"});
    append(list, axes.crossed(layered, "cache-rate", {"full", "checkerboard", "quarter"}));
  }
  append(list, axes.drawn("raster"));
  append(list, axes.crossed(axes.drawn("raytraced"), "layers", {"1", "2", "4", "8", "unlimited"}));
  append(list, axes.drawn("off"));
  return list.empty() ? Configurations{{}} : list;
}

Configurations ways_to_shadow(const SweepScene& scene, const Axes& axes) {
  if (scene.lights == 0) return {{}};
  return axes.crossed(
      {{}}, "shadows",
      scene.swaying_objects > 0 ? Values{"inexact", "exact", "map", "off"} : Values{"exact", "map", "off"});
}

// Other light, what a single picture has no use for, what is as slow as it is exact, and what the defaults of masks,
// steps and matches are compared with.
bool is_another_question(const Configuration& configuration) {
  for (const char* option : {"ao", "reflections", "taa", "mask", "step", "match"})
    if (configuration.contains(option)) return true;
  const auto is = [&](const char* option, std::string_view value) {
    const auto at = configuration.find(option);
    return at != configuration.end() && at->second.starts_with(value);
  };
  return is("translucency", "reference") || is("cache-rate", "temporal") || is("oit", "peel");
}

// What it does not say is as usual.
Configuration completed(Configuration point, const Configuration& usual_drawing, const Configuration& usual_shadows) {
  if (!point.contains("translucency"))
    point.insert(usual_drawing.begin(), usual_drawing.end());
  else if (point["translucency"] == "hybrid" && usual_drawing.contains("cache-rate"))
    point.emplace("cache-rate", "full");
  if (!point.contains("shadows")) point.insert(usual_shadows.begin(), usual_shadows.end());
  return point;
}

CandidateConfiguration candidate(const Configuration& configuration) {
  Configuration drawing, shadows;
  for (const auto& option : configuration) (shadow_options.contains(option.first) ? shadows : drawing).insert(option);
  return {configuration, describe(drawing), describe(shadows)};
}

}  // namespace

std::vector<CandidateConfiguration> candidate_configurations(const SweepScene& scene, const Configuration& given) {
  const Axes axes(given);
  const Configurations drawings = ways_to_draw(scene, axes), shadows = ways_to_shadow(scene, axes);
  Configurations list;
  for (const Configuration& d : drawings)
    for (const Configuration& s : shadows) {
      list.push_back(d);
      list.back().insert(s.begin(), s.end());
    }
  for (const Configuration& point : default_sweep(Sweep::all, scene).configurations) {
    const bool is_open =
        std::none_of(point.begin(), point.end(), [&](const auto& o) { return given.contains(o.first); });
    if (!is_open || is_another_question(point)) continue;
    const Configuration whole = completed(point, drawings.front(), shadows.front());
    if (std::find(list.begin(), list.end(), whole) == list.end()) list.push_back(whole);
  }
  std::vector<CandidateConfiguration> candidates;
  for (const Configuration& configuration : list) candidates.push_back(candidate(configuration));
  return candidates;
}

}  // namespace sideray::lab
