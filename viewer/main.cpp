// The window of `sideray view`.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <span>

#include "viewer/interface/application.h"

namespace {

// A picture that takes longer than this after the window was closed is abandoned.
constexpr double most_seconds_to_end = 0.3;

std::string program_beside() {
  std::error_code error;
  return (std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "sideray").string();
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sideray::viewer;
  try {
    Application application(read_arguments(std::span(argv, static_cast<size_t>(argc)).subspan(1)), program_beside());
    application.run();
    if (!application.ends_within(most_seconds_to_end)) std::_Exit(EXIT_SUCCESS);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    fmt::print(stderr, "sideray: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
