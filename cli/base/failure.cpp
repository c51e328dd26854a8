#include "cli/base/failure.h"

#include <cstdio>

#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

void print_line(const char* prefix, std::string message) {
  while (!message.empty() && message.back() == '\n') message.pop_back();
  message = scenes::printable(std::move(message));
  fmt::print(stderr, "sideray: {}{}\n", prefix, message);
}

}  // namespace

void print_error(const std::string& message) {
  print_line("", message);
}
void print_note(const std::string& message) {
  print_line("", message);
}
void print_warning(const std::string& message) {
  print_line("warning: ", message);
}

}  // namespace sideray::cli
