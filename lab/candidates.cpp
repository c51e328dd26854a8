#include "lab/candidates.h"

#include <algorithm>

namespace sideray::lab {
namespace {

using Values = std::vector<std::string>;
using Configurations = std::vector<Configuration>;

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

Configurations translucency_of(const SweepScene& scene, const Axes& axes) {
  if (scene.translucent_objects == 0 && !scene.has_particles) return {{}};
  Configurations list;
  append(list, axes.drawn("off"));
  append(list, axes.drawn("raster"));
  if (scene.layered_objects > 0) {
    const Configurations layered = axes.crossed(axes.drawn("hybrid"), "layers", {"1", "2", "4", "8"});
    append(list, axes.crossed(layered, "cache-rate", {"full", "checkerboard", "quarter"}));
  }
  append(list, axes.crossed(axes.drawn("raytraced"), "layers", {"1", "2", "4", "8", "unlimited"}));
  return list.empty() ? Configurations{{}} : list;
}

// Other light, what a single picture has no use for, what is as slow as it is exact, and what the defaults of masks,
// steps and matches are compared with.
bool is_another_question(const Configuration& configuration) {
  for (const char* option : {"ao", "reflections", "taa", "mask", "step", "match"})
    if (configuration.contains(option)) return true;
  const auto translucency = configuration.find("translucency"), rate = configuration.find("cache-rate");
  return (translucency != configuration.end() && translucency->second == "reference") ||
         (rate != configuration.end() && rate->second.starts_with("temporal"));
}

}  // namespace

std::vector<Configuration> candidate_configurations(const SweepScene& scene, const Configuration& given) {
  const Axes axes(given);
  Configurations list = translucency_of(scene, axes);
  if (scene.lights > 0)
    list = axes.crossed(
        list, "shadows",
        scene.swaying_objects > 0 ? Values{"off", "map", "inexact", "exact"} : Values{"off", "map", "exact"});
  for (const Configuration& point : default_sweep(Sweep::all, scene).configurations) {
    const bool is_open =
        std::none_of(point.begin(), point.end(), [&](const auto& o) { return given.contains(o.first); });
    if (is_open && !is_another_question(point) && std::find(list.begin(), list.end(), point) == list.end())
      list.push_back(point);
  }
  return list;
}

}  // namespace sideray::lab
