// Writes the stats of a sequence: one object a line, in the order of frames. Main thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sideray::cli {

class SequenceStats {
 public:
  explicit SequenceStats(std::string path) : path_(std::move(path)) {}

  // Takes those lines of the file whose frames `is_there` accepts; skips lines that are cut off or of other frames.
  // Throws Error where the file cannot be read.
  void restore(const std::function<bool(uint32_t)>& is_there);

  bool has(uint32_t frame) const { return lines_.contains(frame); }
  // Rewrites the file now and then, so that a killed run loses only its last lines.
  void add(uint32_t frame, nlohmann::ordered_json stats);
  // Writes the file, completely or not at all.
  void save();

 private:
  std::string path_;
  std::map<uint32_t, std::string> lines_;
  std::chrono::steady_clock::time_point saved_ = std::chrono::steady_clock::now();
};

}  // namespace sideray::cli
