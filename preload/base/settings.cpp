#include "preload/base/settings.h"

#include <unistd.h>

#include <cstdlib>

namespace sideray::run {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

const Settings& settings() {
  // Is never destroyed, since the last report is written when the process ends.
  static const Settings* const all =
      new Settings{variable("SIDERAY_RUN_OFF") == "1",  variable("SIDERAY_RUN_LATE") == "1",    variable("SIDERAY_RUN_RULES"),
                   variable("SIDERAY_RUN_REPORT"),      variable("SIDERAY_RUN_CAPTURE"),        variable("SIDERAY_RUN_PICTURES")};
  return *all;
}

void say(const std::string& line) {
  const std::string whole = "sideray run: " + line + "\n";
  (void)!::write(STDERR_FILENO, whole.data(), whole.size());
}

}  // namespace sideray::run
