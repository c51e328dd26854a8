// Carries a failure inside the library, from where it is found to the C border, which turns it into a status. Any
// thread may throw it.
#pragma once

#include <fmt/format.h>
#include <sideray/sideray.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace sideray {

// `what()` is one line: what was wrong: why; what to do.
struct Failure : std::runtime_error {
  Failure(sideray_status failure_status, const std::string& message)
      : std::runtime_error(message), status(failure_status) {}
  sideray_status status;
};

template <typename... Args>
[[noreturn]] void fail(sideray_status status, fmt::format_string<Args...> format, Args&&... args) {
  throw Failure(status, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace sideray
