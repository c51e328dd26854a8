#include "scenes/builtin/builtin.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "scenes/builtin/builtin_scenes.h"

namespace sideray::scenes {
namespace {

struct Entry {
  Builtin description;
  Content (*make)(const Numbers& numbers);
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list = {
      {{"bistro",
        "an interior at evening: windows to the street, tables crowded with glasses and bottles, lamps, smoke and "
        "flames",
        {{"seed", "1", "what stands where on tables and shelves, 0 to 1000000"},
         {"tables", "6", "laid tables, 1 to 8"},
         {"bottles", "4", "bottles on each table, 0 to 4"},
         {"lamps", "8", "lights, 0 to 1024; those beyond 8 are small bulbs under the ceiling"}}},
       make_bistro},
      {{"forest",
        "trees, bushes, ferns and grass in wind around a pond, and a wall that leaf shadows fall on",
        {{"count", "2000", "plants, 0 to 1000000"}, {"seed", "1", "what grows where, 0 to 1000000"}}},
       make_forest},
      {{"panes",
        "parallel panes of glass before a patterned wall, equal as seen from the camera",
        {{"count", "4", "panes, 1 to 64"},
         {"gap", "0.2", "metres between neighbours, 0 to 10"},
         {"angle", "0", "degrees that the panes are turned about the vertical, -89 to 89"},
         {"distance", "3", "metres from the camera to the first pane, 0.01 to 1e5"}}},
       make_panes},
      {{"haze",
        "hot air over a candle, a wavy pane and water with rings: what distorts the picture behind it",
        {{"strength", "1", "how far they distort, 0 to 10 times"}}},
       make_haze},
      {{"crossing",
        "panes through one another, strips that overlap in a ring, a stack: every kind of blending",
        {{"panes", "5", "intersecting panes, 0 to 64"},
         {"strips", "5", "strips that overlap in a ring, 3 to 64"},
         {"layers", "12", "sheets behind one another, 0 to 256"}}},
       make_crossing},
      {{"solids",
        "solid glass that bends what stands behind it: ball, cube, lens, a tumbler with liquid, a single quad",
        {{"ior", "1.5", "of the glass, 1 to 3"},
         {"liquid_ior", "1.33", "of the liquid, 1 to 3"},
         {"roughness", "0", "of the glass, 0 to 1"},
         {"dispersion", "0", "of the glass, 0 to 10"},
         {"film", "0", "nanometres of a film of index 2 on the glass, 0 to 10000"},
         {"fill", "0.7", "of the tumbler, 0 to 1"},
         {"overlap", "0.004", "metres that the liquid reaches into the glass, -0.02 to 0.02; below 0 a gap"},
         {"segments", "96", "around the axis of what is round, 8 to 4096"}}},
       make_solids},
      {{"edges",
        "stress: silhouettes over other layers, glass at glancing angles, rods thinner than a pixel, curved glass",
        {{"thickness", "1", "factor on the width of the rods, which are 0.25 to 2 pixels of 1280x720, 0.1 to 10"}}},
       make_edges},
      {{"smoke",
        "a column of lit, soft smoke with panes of glass before, within and behind it",
        {{"count", "4000", "sprites at once, about, 1 to 50000"}}},
       make_smoke},
      {{"frosted",
        "rough panes and bottles that reflect bright windows in a dark room, and blocks that touch them",
        {{"roughness", "0", "of all glass, 0.04 to 1; 0: 0.1 to 0.6 from left to right"}}},
       make_frosted},
      {{"empty",
        "opaque objects on a floor, nothing translucent",
        {{"film", "0", "nanometres of a film of index 2 on the objects, 0 to 10000"},
         {"anisotropy", "0", "of the objects, 0 to 1"}}},
       make_empty},
  };
  return list;
}

const Entry& find(const std::string& name) {
  for (const Entry& entry : entries())
    if (entry.description.name == name) return entry;
  std::vector<std::string> names;
  for (const Entry& entry : entries()) names.push_back(entry.description.name);
  throw Error(SIDERAY_INVALID_ARGUMENT,
              fmt::format("{}: no such built-in scene; there are {}", name, fmt::join(names, ", ")));
}

double number(const std::string& scene, const Parameter& parameter, const std::string& text) {
  size_t used = 0;
  double value = 0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !std::isfinite(value))
    throw Error(SIDERAY_INVALID_ARGUMENT, fmt::format("{}: {} is \"{}\", not a number; give a number such as {}", scene,
                                                      parameter.name, text, parameter.default_value));
  return value;
}

}  // namespace

double Numbers::in_range(const std::string& name, double low, double high) const {
  const double value = values.at(name);
  if (!(value >= low && value <= high))
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("{}: {} is {}, out of range; give {} to {}", scene, name, value, low, high));
  return value;
}

int Numbers::whole_in_range(const std::string& name, int low, int high) const {
  const double value = in_range(name, low, high);
  if (value != std::floor(value))
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("{}: {} is {}, not a whole number; give {} to {}", scene, name, value, low, high));
  return static_cast<int>(value);
}

const std::vector<Builtin>& builtins() {
  static const std::vector<Builtin> list = [] {
    std::vector<Builtin> descriptions;
    for (const Entry& entry : entries()) descriptions.push_back(entry.description);
    return descriptions;
  }();
  return list;
}

bool is_builtin(const std::string& name) {
  return std::any_of(entries().begin(), entries().end(), [&](const Entry& e) { return e.description.name == name; });
}

Content generate(const std::string& name, const Settings& settings) {
  const Entry& entry = find(name);
  Numbers numbers{name, {}};
  for (const Parameter& p : entry.description.parameters) numbers.values[p.name] = number(name, p, p.default_value);
  const std::vector<Parameter>& parameters = entry.description.parameters;
  for (const auto& [key, text] : settings) {
    const auto parameter = std::find_if(parameters.begin(), parameters.end(),
                                        [&wanted = key](const Parameter& p) { return p.name == wanted; });
    if (parameter == parameters.end()) {
      std::vector<std::string> names;
      for (const Parameter& p : parameters) names.push_back(p.name);
      throw Error(SIDERAY_INVALID_ARGUMENT,
                  fmt::format("{}: no parameter {}; {}", name, key,
                              names.empty() ? "it has none" : fmt::format("there are {}", fmt::join(names, ", "))));
    }
    numbers.values[key] = number(name, *parameter, text);
  }
  return entry.make(numbers);
}

}  // namespace sideray::scenes
