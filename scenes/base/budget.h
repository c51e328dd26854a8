// What reading one scene may still take: a few bytes of a file can ask for hours, and for all memory. One thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sideray::scenes {

// 0 stands for what the environment says (SIDERAY_LOAD_SECONDS, SIDERAY_LOAD_GB), else for the defaults below.
struct ReadLimits {
  double seconds = 0;  // of processor time of the reading thread: a busy machine or a slow disk refuses no scene
  uint64_t bytes = 0;  // of memory
};

constexpr double default_read_seconds = 20.0;
constexpr uint64_t default_read_bytes = 2'000'000'000;

// Counts memory as it is asked for, not as the allocator gives it. Time is looked at between steps (a list of numbers,
// a row of a picture, a compressed mesh), so that a scene is refused at most one step late.
class Budget {
 public:
  // `path` names the file in errors. Time runs from here on. Throws Error where the environment holds no number above 0.
  Budget(std::string path, const ReadLimits& limits);

  // Call it before memory is taken that stays until the scene is read. All of these throw Error, which names the file,
  // `user` and the remedy.
  void take(uint64_t bytes, std::string_view user);
  void give_back(uint64_t bytes);
  // Call it before memory is taken that goes again at once.
  void check_memory(uint64_t bytes, std::string_view user) const;
  void check_time(std::string_view user) const;

  uint64_t left() const { return bytes_left_; }
  bool is_late() const;
  // What an Error says where the memory does not suffice.
  std::string memory_reason() const;
  std::string memory_remedy() const;

 private:
  std::string path_;
  ReadLimits limits_;
  uint64_t bytes_left_ = 0;
  double start_s_ = 0;
};

// Lines for people. A hostile file can ask for millions: those behind the thousandth are dropped.
class Warnings : public std::vector<std::string> {
 public:
  static constexpr size_t most = 1000;
  Warnings() = default;
  Warnings(std::initializer_list<std::string> lines) : std::vector<std::string>(lines) {}
  void push_back(std::string line);
};

}  // namespace sideray::scenes
