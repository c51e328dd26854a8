// Defines the program's own options of a picture: files, cameras, surroundings, sequences and ways of running. Options
// of how a frame is drawn are in the library's table. Any thread.
#pragma once

#include "cli/options/options.h"

namespace sideray::cli {

struct OwnOption {
  sideray_option row;
  const char* after;  // the library's row before it in --help; "" = at the top
  bool in_config;     // statistics print it
  bool in_chart;      // shared by a chart's reference and all of its rows
  bool in_plan;       // says what is drawn, not how the program runs
};

const std::vector<OwnOption>& own_options();
// Returns NULL where the program has no such option of its own.
const OwnOption* find_own(const std::string& name);

// Returns whether the statistics of a picture print the option.
bool is_in_config(const std::string& name);

}  // namespace sideray::cli
