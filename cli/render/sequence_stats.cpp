#include "cli/render/sequence_stats.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "cli/base/outputs.h"
#include "scenes/base/files.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t most_bytes = uint64_t{8} << 30;
constexpr std::chrono::seconds between_saves{2};

// Returns the frame of a line; empty where the line belongs to none.
std::optional<uint32_t> frame_of(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("frame") || !json.contains("stages_ms")) return {};
  const Json& frame = json["frame"];
  if (!frame.is_number_unsigned() || frame.get<uint64_t>() > UINT32_MAX) return {};
  return frame.get<uint32_t>();
}

}  // namespace

void SequenceStats::restore(const std::function<bool(uint32_t)>& is_there) {
  std::error_code ignored;
  if (!std::filesystem::exists(path_, ignored)) return;
  const std::vector<uint8_t> bytes = scenes::read_file(path_, most_bytes);
  std::istringstream text(std::string(bytes.begin(), bytes.end()));
  for (std::string line; std::getline(text, line);) {
    const std::optional<uint32_t> frame = frame_of(line);
    if (frame && is_there(*frame)) lines_[*frame] = line;
  }
}

void SequenceStats::add(uint32_t frame, Json stats) {
  Json line = {{"frame", frame}};
  line.update(stats);
  lines_[frame] = scenes::json_text(line);
  if (std::chrono::steady_clock::now() - saved_ >= between_saves) save();
}

void SequenceStats::save() {
  std::string text;
  for (const auto& [frame, line] : lines_) text += line + "\n";
  write_text(path_, text);
  saved_ = std::chrono::steady_clock::now();
}

}  // namespace sideray::cli
