// Limits time and memory of reading one scene, because a few bytes of a file can ask for hours and for all memory. One
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sideray::scenes {

// 0 = the value of the environment (SIDERAY_LOAD_SECONDS, SIDERAY_LOAD_GB), else the defaults below.
struct ReadLimits {
  double seconds = 0;  // of processor time of the reading thread, so that a busy machine or a slow disk refuses no
                       // scene
  uint64_t bytes = 0;  // of memory
};

constexpr double default_read_seconds = 20.0;
constexpr uint64_t default_read_bytes = 2'000'000'000;

// Counts requested memory, not what the allocator takes. Time is checked between steps (a list of numbers, a row of a
// picture, a compressed mesh), so that a scene is refused at most one step late.
class Budget {
 public:
  // `path` names the file in errors. Time starts here. Throws Error if the environment holds no number above 0.
  Budget(std::string path, const ReadLimits& limits);

  // Must be called before memory is allocated that stays until the scene is read. All of these throw Error, which names
  // the file, `user` and the remedy.
  void take(uint64_t bytes, std::string_view user);
  void give_back(uint64_t bytes);
  // Must be called before temporary memory is allocated.
  void check_memory(uint64_t bytes, std::string_view user) const;
  void check_time(std::string_view user) const;

  uint64_t left() const { return bytes_left_; }
  bool is_late() const;
  // Return the texts of an Error about memory.
  std::string memory_reason() const;
  std::string memory_remedy() const;

 private:
  std::string path_;
  ReadLimits limits_;
  uint64_t bytes_left_ = 0;
  double start_s_ = 0;
};

// Holds warnings to be read by people. A hostile file can cause millions, so those after the thousandth are dropped.
class Warnings : public std::vector<std::string> {
 public:
  static constexpr size_t most = 1000;
  Warnings() = default;
  Warnings(std::initializer_list<std::string> lines) : std::vector<std::string>(lines) {}
  void push_back(std::string line);
};

}  // namespace sideray::scenes
