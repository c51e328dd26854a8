// Defines how the program fails: exit code 2 for wrong usage, 1 for everything else (sideray::Error). Any thread.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace sideray::cli {

constexpr int exit_ok = 0, exit_failed = 1, exit_usage = 2;

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws UsageError with the line "what: why; what to do".
template <typename... Args>
[[noreturn]] void wrong_usage(fmt::format_string<Args...> format, Args&&... args) {
  throw UsageError(fmt::format(format, std::forward<Args>(args)...));
}

// Print "sideray: MESSAGE" as one line on standard error.
void print_error(const std::string& message);
void print_warning(const std::string& message);
void print_note(const std::string& message);

}  // namespace sideray::cli
