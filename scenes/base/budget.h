// Limits the time and memory for reading one scene, since a few bytes of a file can ask for hours and for all memory.
// One thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sideray::scenes {

// 0 means the value of the environment (SIDERAY_LOAD_SECONDS, SIDERAY_LOAD_GB), or else the defaults below.
struct ReadLimits {
  double seconds = 0;  // processor time of the reading thread: a busy machine does not count
  uint64_t bytes = 0;  // of memory
};

constexpr double default_read_seconds = 20.0;
constexpr uint64_t default_read_bytes = 2'000'000'000;

// Counts requested memory, not what the allocator takes. Time is checked between steps (a list of numbers, a row of a
// picture, a compressed mesh), so that a scene is refused at most one step late.
class Budget {
 public:
  // Starts the time. `path` names the file in errors. Throws Error where the environment's value is not a number above
  // 0.
  Budget(std::string path, const ReadLimits& limits);

  // Reserves memory that is held until the scene is read; call it before allocating. All of these throw Error, which
  // names the file, `user` and the remedy.
  void take(uint64_t bytes, std::string_view user);
  void give_back(uint64_t bytes);
  // Checks that there is room for memory that is freed at once; call it before allocating.
  void check_memory(uint64_t bytes, std::string_view user) const;
  void check_time(std::string_view user) const;

  uint64_t left() const { return bytes_left_; }
  bool is_late() const;
  // Both return texts for an Error about too little memory.
  std::string memory_reason() const;
  std::string memory_remedy() const;

 private:
  std::string path_;
  ReadLimits limits_;
  uint64_t bytes_left_ = 0;
  double start_s_ = 0;
};

// Holds lines for people, at most a thousand: a hostile file can cause millions.
class Warnings : public std::vector<std::string> {
 public:
  static constexpr size_t most = 1000;
  Warnings() = default;
  Warnings(std::initializer_list<std::string> lines) : std::vector<std::string>(lines) {}
  void push_back(std::string line);
};

}  // namespace sideray::scenes
