#include "viewer/drawing/ways.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace sideray::viewer {
namespace {

using Setting = std::pair<const char*, const char*>;

std::vector<Setting> settings_of(Way way) {
  switch (way) {
    case Way::raster:
      return {{"translucency", "raster"}, {"shadows", "map"}, {"ambient", "off"}, {"reflections", "off"}};
    case Way::hybrid: return {{"translucency", "hybrid"}};
    case Way::raytraced: return {{"translucency", "raytraced"}};
    case Way::reference: return {{"reference", "true"}};
    case Way::chosen: return {};
  }
  return {};
}

}  // namespace

bool is_decided_by_window(const std::string& name) {
  constexpr const char* names[] = {"size", "samples", "taa", "reference", "deadline"};
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

Options options_of(Way way, const Options& base) {
  const std::vector<Setting> settings = settings_of(way);
  Options options = settings.empty() ? base : Options::create().value();
  for (const auto& [name, value] : settings) options.set(name, value);
  const auto is_decided = [&](const std::string& name) {
    return std::any_of(settings.begin(), settings.end(), [&](const Setting& s) { return name == s.first; });
  };
  for (size_t i = 0; !settings.empty() && i < sideray_option_count(); ++i) {
    const std::string name = sideray_option_at(i)->name;
    if (!base.is_set(name) || is_decided(name)) continue;
    Options trial = options;
    trial.set(name, base[name]);
    if (sideray_options_check(trial.get(), nullptr) == SIDERAY_OK) options = std::move(trial);
  }
  if (way != Way::reference) return options;
  if (!options.is_set("light-samples")) options.set("light-samples", std::to_string(reference_light_samples));
  // Pictures have light that bounces, so the truth beside them has it too.
  if (!options.is_set("bounces")) options.set("bounces", "unlimited");
  return options;
}

bool needs_rasterizer(const Options& options) {
  return !options.render().reference && options["translucency"] == "raster";
}

}  // namespace sideray::viewer
