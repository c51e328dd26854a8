// The makers behind generate(): one file each.
#pragma once

#include <map>
#include <string>

#include "scenes/content/content.h"

namespace sideray::scenes {

// Holds the values of all parameters of a scene.
struct Numbers {
  std::string scene;
  std::map<std::string, double> values;
  // Both return a parameter, and throw Error where it is out of range.
  double in_range(const std::string& name, double low, double high) const;
  int whole_in_range(const std::string& name, int low, int high) const;
};

Content make_bistro(const Numbers& numbers);
Content make_crossing(const Numbers& numbers);
Content make_forest(const Numbers& numbers);
Content make_panes(const Numbers& numbers);
Content make_solids(const Numbers& numbers);
Content make_smoke(const Numbers& numbers);
Content make_frosted(const Numbers& numbers);
Content make_empty(const Numbers& numbers);
Content make_haze(const Numbers& numbers);
Content make_edges(const Numbers& numbers);

}  // namespace sideray::scenes
