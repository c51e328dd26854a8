// What `sideray run` tells the library, by environment variables, and what the library tells the user.
#pragma once

#include <string>

namespace sideray::run {

struct Settings {
  bool off = false;   // nothing is held back: the program's own picture
  bool late = false;  // nothing waits: answers of an earlier frame are drawn
  std::string rules, report, capture, pictures;  // files and a folder; empty = none
};

const Settings& settings();

// Writes one line to standard error.
void say(const std::string& line);

}  // namespace sideray::run
