// `sideray run`: adds rays to an unmodified OpenGL program.
#pragma once

#include <string>
#include <vector>

namespace sideray::cli {

struct RunArguments {
  std::vector<std::string> words;  // the program and its arguments
  std::string rules, report, capture, pictures;
  bool off = false, late = false;
};

// Replaces this process by the program; returns only if that fails.
int run_program(const RunArguments& arguments);

}  // namespace sideray::cli
