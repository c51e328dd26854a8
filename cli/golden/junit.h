// Writes results in JUnit's format, for CI that shows tests. Any thread.
#pragma once

#include <string>
#include <vector>

namespace sideray::cli {

struct JunitCase {
  std::string name, failure;  // "" = passed
  double seconds = 0;
};

std::string junit_text(const std::string& suite, const std::vector<JunitCase>& cases);

}  // namespace sideray::cli
