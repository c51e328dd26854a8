// What the fuzz targets share: a file in memory that the readers can open, and what an Error must look like. One
// thread.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

namespace sideray::fuzz {

// Ends the run, so that the fuzzer keeps the input.
[[noreturn]] inline void broken(const std::string& promise, const std::string& detail) {
  std::fprintf(stderr, "broken promise: %s: %s\n", promise.c_str(), detail.c_str());
  std::abort();
}

// "what: why; what to do", one line, of printable characters (or UTF-8).
inline void check_message(const std::string& message) {
  for (const char c : message) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) broken("an error is one printable line", message);
  }
  if (message.find(": ") == std::string::npos || message.find("; ") == std::string::npos)
    broken("an error says what: why; what to do", message);
}

}  // namespace sideray::fuzz
