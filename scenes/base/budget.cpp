#include "scenes/base/budget.h"

#include <ctime>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "scenes/base/files.h"

namespace sideray::scenes {
namespace {

double processor_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Returns the number in an environment variable, or `fallback` where it is not set.
double number_from(const char* variable, double fallback, double most) {
  const char* text = std::getenv(variable);
  if (text == nullptr || *text == '\0') return fallback;
  double value = 0;
  const char* end = text + std::strlen(text);
  const auto [stopped, error] = std::from_chars(text, end, value);
  if (error != std::errc{} || stopped != end || !(value > 0 && value <= most))
    refuse("{}: \"{}\" is not a number above 0 and up to {:g}; correct it or unset it", variable, text, most);
  return value;
}

ReadLimits resolved(ReadLimits limits) {
  constexpr double gigabyte = 1e9, most_seconds = 1e9, most_gigabytes = 1e6;
  if (!(limits.seconds > 0)) limits.seconds = number_from("SIDERAY_LOAD_SECONDS", default_read_seconds, most_seconds);
  if (limits.bytes == 0) {
    constexpr double usual = static_cast<double>(default_read_bytes) / gigabyte;
    const double given = number_from("SIDERAY_LOAD_GB", usual, most_gigabytes);
    limits.bytes = static_cast<uint64_t>(std::ceil(given * gigabyte));
  }
  return limits;
}

}  // namespace

Budget::Budget(std::string path, const ReadLimits& limits)
    : path_(std::move(path)), limits_(resolved(limits)), bytes_left_(limits_.bytes), start_s_(processor_seconds()) {}

void Budget::take(uint64_t bytes, std::string_view user) {
  check_memory(bytes, user);
  bytes_left_ -= bytes;
}

void Budget::give_back(uint64_t bytes) {
  bytes_left_ += bytes;
}

void Budget::check_memory(uint64_t bytes, std::string_view user) const {
  if (bytes > bytes_left_) refuse("cannot read {}: {} {}; {}", path_, user, memory_reason(), memory_remedy());
}

bool Budget::is_late() const {
  return processor_seconds() - start_s_ > limits_.seconds;
}

void Budget::check_time(std::string_view user) const {
  if (is_late())
    refuse("cannot read {}: it takes longer than {:g} s, at {}; allow more time with SIDERAY_LOAD_SECONDS or use a "
           "smaller scene", path_, limits_.seconds, user);
}

std::string Budget::memory_reason() const {
  return fmt::format("needs more than the {:g} GB of memory that reading may take",
                     static_cast<double>(limits_.bytes) * 1e-9);
}

std::string Budget::memory_remedy() const {
  return "allow more with SIDERAY_LOAD_GB or use a smaller scene";
}

void Warnings::push_back(std::string line) {
  if (size() < most) std::vector<std::string>::push_back(std::move(line));
  else if (size() == most) std::vector<std::string>::push_back("warnings: there are more, which are not listed");
}

}  // namespace sideray::scenes
