// The program's own options of a picture: files, cameras, surroundings, sequences and ways of running. What frames do
// with the scene is the library's table. Any thread.
#pragma once

#include "cli/options/options.h"

namespace sideray::cli {

struct OwnOption {
  sideray_option row;
  const char* after;  // the library's row that it stands behind in --help; "" = in front of all
  bool in_config;     // the statistics print it
  bool in_chart;      // the same for a chart's reference and for all of its rows
  bool in_plan;       // says what is drawn, and not how the program runs
};

const std::vector<OwnOption>& own_options();
// NULL where the program has no such option of its own.
const OwnOption* find_own(const std::string& name);

// Whether the statistics of a picture print the option at all.
bool is_in_config(const std::string& name);

}  // namespace sideray::cli
