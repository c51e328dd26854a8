#include "cli/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace sideray::cli {
namespace {

constexpr const char* clear_line = "\r\x1b[K";

}  // namespace

Progress::Progress(size_t steps) : steps_(steps), shown_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_ && begun_ > 0) fmt::print(stderr, "{}", clear_line);
}

void Progress::next(const std::string& what) {
  const size_t done = begun_++;
  if (!shown_) return;
  constexpr size_t width = 24;
  const size_t filled = steps_ == 0 ? width : width * done / steps_;
  fmt::print(stderr, "{}[{}{}] {}/{} {:.60}", clear_line, std::string(filled, '#'), std::string(width - filled, ' '),
             done, steps_, what);
  std::fflush(stderr);
}

}  // namespace sideray::cli
