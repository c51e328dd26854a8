// Shared code of the fuzz targets: a file in memory that readers can open, and the required form of an Error. One
// thread.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

namespace sideray::fuzz {

// Names the current input, for the message of a broken promise or a crash.
inline const char* running_what = nullptr;
inline unsigned long long running_number = 0;
inline void print_running() {
  char line[96];
  const int length = std::snprintf(line, sizeof(line), "in %s %llu\n", running_what, running_number);
  if (running_what != nullptr && ::write(STDERR_FILENO, line, static_cast<size_t>(length)) < 0) return;
}
inline void note(const char* what, unsigned long long number) {
  if (running_what == nullptr)
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
      std::signal(signal, [](int caught) {
        print_running();
        std::signal(caught, SIG_DFL);
        std::raise(caught);
      });
  running_what = what, running_number = number;
}

// Set by SIGTERM and SIGINT. The run then ends after the current input and prints its progress: `timeout 60 fuzz_NAME
// SEED COUNT` counts the inputs of a minute.
inline volatile std::sig_atomic_t has_to_stop = 0;
inline void stop_at_signals() {
  for (const int signal : {SIGTERM, SIGINT}) std::signal(signal, [](int) { has_to_stop = 1; });
}

// Ends the run, so that the fuzzer keeps the input.
[[noreturn]] inline void broken(const std::string& promise, const std::string& detail) {
  std::fprintf(stderr, "broken promise: %s: %s\n", promise.c_str(), detail.c_str());
  std::abort();
}

// One line of printable characters (or UTF-8).
inline void check_line(const std::string& message) {
  if (message.empty()) broken("an error has a message", message);
  for (const char c : message) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) broken("an error is one printable line", message);
  }
}

// "what: why; what to do".
inline void check_message(const std::string& message) {
  check_line(message);
  if (message.find(": ") == std::string::npos || message.find("; ") == std::string::npos)
    broken("an error says what: why; what to do", message);
}

}  // namespace sideray::fuzz
