// `sideray run`: an unmodified OpenGL program with rays.
#pragma once

#include <string>
#include <vector>

namespace sideray::cli {

struct RunArguments {
  std::vector<std::string> words;  // the program and its arguments
  std::string rules, report, capture, pictures;
  bool off = false, late = false;
};

// Becomes the program; returns only where it cannot.
int run_program(const RunArguments& arguments);

}  // namespace sideray::cli
