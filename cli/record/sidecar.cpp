#include "cli/record/sidecar.h"

#include <filesystem>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "cli/record/task_note.h"
#include "scenes/base/files.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

constexpr uint64_t most_picture_bytes = uint64_t{4} << 30;

std::string hash_text(const std::string& picture) {
  return fmt::format("{:016x}", scenes::hash_of(scenes::read_file(picture, most_picture_bytes)));
}

}  // namespace

std::string sidecar_path(const std::string& picture) {
  return picture + ".json";
}

void write_sidecar(const std::string& picture, const Json& options, Shard shard, const Json& stats, bool keeps_stats) {
  Json sidecar = {{"schema", 1},
                  {"program", program_build()},
                  {"bytes", std::filesystem::file_size(picture)},
                  {"hash", hash_text(picture)},
                  {"node", node_name()},
                  {"shard", shard.index},
                  {"shards", shard.count},
                  {"options", options},
                  {"config", stats.at("config")},
                  {"device", stats.at("device")}};
  if (keeps_stats) sidecar["stats"] = stats;
  write_text(sidecar_path(picture), scenes::json_text(sidecar, 1) + "\n");
}

std::optional<Json> read_sidecar(const std::string& picture, const Json& options) {
  std::error_code error;
  const uint64_t bytes = std::filesystem::file_size(picture, error);
  if (error || !std::filesystem::is_regular_file(sidecar_path(picture), error)) return {};
  Json sidecar = Json::parse(scenes::read_file(sidecar_path(picture), most_picture_bytes), nullptr, false);
  if (!sidecar.is_object() || sidecar.value("bytes", uint64_t{0}) != bytes) return {};
  if (!sidecar.contains("options") || !Json::diff(sidecar["options"], options).empty()) return {};
  return sidecar;
}

bool has_written_bytes(const std::string& picture, const Json& sidecar) {
  return sidecar.value("hash", "") == hash_text(picture);
}

}  // namespace sideray::cli
