// Holds the settings that `sideray run` passes in environment variables; prints messages to the user.
#pragma once

#include <string>

namespace sideray::run {

struct Settings {
  bool off = false;   // nothing is held back: the picture is the program's own
  bool late = false;  // nothing waits: answers of an earlier frame are drawn
  std::string rules, report, capture, pictures;  // files and a folder; empty = none
};

const Settings& settings();

// Writes one line to standard error.
void say(const std::string& line);

}  // namespace sideray::run
